#include "host_tools/text/file_layer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <filesystem>

namespace inbetween {
namespace {

int open_again_if_interrupted(const char* path, int flags, mode_t mode, int& descriptor) {
  do descriptor = ::open(path, flags, mode);
  while (descriptor < 0 && errno == EINTR);
  return descriptor < 0 ? errno : 0;
}

int read_file(const std::string& path, std::size_t max_bytes, std::string& bytes) {
  bytes.clear();
  int descriptor = -1;
  // A pipe would otherwise wait for a writer.
  if (const int error =
          open_again_if_interrupted(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0, descriptor)) {
    return error;
  }
  const int error = read_open_file(descriptor, max_bytes, bytes);
  ::close(descriptor);
  return error;
}

int write_some(int descriptor, std::string_view bytes, std::size_t& written) {
  ssize_t count = 0;
  do count = ::write(descriptor, bytes.data(), bytes.size());
  while (count < 0 && errno == EINTR);
  if (count < 0) return errno;
  written = static_cast<std::size_t>(count);
  return count == 0 ? EIO : 0;
}

int sync_folder(const std::string& folder) {
  int descriptor = -1;
  if (const int error =
          open_again_if_interrupted(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0, descriptor)) {
    return error;
  }
  const int error = errno_of(::fsync(descriptor));
  ::close(descriptor);
  return error;
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

int write_all(const FileLayer& files, int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    std::size_t written = 0;
    if (const int error = files.write(descriptor, bytes, written)) return error;
    bytes.remove_prefix(written);
  }
  return files.sync(descriptor);
}

}  // namespace

int errno_of(int result) {
  return result == 0 ? 0 : errno;
}

int read_open_file(int descriptor, std::size_t max_bytes, std::string& bytes) {
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0) return errno;
  if (!S_ISREG(status.st_mode)) return S_ISDIR(status.st_mode) ? EISDIR : EINVAL;
  std::array<char, 4096> block = {};
  while (true) {
    const ssize_t count = ::read(descriptor, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    if (count == 0) return 0;
    bytes.append(block.data(), static_cast<std::size_t>(count));
    if (bytes.size() > max_bytes) return EFBIG;
  }
}

int inherit_from(const struct stat& status, int descriptor) {
  // Another's file that this user may replace stays another's only if the kernel allows it.
  if (::fchown(descriptor, status.st_uid, status.st_gid) != 0 && errno != EPERM) return errno;
  return errno_of(::fchmod(descriptor, status.st_mode & 0777U));
}

int may_write_at(int folder, const char* path) {
  struct stat status = {};
  if (::fstatat(folder, path, &status, 0) != 0) return 0;  // opening it tells what is wrong
  // The kernel lets root write what nobody shall.
  if ((status.st_mode & 0222U) == 0) return EACCES;
  return errno_of(::faccessat(folder, path, W_OK, AT_EACCESS));
}

int being_written(int descriptor) {
  // The kernel gives a lease to read where nobody has the file open to write. Whoever opens it meanwhile
  // waits until it is given back, and a signal tells of him: one that nobody hears.
  if (::fcntl(descriptor, F_SETSIG, SIGURG) != 0) return 0;
  if (::fcntl(descriptor, F_SETLEASE, F_RDLCK) != 0) return errno == EAGAIN ? ETXTBSY : 0;
  return errno_of(::fcntl(descriptor, F_SETLEASE, F_UNLCK));
}

FileLayer system_files() {
  return {.read = read_file,
          .create =
              [](const std::string& path, int& descriptor) {
                return open_again_if_interrupted(
                    path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0644, descriptor);
              },
          .may_write = [](const std::string& path) { return may_write_at(AT_FDCWD, path.c_str()); },
          .being_written =
              [](const std::string& path) {
                int descriptor = -1;
                if (const int error = open_again_if_interrupted(
                        path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK, 0, descriptor)) {
                  return error;
                }
                const int error = being_written(descriptor);
                ::close(descriptor);
                return error;
              },
          .inherit =
              [](const std::string& path, int descriptor) {
                struct stat status = {};
                if (::stat(path.c_str(), &status) != 0) return errno == ENOENT ? 0 : errno;
                return inherit_from(status, descriptor);
              },
          .write = write_some,
          .sync = [](int descriptor) { return errno_of(::fsync(descriptor)); },
          .close = [](int descriptor) { return errno_of(::close(descriptor)); },
          .rename = [](const std::string& from,
                       const std::string& to) { return errno_of(std::rename(from.c_str(), to.c_str())); },
          .rename_new =
              [](const std::string& from, const std::string& to) {
                return errno_of(::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE));
              },
          .swap =
              [](const std::string& one, const std::string& other) {
                return errno_of(::renameat2(AT_FDCWD, one.c_str(), AT_FDCWD, other.c_str(), RENAME_EXCHANGE));
              },
          .remove = [](const std::string& path) { return errno_of(::unlink(path.c_str())); },
          .sync_folder = sync_folder,
          .make_folder = [](const std::string& folder) { return errno_of(::mkdir(folder.c_str(), 0755)); }};
}

