#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "inbetween/play/free_axis.hpp"
#include "tests/support/property.hpp"

/// Commands in any order at any tick: what comes out is differentiated again here, and held against the
/// limits.

namespace inbetween {
namespace free_axis_property_test {

constexpr int many_sequences = 2000;
constexpr int commanded_ticks = 600;
/// Last bits of a position that hundreds of commands, each of which begins from a rounded state, may cost.
constexpr int grains = 512;

struct Axis {
  FreeAxisLimits limits;
  double tick_s = 0;
  FreeAxis axis;
};

/// Scales from micrometres to kilometres, from sluggish to sharp, and rates from 50 Hz to 4 kHz.
Axis any_axis() {
  const double unit = std::pow(10.0, static_cast<double>(*rc::gen::inRange(-3, 4)));
  const auto number = [](int low, int high) {
    return static_cast<double>(*rc::gen::inRange(low, high)) / 100;
  };
  FreeAxisLimits limits;
  limits.velocity = unit * number(10, 1000);
  limits.acceleration = limits.velocity * number(50, 2000);
  limits.jerk = limits.acceleration * number(100, 5000);
  limits.min = unit * number(-1000, 1000);
  limits.max = limits.min + limits.velocity * number(1, 500);
  const double tick_s = 1 / static_cast<double>(*rc::gen::element(50, 100, 250, 1000, 4000));
  const double share = number(0, 101);
  const double position = std::clamp(limits.min + share * (limits.max - limits.min), limits.min, limits.max);
  return {limits, tick_s, *FreeAxis::make(limits, position, tick_s)};
}

/// What a tick may do at most, by differences of what came out at the ticks before.
class Differences {
 public:
  Differences(const FreeAxisLimits& limits, double tick_s) : limits_(limits), tick_s_(tick_s) {
    const double reach = std::max(std::fabs(limits.min), std::fabs(limits.max));
    grain_ = grains * std::numeric_limits<double>::epsilon() * reach;
  }

