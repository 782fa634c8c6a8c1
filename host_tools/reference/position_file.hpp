// A file keeps where open-loop axes rest, from one run to the next.
//
// Nothing reports where a stepper or a hobby servo is, so this program remembers it: before an axis moves,
// the file says that it moves, and after it has come to rest, where. Both are on the disk, not only on their
// way to it, when the call returns. So after a power cut an axis is where the file says, or the file does not
// know. It never guesses, and never takes 0 for a position.
//
// The file cannot know that an axis was moved by hand, that a stepper has fallen into its nearest full
// step when its current went, and that the same motors have been moved by way of a rig of another name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/linux/instance_lock.hpp"
#include "host_tools/reference/position_text.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/file_layer.hpp"

namespace inbetween {

/// The axes of `rig` whose reference is not their drive, as indices, in its order.
std::vector<std::size_t> kept_axes(const RigFile& rig);

/// A hash of all that the kept positions depend on: names, units, drives with their addresses and scales, and
/// home switches. Limits may change without a loss of position.
std::uint64_t position_identity(const RigFile& rig);

/// The file of the positions of a rig, by its name alone: a rig that is changed and changed back finds
/// what was written in between. $XDG_STATE_HOME/inbetween/NAME-HASH.positions, or without an absolute
/// XDG_STATE_HOME (or nullptr) $HOME/.local/state/inbetween/... (XDG Base Directory Specification 0.8).
/// Throws std::runtime_error if there is neither.
std::string position_file_path(const std::string& rig_name, const char* xdg_state_home, const char* home);

/// The usual file of a rig in this process's environment.
std::string usual_position_file(const RigFile& rig);

/// One program at a time reads a file and writes it, whatever name it has it by. Held from before the file is
/// read until its axes move no more. Throws InputError where another program has it.
std::unique_ptr<InstanceLock> lock_positions(const std::string& path);

/// A kept axis, with its position if it is known.
struct KnownAxis {
  std::size_t axis = 0;            // of the rig
  std::optional<double> position;  // at rest, in the unit of the axis; absent: unreferenced
  std::vector<double> zeros;       // KeptAxis::zeros
  std::string why;                 // it is unreferenced, in words; otherwise empty
};

/// The positions of one rig. Writing throws std::runtime_error, one line that starts with the name of the
/// file and says what to do. Whoever has one that other programs could have too holds its lock.
class PositionFile {
 public:
  /// Reads the file. A file that is missing, unreadable, damaged, or of another rig leaves every axis
  /// unreferenced; nothing is thrown and nothing is written.
  PositionFile(std::string path, const RigFile& rig, FileLayer files = system_files());

  [[nodiscard]] const std::string& path() const { return path_; }
  /// The kept axes as they are known now.
  [[nodiscard]] const std::vector<KnownAxis>& axes() const { return known_; }

  /// Before any of `axes` (of the rig; those that are not kept are passed over) moves. If it throws, nothing
  /// may move.
  void about_to_move(std::span<const std::size_t> axes);

  /// The position at which axis `axis` rests now, or std::nullopt if it is not known any more.
  struct Rest {
    std::size_t axis = 0;            // of the rig, kept
    std::optional<double> position;  // finite, in the unit of the axis
    std::vector<double> zeros = {};  // KeptAxis::zeros
  };
  /// After the axes have come to rest. If it throws, the file still says that they move, or what was to be
  /// written.
  void at_rest(std::span<const Rest> rests);

 private:
  [[nodiscard]] std::string why_not(const KeptPositions& kept) const;
  void write(const KeptPositions& kept);

  std::string path_;
  FileLayer files_;
  KeptPositions kept_;
  std::vector<KnownAxis> known_;
};

}  // namespace inbetween
