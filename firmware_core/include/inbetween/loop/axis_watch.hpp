#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "inbetween/base/precision.hpp"
#include "inbetween/loop/ports.hpp"

/// A motor against what it was told: whether it has arrived, whether it moves, and whether it gets away from
/// its own drive after a following error.

namespace inbetween {

/// The bounds that a motor must keep, in its unit and seconds. All but the ends of its range are above 0.
struct WatchBounds {
  double min = 0;
  double max = 0;
  double max_velocity = 0;
  double stop_acceleration = 0;
  double max_following_error = 0;
  double in_position = 0;  ///< no further from its target than this it has arrived
  double rest = 0;         ///< it rests where it has not gone further than this in 25 to 50 ms
};

/// In every tick look() takes what the motor tells, and then tell() takes what it is told. Every call is O(1)
/// and allocates nothing.
class AxisWatch {
 public:
  explicit AxisWatch(const WatchBounds& bounds) : bounds_(bounds) {}

  /// The drives are switched on anew.
  void reset() { *this = AxisWatch(bounds_); }

  void look(double actual, std::int64_t now_ns) {
    actual_ = actual;
    now_ns_ = now_ns;
    long_.look({actual, now_ns}, 25'000'000);
    short_.look({actual, now_ns}, 8'000'000);
  }
  void tell(double target) { target_ = target; }
  /// It is told nothing any more.
  void tell_nothing() { target_.reset(); }

  /// True as well where it is told nothing.
  [[nodiscard]] bool is_in_position() const {
    return !target_ || std::fabs(actual_ - *target_) <= bounds_.in_position;
  }
  /// Its mean speed in the last 25 to 50 ms.
  [[nodiscard]] double speed() const { return speed_since(long_.before); }
  /// It has gone further than it may at rest, and is not just coming to rest: what brakes was faster before.
  [[nodiscard]] bool moves() const {
    constexpr double goes_on = 0.6;
    return long_.before && std::fabs(actual_ - long_.before->place) > bounds_.rest &&
           speed_since(short_.before) > goes_on * speed();
  }

  /// Its own drive is to stop it from now on.
  void begin_stop() {
    const double velocity = std::min(speed(), bounds_.max_velocity);
    const double target = target_.value_or(actual_);
    stop_ =
        Stop{.target = target,
             .place = actual_,
             .reach = std::fabs(actual_ - target) + velocity * velocity / (2 * bounds_.stop_acceleration) +
                      bounds_.max_following_error};
  }
  /// It goes on where its drive was to stop it: further from the target that it had then than it was, by more
  /// than braking takes and a following error; or out of its range. What stands still while its path goes on
  /// does neither.
  [[nodiscard]] bool gets_away() const {
    if (!stop_) return false;
    const bool is_outside = actual_ > std::max(bounds_.max, stop_->place) + bounds_.in_position ||
                            actual_ < std::min(bounds_.min, stop_->place) - bounds_.in_position;
    return is_outside || std::fabs(actual_ - stop_->target) > stop_->reach;
  }

 private:
  struct Look {
    double place;
    std::int64_t at_ns;
  };
  /// Remembers where the motor was at least `apart_ns` ago, and at most twice as long ago.
  struct Before {
    std::optional<Look> before, latest;
    void look(const Look& now, std::int64_t apart_ns) {
      if (!latest) before = latest = now;
      if (now.at_ns - latest->at_ns < apart_ns) return;
      before = latest;
      latest = now;
    }
  };
  [[nodiscard]] double speed_since(const std::optional<Look>& from) const {
    if (!from || now_ns_ <= from->at_ns) return 0;
    return std::fabs(actual_ - from->place) / (static_cast<double>(now_ns_ - from->at_ns) * 1e-9);
  }
  struct Stop {
    double target;
    double place;
    double reach;
  };

  WatchBounds bounds_;
  double actual_ = 0;
  std::int64_t now_ns_ = 0;
  Before long_, short_;
  std::optional<double> target_;
  std::optional<Stop> stop_;
};

}  // namespace inbetween
