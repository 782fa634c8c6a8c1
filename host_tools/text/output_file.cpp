#include "host_tools/text/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "host_tools/text/file_layer.hpp"

namespace inbetween {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view choose_a_folder = "choose a folder that exists and that you may write to";

[[noreturn]] void fail(std::string_view name, std::string_view what, std::string_view remedy) {
  const std::string reason = std::generic_category().message(errno);
  throw std::runtime_error(fmt::format("{}: error: {}: {}; {}", name, what, reason, remedy));
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// Removes a half-written file unless it was kept.
struct Discard {
  std::string path;
  ~Discard() {
    if (!path.empty()) std::remove(path.c_str());
  }
};

/// The file that a symbolic link points to.
fs::path behind_links(fs::path file) {
  constexpr int max_links = 40;  // as many as Linux follows
  std::error_code error;
  for (int link = 0; link < max_links && fs::is_symlink(fs::symlink_status(file, error)); ++link) {
    file = file.parent_path() / fs::read_symlink(file, error);
  }
  return file;
}

void refuse_write_protected(const std::string& name) {
  errno = may_write_at(AT_FDCWD, name.c_str());
  if (errno != 0) fail(name, "is write-protected", "chmod u+w lets it be written, or choose another file");
}

/// A new file beside `target`, and its name: nobody else's is emptied.
std::FILE* create_beside(const fs::path& target, std::string& name) {
  for (int number = 1;; ++number) {
    name = fmt::format("{}.{}-{}.part", target.string(), ::getpid(), number);
    std::FILE* const file = std::fopen(name.c_str(), "wbx");
    if (file != nullptr || errno != EEXIST) return file;
  }
}

bool fill(std::FILE* file, const std::function<void(std::FILE*)>& write) {
  write(file);
  return std::fflush(file) == 0 && std::ferror(file) == 0;
}

/// Opening a FIFO would wait for a reader: where there is none it is refused. A reader may take its time.
std::FILE* open_special(const std::string& name) {
  const int file = ::open(name.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0 && errno == ENXIO)
    fail(name, "nobody reads it", "start its reader first, or choose another file");
  if (file < 0) return nullptr;
  const int flags = ::fcntl(file, F_GETFL);
  if (flags < 0 || ::fcntl(file, F_SETFL, flags & ~O_NONBLOCK) != 0) {
    ::close(file);
    return nullptr;
  }
  return ::fdopen(file, "wb");
}

/// Until the program ends: a reader that sees its FIFO closed goes away.
void hold_open(const std::string& name) {
  static std::vector<std::unique_ptr<std::FILE, CloseFile>> held;
  held.emplace_back(open_special(name));
}

void write_directly(const std::string& name, const std::function<void(std::FILE*)>& write) {
  std::unique_ptr<std::FILE, CloseFile> file(open_special(name));
  if (!file) fail(name, "cannot be written", "choose another file");
  if (!fill(file.get(), write) || std::fclose(file.release()) != 0) {
    fail(name, "could not be written completely", "choose another file");
  }
}

}  // namespace

bool is_special(const std::string& name) {
  std::error_code ignored;
  const fs::file_status status = fs::status(name, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

void write_output(const std::string& name, const std::function<void(std::FILE*)>& write) {
  if (name == "-") {
    write(stdout);
    check_standard_output();
    return;
  }
  if (is_special(name)) {
    write_directly(name, write);
    return;
  }
  const fs::path target = behind_links(name);
  refuse_write_protected(target.string());
  std::string written;
  std::unique_ptr<std::FILE, CloseFile> file(create_beside(target, written));
  if (!file) fail(name, "cannot be written", choose_a_folder);
  Discard unless_kept{written};
  if (!fill(file.get(), write) || std::fclose(file.release()) != 0) {
    fail(name, "could not be written completely", "make room or choose another disk");
  }
  std::error_code error;
  if (fs::exists(target, error)) fs::permissions(written, fs::status(target).permissions(), error);
  if (std::rename(written.c_str(), target.c_str()) != 0) fail(name, "cannot be replaced", choose_a_folder);
  unless_kept.path.clear();
}

void check_output(const std::string& name) {
  if (name == "-") return;
  std::error_code error;
  if (fs::is_directory(name, error)) {
    errno = EISDIR;
    fail(name, "cannot be written", "choose another file");
  }
  if (is_special(name)) {
    if (::access(name.c_str(), W_OK) != 0) fail(name, "cannot be written", "choose another file");
    if (fs::is_fifo(name, error)) hold_open(name);
    return;
  }
  refuse_write_protected(name);
  const fs::path folder = behind_links(name).parent_path();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) != 0) {
    fail(name, "cannot be written", choose_a_folder);
  }
}

void check_standard_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    fail("standard output", "cannot be written", "redirect it to another file");
  }
}

}  // namespace inbetween
