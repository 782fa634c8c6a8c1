#include "host_tools/files/file_layer.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
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

FileLayer system_files() {
  return {.read = read_file,
          .create =
              [](const std::string& path, int& descriptor) {
                return open_again_if_interrupted(
                    path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644, descriptor);
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
          .swap =
              [](const std::string& one, const std::string& other) {
                return errno_of(::renameat2(AT_FDCWD, one.c_str(), AT_FDCWD, other.c_str(), RENAME_EXCHANGE));
              },
          .remove = [](const std::string& path) { return errno_of(::unlink(path.c_str())); },
          .sync_folder = sync_folder,
          .make_folder = [](const std::string& folder) { return errno_of(::mkdir(folder.c_str(), 0755)); }};
}

namespace {

using PutInPlace = std::function<int(const std::string& part, const std::string& path)>;

/// Writes PATH.part and puts it into its place.
FileFailure write_durably(const FileLayer& files, const std::string& path, std::string_view bytes,
                          const PutInPlace& put_in_place) {
  const std::string part = path + ".part";
  int descriptor = -1;
  if (const int error = files.create(part, descriptor)) return {"cannot be written", part, error};
  // Before its first byte: what nobody may read stays so.
  if (const int error = files.inherit(path, descriptor)) {
    files.close(descriptor);
    return {"cannot be given the permissions of the old file", part, error};
  }
  const int not_written = write_all(files, descriptor, bytes);
  const int not_closed = files.close(descriptor);
  if (not_written != 0 || not_closed != 0) {
    files.remove(part);  // it is of no use, and the disk may be full
    return {"could not be written completely", part, not_written != 0 ? not_written : not_closed};
  }
  if (const int error = put_in_place(part, path)) return {"cannot be replaced", path, error};
  const std::string folder = folder_of(path);
  if (const int error = files.sync_folder(folder)) return {"could not be made sure of", folder, error};
  return {};
}

}  // namespace

FileFailure replace_durably(const FileLayer& files, const std::string& path, std::string_view bytes) {
  return write_durably(files, path, bytes, files.rename);
}

FileFailure exchange_durably(const FileLayer& files, const std::string& path, std::string_view bytes) {
  return write_durably(files, path, bytes, files.swap);
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
