#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "inbetween/limits/roll.hpp"
#include "tests/support/oracle_limits.hpp"
#include "tests/support/property.hpp"
#include "tests/support/roll_keeps.hpp"

/// Pre-rolls and post-rolls against the five conditions that define them, solved here, in long double.

namespace inbetween {
namespace roll_property_test {

/// The quartic about the joint from Cramer's rule on velocity = acceleration = 0 at `far` seconds.
struct Quartic {
  std::array<long double, 5> c{};
  long double far = 0;

  Quartic(const RollSpan& span, const AxisMotion& joint) {
    const auto v = static_cast<long double>(joint.velocity);
    const auto a = static_cast<long double>(joint.acceleration);
    const long double seconds =
        static_cast<long double>(span.frames) * span.fps.denominator / span.fps.numerator;
    far = span.end == RollEnd::before ? -seconds : seconds;
    const long double t = far;
    c = {static_cast<long double>(joint.position), v, a / 2,
         (4 * t * t * t * a - 12 * t * t * (v + a * t)) / (12 * t * t * t * t),
         (6 * t * (v + a * t) - 3 * t * t * a) / (12 * t * t * t * t)};
  }
  long double position(long double t) const { return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4]))); }
  long double velocity(long double t) const { return c[1] + t * (2 * c[2] + t * (3 * c[3] + t * 4 * c[4])); }
  long double acceleration(long double t) const { return 2 * c[2] + t * (6 * c[3] + t * 12 * c[4]); }
  long double jerk(long double t) const { return 6 * c[3] + 24 * t * c[4]; }

  /// lowest, highest, velocity, acceleration, jerk.
  std::array<oracle::Extreme, 5> extremes(int samples) const {
    const auto search = [&](auto function) {
      return oracle::peak_of(function, std::min(far, 0.0L), std::max(far, 0.0L), samples);
    };
    oracle::Extreme lowest = search([&](long double t) { return -position(t); });
    lowest.value = -lowest.value;
    return {lowest, search([&](long double t) { return position(t); }),
            search([&](long double t) { return std::fabs(velocity(t)); }),
            search([&](long double t) { return std::fabs(acceleration(t)); }),
            search([&](long double t) { return std::fabs(jerk(t)); })};
  }
};

std::array<Peak, 5> listed(const AxisPeaks& peaks) {
  return {peaks.lowest, peaks.highest, peaks.velocity, peaks.acceleration, peaks.jerk};
}

int any_int(int from, int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
}

/// Evenly spread over [-1, 1], now and then exactly 0.
double share() {
  return any_int(0, 8) == 0 ? 0 : any_int(-1'000'000, 1'000'001) * 1e-6;
}

RollSpan any_span(int max_frames) {
  RollSpan span;
  span.end = *rc::gen::element(RollEnd::before, RollEnd::after);
  span.joint_frame = span.end == RollEnd::before ? 0 : any_int(1, 1000);
  span.frames = any_int(1, max_frames + 1);
  span.fps = *rc::gen::element(FrameRate{24, 1}, FrameRate{24000, 1001}, FrameRate{120, 1});
  return span;
}

/// Acceleration and velocity in every ratio r = a T / v from -20 to 20, in those where the shape of the roll
/// changes, and without one of them.
AxisMotion any_joint(const RollSpan& span) {
  const double seconds = span.frames / span.fps.frames_per_second();
  const double scale = std::ldexp(1.0, any_int(-12, 13));
  const double v = scale * share();
  const double h = span.end == RollEnd::before ? seconds : -seconds;
  const double r = any_int(0, 4) == 0 ? *rc::gen::element(1.5, 2.0, 3.0, 6.0) : 20 * share();
  const bool only_acceleration = any_int(0, 10) == 0;
  AxisMotion joint;
  joint.position = static_cast<double>(1000 * share());
  joint.velocity = only_acceleration ? 0.0 : static_cast<double>(v);
  joint.acceleration = static_cast<double>((only_acceleration ? scale * share() : r * v) / h);
  return joint;
}

long double speed_scale(const AxisMotion& joint, const Quartic& quartic) {
  return 3 * std::fabs(static_cast<long double>(joint.velocity)) +
         std::fabs(static_cast<long double>(joint.acceleration) * quartic.far);
}