  void take(const Setpoint& now) {
    const double h = tick_s_;
    const double little = 1 + 64 * std::numeric_limits<double>::epsilon();
    hold(std::fabs(now.velocity) <= little * limits_.velocity, "velocity");
    hold(std::fabs(now.acceleration) <= little * limits_.acceleration, "acceleration");
    // Of a velocity and an acceleration the last bits are those of their greatest values.
    const double v_grain = 64 * std::numeric_limits<double>::epsilon() * limits_.velocity;
    const double a_grain = 8 * std::sqrt(std::numeric_limits<double>::epsilon()) * limits_.acceleration;
    taken_.push_back(now);
    const std::size_t n = taken_.size();
    if (n < 2) return;
    const Setpoint& before = taken_[n - 2];
    hold(std::fabs(now.velocity - before.velocity) <= limits_.acceleration * h + v_grain,
         "acceleration between ticks");
    hold(std::fabs(now.acceleration - before.acceleration) <= limits_.jerk * h + a_grain,
         "jerk between ticks");
    const double expected = h * (before.velocity + h * before.acceleration / 2);
    hold(std::fabs(now.position - before.position - expected) <=
             limits_.jerk * h * h * h / 6 + grain_ + v_grain * h,
         "position does not follow velocity and acceleration");
    const double gained = now.velocity - before.velocity - h * before.acceleration;
    hold(std::fabs(gained) <= limits_.jerk * h * h / 2 + v_grain + a_grain * h,
         "velocity does not follow acceleration");
    if (n < 4) return;
    const double third =
        (now.position - taken_[n - 4].position) - 3 * (taken_[n - 2].position - taken_[n - 3].position);
    hold(std::fabs(third) <= limits_.jerk * h * h * h + 8 * grain_, "third difference of the positions");
  }
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  void hold(bool kept, const char* what) {
    if (!kept && complaint_.empty())
      complaint_ = std::string(what) + " at tick " + std::to_string(taken_.size());
  }
  FreeAxisLimits limits_;
  double tick_s_;
  double grain_ = 0;
  std::vector<Setpoint> taken_;
  std::string complaint_;
};

double any_position(const FreeAxisLimits& limits) {
  const double share = static_cast<double>(*rc::gen::inRange(0, 101)) / 100;
  return std::clamp(limits.min + share * (limits.max - limits.min), limits.min, limits.max);
}

void command(Axis& any) {
  const FreeAxisLimits& limits = any.limits;
  const double share = static_cast<double>(*rc::gen::inRange(-100, 101)) / 100;
  switch (*rc::gen::inRange(0, 6)) {
    case 0:
    case 1:
      static_cast<void>(any.axis.drive(share * limits.velocity));
      break;
    case 2:
      static_cast<void>(any.axis.drive(share < 0 ? -limits.velocity : limits.velocity));
      break;
    case 3:
      RC_ASSERT(any.axis.go_to(any_position(limits)).has_value());
      break;
    case 4:
      if (share != 0)
        RC_ASSERT(any.axis.go_to(any_position(limits), std::fabs(share) * limits.velocity).has_value());
      break;
    default:
      any.axis.stop();
  }
}

void play_any_commands() {
  Axis any = any_axis();
  Differences differences(any.limits, any.tick_s);
  const auto tick = [&] {
    differences.take(any.axis.tick());
    RC_ASSERT(any.axis.position() >= any.limits.min);
    RC_ASSERT(any.axis.position() <= any.limits.max);
    if (!differences.complaint().empty()) RC_FAIL(differences.complaint());
  };
  const int seldom = *rc::gen::element(2, 10, 50, 200);
  for (int i = 0; i < commanded_ticks; ++i) {
    if (*rc::gen::inRange(0, seldom) == 0) command(any);
    tick();
  }
  const double rest = any.axis.position() + any.axis.stop_distance();
  const double seconds = any.axis.stop_seconds();
  any.axis.stop();
  int needed = 0;
  for (; !any.axis.is_resting() && needed < 10'000'000; ++needed) tick();
  const double grain = grains * std::numeric_limits<double>::epsilon() *
                       std::max(std::fabs(any.limits.min), std::fabs(any.limits.max));
  RC_ASSERT(std::fabs(any.axis.position() - rest) <= grain);
  RC_ASSERT(static_cast<double>(needed - 1) * any.tick_s <= seconds * (1 + grain) + any.tick_s / 100);
  RC_ASSERT(any.axis.state().velocity == 0);
  RC_ASSERT(any.axis.state().acceleration == 0);
}

TEST(FreeAxisProperty, AnyCommandsAtAnyTickKeepTheLimitsAndRestInside) {
  check_property(many_sequences, [] { play_any_commands(); });
}

void arrive_from_any_state() {
  Axis any = any_axis();
  Differences differences(any.limits, any.tick_s);
  for (int i = *rc::gen::inRange(0, 200); i > 0; --i) {
    if (*rc::gen::inRange(0, 20) == 0) command(any);
    differences.take(any.axis.tick());
  }
  const double target = any_position(any.limits);
  RC_ASSERT(any.axis.go_to(target).has_value());
  for (int i = 0; !any.axis.is_resting(); ++i) {
    RC_ASSERT(i < 10'000'000);
    differences.take(any.axis.tick());
    if (!differences.complaint().empty()) RC_FAIL(differences.complaint());
  }
  RC_ASSERT(any.axis.position() == target);
}

TEST(FreeAxisProperty, ItArrivesToTheLastBitFromAnyState) {
  check_property(many_sequences, [] { arrive_from_any_state(); });
}

/// Outside its soft limits it comes in or rests, and is at no tick further outside than before.
TEST(FreeAxisProperty, OutsideItOnlyMovesTowardsTheInside) {
  check_property(many_sequences, [] {
    Axis any = any_axis();
    const bool above = *rc::gen::arbitrary<bool>();
    const double off = any.limits.velocity * *rc::gen::inRange(1, 200) / 100.0;
    RC_ASSERT(any.axis.place(above ? any.limits.max + off : any.limits.min - off).has_value());
    RC_ASSERT(!any.axis.drive(above ? any.limits.velocity : -any.limits.velocity).has_value());
    Differences differences(any.limits, any.tick_s);
    const auto outside = [&] {
      return std::max({any.axis.position() - any.limits.max, any.limits.min - any.axis.position(), 0.0});
    };
    for (int i = 0; i < commanded_ticks; ++i) {
      if (*rc::gen::inRange(0, 50) == 0) command(any);
      const double before = outside();
      differences.take(any.axis.tick());
      RC_ASSERT(outside() <= before);
      if (!differences.complaint().empty()) RC_FAIL(differences.complaint());
    }
  });
}

}  // namespace free_axis_property_test
}  // namespace inbetween
