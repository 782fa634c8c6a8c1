#include "host_tools/check/check_refusals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/plan/rest_keys.hpp"
#include "inbetween/limits/verdict.hpp"

namespace inbetween {
namespace {

/// So many other keys at which an axis steps are told by their numbers.
constexpr std::size_t max_keys_named = 8;

/// The faults of one axis, in words.
class AxisRefusals {
 public:
  AxisRefusals(const Plan& plan, std::size_t index, CheckReport& report)
      : move_(plan.move()),
        track_(plan.move().tracks[*plan.axes()[index].track]),
        place_(plan.place_of(index)),
        rig_(*plan.rig()),
        limits_(plan.rig()->axes[index]),
        index_(index),
        axis_in_track_(plan.axes()[index].track_axis),
        axis_(report.axes[index]),
        report_(report) {}

  void add_all() {
    add_position();
    add_velocity_step();
    add_acceleration_step();
    if (add_unbounded()) return;
    add_peak(axis_.velocity, "max_velocity", "/s");
    add_peak(axis_.acceleration, "max_acceleration", "/s^2");
    add_peak(axis_.jerk, "max_jerk", "/s^3");
  }

 private:
  void refuse(const Place& place, double frame, std::string what, std::string_view remedy, bool slower_helps,
              bool at_any_rate = false) {
    report_.refusals.push_back(
        {place, std::move(what), std::string(remedy), index_, frame, slower_helps, at_any_rate});
  }

  void add_position() {
    const Peak& lowest = axis_.range->lowest;
    const Peak& highest = axis_.range->highest;
    const RangeVerdict range = judge_range(lowest.value, highest.value, limits_of(limits_));
    if (!range.below && !range.above) return;
    const double below = limits_.min - lowest.value;
    const double above = highest.value - limits_.max;
    const Peak& worst = below > above ? lowest : highest;
    const double limit = below > above ? limits_.min : limits_.max;
    const std::string value = told_apart(worst.value, limit, Digits::significant, 6).first;
    refuse(place_at(worst.frame), worst.frame,
           fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {} of the rig {}",
                       in_quotes(axis_.name), value, axis_.unit, worst.frame, range_in_words(limits_),
                       in_quotes(rig_.name)),
           remedy_of_position(), false, true);
  }
  /// It rounds up to three digits, so that moving by the result is enough.
  [[nodiscard]] static double rounded_up(double number) {
    const double unit = std::pow(10, std::floor(std::log10(number)) - 2);
    return std::ceil(number / unit) * unit;
  }
  /// Where its keys are inside, it is the curve between them that goes beyond.
  [[nodiscard]] std::string remedy_of_position() const {
    const bool can_overshoot = track_.overshoot && !track_.network && !track_.table &&
                               (track_.spline == Spline::smooth || track_.spline == Spline::catmull_rom);
    const bool keys_are_inside = !track_.space && std::ranges::all_of(track_.keys, [&](const MoveKey& key) {
      const double at = key.at[axis_in_track_];
      return at >= limits_.min && at <= limits_.max;
    });
    const bool low = limits_.min - axis_.range->lowest.value > axis_.range->highest.value - limits_.max;
    const Peak& worst = low ? axis_.range->lowest : axis_.range->highest;
    std::string inward =
        fmt::format("move its {} inward by {:.6g} {}",
                    track_.table     ? "rows there"
                    : track_.network ? "keys and the drawn curves"
                                     : "keys",
                    rounded_up(low ? limits_.min - worst.value : worst.value - limits_.max), axis_.unit);
    if (!keys_are_inside || !can_overshoot) return inward;
    // There overshoot = false would break max_jerk.
    if (is_over_time(track_) && limits_.max_jerk) {
      const std::optional<std::size_t> key = key_to_rest(track_, worst.frame, axis_in_track_, low);
      if (!key) return inward;
      return fmt::format("write {}, or {}", twice_in_words(track_, {*key}), inward);
    }
    return "keep the curve between its keys with overshoot = false, or " + inward;
  }

  /// The steps of this axis that are refused, and the largest of them.
  struct RefusedSteps {
    std::vector<const CheckedStep*> all = {};
    const CheckedStep* largest = nullptr;

