#include "host_tools/fit/fit_output.hpp"

namespace inbetween {
namespace {

/// As many as an axis over time has in the picture of a plan (smooth_samples in plan_plot.cpp): it looks
/// smooth.
constexpr int curve_samples = 1200;

/// phi over the frames 0..`frames` of the picture.
std::vector<Point> curve_of(const SolvedTrack& solved, std::int32_t frames) {
  const SpeedProfile& profile = solved.track().profile();
  std::vector<Point> samples;
  for (int i = 0; i <= curve_samples; ++i) {
    const double share = static_cast<double>(i) / curve_samples;
    samples.push_back({share * frames, profile.value(share * profile.span_count())});
  }
  return samples;
}

}  // namespace

void add_fitted_curves(const Plan& before, const Plan& after, const SpeedFit& fit, LimitsPlot& plot) {
  for (const TrackFit& track : fit.tracks) {
    plot.curves.push_back({.axes = comma_separated(before.move().tracks[track.track].axes),
                           .before = curve_of(before.tracks()[track.track], after.move().frames),
                           .after = curve_of(after.tracks()[track.track], after.move().frames)});
  }
}

}  // namespace inbetween
