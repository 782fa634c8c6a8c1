// Which axes of a rig know where they are, and what is kept of that from one run to the next.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/reference/position_file.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/file_layer.hpp"
#include "inbetween/loop/ports.hpp"

namespace inbetween {

/// The axes whose reference is not their drive, from what the position file says at the beginning to what is
/// written into it at the end. Axes that their drives know are none of its business and always referenced.
///
/// A drive on a bus tells its place, but most forget turns without power. So its axis keeps its place from
/// one program to the next only if the drive tells the same place as before. How the drive counts is kept
/// beside the place, and the drive's own count goes on: a small difference, as of an axis that has sunk onto
/// its brake, is what really happened.
///
/// Without a file, which is for simulated rigs, every axis is referenced where it stands and nothing is kept.
/// Refers to the rig. What writes throws std::runtime_error, one line: see PositionFile. Not for the loop's
/// thread, because a disk takes its time.
class RigReference {
 public:
  explicit RigReference(const RigFile& rig) : rig_(rig), axes_(rig.axes.size()) {}
  RigReference(const RigFile& rig, std::string file, FileLayer files = system_files());

  /// The position at which an axis rests, if it is known.
  [[nodiscard]] std::optional<double> position(std::size_t axis) const { return axes_[axis].position; }
  /// The same as its drive counts it.
  [[nodiscard]] std::optional<double> counted_position(std::size_t axis) const;
  /// Tells the drives where their axes rest, or from where they count. Before they are switched on.
  void place(RigDrives& drives) const;
  /// The drives are on and have told these positions. Throws InputError at the place of an axis that was left
  /// elsewhere by what its drive tells: the drive has forgotten turns, or the axis was moved. Nobody knows
  /// where it is until somebody says it. Of the others it is kept how their drives count.
  void compare(const RigDrives& drives, std::span<const double> positions);

  [[nodiscard]] bool is_referenced(std::size_t axis) const { return axes_[axis].why.empty(); }
  /// Throws InputError at the place of the first of `axes` that is unreferenced, with why and what to do.
  void refuse_unreferenced(std::span<const std::size_t> axes) const;

  /// Before any of `axes` moves; those that are under way already are passed over. If it throws, nothing may
  /// move.
  void about_to_move(std::span<const std::size_t> axes);
  /// The axes that were to move rest where their drives tell. An axis that was referenced stays so, unless
  /// it has lost its steps, its drive is out of reach, or its motor was without power (`power_was_cut`) and
  /// nothing reports where it went. What has not moved stays as it is.
  void at_rest(const RigDrives& drives, std::span<const DriveState> states, bool power_was_cut);
  /// The drives are switched off again. An axis whose drive has started anew since it was placed is lost,
  /// also if it was not to move.
  void forget_restarted(const RigDrives& drives);

  /// Somebody says where an axis rests, or its switch has told. Throws std::logic_error for an axis that
  /// its drive knows.
  void stands_at(std::size_t axis, double position);
  /// Nobody knows where an axis rests. The same.
  void is_lost(std::size_t axis, const std::string& why);

 private:
  friend RigReference reference_of(const RigFile& rig, const std::optional<std::string>& file,
                                   bool is_simulated);
  struct Axis {
    std::optional<double> position = {};
    std::vector<double> zeros = {};  ///< KeptAxis::zeros
    std::string why = {};            ///< it is unreferenced
    bool moves = false;
  };
  [[nodiscard]] bool is_kept(std::size_t axis) const;
  /// Its drive tells where it is, and nothing proves that.
  [[nodiscard]] bool is_told(std::size_t axis) const;
  void refuse_if_elsewhere(std::size_t axis, double told);
  void keep(std::span<const PositionFile::Rest> rests);

  const RigFile& rig_;
  std::unique_ptr<InstanceLock> lock_;
  std::optional<PositionFile> file_;
  std::vector<Axis> axes_;
};

/// The reference of a rig that is used as a command says: in the file that is named, else in its usual one,
/// and in a simulation nowhere. A rig whose drives all know where they are needs no file. The file is locked
/// for as long as the reference is there; throws InputError where another program has it.
RigReference reference_of(const RigFile& rig, const std::optional<std::string>& file, bool is_simulated);

}  // namespace inbetween