TEST(RollProperty, IsTheQuarticOfTheFiveConditions) {
  check_property(5000, [] {
    const RollSpan span = any_span(500);
    const auto joint = any_joint(span);
    const auto roll = *RollAxis::make(span, joint);
    const Quartic quartic(span, joint);
    const auto epsilon = static_cast<long double>(std::numeric_limits<double>::epsilon());
    const long double seconds = std::fabs(quartic.far);
    const long double scale = 20 * epsilon * speed_scale(joint, quartic);
    const auto near = [](double value, long double wanted, long double within) {
      RC_LOG() << value << " instead of " << wanted << " within " << within << "\n";
      RC_ASSERT(std::fabs(static_cast<long double>(value) - wanted) <= within);
    };
    for (int i = 0; i <= 16; ++i) {
      const int eighths = any_int(0, 8 * span.frames + 1);
      const long double away = eighths / 8.0L;
      const long double t = quartic.far * away / span.frames;
      const bool before = span.end == RollEnd::before;
      const int numbered = 8 * span.joint_frame + (before ? -eighths : eighths);
      const auto frame = static_cast<std::int32_t>(std::floor(numbered / 8.0));
      const auto at = roll.motion({frame, static_cast<double>(numbered - 8 * frame) / 8});
      near(at.position, quartic.position(t), scale * seconds + 2 * epsilon * std::fabs(quartic.c[0]));
      near(at.velocity, quartic.velocity(t), scale);
      near(at.acceleration, quartic.acceleration(t), scale / seconds);
      near(at.jerk, quartic.jerk(t), 2 * scale / seconds / seconds);
    }
    const auto c = roll.coefficients();
    for (std::size_t i = 0; i < 5; ++i) {
      const long double place = scale * std::pow(seconds, 1.0L - static_cast<long double>(i));
      near(c[i], quartic.c[i], place);
    }
  });
}

/// So many seconds from the joint.
FrameTime time_of(const RollSpan& span, double seconds) {
  return moved_by({span.joint_frame, 0}, seconds * span.fps.frames_per_second());
}

TEST(RollProperty, ReDifferentiatedItRestsAtOneEndAndJoinsTheMoveAtTheOther) {
  check_property(2000, [] {
    const RollSpan span = any_span(500);
    const auto joint = any_joint(span);
    const auto roll = *RollAxis::make(span, joint);
    const Quartic quartic(span, joint);
    // Five positions at the ends of the roll, differentiated to the fourth order: exact for a quartic but for
    // rounding.
    const double step = static_cast<double>(quartic.far) / 8;
    const auto differentiate = [&](double from, double h) {
      std::array<double, 5> p{};
      for (int i = 0; i < 5; ++i)
        p[static_cast<std::size_t>(i)] = roll.motion(time_of(span, from + i * h)).position;
      return std::array<double, 2>{
          (-25 * p[0] + 48 * p[1] - 36 * p[2] + 16 * p[3] - 3 * p[4]) / (12 * h),
          (35 * p[0] - 104 * p[1] + 114 * p[2] - 56 * p[3] + 11 * p[4]) / (12 * h * h)};
    };
    const double noise = 1e-14 * (std::fabs(joint.position) +
                                  std::fabs(8 * step) * static_cast<double>(speed_scale(joint, quartic)));
    const auto at_rest = differentiate(static_cast<double>(quartic.far), -step);
    RC_ASSERT(std::fabs(at_rest[0]) <= noise / std::fabs(step) * 10);
    RC_ASSERT(std::fabs(at_rest[1]) <= noise / (step * step) * 30);
    const auto at_joint = differentiate(0, step);
    RC_ASSERT(std::fabs(at_joint[0] - joint.velocity) <= noise / std::fabs(step) * 10);
    RC_ASSERT(std::fabs(at_joint[1] - joint.acceleration) <= noise / (step * step) * 30);
    RC_ASSERT(roll.motion({span.joint_frame, 0}).position == joint.position);
    RC_ASSERT(roll.motion({span.joint_frame, 0}).velocity == joint.velocity);
    RC_ASSERT(roll.motion({span.joint_frame, 0}).acceleration == joint.acceleration);
  });
}

