// A disk without a disk, whose power can be cut at any operation and at any byte.
//
// It promises no more than POSIX does: bytes are kept once their file has been synced, names once their
// folder has been. Until then each may be kept or lost on its own, in any order.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/file_layer.hpp"

namespace inbetween {

/// Thrown by the operation at which the power is cut.
struct PowerCut {};

/// What is on a disk: the bytes of each file by its path.
using DiskContent = std::map<std::string, std::string>;

class SimulatedDisk {
 public:
  explicit SimulatedDisk(const DiskContent& content = {});

  SimulatedDisk(const SimulatedDisk&) = delete;
  SimulatedDisk& operator=(const SimulatedDisk&) = delete;

  /// Its operations, as long as it lasts.
  FileLayer layer();

  /// Operations so far; a write of n bytes is n of them, and one more.
  [[nodiscard]] std::size_t operations() const { return operations_; }
  /// The operation of that number does not happen any more, nor any after it: it throws PowerCut.
  void cut_power_at(std::size_t operation) { cut_at_ = operation; }
  /// The call during which that operation would happen fails with `error`, and so does every call after it,
  /// or only this one.
  void fail_at(std::size_t operation, int error, bool for_good);

  /// Everything that may be in a file if the power is cut now; nothing where the file is not there.
  [[nodiscard]] std::set<std::optional<std::string>> after_power_cut(const std::string& path) const;
  /// As programs see it.
  [[nodiscard]] DiskContent content() const;

 private:
  struct File {
    std::string safe;  // as of its last sync
    std::string now;
    bool synced = true;
  };
  using Folder = std::map<std::string, std::size_t>;
  /// A change of names in the folder that has not been synced.
  struct Change {
    std::string removed;  // empty: none
    Folder named;
  };

  int step();
  static void apply(const Change& change, Folder& folder);
  [[nodiscard]] static std::vector<std::string> possible_bytes(const File& file);

  std::vector<File> files_;
  Folder safe_;
  Folder now_;
  std::vector<Change> changes_;
  std::size_t operations_ = 0;
  std::optional<std::size_t> cut_at_;
  std::optional<std::size_t> fail_at_;
  int error_ = 0;
  bool fails_for_good_ = false;
};

}  // namespace inbetween
