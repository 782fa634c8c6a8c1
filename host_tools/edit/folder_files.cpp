#include "host_tools/edit/folder_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace inbetween {
namespace {

/// Closes itself with the last operation that holds it.
class OpenFolder {
 public:
  explicit OpenFolder(const std::string& path)
      : descriptor_(::open(path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0) refuse(path);
    int probe = -1;
    if (open(".", O_RDONLY | O_DIRECTORY, 0, probe) != 0) refuse(path);
    ::close(probe);
  }
  ~OpenFolder() { ::close(descriptor_); }
  OpenFolder(const OpenFolder&) = delete;
  OpenFolder& operator=(const OpenFolder&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] int open(const std::string& name, int flags, mode_t mode, int& descriptor) const {
    struct open_how how = {};
    how.flags = static_cast<decltype(how.flags)>(flags | O_CLOEXEC);
    how.mode = mode;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
    do {
      descriptor = static_cast<int>(::syscall(SYS_openat2, descriptor_, name.c_str(), &how, sizeof how));
    } while (descriptor < 0 && (errno == EINTR || errno == EAGAIN));
    return descriptor < 0 ? errno : 0;
  }

 private:
  [[noreturn]] static void refuse(const std::string& path) {
    const int error = errno;
    const char* remedy = error == ENOSYS ? "the editor needs Linux 5.6 or later" : "check its permissions";
    throw std::runtime_error(fmt::format("{}: error: the folder cannot be opened: {}; {}", path,
                                         std::generic_category().message(error), remedy));
  }

  int descriptor_;
};

/// A name without a folder, so that renaming stays where opening does.
bool is_plain(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos;
}

}  // namespace

FileLayer files_beneath(const std::string& folder) {
  const auto opened = std::make_shared<const OpenFolder>(folder);
  FileLayer files = system_files();
  files.read = [opened](const std::string& name, std::size_t max_bytes, std::string& bytes) {
    bytes.clear();
    int descriptor = -1;
    if (const int error = opened->open(name, O_RDONLY | O_NONBLOCK, 0, descriptor)) return error;
    const int error = read_open_file(descriptor, max_bytes, bytes);
    ::close(descriptor);
    return error;
  };
  files.create = [opened](const std::string& name, int& descriptor) {
    return opened->open(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0644, descriptor);
  };
  files.may_write = [opened](const std::string& name) {
    return is_plain(name) ? may_write_at(opened->descriptor(), name.c_str()) : EXDEV;
  };
  files.being_written = [opened](const std::string& name) {
    int descriptor = -1;
    if (const int error = opened->open(name, O_RDONLY | O_NONBLOCK, 0, descriptor)) return error;
    const int error = being_written(descriptor);
    ::close(descriptor);
    return error;
  };
  files.inherit = [opened](const std::string& name, int descriptor) {
    struct stat status = {};
    if (::fstatat(opened->descriptor(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
      return errno == ENOENT ? 0 : errno;
    return inherit_from(status, descriptor);
  };
  files.rename = [opened](const std::string& from, const std::string& to) {
    if (!is_plain(from) || !is_plain(to)) return EXDEV;
    return errno_of(::renameat(opened->descriptor(), from.c_str(), opened->descriptor(), to.c_str()));
  };
  files.rename_new = [opened](const std::string& from, const std::string& to) {
    if (!is_plain(from) || !is_plain(to)) return EXDEV;
    return errno_of(
        ::renameat2(opened->descriptor(), from.c_str(), opened->descriptor(), to.c_str(), RENAME_NOREPLACE));
  };
  files.swap = [opened](const std::string& one, const std::string& other) {
    if (!is_plain(one) || !is_plain(other)) return EXDEV;
    return errno_of(
        ::renameat2(opened->descriptor(), one.c_str(), opened->descriptor(), other.c_str(), RENAME_EXCHANGE));
  };
  files.remove = [opened](const std::string& name) {
    return is_plain(name) ? errno_of(::unlinkat(opened->descriptor(), name.c_str(), 0)) : EXDEV;
  };
  files.sync_folder = [opened](const std::string& name) {
    int descriptor = -1;
    if (const int error = opened->open(name, O_RDONLY | O_DIRECTORY, 0, descriptor)) return error;
    const int error = errno_of(::fsync(descriptor));
    ::close(descriptor);
    return error;
  };
  files.make_folder = [](const std::string&) { return EPERM; };
  return files;
}

}  // namespace inbetween
