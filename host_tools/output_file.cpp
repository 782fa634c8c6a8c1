#include "host_tools/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace inbetween {
namespace {

[[noreturn]] void fail(const std::string& name, const char* what) {
  throw std::runtime_error(
      fmt::format("{}: error: {}: {}; choose another file", name, what, std::strerror(errno)));
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

bool is_special(const std::string& name) {
  std::error_code ignored;
  const auto status = std::filesystem::status(name, ignored);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

void write_output(const std::string& name, const std::function<void(std::FILE*)>& write) {
  if (name == "-") {
    write(stdout);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) fail("standard output", "cannot be written");
    return;
  }
  // A pipe or a device is not replaced by a file of its name.
  const bool direct = is_special(name);
  const std::string written = direct ? name : fmt::format("{}.{}.part", name, ::getpid());
  std::unique_ptr<std::FILE, CloseFile> file(std::fopen(written.c_str(), "wb"));
  if (!file) fail(name, "cannot be written");
  Discard unless_kept{direct ? std::string() : written};
  write(file.get());
  const bool arrived = std::fflush(file.get()) == 0 && std::ferror(file.get()) == 0;
  if (!arrived || std::fclose(file.release()) != 0) fail(name, "could not be written completely");
  if (direct) return;
  if (std::rename(written.c_str(), name.c_str()) != 0) fail(name, "cannot be replaced");
  unless_kept.path.clear();
}

}  // namespace inbetween
