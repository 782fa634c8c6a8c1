// The transit of some axes of a rig to other positions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/loop/motion_loop.hpp"
#include "inbetween/play/free_axis.hpp"

namespace inbetween {

/// "bring it in with inbetween goto --rig RIG AXIS=LIMIT", of an axis that stands beyond one of its limits;
/// SessionOptions::as_arguments stand behind RIG.
std::string remedy_outside(const RigFile& rig, std::size_t axis, double position,
                           const std::string& as_arguments);

/// The usual share of the limits of velocity, acceleration and jerk that a transit may use.
inline constexpr double transit_share = 0.1;

/// The position to which an axis of the rig is to go.
struct GoTarget {
  std::size_t axis = 0;
  double position = 0;
};

/// A FreeSource: all axes go together on a straight line, from rest to rest, as quickly as `share` of the
/// limits of each allows. A stop on the way keeps to the line, and may use the stop limits of the rig. An
/// axis that stands outside its limits comes in by the shortest line. Refers to the rig. Allocates only when
/// it is made.
class Transit {
 public:
  /// From `actual`, a position for every axis of the rig. Throws InputError at the rig where the axes cannot
  /// be moved so.
  Transit(const RigFile& rig, std::span<const GoTarget> targets, std::span<const double> actual,
          double share);
  Transit(const Transit&) = delete;
  Transit& operator=(const Transit&) = delete;

  void tick(std::int64_t now_ns, std::span<Setpoint> out);
  void stop() { along_.stop(); }
  void halt() { along_.halt(); }
  [[nodiscard]] bool is_resting() const { return along_.is_resting(); }

  [[nodiscard]] FreeSpec loop_spec();
  [[nodiscard]] std::span<const std::size_t> axes() const { return axes_; }
  /// Until it rests at its end.
  [[nodiscard]] std::int64_t ticks() const { return ticks_; }
  /// For somebody who has to agree: what moves from where to where, and how long it takes. Lines, the first
  /// of them `title`, without a newline at the end.
  [[nodiscard]] std::string describe(const std::string& title) const;

 private:
  const RigFile& rig_;
  double share_;
  std::vector<std::size_t> axes_;
  std::vector<AxisLimits> limits_;
  std::vector<double> from_, to_;
  FreeAxis along_;  ///< from 0, where every axis is at `from_`, to 1
  std::int64_t ticks_ = 0;
};

}  // namespace inbetween