TEST(RollProperty, PeaksAreNeverBelowTheTruthAndHardlyAboveIt) {
  check_property(5000, [] {
    const RollSpan span = any_span(500);
    const auto joint = any_joint(span);
    const Quartic quartic(span, joint);
    const auto truth = quartic.extremes(64);
    const auto peaks = listed(RollAxis::make(span, joint)->peaks());
    const long double seconds = std::fabs(quartic.far);
    const long double speed = speed_scale(joint, quartic);
    const std::array<long double, 5> scales = {seconds * speed, seconds * speed, speed, speed / seconds,
                                               speed / seconds / seconds};
    for (std::size_t i = 0; i < 5; ++i) {
      const long double sign = i == 0 ? -1 : 1;
      const long double above = sign * (static_cast<long double>(peaks[i].value) - truth[i].value);
      const long double noise = 1e-17L * (scales[i] + (i < 2 ? std::fabs(quartic.c[0]) : 0));
      const long double allowed =
          i < 2 ? 1e-9L * (std::fabs(quartic.c[0]) + scales[i]) : 1e-9L * std::fabs(truth[i].value);
      RC_LOG() << "quantity " << i << ": " << peaks[i].value << ", truth " << truth[i].value << ", above by "
               << above << ", allowed " << allowed << "\n";
      RC_ASSERT(above >= -noise);
      RC_ASSERT(above <= allowed + noise);
    }
  });
}

TEST(RollProperty, PeaksAreReachedWhereTheySay) {
  check_property(2000, [] {
    const RollSpan span = any_span(500);
    const auto joint = any_joint(span);
    const Quartic quartic(span, joint);
    const auto peaks = listed(RollAxis::make(span, joint)->peaks());
    const long double seconds = std::fabs(quartic.far);
    const long double speed = speed_scale(joint, quartic);
    const long double share = 1e-9L;
    const auto time = [&](std::size_t i) {
      const long double frames = static_cast<long double>(peaks[i].frame) - span.joint_frame;
      RC_ASSERT(std::fabs(frames) <= span.frames);
      RC_ASSERT(frames == 0 || (frames < 0) == (span.end == RollEnd::before));
      return frames * span.fps.denominator / span.fps.numerator;
    };
    const auto near = [&](std::size_t i, long double value, long double scale) {
      RC_LOG() << "quantity " << i << ": " << peaks[i].value << ", at frame " << peaks[i].frame << " "
               << value << "\n";
      RC_ASSERT(std::fabs(static_cast<long double>(peaks[i].value) - value) <= share * scale);
    };
    near(0, quartic.position(time(0)), seconds * speed + std::fabs(quartic.c[0]));
    near(1, quartic.position(time(1)), seconds * speed + std::fabs(quartic.c[0]));
    near(2, std::fabs(quartic.velocity(time(2))), speed);
    near(3, std::fabs(quartic.acceleration(time(3))), speed / seconds);
    near(4, std::fabs(quartic.jerk(time(4))), speed / seconds / seconds);
  });
}

// --- the smallest number of frames

constexpr int longest_tried = 160;

/// The true extremes of one axis for every length of the roll from 1 to longest_tried.
using Lengths = std::vector<std::array<oracle::Extreme, 5>>;

Lengths extremes_of_lengths(RollSpan span, const AxisMotion& joint) {
  Lengths lengths;
  for (span.frames = 1; span.frames <= longest_tried; ++span.frames) {
    lengths.push_back(Quartic(span, joint).extremes(24));
  }
  return lengths;
}

/// Limits near what the axis does on a roll of some length, so that every one of them decides now and then.
AxisLimits tight_limits(const AxisMotion& joint, const Lengths& lengths) {
  const auto like = [&] { return lengths[static_cast<std::size_t>(any_int(0, longest_tried))]; };
  const auto room = [&] { return static_cast<long double>(1 + 0.3 * std::fabs(share())); };
  const auto number = [](long double x) { return static_cast<double>(x); };
  const long double here = static_cast<long double>(joint.position);
  AxisLimitsSpec spec;
  spec.min = number(here - 1e-3L - (here - like()[0].value) * room());
  spec.max = number(here + 1e-3L + (like()[1].value - here) * room());
  spec.max_velocity = number(std::max(1e-3L, like()[2].value * room()));
  spec.max_acceleration = number(std::max(1e-3L, like()[3].value * room()));
  if (*rc::gen::arbitrary<bool>()) spec.max_jerk = number(std::max(1e-3L, like()[4].value * room()));
  return *AxisLimits::make(spec);
}

