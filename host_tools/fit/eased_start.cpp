#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "host_tools/fit/control_curve.hpp"
#include "host_tools/fit/fewest_frames.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/fit/speed_start.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// The distances of the axes are summed over so many points. They only say in which proportion frames are
/// shared out at first.
constexpr int points_per_stretch = 256;
/// A stretch from rest to rest has at least so many control values, for it rises from 0 and returns to 0
/// within them, and the values beside a rest are 0 too.
constexpr std::size_t min_values_per_stretch = 16;

/// A place where the move rests or touches 0, or an end of it.
struct RestingPlace {
  double distance = 0;
  double begin = 0, end = 0;  ///< frames
  bool is_free = false;       ///< it has no frame of its own
};

std::vector<RestingPlace> resting_places(const FittedTrack& fitted) {
  std::vector<RestingPlace> places;
  const KeyTiming& timing = *fitted.solved().key_timing();
  for (const KeyLock& lock : timing.locks) {
    const double begin = timing.frame_of(lock, fitted.frames());
    const bool has_frame = lock.key >= 0 && static_cast<std::size_t>(lock.key) < fitted.file().keys.size() &&
                           fitted.file().keys[static_cast<std::size_t>(lock.key)].frame.has_value();
    const auto whole = static_cast<std::int32_t>(begin);
    const TwoSum distance = fitted.track().distance({whole, begin - whole});
    places.push_back({distance.high + distance.low, begin, begin + lock.hold, lock.ease && !has_frame});
  }
  return places;
}

/// From rest to rest along the path, as if each axis went its whole distance straight on.
double seconds_between(const FittedTrack& fitted, double begin, double end) {
  const Path& path = fitted.track().path();
  std::vector<double> before(fitted.axes().size());
  std::vector<double> distances(fitted.axes().size());
  for (int i = 0; i <= points_per_stretch; ++i) {
    const PathPoint point =
        fitted.track().arc_length().locate({begin + (end - begin) * i / points_per_stretch, 0});
    for (std::size_t d = 0; d < distances.size(); ++d) {
      const double position = path.position(point, static_cast<std::int32_t>(d));
      if (i > 0) distances[d] += std::fabs(position - before[d]);
      before[d] = position;
    }
  }
  double seconds = 0;
  for (std::size_t d = 0; d < distances.size(); ++d) {
    const RigAxis& limits = fitted.axes()[d];
    seconds = std::max(seconds, 2 * seconds_from_rest(distances[d] / 2, limits));
    if (limits.max_jerk) seconds = std::max(seconds, 4 * std::cbrt(distances[d] / (2 * *limits.max_jerk)));
  }
  return seconds;
}

/// Gives each free place its frames between the two nearest that are not free.
void share_out(const FittedTrack& fitted, std::span<RestingPlace> places) {
  std::size_t first = 0;
  for (std::size_t last = 1; last < places.size(); ++last) {
    if (places[last].is_free) continue;
    std::vector<double> seconds{0};
    for (std::size_t i = first; i < last; ++i) {
      seconds.push_back(seconds.back() + seconds_between(fitted, places[i].distance, places[i + 1].distance));
    }
    const double frames = places[last].begin - places[first].end;
    for (std::size_t i = first + 1; i < last; ++i) {
      places[i].begin = places[i].end = places[first].end + frames * seconds[i - first] / seconds.back();
    }
    first = last;
  }
}

/// The speed at u of a stretch whose mean speed is 1.
double shape(double u, bool rises, bool falls) {
  const double left = 1 - u;
  if (rises && falls) return 30 * u * u * left * left;
  if (rises) return 2 * u * u * (3 - 2 * u);
  return falls ? 2 * left * left * (3 - 2 * left) : 1;
}

}  // namespace

std::optional<Plan> with_eases_shared_out(const FittedTrack& fitted) {
  if (!fitted.solved().key_timing()) return std::nullopt;
  std::vector<RestingPlace> places = resting_places(fitted);
  if (std::ranges::none_of(places, &RestingPlace::is_free)) return std::nullopt;
  share_out(fitted, places);
  std::vector<double> values = fitted.solved().control_values();
  while (values.size() < min_values_per_stretch * places.size() && 2 * values.size() <= max_refined_values) {
    values = refined(values, fitted.ends());
  }
  const std::vector<bool> rests = rests_of(values, fitted.ends());
  const double frames_per_value = fitted.frames() / static_cast<double>(values.size() - 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double frame = static_cast<double>(i) * frames_per_value;
    values[i] = 0;
    for (std::size_t k = 0; k + 1 < places.size(); ++k) {
      const double begin = places[k].end;
      const double end = places[k + 1].begin;
      if (frame < begin || frame > end || !(end > begin)) continue;
      const bool rises = k > 0 || rests.front();
      const bool falls = k + 2 < places.size() || rests.back();
      const double mean = (places[k + 1].distance - places[k].distance) / (end - begin);
      values[i] = mean * shape((frame - begin) / (end - begin), rises, falls);
    }
  }
  const double wanted = ControlCurve(fitted.solved().control_values(), fitted.ends()).mean();
  if (fitted.ends() == CurveEnds::periodic) values.back() = values.front();
  const double largest = *std::ranges::max_element(values);
  const double factor =
      std::min(wanted / ControlCurve(values, fitted.ends()).mean(), largest_control_value / largest);
  for (double& value : values) value *= factor;
  if (rests.front()) values[0] = values[1] = 0;
  if (rests.back()) values[values.size() - 1] = values[values.size() - 2] = 0;
  MoveFile move = fitted.played().move();
  replace_curve(move.tracks.front(), std::move(values));
  try {
    return Plan(std::move(move), fitted.played());
  } catch (const InputError&) {  // no such curve meets the keys
    return std::nullopt;
  }
}

}  // namespace inbetween