    void take(const CheckedStep& next, double CheckedStep::*size) {
      all.push_back(&next);
      if (largest == nullptr || next.*size > largest->*size) largest = &next;
    }
    /// The keys beside the largest by their numbers, if they are few.
    [[nodiscard]] std::string where() const {
      std::string words = fmt::format("frame {:.2f}", largest->frame);
      if (largest->key) words = fmt::format("key {}, {}", *largest->key, words);
      std::vector<std::string> keys;
      for (const CheckedStep* step : all) {
        if (step != largest && step->key) keys.push_back(std::to_string(*step->key));
      }
      const std::size_t others = all.size() - 1;
      if (others == 0) return words;
      if (keys.size() < others || others > max_keys_named)
        return words + fmt::format(", and at {} more place{}", others, others == 1 ? "" : "s");
      return words + fmt::format(", and at key{} {}", others == 1 ? "" : "s", listed_with_and(keys));
    }
  };

  void add_velocity_step() {
    RefusedSteps steps;
    for (const CheckedStep& step : report_.steps) {
      if (step.axis == index_ && step.velocity > 0) steps.take(step, &CheckedStep::velocity);
    }
    if (steps.largest == nullptr) return;
    refuse(place_of(*steps.largest), steps.largest->frame,
           fmt::format("axis {} would step by {:.6g} {}/s at {}, which no drive can follow",
                       in_quotes(axis_.name), steps.largest->velocity, axis_.unit, steps.where()),
           remedy_of(steps), false);
  }

  void add_acceleration_step() {
    RefusedSteps steps;
    for (const CheckedStep& step : report_.steps) {
      // A step of the velocity has been said, and its remedy cures both.
      const bool is_refused = step.velocity == 0 && breaks_jerk_limit(step, limits_);
      if (step.axis == index_ && is_refused) steps.take(step, &CheckedStep::acceleration);
    }
    if (steps.largest == nullptr) return;
    const auto [step, most] = told_apart(steps.largest->acceleration,
                                         limits_.max_acceleration_step.value_or(0), Digits::significant, 6);
    const std::string rule = limits_.max_acceleration_step
                                 ? fmt::format("max_acceleration_step is {} {}/s^2", most, axis_.unit)
                                 : "max_jerk allows no step";
    refuse(place_of(*steps.largest), steps.largest->frame,
           fmt::format("axis {} would step by {} {}/s^2 at {}, and {}", in_quotes(axis_.name), step,
                       axis_.unit, steps.where(), rule),
           remedy_of(steps), limits_.max_acceleration_step.has_value());
  }

  /// If something has no bound, its derivatives have none either: it is said once.
  bool add_unbounded() {
    if (!std::isfinite(axis_.velocity.value)) {
      add_unbounded("a velocity", axis_.velocity, "stands still for the axes that have a weight");
    } else if (!std::isfinite(axis_.acceleration.value)) {
      add_unbounded("an acceleration", axis_.acceleration, "turns on the spot");
    } else if (!std::isfinite(axis_.jerk.value) && axis_.jerk.limit) {
      add_unbounded("a jerk", axis_.jerk, "turns on the spot");
    } else {
      return false;
    }
    return true;
  }
  void add_unbounded(std::string_view quantity, const CheckedPeak& peak, std::string_view what) {
    refuse(
        place_, peak.frame,
        fmt::format("axis {} would need {} without bound near frame {:.2f}, where the path {} and is passed "
                    "at a speed",
                    in_quotes(axis_.name), quantity, peak.frame, what),
        remedy_of_turn(peak.frame), false, true);
  }

  void add_peak(const CheckedPeak& peak, std::string_view limit, std::string_view per) {
    if (!peak.is_exceeded()) return;
    const auto [value, most] = told_apart(peak.value, *peak.limit, Digits::significant, 6);
    refuse(place_at(peak.frame), peak.frame,
           fmt::format(
               "axis {} would reach {} {}{} at frame {:.2f}, and {} {} {} {}{}", in_quotes(axis_.name), value,
               axis_.unit, per, peak.frame, limit,
               limits_.backlash && !limits_.calibration ? "leaves beside the take-up of the backlash" : "is",
               most, axis_.unit, per),
           track_.table                     ? "bake the rows slower there, on more frames"
           : track_.timing == Timing::speed ? "give the move more frames, or draw a flatter speed curve there"
                                            : "give the move more frames there",
           true);
  }
  /// This is where the axis is named, or the row of a table on that frame or before it.
  [[nodiscard]] Place place_at(double frame) const {
    if (!track_.table) return place_;
    const std::vector<std::int32_t>& frames = track_.table->frames;
    const auto behind = std::ranges::upper_bound(frames, frame);
    return track_.table->place_of(
        static_cast<std::size_t>(std::max<std::ptrdiff_t>(behind - frames.begin(), 1) - 1));
  }

