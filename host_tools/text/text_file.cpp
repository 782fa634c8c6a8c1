#include "host_tools/text/text_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes) {
  const Place whole{path.string()};
  const auto refuse = [&](const std::string& message) { throw InputError(whole, message); };
  const auto refuse_system = [&](int error_number, std::string_view remedy) {
    refuse(fmt::format("cannot be read: {}; {}", std::generic_category().message(error_number), remedy));
  };

  std::error_code status_error;
  const auto status = std::filesystem::status(path, status_error);
  if (status.type() == std::filesystem::file_type::not_found) refuse("there is no such file; check the path");
  if (status_error) refuse_system(status_error.value(), "check the path");
  if (is_directory(status)) refuse("is a directory; name the file in it");
  if (is_regular_file(status)) {
    const auto size = std::filesystem::file_size(path);
    if (size > max_bytes) {
      refuse(fmt::format("has {} bytes, more than the {} allowed; check that it is the right file", size,
                         max_bytes));
    }
  }

  const auto close = [](std::FILE* file) { std::fclose(file); };
  const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rb"), close);
  if (!file) refuse_system(errno, "check its permissions");
  std::string text;
  std::vector<char> block(std::size_t{1} << 16U);
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), file.get())) {
    text.append(block.data(), count);
    if (text.size() > max_bytes) {
      refuse(fmt::format("goes on beyond the {} bytes allowed; check that it is the right file", max_bytes));
    }
  }
  if (std::ferror(file.get()) != 0) refuse_system(errno, "check that it is a text file");
  return text;
}

}  // namespace inbetween
