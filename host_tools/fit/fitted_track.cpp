#include "host_tools/fit/fitted_track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/plan/turns.hpp"

namespace inbetween {
namespace {

/// Reading the new curve may change a control value by this share of the largest one, by rounding.
constexpr double reading_rounding = 1e-7;
/// Nothing moves between two locks with less Phi between them than this share of Phi(f).
constexpr double still_share = 1e-12;
/// A control value influences the curve this far on either side: so wide is a uniform cubic B-spline.
constexpr double value_reach = 2;
/// Reading a curve brings every value to rest that is nearer to a hold than this.
constexpr double hold_reach = 3;

Plan plan_of(const Plan& plan, std::size_t index) {
  MoveFile move = plan.move();
  move.tracks = {plan.move().tracks[index]};
  return {std::move(move), plan.rig(), {.kinematics = plan.kinematics()}};
}

/// What lies beyond an end of a periodic curve is at its other end.
void rest_between(double begin, double end, CurveFrame& frame) {
  const auto f = static_cast<double>(frame.rests.size() - 1);
  for (std::size_t i = 0; i < frame.rests.size(); ++i) {
    const auto here = static_cast<double>(i);
    const auto is_between = [&](double place) { return place > begin && place < end; };
    const bool wraps = frame.ends == CurveEnds::periodic && (is_between(here - f) || is_between(here + f));
    if (is_between(here) || wraps) frame.rests[i] = true;
  }
}

/// The report of check_until_refused(). A periodic move is to fit in two turns as well, with its seam between
/// them.
CheckReport checked(const Plan& plan) {
  CheckReport once = check_until_refused(plan);
  if (!plan.move().tracks.front().periodic || !once.fits() || fitting_turns(plan).turns < 2) return once;
  CheckReport twice =
      check_until_refused(Plan(turns_of(plan, 2), plan.rig(), {.kinematics = plan.kinematics()}));
  if (twice.fits()) return once;
  const double frames = plan.move().frames;
  for (CheckedAxis& axis : twice.axes) {
    for (CheckedPeak* peak : {&axis.velocity, &axis.acceleration, &axis.jerk}) {
      if (peak->frame > frames) peak->frame -= frames;
    }
  }
  return twice;
}

}  // namespace

FittedTrack::FittedTrack(const Plan& plan, const CheckReport& report, std::size_t index)
    : played_(plan_of(plan, index)), report_(plan.tracks().size() == 1 ? report : check(played_)) {
  axes_.resize(file().axes.size());
  rig_axes_.resize(axes_.size());
  for (std::size_t a = 0; a < played_.axes().size(); ++a) {
    const PlanAxis& axis = played_.axes()[a];
    if (!axis.track) continue;
    axes_[axis.track_axis] = played_.rig()->axes[a];
    rig_axes_[axis.track_axis] = a;
  }
}

EndSteps FittedTrack::end_steps() const {
  EndSteps steps;
  for (const CheckedStep& step : report_.steps) {
    if (step.frame <= 0) steps.begin = true;
    if (step.frame >= frames()) steps.end = true;
  }
  return steps;
}

CurveFrame FittedTrack::frame_of(std::span<const double> baseline) const {
  CurveFrame frame{.wanted = {baseline.begin(), baseline.end()},
                   .rests = rests_of(baseline, ends()),
                   .fixed_areas = {},
                   .ends = ends()};
  const ControlCurve curve(baseline, ends());
  const auto f = static_cast<double>(curve.span_count());
  const auto area_at = [&](double a) { return curve.at(place_at(a, curve.span_count())).area; };
  double before = 0;
  const auto fix = [&](double a) {
    if (a <= before) return;
    if (area_at(a) - area_at(before) > still_share * curve.total()) {
      frame.fixed_areas.push_back(a);
    } else {
      rest_between(before - value_reach, a + value_reach, frame);
    }
    before = a;
  };
  if (const std::optional<KeyTiming>& timing = solved().key_timing()) {
    for (const KeyLock& lock : timing->locks) {
      const double begin = timing->frame_of(lock, frames()) * f / frames();
      const double end = (lock.frame + lock.hold) * f / frames();
      fix(begin);
      if (lock.hold == 0) continue;
      rest_between(begin - hold_reach, end + hold_reach, frame);
      before = end;
    }
  }
  fix(f);
  return frame;
}

std::optional<CheckReport> FittedTrack::judge(std::span<const double> values, std::string& trouble) const {
  MoveFile move = played_.move();
  replace_curve(move.tracks.front(), {values.begin(), values.end()});
  try {
    const Plan plan(std::move(move), played_);
    const std::vector<double>& again = plan.tracks().front().control_values();
    double largest = 0;
    double difference = again.size() == values.size() ? 0 : largest_control_value;
    for (std::size_t i = 0; i < std::min(again.size(), values.size()); ++i) {
      largest = std::max(largest, values[i]);
      difference = std::max(difference, std::fabs(again[i] - values[i]));
    }
    if (difference <= reading_rounding * largest) return checked(plan);
    trouble = "a curve that keeps the limits is changed again by the locked keys; give the holds more frames";
  } catch (const InputError& error) {
    trouble = error.message();
  }
  return std::nullopt;
}

}  // namespace inbetween