  [[nodiscard]] static bool is_start(const CheckedStep& step) { return step.frame <= 0; }
  [[nodiscard]] bool is_end(const CheckedStep& step) const { return step.frame >= move_.frames; }
  [[nodiscard]] const MoveKey* key_of(const CheckedStep& step) const {
    return step.key ? &track_.keys[static_cast<std::size_t>(*step.key)] : nullptr;
  }

  [[nodiscard]] const Place& place_of(const CheckedStep& step) const {
    if (is_start(step) && !track_.speed_places.empty()) return track_.speed_places.front();
    if (is_end(step) && !track_.speed_places.empty()) return track_.speed_places.back();
    return step.key ? key_of(step)->place : place_;
  }
  /// What cures every step: what the largest asks for, and then what others ask for.
  [[nodiscard]] std::string remedy_of(const RefusedSteps& steps) const {
    if (is_over_time(track_) && track_.spline == Spline::smooth && !track_.overshoot)
      return remedy_of_rests(steps);
    const bool has_curve = track_.timing == Timing::speed;
    const bool at_start = std::ranges::any_of(steps.all, [&](const auto* step) { return is_start(*step); });
    const bool at_end = std::ranges::any_of(steps.all, [&](const auto* step) { return is_end(*step); });
    std::vector<std::string> remedies;
    const auto add = [&](std::string remedy) {
      if (std::ranges::find(remedies, remedy) == remedies.end()) remedies.push_back(std::move(remedy));
    };
    const auto add_of = [&](const CheckedStep& step) {
      const bool is_at_an_end = is_start(step) || is_end(step);
      add(has_curve && at_start && at_end && is_at_an_end ? "begin and end the speed curve with 0, 0, at rest"
                                                          : remedy_of(step));
    };
    add_of(*steps.largest);
    for (const CheckedStep* step : steps.all) add_of(*step);
    return listed_with_and(remedies);
  }
  /// What keeps an axis between its keys lowers its slope, and its acceleration steps there.
  [[nodiscard]] std::string remedy_of_rests(const RefusedSteps& steps) const {
    std::set<std::size_t> keys;
    for (const CheckedStep* step : steps.all) {
      if (!step->key || !rest_at_key(track_, static_cast<std::size_t>(*step->key)))
        return "take away overshoot = false";
      keys.insert(static_cast<std::size_t>(*step->key));
    }
    if (keys.size() > max_keys_named)
      return "write each of these keys twice, on two neighbouring frames, for a rest there";
    return "write " + twice_in_words(track_, keys);
  }
  [[nodiscard]] std::string remedy_of(const CheckedStep& step) const {
    const bool is_at_an_end = is_start(step) || is_end(step);
    if (!has_speed_curve(track_)) {
      if (track_.spline == Spline::linear) return "use spline = \"smooth\" and kinetic = \"curves\"";
      if (kinetic_of(track_) != MoveKinetic::curves) return "use kinetic = \"curves\"";
      if (track_.spline != Spline::smooth)
        return fmt::format("use spline = \"smooth\"{}", track_.overshoot ? "" : " and overshoot = true");
      if (is_at_an_end) return "use rest = \"both\"";
      return "write the key twice, on two neighbouring frames, for a rest there";
    }
    if (track_.timing == Timing::frames && is_at_an_end) return "use rest = \"both\"";
    if (is_start(step)) return "begin the speed curve with 0, 0, at rest";
    if (is_end(step)) return "end the speed curve with 0, 0, at rest";
    if (!step.key) return remedy_of_turn(step.frame);
    if (key_of(step)->breaks) return "take away the break of the key";
    const std::string ease = track_.timing == Timing::frames
                                 ? "let the speed touch 0 there with ease = true"
                                 : "let the speed touch 0 there with ease = true, or rest there with hold";
    return (track_.spline != Spline::smooth ? "use spline = \"smooth\", or " : "") + ease;
  }
  /// Where the path turns on the spot, at a key or between keys.
  [[nodiscard]] std::string remedy_of_turn(double frame) const {
    if (!has_speed_curve(track_))
      return "use kinetic = \"curves\", or move a key so that the path goes round";
    // A path that goes beyond a key and back turns so near to it that both touches would be on one frame.
    const bool can_overshoot = track_.overshoot && !track_.space &&
                               (track_.spline == Spline::smooth || track_.spline == Spline::catmull_rom);
    const bool has_rest =
        std::ranges::any_of(track_.keys, [](const MoveKey& key) { return key.ease || key.hold; });
    if (can_overshoot && has_rest && !track_.ease_corners)
      return "let the speed touch 0 there with overshoot = false and corners = \"ease\"";
    if (!track_.ease_corners)
      return "let the speed touch 0 there with corners = \"ease\", or move a key so that the path goes round";
    if (track_.timing == Timing::speed && frame < 1) return "begin the speed curve with 0, 0, at rest";
    if (track_.timing == Timing::speed && frame > move_.frames - 1)
      return "end the speed curve with 0, 0, at rest";
    return "move a key so that the path goes round";
  }

