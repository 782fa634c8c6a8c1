#include "host_tools/edit/launch_page.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace inbetween {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const fs::path& path) {
  throw std::runtime_error(
      fmt::format("{} cannot be written: {}", path.string(), std::generic_category().message(errno)));
}

/// An address of ours has no character that HTML would read otherwise.
std::string leading_to(const std::string& address) {
  return fmt::format(
      "<!doctype html>\n<meta charset=\"utf-8\">\n<meta name=\"referrer\" content=\"no-referrer\">\n"
      "<meta http-equiv=\"refresh\" content=\"0;url={0}\">\n<a href=\"{0}\">To the move</a>\n",
      address);
}

void write_private(const std::string& path, const std::string& text) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) cannot_write(path);
  const bool is_written = ::write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (::close(descriptor) != 0 || !is_written) cannot_write(path);
}

void remove_quietly(const fs::path& folder) {
  std::error_code ignored;
  fs::remove_all(folder, ignored);
}

}  // namespace

LaunchPage::LaunchPage(const std::string& address) {
  std::string folder = (fs::temp_directory_path() / "inbetween-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) cannot_write(folder);
  folder_ = folder;
  try {
    write_private(path(), leading_to(address));
  } catch (...) {
    remove_quietly(folder_);
    throw;
  }
}

LaunchPage::~LaunchPage() {
  remove_quietly(folder_);
}

}  // namespace inbetween
