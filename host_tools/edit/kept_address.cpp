#include "host_tools/edit/kept_address.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "host_tools/edit/edit_session.hpp"
#include "host_tools/text/file_layer.hpp"
#include "host_tools/text/state_folder.hpp"

namespace inbetween {
namespace {

constexpr std::size_t max_bytes = 65'536;
constexpr std::size_t max_ports = 8;  // beyond them the last one is another each time

}  // namespace

std::string random_key() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("inbetween: error: the kernel gives no random numbers");
  std::string key;
  for (const unsigned char byte : bytes) key += fmt::format("{:02x}", byte);
  return key;
}

std::string file_id(const std::string& path) {
  return revision_of(path);
}

KeptAddress::KeptAddress(const std::filesystem::path& folder, std::string move)
    : path_(
          (folder / state_file_name(std::filesystem::path(move).stem().string(), move, "address")).string()),
      move_(std::move(move)) {
  const auto fail = [this](int error) {
    throw std::runtime_error(
        fmt::format("{} cannot be written: {}", path_, std::generic_category().message(error)));
  };
  if (const FileFailure failure = make_folders(system_files(), folder.string())) fail(failure.error);
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor_ < 0) fail(errno);
  try {
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      throw EditedElsewhere(
          fmt::format("{}: error: another inbetween edit has it open; go on in its page, or end it", move_));
    }
    load();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

KeptAddress::~KeptAddress() {
  ::close(descriptor_);
}

void KeptAddress::load() {
  struct stat status = {};
  if (::fstat(descriptor_, &status) != 0) throw std::system_error(errno, std::generic_category(), path_);
  const bool is_secret = status.st_uid == ::geteuid() && (status.st_mode & 0077U) == 0;
  std::string text;
  const int error = read_open_file(descriptor_, max_bytes, text);
  const nlohmann::json kept = nlohmann::json::parse(text, nullptr, false);
  const bool is_ours = is_secret && error == 0 && kept.is_object() && kept.value("move", "") == move_;
  if (is_ours) {
    key_ = kept.value("key", "");
    ports_ = kept.value("ports", std::vector<int>{});
  }
  if (key_.size() == 32) return;
  key_ = random_key();
  ports_.clear();
  ::fchmod(descriptor_, 0600);
  store();
}

void KeptAddress::store() const {
  const std::string text = nlohmann::json{{"move", move_}, {"key", key_}, {"ports", ports_}}.dump() + "\n";
  // In its place, since the lock is on it. A power cut in between costs no more than the address.
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()) ||
      ::fsync(descriptor_) != 0)
    throw std::runtime_error(
        fmt::format("{} cannot be written: {}", path_, std::generic_category().message(errno)));
}

void KeptAddress::add_port(int port) {
  if (std::ranges::count(ports_, port) > 0) return;
  if (ports_.size() == max_ports) ports_.pop_back();
  ports_.push_back(port);
  store();
}

}  // namespace inbetween
