#include "host_tools/takes/database_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace inbetween {
namespace {

namespace fs = std::filesystem;

/// The write-ahead log, or the journal of the transaction that made the database. SQLite looks for either.
constexpr std::array<const char*, 2> log_suffixes = {"-wal", "-journal"};

std::string without_links(const std::string& file) {
  std::error_code unknown;
  const fs::path path = fs::weakly_canonical(file, unknown);
  return unknown ? file : path.string();
}

bool has_content(const std::string& file) {
  std::error_code none;
  const std::uintmax_t size = fs::file_size(file, none);
  return !none && size > 0;
}

}  // namespace

std::string address_of_database(const std::string& file) {
  std::string address = fs::path(file).is_absolute() ? "file://" : "file:";
  for (const char letter : file) {
    if (letter == '%' || letter == '?' || letter == '#') {
      address += fmt::format("%{:02x}", static_cast<int>(letter));
    } else {
      address += letter;
    }
  }
  return address;
}

std::error_code refusal_beside(const std::string& file) {
  const std::string folder = fs::path(without_links(file)).parent_path();
  return ::access(folder.c_str(), W_OK) == 0 ? std::error_code()
                                             : std::error_code(errno, std::generic_category());
}

bool has_database_log(const std::string& file) {
  const std::string place = without_links(file);
  return std::ranges::any_of(log_suffixes, [&](const char* suffix) { return has_content(place + suffix); });
}

DatabaseCopy::DatabaseCopy(const std::string& file) {
  std::string folder = (fs::temp_directory_path() / "inbetween-takes-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) throw std::system_error(errno, std::generic_category());
  folder_ = folder;
  const std::string place = without_links(file);
  std::error_code error;
  fs::copy_file(place, path(), error);
  for (const char* suffix : log_suffixes) {
    if (!error && has_content(place + suffix)) fs::copy_file(place + suffix, path() + suffix, error);
  }
  if (!error) return;
  std::error_code ignored;  // the first error is the one to tell
  fs::remove_all(folder_, ignored);
  throw std::system_error(error);
}

DatabaseCopy::~DatabaseCopy() {
  std::error_code ignored;  // a destructor has nobody to tell
  fs::remove_all(folder_, ignored);
}

}  // namespace inbetween
