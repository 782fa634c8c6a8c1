#include "host_tools/takes/take_measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

double length_of(const Vector3& v) {
  return std::hypot(v.x, v.y, v.z);
}

}  // namespace

double angle_between(const Rotation3& from, const Rotation3& to) {
  const Rotation3 turn = inverse(from) * to;
  // Of a turn by w about u: this vector is 2 sin w u, and the trace is 1 + 2 cos w.
  const Vector3 sine{turn.y.z - turn.z.y, turn.z.x - turn.x.z, turn.x.y - turn.y.x};
  const double cosine = turn.x.x + turn.y.y + turn.z.z - 1;
  return std::atan2(length_of(sine), cosine) * 180 / std::numbers::pi;
}

std::string in_words(double error, const Measure& measure) {
  const double magnitude = std::fabs(error);
  if (!std::isfinite(magnitude)) return "out of sight";
  if (magnitude < measured_least) return "0 " + measure.unit;
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(magnitude)));
  const double last_digit = std::pow(10.0, -decimals);
  // A number that has two digits, but for its rounding, stays.
  constexpr double rounding = 1e-9;
  const double rounded = std::ceil(magnitude / last_digit * (1 - rounding)) * last_digit;
  if (magnitude < 1e-4 || magnitude >= 1e6) return fmt::format("{:.1e} {}", rounded, measure.unit);
  return fmt::format("{:.{}f} {}", rounded, std::max(decimals, 0), measure.unit);
}

RigMeasures::RigMeasures(const RigFile& rig, std::shared_ptr<const Kinematics> kinematics)
    : kinematics_(std::move(kinematics)), axes_(rig.axes.size()) {
  for (std::size_t i = 0; i < axes_; ++i) {
    const RigAxis& axis = rig.axes[i];
    measures_.push_back({Measure::Kind::axis, axis.name, std::string(to_string(axis.unit))});
    moved_by_.push_back({i});
  }
  if (kinematics_ == nullptr) return;
  for (const Tip& tip : kinematics_->tips()) {
    add({Measure::Kind::distance, tip.name, "mm"}, tip);
    add({Measure::Kind::angle, tip.name, "deg"}, tip);
  }
  if (const std::optional<RigLens>& lens = rig.lens) {
    const Tip& tip = *std::ranges::find(kinematics_->tips(), lens->tip, &Tip::name);
    lens_.emplace(*lens);
    lens_link_ = static_cast<std::size_t>(tip.link);
    add({Measure::Kind::picture, tip.name, "px"}, tip);
  }
}

void RigMeasures::refuse_other_axes(const TakeSamples& samples) const {
  const auto is_axis = [](const TakeAxis& axis, const Measure& measure) {
    return axis.name == measure.name && axis.unit == measure.unit;
  };
  if (std::ranges::equal(samples.axes(), std::span(measures_).first(axes_), is_axis)) return;
  std::vector<std::string> names;
  for (const TakeAxis& axis : samples.axes()) names.push_back(axis.name);
  throw std::runtime_error(
      fmt::format("inbetween: error: take {} has the axes {}, and the rig others; choose takes of one rig",
                  samples.number(), comma_separated(names)));
}

void RigMeasures::add(Measure measure, const Tip& tip) {
  measures_.push_back(std::move(measure));
  std::vector<std::size_t>& axes = moved_by_.emplace_back();
  for (std::size_t i = 0; i < axes_; ++i) {
    if (kinematics_->tree().moves(static_cast<std::int32_t>(i), tip.link)) axes.push_back(i);
  }
}

void RigMeasures::poses(std::span<const double> axes, std::vector<Pose>& out) const {
  out.resize(kinematics_ == nullptr ? 0 : kinematics_->tree().joints().size());
  if (kinematics_ == nullptr) return;
  const Status status = kinematics_->tree().poses(axes, out);
  if (!status) {
    throw std::runtime_error(fmt::format(
        "inbetween: error: {} is at {}, which is no position of a joint; look at what its drive told",
        measures_[static_cast<std::size_t>(status.error().axis)].name,
        axes[static_cast<std::size_t>(status.error().axis)]));
  }
}

void RigMeasures::take(std::span<const double> from, std::span<const double> to,
                       std::span<double> out) const {
  for (std::size_t i = 0; i < axes_; ++i) out[i] = to[i] - from[i];
  if (kinematics_ == nullptr) return;
  if (std::ranges::equal(from, to)) {
    // No rounding of the same posture, twice the way to the same picture, is an error of the rig.
    std::ranges::fill(out.subspan(axes_), 0.0);
    return;
  }
  std::vector<Pose> before, behind;
  poses(from, before);
  poses(to, behind);
  std::size_t at = axes_;
  for (const Tip& tip : kinematics_->tips()) {
    const auto link = static_cast<std::size_t>(tip.link);
    out[at++] = mm_per_m * length_of(behind[link].position - before[link].position);
    out[at++] = angle_between(before[link].rotation, behind[link].rotation);
  }
  if (lens_) out[at] = lens_->shift(before[lens_link_], behind[lens_link_]);
}

double RigMeasures::effect_of(std::span<const double> errors, std::span<const double> place,
                              std::size_t measure) const {
  std::vector<double> values(measures_.size());
  double sum = 0;
  for (const std::size_t axis : axes_of(measure)) {
    if (errors[axis] == 0) continue;
    std::vector<double> away(place.begin(), place.end());
    away[axis] += errors[axis];
    take(place, away, values);
    sum += std::fabs(values[measure]);
  }
  return sum;
}

}  // namespace inbetween