  const MoveFile& move_;
  const MoveTrack& track_;
  const Place& place_;
  const RigFile& rig_;
  const RigAxis& limits_;
  std::size_t index_;
  std::size_t axis_in_track_;
  const CheckedAxis& axis_;
  CheckReport& report_;
};

std::string_view name_of(RollEnd end) {
  return end == RollEnd::before ? "pre-roll" : "post-roll";
}

/// How far beyond its limit, in words: "would go to -3 mm at frame -12.00, outside 0..1500 mm".
std::string breach_in_words(const RollBreach& breach, const RigAxis& axis) {
  const std::string_view unit = to_string(axis.unit);
  const auto [value, most] = told_apart(breach.value, breach.limit, Digits::significant, 6);
  const auto beyond = [&, &value = value, &most = most](std::string_view per, std::string_view limit) {
    return fmt::format("would reach {} {}{} at frame {:.2f}, and {} is {} {}{}", value, unit, per,
                       breach.frame, limit, most, unit, per);
  };
  switch (breach.quantity) {
    case RollQuantity::velocity:
      return beyond("/s", "max_velocity");
    case RollQuantity::acceleration:
      return beyond("/s^2", "max_acceleration");
    case RollQuantity::jerk:
      return beyond("/s^3", "max_jerk");
    case RollQuantity::position:
      break;
  }
  return fmt::format("would go to {} {} at frame {:.2f}, outside {}", value, unit, breach.frame,
                     range_in_words(axis));
}

/// An axis that starts on its limit and moves away from it has no room, however slow it is.
bool has_room(const Plan& plan, const RollObstacle& obstacle) {
  const RollBreach& breach = obstacle.breach;
  if (breach.quantity != RollQuantity::position) return true;
  const double position = obstacle.joint_position;
  const AxisLimits& limits = plan.limits()[static_cast<std::size_t>(breach.axis)];
  const double room = breach.value > breach.limit ? limits.max() - position : position - limits.min();
  return room > step_rounding * (limits.max() - limits.min());
}

}  // namespace

bool breaks_jerk_limit(const CheckedStep& step, const RigAxis& limits) {
  return breaks_jerk_limit(step.acceleration, limits_of(limits));
}

void refuse_axis(const Plan& plan, std::size_t axis, CheckReport& report) {
  AxisRefusals(plan, axis, report).add_all();
}

