#include "host_tools/fit/speed_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host_tools/fit/control_curve.hpp"
#include "host_tools/fit/path_turns.hpp"
#include "inbetween/base/bisection.hpp"

namespace inbetween {
namespace {

/// In spans of the drawn curve: it rests with two control values, and the next one is at half the height. A
/// longer ramp leaves short moves no speed between their rests.
constexpr double ramp_spans = 2;
/// A segment has so many points, which show how its curvature rises and falls
/// (SpeedFit.TheCurvatureStartMakesTheAccelerationAcrossAnEllipseEven).
constexpr int points_per_segment = 64;
/// Of a path of thousands of keys each segment has fewer, but never fewer than so many.
constexpr int min_points_per_segment = 8;
/// A path of a thousand segments has points_per_segment; the time grows with the points.
constexpr int max_points = 64'000;
/// Of an interval whose ends are a factor of four apart: 54 come to its last bit.
constexpr int bisections = 100;

/// 0 at the rests, 1 far from them, for every control value.
std::vector<double> ramp_of(const StartRequest& request) {
  const std::size_t count = request.values.size();
  const double step = std::ldexp(1 / ramp_spans, -request.refinements);
  std::vector<double> ramp(count, 1);
  double away = 1;
  for (std::size_t i = 0; i < count; ++i) {
    away = request.rests[i] ? 0 : std::min(away + step, 1.0);
    ramp[i] = away;
  }
  away = 1;
  for (std::size_t i = count; i-- > 0;) {
    away = request.rests[i] ? 0 : std::min(away + step, 1.0);
    const double u = std::min(ramp[i], away);
    ramp[i] = u * u * (3 - 2 * u);
  }
  return ramp;
}

/// Scales the values so that their Phi(f) is that of the request. A value may end above 100.
std::vector<double> scaled(std::vector<double> values, const StartRequest& request) {
  const double factor =
      ControlCurve(request.values, request.ends).total() / ControlCurve(values, request.ends).total();
  for (double& value : values) value *= factor;
  return values;
}

/// A short part of a segment.
struct Reach {
  double fastest = 0;   ///< unit/s
  double bend = 0;      ///< the root of the curvature
  double seconds = 0;   ///< at the fastest
  double per_pace = 0;  ///< seconds, times the pace, where the curvature says how fast
};

std::vector<Reach> reaches_of(const Track& track, std::span<const RigAxis> axes) {
  std::vector<Reach> reaches;
  PathTurns turns;
  const Path& path = track.path();
  const int points =
      std::clamp(max_points / std::max(path.segment_count(), 1), min_points_per_segment, points_per_segment);
  double begin = 0;
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    for (int k = 0; k < points; ++k) {
      const double t = (k + 1.0) / points;
      const double end = track.arc_length().distance(path, {i, t}).high;
      if (!(end > begin) || !turns.find(path, {i, (k + 0.5) / points})) continue;
      double fastest = std::numeric_limits<double>::infinity();
      for (std::size_t d = 0; d < axes.size(); ++d) {
        fastest = std::min(fastest, axes[d].max_velocity / std::fabs(turns.axes[d][0]));
      }
      const double bend = std::sqrt(turns.curvature);
      reaches.push_back({fastest, bend, (end - begin) / fastest, (end - begin) * bend});
      begin = end;
    }
  }
  return reaches;
}

double speed_of(const Reach& reach, double pace) {
  return reach.bend > 0 ? std::min(reach.fastest, pace / reach.bend) : reach.fastest;
}

double seconds_of(const Reach& reach, double slowness) {
  return std::max(reach.seconds, reach.per_pace * slowness);
}

double seconds_of(std::span<const Reach> reaches, double pace) {
  double seconds = 0;
  for (const Reach& reach : reaches) seconds += seconds_of(reach, 1 / pace);
  return seconds;
}

/// The pace at which the reaches take `seconds`, or the fastest pace if even that takes longer.
double pace_for(std::span<const Reach> reaches, double seconds) {
  double high = 1;
  double low = 1;
  for (int i = 0; i < bisections && seconds_of(reaches, high) > seconds; ++i) high *= 4;
  for (int i = 0; i < bisections && seconds_of(reaches, low) < seconds; ++i) low /= 4;
  const auto is_too_slow = [&](double pace) { return seconds_of(reaches, pace) > seconds; };
  return bisected({low, high}, bisections, is_too_slow).high;
}

}  // namespace

std::vector<double> flat_start(const StartRequest& request) {
  return scaled(ramp_of(request), request);
}

std::vector<double> curvature_start(const Track& track, std::span<const RigAxis> axes,
                                    const StartRequest& request) {
  const std::vector<double> ramp = ramp_of(request);
  const std::vector<Reach> reaches = reaches_of(track, axes);
  const double spans_per_s = std::ldexp(track.curve_rate(), request.refinements);
  // dL/dt = ramp(a) speed(L) is separable: the seconds at full speed are the integral of the ramp.
  const ControlCurve ramp_curve(ramp, request.ends);
  const double seconds = ramp_curve.total() / spans_per_s;
  const double pace = pace_for(reaches, seconds);
  const double all = seconds_of(reaches, pace);
  std::vector<double> values;
  std::size_t next = 0;
  double elapsed = 0;
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    const CurveValues at = ramp_curve.at(place_at(static_cast<double>(i), ramp_curve.span_count()));
    const double wanted = all * at.area / ramp_curve.total();
    while (next + 1 < reaches.size()) {
      const double takes = seconds_of(reaches[next], 1 / pace);
      if (elapsed + takes >= wanted) break;
      elapsed += takes;
      ++next;
    }
    values.push_back(ramp[i] * speed_of(reaches[next], pace));
  }
  return scaled(values, request);
}

}  // namespace inbetween
