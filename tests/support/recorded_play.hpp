// What a playhead does, tick by tick, and whether every axis stays within what a stop may ask of it.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/planned_stops.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

/// Records the setpoints of a playhead before rounding and differentiates them again: the second difference
/// over a tick squared is a mean of the acceleration, the third over its cube one of the jerk, so that
/// neither may be above its limit, whatever happens between ticks.
class RecordedPlay {
 public:
  RecordedPlay(const Plan& plan, const StopBounds& bounds, double tick_s);

  /// Where the certificate lists a step of the acceleration there may be one: no jerk is compared across it.
  void allow_steps_of(const CheckReport& report) {
    for (const CheckedStep& step : report.steps) steps_.push_back(step.frame);
  }
  /// Takes the place of the playhead after a tick (or before the first).
  void take(const Playhead& playhead);
  /// Forgets the setpoints so far: the next is not compared with them.
  void restart() { count_ = 0; }
  /// Across a step that was allowed, how often the jerk was above its limit.
  [[nodiscard]] int excused() const { return excused_; }
  /// The first thing that was wrong; "" so far.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }
  /// As a share of its stop limit, the largest acceleration and jerk so far.
  [[nodiscard]] double acceleration_share() const { return acceleration_share_; }
  [[nodiscard]] double jerk_share() const { return jerk_share_; }

 private:
  [[nodiscard]] bool is_across_step() const;
  void compare(std::size_t axis, const Playhead& playhead);
  void complain(const std::string& words, const Playhead& playhead);

  const Plan& plan_;
  const StopBounds& bounds_;
  double tick_s_;
  std::vector<double> sizes_;                     ///< of the positions, for their rounding
  std::array<std::vector<double>, 4> positions_;  ///< of the last four ticks, newest first
  std::array<double, 4> frames_{};                ///< and where the playhead was
  std::vector<double> steps_;
  int excused_ = 0;
  int count_ = 0;
  std::string complaint_;
  std::string before_;
  double acceleration_share_ = 0;
  double jerk_share_ = 0;
};

}  // namespace inbetween