/// Whether the true motion keeps the limits when these are widened by a share, which may be negative.
bool keeps(const std::array<oracle::Extreme, 5>& truth, const AxisLimits& limits, long double widened) {
  const auto at_most = [&](long double value, double limit, long double scale) {
    return value <= static_cast<long double>(limit) + widened * scale;
  };
  const long double range = std::max(std::fabs(static_cast<long double>(limits.min())),
                                     std::fabs(static_cast<long double>(limits.max())));
  const std::optional<double> jerk = limits.max_jerk();
  return at_most(-truth[0].value, -limits.min(), 3 * range) &&
         at_most(truth[1].value, limits.max(), 3 * range) &&
         at_most(truth[2].value, limits.max_velocity(), static_cast<long double>(limits.max_velocity())) &&
         at_most(truth[3].value, limits.max_acceleration(),
                 static_cast<long double>(limits.max_acceleration())) &&
         (!jerk || at_most(truth[4].value, *jerk, static_cast<long double>(*jerk)));
}

TEST(RollProperty, NoSmallerNumberOfFramesFits) {
  int found = 0;
  int refused = 0;
  int after_a_gap = 0;
  check_property(1000, [&] {
    RollSpan span = any_span(1);
    std::vector<AxisMotion> joints;
    std::vector<AxisLimits> limits;
    std::vector<Lengths> lengths;
    const int axes = any_int(1, 4);
    for (int i = 0; i < axes; ++i) {
      RollSpan typical = span;
      typical.frames = any_int(4, longest_tried);
      joints.push_back(any_joint(typical));
      lengths.push_back(extremes_of_lengths(span, joints.back()));
      limits.push_back(tight_limits(joints.back(), lengths.back()));
    }
    const RollRequest request{span.end, span.joint_frame, span.fps, joints, limits};
    const Result<std::int32_t> frames = roll_frames(request);
    const long double slack = 1e-9L;
    const auto fits = [&](int length, long double widened) {
      for (std::size_t i = 0; i < joints.size(); ++i) {
        if (!keeps(lengths[i][static_cast<std::size_t>(length - 1)], limits[i], widened)) return false;
      }
      return true;
    };
    const bool at_rest = std::all_of(joints.begin(), joints.end(), [](const AxisMotion& joint) {
      return joint.velocity == 0 && joint.acceleration == 0;
    });
    if (at_rest) {
      RC_ASSERT(frames.has_value() && *frames == 0);
      return;
    }
    const int last = frames ? std::min(*frames - 1, longest_tried) : longest_tried;
    for (int length = 1; length <= last; ++length) {
      RC_LOG() << "length " << length << (frames ? " of " + std::to_string(*frames) : frames.error().what)
               << "\n";
      RC_ASSERT(!fits(length, -slack));
    }
    if (!frames) {
      ++refused;
      const auto obstacle = *roll_obstacle(request);
      RC_ASSERT(obstacle.has_value() && obstacle->axis == frames.error().axis);
      if (obstacle->quantity == RollQuantity::position) {
        RC_ASSERT(obstacle->value != obstacle->limit);
      } else {
        RC_ASSERT(obstacle->value > obstacle->limit);
      }
      return;
    }
    ++found;
    RC_ASSERT(*frames >= 1);
    if (*frames <= longest_tried) RC_ASSERT(fits(*frames, 1e-17L));
    RC_ASSERT(roll_keeps(request, *frames));
    for (std::size_t i = 0; i < joints.size(); ++i) {  // one axis alone would do with less, and not with more
      const RollRequest alone{span.end, span.joint_frame, span.fps, {&joints[i], 1}, {&limits[i], 1}};
      const auto least = *roll_frames(alone);
      RC_ASSERT(least <= *frames);
      bool fitted = false;
      for (int length = std::max(least, 1); length < *frames && length <= longest_tried; ++length) {
        fitted = fitted || roll_keeps(alone, length);
        if (fitted && !roll_keeps(alone, length)) {
          ++after_a_gap;
          break;
        }
      }
    }
  });
  std::cout << found << " found, " << after_a_gap << " of them beyond lengths that fit no more, " << refused
            << " refused\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(found, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace roll_property_test
}  // namespace inbetween