namespace {

/// Makes `part` a file of `bytes`, synced, that has the permissions of `path`.
FileFailure write_part(const FileLayer& files, const std::string& part, const std::string& path,
                       std::string_view bytes) {
  if (const int error = files.may_write(path))
    return {"is write-protected (chmod u+w lets it be written)", path, error};
  int descriptor = -1;
  int error = files.create(part, descriptor);
  if (error == EEXIST) {  // of a power cut
    files.remove(part);
    error = files.create(part, descriptor);
  }
  if (error != 0) return {"cannot be written", part, error};
  // Before its first byte: what nobody may read stays so.
  if (const int not_inherited = files.inherit(path, descriptor)) {
    files.close(descriptor);
    files.remove(part);
    return {"cannot be given the permissions of the old file", part, not_inherited};
  }
  const int not_written = write_all(files, descriptor, bytes);
  const int not_closed = files.close(descriptor);
  if (not_written != 0 || not_closed != 0) {
    files.remove(part);  // it is of no use, and the disk may be full
    return {"could not be written completely", part, not_written != 0 ? not_written : not_closed};
  }
  return {};
}

FileFailure sync_folder_of(const FileLayer& files, const std::string& path) {
  const std::string folder = folder_of(path);
  if (const int error = files.sync_folder(folder)) return {"could not be made sure of", folder, error};
  return {};
}

bool has(const FileLayer& files, const std::string& path, std::string_view bytes) {
  std::string there;
  return files.read(path, bytes.size(), there) == 0 && there == bytes;
}

FileFailure changed_by_others(const std::string& path) {
  return {"has been changed by somebody else", path, ESTALE};
}

/// Swaps the names once more, so that `path` is what it was. A file that came there meanwhile stays as
/// `part`.
FileFailure put_back(const FileLayer& files, const std::string& part, const std::string& path,
                     std::string_view bytes) {
  if (const int error = files.swap(part, path))
    return {"cannot be put back; what it had is in its part", path, error};
  if (FileFailure failure = sync_folder_of(files, path)) return failure;
  if (files.being_written(part) == 0 && has(files, part, bytes)) files.remove(part);
  return {};
}

/// Without a moment in which the names are swapped: somebody may come between the look and the new name.
FileFailure put_in_place_if_expected(const FileLayer& files, const std::string& part, const std::string& path,
                                     const std::optional<std::string>& expected) {
  std::string there;
  const int error = files.read(path, expected ? expected->size() : 0, there);
  const bool is_as_expected = expected ? error == 0 && there == *expected : error == ENOENT;
  if (!is_as_expected) {
    files.remove(part);
    return changed_by_others(path);
  }
  if (const int not_named = files.rename(part, path)) return {"cannot be replaced", path, not_named};
  return sync_folder_of(files, path);
}

}  // namespace

std::string part_of(const std::string& path) {
  return path + ".inbetween-part";
}

FileFailure replace_durably(const FileLayer& files, const std::string& path, std::string_view bytes) {
  const std::string part = part_of(path);
  if (FileFailure failure = write_part(files, part, path, bytes)) return failure;
  if (const int error = files.rename(part, path)) return {"cannot be replaced", path, error};
  return sync_folder_of(files, path);
}

FileFailure replace_expected(const FileLayer& files, const std::string& path,
                             const std::optional<std::string>& expected, std::string_view bytes) {
  const std::string part = part_of(path);
  if (FileFailure failure = write_part(files, part, path, bytes)) return failure;
  const int error = expected ? files.swap(part, path) : files.rename_new(part, path);
  if (error == EINVAL) return put_in_place_if_expected(files, part, path, expected);
  if (error == ENOENT || error == EEXIST) {
    files.remove(part);
    return changed_by_others(path);
  }
  if (error != 0) return {"cannot be replaced", path, error};
  if (FileFailure failure = sync_folder_of(files, path)) return failure;
  if (!expected) return {};
  // Also who has opened the old file and has not written it yet would write into what is removed here.
  const bool is_busy = files.being_written(part) == ETXTBSY;
  if (is_busy || !has(files, part, *expected)) {
    if (FileFailure failure = put_back(files, part, path, bytes)) return failure;
    if (is_busy) return {"is being written by another program", path, ETXTBSY};
    return changed_by_others(path);
  }
  files.remove(part);  // where this fails, it is in the way of nobody
  return {};
}

FileFailure make_folders(const FileLayer& files, const std::string& folder) {
  std::filesystem::path made;
  for (const std::filesystem::path& part : std::filesystem::path(folder)) {
    made /= part;
    const int error = files.make_folder(made.string());
    if (error == EEXIST) continue;
    if (error != 0) return {"cannot be made", made.string(), error};
    const std::string above = folder_of(made.string());
    if (const int not_synced = files.sync_folder(above))
      return {"could not be made sure of", above, not_synced};
  }
  return {};
}

}  // namespace inbetween