void refuse_roll(const Plan& plan, const RollObstacle& obstacle, CheckReport& report) {
  const RollBreach& breach = obstacle.breach;
  const std::size_t index = plan.axis_of(static_cast<std::size_t>(breach.axis));
  const RigAxis& axis = plan.rig()->axes[index];
  const MoveTrack& track = plan.move().tracks[*plan.axes()[index].track];
  const bool starts = obstacle.end == RollEnd::before;
  // The move breaks the limit itself, which has been said.
  if (breach.at_joint && !report.refusals.empty()) return;
  const bool room = has_room(plan, obstacle);
  const std::int32_t frame = starts ? plan.part().first : plan.part().last;
  if (frame != (starts ? 0 : plan.move().frames)) {
    report.refusals.push_back(
        {plan.place_of(index),
         fmt::format("frame {} is passed moving, and on a {} of {} axis {} {}", frame, name_of(obstacle.end),
                     counted(breach.frames, "frame"), in_quotes(axis.name), breach_in_words(breach, axis)),
         fmt::format("{} on a frame where the move is slower or rests{}", starts ? "begin" : "end",
                     room ? ", or give the move more frames" : ""),
         index, static_cast<double>(frame), room});
    return;
  }
  const std::string remedy =
      track.table ? fmt::format("{} the table with two equal rows, at rest", starts ? "begin" : "end")
      : track.timing == Timing::speed
          ? fmt::format("{} the speed curve with 0, 0, at rest{}", starts ? "begin" : "end",
                        room ? ", or give the move more frames" : ", or move the key inward")
          : std::string(room ? "give the move more frames" : "move the key inward");
  report.refusals.push_back(
      {track.speed_places.empty() ? plan.place_of(index)
       : starts                   ? track.speed_places.front()
                                  : track.speed_places.back(),
       fmt::format("the move {} moving, and on a {} of {} axis {} {}", starts ? "starts" : "ends",
                   name_of(obstacle.end), counted(breach.frames, "frame"), in_quotes(axis.name),
                   breach_in_words(breach, axis)),
       remedy, index, static_cast<double>(frame), room});
}

void refuse_motor(const Plan& plan, const CheckedMotor& motor, CheckReport& report) {
  const RigAxis& axis = plan.rig()->axes[motor.axis];
  const auto refuse = [&](const CheckedPeak& peak, std::string_view limit, std::string_view per) {
    // What has no bound of the axis has been said.
    if (!peak.is_exceeded() || !std::isfinite(peak.value)) return;
    const auto [value, most] = told_apart(peak.value, *peak.limit, Digits::significant, 6);
    report.refusals.push_back(
        {plan.place_of(motor.axis),
         fmt::format(
             "the motor of axis {} would reach {} {}{} at frame {:.2f}, and {} of its calibration {} {} {}{}",
             in_quotes(axis.name), value, motor.unit, per, peak.frame, limit,
             axis.backlash ? "leaves beside the take-up of the backlash" : "is", most, motor.unit, per),
         "give the move more frames, or draw it slower there", motor.axis, peak.frame, true});
  };
  refuse(motor.velocity, "max_velocity", "/s");
  refuse(motor.acceleration, "max_acceleration", "/s^2");
  refuse(motor.jerk, "max_jerk", "/s^3");
}

void refuse_stop(const Plan& plan, const PlannedStops& planned, CheckReport& report) {
  const StopObstacle& obstacle = *planned.obstacle();
  const std::size_t index = plan.axis_of(static_cast<std::size_t>(obstacle.axis));
  const CheckedAxis& axis = report.axes[index];
  const bool by_jerk = obstacle.quantity == StopQuantity::jerk;
  const std::string_view per = by_jerk ? "/s^3" : "/s^2";
  const std::string_view limit = by_jerk ? "stop_jerk" : "stop_acceleration";
  const std::string_view unit = planned.is_of_motor() ? to_string(plan.rig()->axes[index].calibration->unit)
                                                      : std::string_view(axis.unit);
  // A bound of a cell may be above the one of the whole move, which is nearer to the truth.
  double peak = by_jerk ? axis.jerk.value : axis.acceleration.value;
  if (planned.is_of_motor()) peak = obstacle.value;
  const auto [value, most] =
      told_apart(std::min(obstacle.value, peak), obstacle.limit, Digits::significant, 6);
  // The motion itself is beyond its limit, which has been said.
  if (!report.refusals.empty()) return;
  report.refusals.push_back(
      {plan.place_of(index),
       fmt::format("{}axis {} could not be stopped at frame {:.2f}: the motion alone takes {} {}{} there, "
                   "and {} is {} {}{}",
                   planned.is_of_motor() ? "the motor of " : "", in_quotes(axis.name), obstacle.frame, value,
                   unit, per, limit, most, unit, per),
       fmt::format("give the move more frames, or raise {}", limit), index, obstacle.frame, true});
}

}  // namespace inbetween
