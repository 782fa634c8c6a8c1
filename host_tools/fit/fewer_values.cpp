#include "host_tools/fit/fewer_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "host_tools/fit/control_curve.hpp"
#include "host_tools/fit/curve_samples.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::size_t, 11> tried_counts{6, 8, 10, 12, 14, 16, 20, 24, 32, 40, 48};
/// Of its mean: a curve that is no further away than this is taken, and none of more values is tried. A
/// smaller share shows a curve that is nearer and harder to edit.
constexpr double near_enough = 0.05;
/// The drawn curve is seen at so many moments, ten between two of the most values that are tried.
constexpr std::size_t moments_of_curve = 512;

std::vector<double> moments() {
  std::vector<double> moments;
  for (std::size_t i = 0; i <= moments_of_curve; ++i)
    moments.push_back(static_cast<double>(i) / static_cast<double>(moments_of_curve));
  return moments;
}

CurvePlace place_of(double moment, const ControlCurve& curve) {
  return place_at(moment * static_cast<double>(curve.span_count()), curve.span_count());
}

/// The root mean square of the difference of two curves, whatever their control values, each as a share of
/// its mean.
double distance(std::span<const double> one, std::span<const double> other) {
  const ControlCurve a(one);
  const ControlCurve b(other);
  double squares = 0;
  for (const double moment : moments()) {
    const double off =
        a.at(place_of(moment, a)).value / a.mean() - b.at(place_of(moment, b)).value / b.mean();
    squares += off * off;
  }
  return std::sqrt(squares / static_cast<double>(moments_of_curve + 1));
}

/// The curve in `count` control values, with its mean and its rests at the ends; nothing where there is none.
std::optional<std::vector<double>> in_fewer(std::span<const double> values, std::size_t count) {
  const ControlCurve curve(values);
  const std::vector<double> at = moments();
  std::vector<double> areas;
  areas.reserve(at.size());
  for (const double moment : at) areas.push_back(curve.at(place_of(moment, curve)).area / curve.total());
  const std::vector<bool> rests = rests_of(values);
  auto fewer = CurveSamples(at, count - 1)
                   .fit(areas, {.total = 1, .rests_at_start = rests.front(), .rests_at_end = rests.back()});
  if (!fewer) return std::nullopt;
  const double scale = curve.mean() / ControlCurve(*fewer).mean();
  for (double& value : *fewer) value *= scale;
  if (std::ranges::max(*fewer) > max_control_value) return std::nullopt;
  return fewer;
}

/// The curve with which the move fits where `drawn` is what its author draws, in as many control values as
/// that takes; the other tracks have the curves of the fit.
std::optional<std::vector<double>> fitted_from(const Plan& plan, const SpeedFit& fit, std::size_t track,
                                               std::vector<double> drawn, const FitOptions& options) {
  MoveFile move = plan.move();
  for (const TrackFit& other : fit.tracks) {
    if (other.track != track) replace_curve(move.tracks[other.track], other.speed);
  }
  move.tracks[track].speed = std::move(drawn);
  move.tracks[track].through = false;
  try {
    const Plan coarse(std::move(move), plan);
    const SpeedFit found = fit_speed(coarse, check(coarse), options);
    if (!found.found) return std::nullopt;
    for (const TrackFit& changed : found.tracks) {
      if (changed.track == track) return changed.speed;
    }
    return coarse.tracks()[track].control_values();
  } catch (const InputError&) {  // so few values cannot meet its locked keys
    return std::nullopt;
  }
}

std::optional<FewerValues> fewer_values(const Plan& plan, const SpeedFit& fit, const TrackFit& changed,
                                        const FitOptions& options) {
  const MoveTrack& track = plan.move().tracks[changed.track];
  const std::vector<double>& played = plan.tracks()[changed.track].control_values();
  if (track.periodic || track.speed.size() < 2) return std::nullopt;
  const std::vector<double>& drawn = track.through ? played : track.speed;
  std::optional<FewerValues> nearest;
  for (const std::size_t count : tried_counts) {
    if (nearest && nearest->further_share <= near_enough) break;
    if (count >= changed.speed.size() || options.ends()) break;
    std::optional<std::vector<double>> coarse = in_fewer(drawn, count);
    if (!coarse) continue;
    auto found = fitted_from(plan, fit, changed.track, std::move(*coarse), options);
    if (!found || found->size() >= changed.speed.size()) continue;
    const double further = distance(*found, played) - distance(changed.speed, played);
    if (nearest && further >= nearest->further_share) continue;
    nearest = {.speed = std::move(*found), .further_share = std::max(0.0, further)};
  }
  return nearest;
}

}  // namespace

void add_fewer_values(const Plan& plan, SpeedFit& fit, const FitOptions& options) {
  FitOptions quick = options;
  quick.progress = {};
  quick.refinements = 0;
  for (TrackFit& changed : fit.tracks) {
    if (changed.speed.size() > max_editable_values) changed.fewer = fewer_values(plan, fit, changed, quick);
  }
}

}  // namespace inbetween
