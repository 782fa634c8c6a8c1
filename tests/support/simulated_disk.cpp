#include "tests/support/simulated_disk.hpp"

#include <cerrno>

namespace inbetween {

SimulatedDisk::SimulatedDisk(const DiskContent& content) {
  for (const auto& [path, bytes] : content) {
    now_[path] = files_.size();
    files_.push_back({bytes, bytes, true});
  }
  safe_ = now_;
}

void SimulatedDisk::fail_at(std::size_t operation, int error, bool for_good) {
  fail_at_ = operation;
  error_ = error;
  fails_for_good_ = for_good;
}

/// An operation begins: cut off, failing, or 0.
int SimulatedDisk::step() {
  const std::size_t operation = operations_++;
  if (cut_at_ && operation >= *cut_at_) throw PowerCut{};
  if (fail_at_ && (operation == *fail_at_ || (fails_for_good_ && operation > *fail_at_))) return error_;
  return 0;
}

void SimulatedDisk::apply(const Change& change, Folder& folder) {
  if (!change.removed.empty()) folder.erase(change.removed);
  for (const auto& [name, file] : change.named) folder[name] = file;
}

FileLayer SimulatedDisk::layer() {
  FileLayer layer;
  layer.read = [this](const std::string& path, std::size_t most, std::string& bytes) {
    const auto found = now_.find(path);
    if (found == now_.end()) return ENOENT;
    bytes = files_[found->second].now;
    return bytes.size() > most ? EFBIG : 0;
  };
  layer.create = [this](const std::string& path, int& descriptor) {
    if (const int error = step()) return error;
    if (now_.contains(path)) return EEXIST;
    descriptor = static_cast<int>(files_.size());
    changes_.push_back({"", {{path, files_.size()}}});
    apply(changes_.back(), now_);
    files_.emplace_back();
    return 0;
  };
  layer.may_write = [](const std::string& /*path*/) { return 0; };
  layer.being_written = [](const std::string& /*path*/) { return 0; };
  layer.inherit = [this](const std::string& /*path*/, int /*descriptor*/) { return step(); };
  layer.write = [this](int descriptor, std::string_view bytes, std::size_t& written) {
    File& file = files_.at(static_cast<std::size_t>(descriptor));
    if (const int error = step()) return error;
    for (written = 0; written < bytes.size(); ++written) {
      // A disk that fills up takes what still fits.
      if (const int error = step()) return written > 0 ? 0 : error;
      file.now += bytes[written];
      file.synced = false;
    }
    return 0;
  };
  layer.sync = [this](int descriptor) {
    if (const int error = step()) return error;
    File& file = files_.at(static_cast<std::size_t>(descriptor));
    file.safe = file.now;
    file.synced = true;
    return 0;
  };
  layer.close = [this](int /*descriptor*/) { return step(); };
  layer.rename = [this](const std::string& from, const std::string& to) {
    if (const int error = step()) return error;
    const auto found = now_.find(from);
    if (found == now_.end()) return ENOENT;
    changes_.push_back({from, {{to, found->second}}});
    apply(changes_.back(), now_);
    return 0;
  };
  layer.rename_new = [this, rename = layer.rename](const std::string& from, const std::string& to) {
    return now_.contains(to) ? EEXIST : rename(from, to);
  };
  layer.swap = [this](const std::string& one, const std::string& other) {
    if (const int error = step()) return error;
    const auto first = now_.find(one);
    const auto second = now_.find(other);
    if (first == now_.end() || second == now_.end()) return ENOENT;
    changes_.push_back({"", {{one, second->second}, {other, first->second}}});
    apply(changes_.back(), now_);
    return 0;
  };
  layer.remove = [this](const std::string& path) {
    if (const int error = step()) return error;
    if (!now_.contains(path)) return ENOENT;
    changes_.push_back({path, {}});
    apply(changes_.back(), now_);
    return 0;
  };
  layer.sync_folder = [this](const std::string& /*folder*/) {
    if (const int error = step()) return error;
    safe_ = now_;
    changes_.clear();
    return 0;
  };
  layer.make_folder = [](const std::string& /*folder*/) { return EEXIST; };
  return layer;
}

/// What a file that was not synced may have: its old bytes, the new ones up to any byte, those with the old
/// end behind them, and as many zeros, where only its length has reached the disk.
std::vector<std::string> SimulatedDisk::possible_bytes(const File& file) {
  if (file.synced) return {file.safe};
  std::vector<std::string> possible = {file.safe, std::string(file.now.size(), '\0')};
  for (std::size_t kept = 0; kept <= file.now.size(); ++kept) {
    possible.push_back(file.now.substr(0, kept));
    if (kept < file.safe.size()) possible.push_back(file.now.substr(0, kept) + file.safe.substr(kept));
  }
  return possible;
}

std::set<std::optional<std::string>> SimulatedDisk::after_power_cut(const std::string& path) const {
  std::set<std::optional<std::string>> possible;
  for (std::size_t kept = 0; kept < (std::size_t{1} << changes_.size()); ++kept) {
    Folder folder = safe_;
    for (std::size_t i = 0; i < changes_.size(); ++i) {
      if (((kept >> i) & 1U) != 0) apply(changes_[i], folder);
    }
    const auto found = folder.find(path);
    if (found == folder.end()) {
      possible.insert(std::nullopt);
    } else {
      for (const std::string& bytes : possible_bytes(files_[found->second])) possible.insert(bytes);
    }
  }
  return possible;
}

DiskContent SimulatedDisk::content() const {
  DiskContent content;
  for (const auto& [path, file] : now_) content[path] = files_[file].now;
  return content;
}

}  // namespace inbetween
