#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "inbetween/can/servo_report.hpp"

/// Whether a drive that takes positions in one scale and tells them in another moves as far as it is told.

namespace inbetween::can {

/// The drive lags behind what it is told, and nobody knows by how much. So every lag of up to 32 ms is
/// tried, in steps of 4 ms: with one of them the axis has been where it was told to be in every tick since
/// its first motion, but for the noise of its encoder, a share of the distance, and what a ramp of its own
/// takes to brake. If none is left, it is the scale that is wrong. Beyond `proof_turns` the scale is known,
/// and nothing is judged any more: the following error looks after the axis. Positions in turns; 104 bytes,
/// O(1).
class ScaleWatch {
 public:
  struct Settings {
    double noise_turns = 0;
    double proof_turns = 0;
    double ramp_turns_per_s2 = 0;  ///< by which it goes from target to target
  };

  void begin() { *this = {}; }
  /// Is called in every tick that has a target. The drive has told `place_turns` in this tick if it `is_new`.
  void look(const Settings& settings, double place_turns, bool is_new, const ServoTarget& told,
            std::int64_t now_ns) {
    constexpr std::int64_t apart_ns = 4'000'000;
    if (!has_begun_) {
      has_begun_ = true;
      first_place_ = place_turns;
      told_.fill(told.turns);
      first_told_ = told.turns;
      shifted_ns_ = now_ns;
    }
    told_[0] = told.turns;
    distance_ = std::max(distance_, std::fabs(told.turns - first_told_));
    turns_per_s_ = std::max(turns_per_s_, std::fabs(told.turns_per_s));
    if (is_new && !is_proven_) judge(settings, place_turns - first_place_);
    if (now_ns - shifted_ns_ < apart_ns) return;
    shifted_ns_ = now_ns;
    std::shift_right(told_.begin(), told_.end(), 1);
  }
  [[nodiscard]] bool differs() const { return possible_ == 0; }

 private:
  static constexpr std::size_t lags = 8;

  void judge(const Settings& settings, double distance) {
    constexpr double share = 0.01;
    const double braking = turns_per_s_ * turns_per_s_ / (2 * settings.ramp_turns_per_s2);
    const double allowed = settings.noise_turns + share * distance_ + braking;
    for (std::size_t i = 0; i < lags; ++i) {
      const double least = std::min(told_[i], told_[i + 1]) - first_told_;
      const double most = std::max(told_[i], told_[i + 1]) - first_told_;
      if (distance < least - allowed || distance > most + allowed) possible_ &= ~(1U << i);
    }
    is_proven_ = possible_ != 0 && std::fabs(distance) > settings.proof_turns;
  }

  bool has_begun_ = false;
  bool is_proven_ = false;
  std::uint32_t possible_ = (1U << lags) - 1;  ///< a bit for each lag
  double first_place_ = 0;
  double first_told_ = 0;
  double distance_ = 0;                  ///< the longest that it was told
  double turns_per_s_ = 0;               ///< the fastest
  std::array<double, lags + 1> told_{};  ///< now, and before
  std::int64_t shifted_ns_ = 0;
};

}  // namespace inbetween::can
