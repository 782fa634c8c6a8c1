#include "host_tools/fit/motion_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "host_tools/fit/curve_samples.hpp"
#include "host_tools/fit/key_fit.hpp"
#include "inbetween/path/arc_length.hpp"

namespace inbetween {
namespace {

/// Of the tolerance: how near the path of one axis, and at least that of the first keys, comes to the motion
/// without noise. The other half is for the noise that is left in it
/// (MotionFitProperty.AHandsMotionComesBackWithinItsToleranceAndTwoPercentOfItsPeakSpeed).
constexpr double key_share = 0.5;
/// Or so much of how far the motion reaches: enough for the first keys to show how it winds.
constexpr double coarse = 0.03;
/// A root mean square of this share of the tolerance is not worth another key.
constexpr double worth = 0.1;
/// A path that goes so many tolerances astray between two samples makes loops of its own.
constexpr double farthest_astray = 2;
/// Keys are no nearer to each other, in tolerances: where the hand stands they would follow its noise.
constexpr double nearest_keys = 4;
/// The search for keys ends where so many more of them gain nothing: a key that gains nothing may be one of
/// two that do.
constexpr int max_idle_keys = 3;
/// Each time a key is added the keys descend so far. The next key moves them again, so that the least is not
/// needed.
constexpr int max_key_steps = 12;
/// No sample is known better than to this share of the tolerance: without noise the criterion would grant as
/// many control values as there are.
constexpr double finest = 1e-3;
/// Control values are tried in steps of a quarter more, up to one for three samples and no more than this.
/// The criterion grants fewer to a hand; the time grows with them.
constexpr std::size_t max_spans = 160;
/// A speed curve counts by its shape: 10 of 100 is written with few digits and leaves room to draw higher.
constexpr double largest_value = 10;
/// A hand that is slower than this share of the peak at an end stands there. Its curve rests, because a speed
/// of 0 that rises at once would step the acceleration:
/// MotionFit.AHandThatStartsAndStopsAtOnceStillRestsAtItsEnds.
constexpr double slow_end = 0.05;
/// The motion without its noise is looked at in so many places between two control values.
constexpr std::size_t per_span = 8;

[[noreturn]] void refuse(const std::string& why) {
  throw std::invalid_argument(why);
}

/// Exact positions may be so many tolerances from the path, and what is left of one early or late. A path
/// that is nearer has more keys, and its curve may have fewer values: the three are tried.
constexpr std::array<double, 3> path_shares{0.7, 0.3, 0.1};
/// Exact positions that need more keys were not drawn so. The search takes seconds with these.
constexpr std::size_t max_exact_keys = 40;
/// Of exact positions the drawn number of control values is met, up to this one; more are tried in steps of a
/// quarter.
constexpr std::size_t max_single_spans = 32;
/// A curve of exact positions is written with so many digits that rounding moves nothing by more than this
/// share of the tolerance.
constexpr double written_lag = 0.01;

/// Counts of spans worth trying, rising.
std::vector<std::size_t> span_counts(std::size_t samples) {
  std::vector<std::size_t> counts;
  const std::size_t most = std::min(max_spans, std::max<std::size_t>(samples / 3, 4));
  for (std::size_t spans = 4; spans <= most; spans = std::max(spans + 1, spans * 5 / 4))
    counts.push_back(spans);
  return counts;
}

/// The recording, checked, with its times as shares of the fitted frames and its positions in tolerances.
struct Recording {
  explicit Recording(const SampledMotion& sampled);

  [[nodiscard]] double at(std::size_t sample, std::size_t axis) const {
    return positions[sample * axes + axis];
  }
  std::size_t axes = 0;
  bool is_exact = false;
  std::int32_t frames = 1;
  std::vector<double> moments;       ///< 0..1
  std::vector<double> positions;     ///< in axis units
  std::vector<double> scales;        ///< one over the tolerance, 0 for an axis that does not count
  std::vector<std::size_t> counted;  ///< axes
};

Recording::Recording(const SampledMotion& sampled)
    : axes(sampled.tolerances.size()), is_exact(sampled.is_exact), positions(sampled.positions) {
  const std::size_t count = sampled.times.size();
  if (count < 8) refuse("a motion needs 8 samples at least; draw longer");
  if (count > max_motion_samples) refuse(fmt::format("a motion has {} samples at most", max_motion_samples));
  if (axes == 0 || positions.size() != count * axes || sampled.weights.size() != axes)
    refuse("a motion has a position for every axis and time");
  for (const double position : positions) {
    if (!(std::fabs(position) <= 1e12)) refuse("a motion has finite positions");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!(sampled.times[i] <= 1e6) ||
        (i == 0 ? sampled.times[0] != 0 : !(sampled.times[i] > sampled.times[i - 1])))
      refuse("the times of a motion rise from 0");
  }
  for (std::size_t a = 0; a < axes; ++a) {
    if (!(sampled.tolerances[a] > 0) || !(sampled.weights[a] >= 0) || !std::isfinite(sampled.weights[a]))
      refuse("a tolerance is above 0, and a weight not below");
    scales.push_back(1 / sampled.tolerances[a]);
    if (scales.back() > 0) counted.push_back(a);
  }
  const double frames_needed = sampled.times.back() * sampled.frames_per_second;
  if (!(frames_needed > 0 && frames_needed <= 50'000)) refuse("a motion has 1 to 50000 frames");
  frames = std::max(1, static_cast<std::int32_t>(std::ceil(frames_needed - 1e-6)));
  const double seconds = frames / sampled.frames_per_second;
  for (const double time : sampled.times) moments.push_back(time / seconds);
}

/// The motion without its noise.
struct SmoothMotion {
  std::vector<CurveSamples::Free> curves;   ///< one per axis
  std::vector<std::vector<double>> points;  ///< densely over the time of the recording
  double noise = 0;
};

std::vector<double> point_at(const std::vector<CurveSamples::Free>& curves, double moment) {
  std::vector<double> point;
  for (const CurveSamples::Free& curve : curves) {
    const ControlCurve integral(curve.values);
    const std::size_t spans = integral.span_count();
    point.push_back(curve.offset + integral.at(place_at(moment * static_cast<double>(spans), spans)).area);
  }
  return point;
}

SmoothMotion smoothed(const Recording& recording) {
  const std::size_t count = recording.moments.size();
  SmoothMotion best;
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t spans : span_counts(count)) {
    const CurveSamples samples(recording.moments, spans);
    std::vector<CurveSamples::Free> curves;
    double square = 0;
    for (std::size_t a = 0; a < recording.axes; ++a) {
      std::vector<double> values(count);
      for (std::size_t i = 0; i < count; ++i) values[i] = recording.at(i, a);
      curves.push_back(samples.fit(values));
      const ControlCurve integral(curves.back().values);
      for (std::size_t i = 0; i < count; ++i) {
        const CurvePlace place = place_at(recording.moments[i] * static_cast<double>(spans), spans);
        const double left =
            (curves.back().offset + integral.at(place).area - values[i]) * recording.scales[a];
        square += left * left;
      }
    }
    const std::size_t numbers = count * recording.counted.size();
    square /= static_cast<double>(numbers);
    const double score =
        information(square + finest * finest, numbers, (spans + 2) * recording.counted.size());
    if (score >= least) continue;
    least = score;
    best = {.curves = std::move(curves), .points = {}, .noise = std::sqrt(square)};
  }
  const std::size_t places = per_span * (best.curves.front().values.size() - 1);
  for (std::size_t i = 0; i <= places; ++i) {
    best.points.push_back(point_at(
        best.curves, recording.moments.back() * static_cast<double>(i) / static_cast<double>(places)));
  }
  return best;
}

/// Where the motion is without noise at some of its points, as keys.
std::vector<double> keys_at(const SmoothMotion& motion, const std::vector<std::size_t>& points) {
  std::vector<double> keys;
  for (const std::size_t point : points)
    keys.insert(keys.end(), motion.points[point].begin(), motion.points[point].end());
  return keys;
}

/// For each moment of `moments` (shares of the recording), where it lies between the points that are keys.
std::vector<double> places_between(const std::vector<std::size_t>& keys, std::span<const double> moments) {
  const auto last = static_cast<double>(keys.back());
  std::vector<double> places;
  for (const double moment : moments) {
    const double point = moment * last;
    auto k = static_cast<std::size_t>(std::ranges::upper_bound(keys, static_cast<std::size_t>(point)) -
                                      keys.begin() - 1);
    k = std::min(k, keys.size() - 2);
    const auto begin = static_cast<double>(keys[k]);
    const double share = (point - begin) / (static_cast<double>(keys[k + 1]) - begin);
    places.push_back(static_cast<double>(k) + share);
  }
  return places;
}

PassedPoints points_of(const SmoothMotion& motion, const Recording& recording,
                       std::span<const double> weights) {
  PassedPoints points{.axes = recording.axes,
                      .positions = {},
                      .scales = recording.scales,
                      .weights = {weights.begin(), weights.end()}};
  for (const std::vector<double>& point : motion.points)
    points.positions.insert(points.positions.end(), point.begin(), point.end());
  return points;
}

/// The samples, but at its ends the motion without noise: there nothing else says how far the path goes.
PassedPoints samples_of(const SmoothMotion& motion, const Recording& recording,
                        std::span<const double> weights) {
  PassedPoints points = points_of(motion, recording, weights);
  points.positions = recording.positions;
  std::ranges::copy(motion.points.front(), points.positions.begin());
  std::ranges::copy(motion.points.back(),
                    points.positions.end() - static_cast<std::ptrdiff_t>(recording.axes));
  return points;
}

/// Points of the motion without noise whose path is nowhere farther than `distance` from it: keys are added
/// where it is farthest.
std::vector<std::size_t> points_within(const SmoothMotion& motion, const PassedPoints& points,
                                       double distance) {
  std::vector<std::size_t> keys = {0, motion.points.size() - 1};
  std::vector<double> moments;
  for (std::size_t i = 0; i < motion.points.size(); ++i)
    moments.push_back(static_cast<double>(i) / static_cast<double>(motion.points.size() - 1));
  while (true) {
    const KeyFit fit(points, keys_at(motion, keys), places_between(keys, moments));
    if (!fit.is_path()) refuse("the motion stands where a key would be; draw it again");
    const std::size_t worst = fit.farthest();
    if (fit.distance(worst) <= distance) return keys;
    const auto after = std::ranges::lower_bound(keys, worst);
    if (keys.size() >= max_drawn_keys || (after != keys.end() && *after == worst))
      refuse(fmt::format("no path with {} keys is within the tolerance; allow more", max_drawn_keys));
    keys.insert(after, worst);
  }
}

/// How far the motion reaches, in tolerances.
double extent_of(const SmoothMotion& motion, const Recording& recording) {
  double square = 0;
  for (const std::size_t a : recording.counted) {
    const auto [low, high] = std::ranges::minmax_element(
        motion.points, {}, [a](const std::vector<double>& point) { return point[a]; });
    square += std::pow(((*high)[a] - (*low)[a]) * recording.scales[a], 2);
  }
  return std::sqrt(square);
}

struct Keys {
  std::vector<double> at;
  std::vector<double> places;  ///< of the samples
  double deviation = 0;
};

/// How far the samples themselves bend between one and the next, in tolerances: a second difference is eight
/// times that.
double sag_of(const Recording& recording) {
  double largest = 0;
  for (std::size_t i = 1; i + 1 < recording.moments.size(); ++i) {
    double square = 0;
    for (const std::size_t a : recording.counted) {
      const double bend = recording.at(i - 1, a) - 2 * recording.at(i, a) + recording.at(i + 1, a);
      square += std::pow(bend * recording.scales[a] / 8, 2);
    }
    largest = std::max(largest, std::sqrt(square));
  }
  return largest;
}

/// How far each point of the motion is along it, in tolerances.
std::vector<double> lengths_along(const SmoothMotion& motion, const Recording& recording) {
  std::vector<double> lengths{0};
  for (std::size_t i = 1; i < motion.points.size(); ++i) {
    double square = 0;
    for (const std::size_t a : recording.counted)
      square += std::pow((motion.points[i][a] - motion.points[i - 1][a]) * recording.scales[a], 2);
    lengths.push_back(lengths.back() + std::sqrt(square));
  }
  return lengths;
}

/// So many points of the motion that are as far apart as each other along it.
std::vector<std::size_t> even_points(const SmoothMotion& motion, const Recording& recording,
                                     std::size_t count) {
  const std::vector<double> lengths = lengths_along(motion, recording);
  std::vector<std::size_t> points{0};
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const double at = lengths.back() * static_cast<double>(k) / static_cast<double>(count - 1);
    const auto point = static_cast<std::size_t>(std::ranges::lower_bound(lengths, at) - lengths.begin());
    if (point > points.back() && point + 1 < motion.points.size()) points.push_back(point);
  }
  points.push_back(motion.points.size() - 1);
  return points;
}

/// From two keys on, one more at a time, until every sample is near enough. Each number of keys is tried from
/// keys that are evenly apart, and from those before with one more where they miss most. Nothing where no
/// path of `max_count` keys is near enough.
std::optional<Keys> exact_keys(const SmoothMotion& motion, const Recording& recording,
                               std::span<const double> weights, double share, std::size_t max_count) {
  const PassedPoints samples = samples_of(motion, recording, weights);
  std::vector<double> shares = recording.moments;
  for (double& moment : shares) moment /= recording.moments.back();
  const auto fit_through = [&](const std::vector<std::size_t>& points) {
    return KeyFit(samples, keys_at(motion, points), places_between(points, shares));
  };
  const double astray = farthest_astray * (1 + sag_of(recording));
  const auto is_near = [&](const KeyFit& fit) {
    return fit.is_path() && fit.distance(fit.farthest()) <= share && fit.excursion() <= astray;
  };
  const auto keys_of = [](const KeyFit& fit) {
    return Keys{
        {fit.keys().begin(), fit.keys().end()}, {fit.places().begin(), fit.places().end()}, fit.deviation()};
  };
  KeyFit grown = fit_through({0, motion.points.size() - 1});
  for (std::size_t count = 2; count <= max_count && grown.is_path(); ++count) {
    grown.descend(max_key_steps);
    if (is_near(grown)) return keys_of(grown);
    KeyFit even = fit_through(even_points(motion, recording, count));
    if (even.is_path()) even.descend(max_key_steps);
    if (is_near(even)) return keys_of(even);
    if (even.is_path() && even.mean_square() < grown.mean_square()) grown = even;
    if (!grown.split_worst(0)) break;
  }
  return std::nullopt;
}

/// From few keys on, one more at a time, as long as the criterion gains by it.
Keys fitted_keys(const SmoothMotion& motion, const Recording& recording, std::span<const double> weights) {
  const PassedPoints smooth = points_of(motion, recording, weights);
  const PassedPoints samples = samples_of(motion, recording, weights);
  std::vector<double> shares = recording.moments;
  for (double& share : shares) share /= recording.moments.back();
  const auto through_points = [&]() -> Keys {
    const std::vector<std::size_t> points = points_within(motion, smooth, key_share);
    const KeyFit fit(samples, keys_at(motion, points), places_between(points, shares));
    return {
        {fit.keys().begin(), fit.keys().end()}, {fit.places().begin(), fit.places().end()}, fit.deviation()};
  };
  if (recording.counted.size() == 1) return through_points();
  const std::vector<std::size_t> points =
      points_within(motion, smooth, std::max(key_share, coarse * extent_of(motion, recording)));
  KeyFit fit(samples, keys_at(motion, points), places_between(points, shares));
  Keys best;
  double least = std::numeric_limits<double>::infinity();
  double nearest = least;  // as long as no path was near enough
  const std::size_t across = recording.counted.size() - 1;
  for (int idle = 0; idle < max_idle_keys && fit.key_count() <= max_drawn_keys; ++idle) {
    fit.descend(max_key_steps);
    const double score = information(fit.mean_square() / static_cast<double>(across) + worth * worth,
                                     shares.size() * across, fit.key_count() * (across + 1));
    const double miss = std::max(fit.deviation(), fit.excursion() / farthest_astray);
    if (miss <= 1 && score < least) {
      least = score;
      best = {{fit.keys().begin(), fit.keys().end()},
              {fit.places().begin(), fit.places().end()},
              fit.deviation()};
      idle = -1;
    } else if (best.at.empty() && miss < nearest) {
      nearest = miss;
      idle = -1;
    }
    if (!fit.split_worst(nearest_keys)) break;
  }
  // The descent can be lost in a hairpin. The path without noise is less near, and has more keys.
  return best.at.empty() ? through_points() : best;
}

/// The distance along the path to each of its places, and behind them to its end.
std::vector<double> distances_of(const KeyFit& fit) {
  const auto segments = static_cast<std::size_t>(fit.path().segment_count());
  std::vector<ArcPiece> pieces(400 * segments);
  std::vector<double> begins(pieces.size());
  std::vector<std::int32_t> buckets(pieces.size());
  std::vector<std::int32_t> first_pieces(segments + 1);
  std::vector<TwoSum> segment_begins(segments + 1);
  const auto length =
      ArcLength::make(fit.path(), {}, {pieces, begins, buckets, first_pieces, segment_begins});
  if (!length || !(length->total() > 0)) refuse("the motion goes nowhere; draw farther");
  std::vector<double> distances;
  for (const double s : fit.places()) {
    const std::int32_t segment = std::clamp(static_cast<std::int32_t>(s), 0, fit.path().segment_count() - 1);
    distances.push_back(length->distance(fit.path(), {segment, s - segment}).high);
  }
  distances.push_back(length->total());
  return distances;
}

struct Pace {
  std::vector<double> values;
  double lag = 0;
};

/// What a curve leaves of the distances.
std::vector<double> left_of(std::span<const double> values, const Recording& recording,
                            std::span<const double> distances) {
  const ControlCurve curve(values);
  const std::size_t spans = curve.span_count();
  std::vector<double> left;
  left.reserve(distances.size());
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const double a = recording.moments[i] * static_cast<double>(spans);
    left.push_back(curve.at(place_at(a, spans)).area - distances[i]);
  }
  return left;
}

double mean_square_of(std::span<const double> numbers) {
  double square = 0;
  for (const double number : numbers) square += number * number;
  return square / static_cast<double>(numbers.size());
}

double largest_size_of(std::span<const double> numbers) {
  double largest = 0;
  for (const double number : numbers) largest = std::max(largest, std::fabs(number));
  return largest;
}

/// span_counts() with every count of few spans.
std::vector<std::size_t> exact_span_counts(std::size_t samples) {
  std::vector<std::size_t> counts;
  for (const std::size_t spans : span_counts(samples)) {
    const std::size_t from = counts.empty() ? spans : counts.back() + 1;
    for (std::size_t more = from; more < spans && more <= max_single_spans; ++more) counts.push_back(more);
    counts.push_back(spans);
  }
  return counts;
}

/// The first curve by which no sample is early or late by more than `tolerance`, in distance.
std::optional<Pace> exact_pace(const Recording& recording, std::span<const double> distances, double total,
                               double tolerance) {
  for (const std::size_t spans : exact_span_counts(distances.size())) {
    const CurveSamples samples(recording.moments, spans);
    for (const auto& [start, end] : {std::pair(true, true), {true, false}, {false, true}, {false, false}}) {
      const CurveBounds bounds{.total = total, .rests_at_start = start, .rests_at_end = end};
      const auto values = samples.fit(distances, bounds);
      if (!values) continue;
      const std::vector<double> left = left_of(*values, recording, distances);
      if (largest_size_of(left) > tolerance) continue;
      Pace pace{.values = *values, .lag = std::sqrt(mean_square_of(left)) / total};
      const double scale = largest_value / *std::ranges::max_element(*values);
      const double digits =
          std::pow(10, std::ceil(-std::log10(written_lag * largest_value * tolerance / total)));
      for (double& value : pace.values) value = std::round(value * scale * digits) / digits;
      return pace;
    }
  }
  return std::nullopt;
}

Pace fitted_pace(const Recording& recording, std::span<const double> distances, double total,
                 double tolerance) {
  std::vector<double> best;
  CurveBounds ends;
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t spans : span_counts(distances.size())) {
    const CurveSamples samples(recording.moments, spans);
    for (const auto& [start, end] : {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
      const CurveBounds bounds{.total = total, .rests_at_start = start, .rests_at_end = end};
      const auto values = samples.fit(distances, bounds);
      if (!values) continue;
      const double floor = finest * tolerance;
      const std::size_t rests = 2 * (static_cast<std::size_t>(start) + static_cast<std::size_t>(end));
      const double score = information(mean_square_of(left_of(*values, recording, distances)) + floor * floor,
                                       distances.size(), spans - rests);
      if (score < least) least = score, best = *values, ends = bounds;
    }
  }
  if (best.empty()) refuse("no speed curve follows the motion; draw it again");
  // With as many control values: a curve that rests would be granted more of them, for the noise there.
  const double standing = slow_end * *std::ranges::max_element(best);
  ends.rests_at_start = ends.rests_at_start || best.front() < standing;
  ends.rests_at_end = ends.rests_at_end || best.back() < standing;
  if (auto resting = CurveSamples(recording.moments, best.size() - 1).fit(distances, ends))
    best = std::move(*resting);
  Pace pace{.values = best, .lag = std::sqrt(mean_square_of(left_of(best, recording, distances))) / total};
  const double scale = largest_value / *std::ranges::max_element(best);
  for (double& value : pace.values) value = std::round(value * scale * 1e4) / 1e4;
  return pace;
}

/// The distances of the samples along the path of these keys.
struct PassedDistances {
  std::vector<double> samples;
  double total = 0;
  double tolerance = 0;  ///< so much distance is a tolerance
};

PassedDistances distances_along(const Keys& keys, const SmoothMotion& motion, const Recording& recording,
                                std::span<const double> weights) {
  const PassedPoints samples = samples_of(motion, recording, weights);
  std::vector<double> distances = distances_of(KeyFit(samples, keys.at, keys.places));
  const double total = distances.back();
  distances.pop_back();
  return {std::move(distances), total, total / lengths_along(motion, recording).back()};
}

MotionFit fit_of(const Keys& keys, const Pace& pace, const Recording& recording, double noise) {
  MotionFit found{.keys = {},
                  .speed = pace.values,
                  .frames = recording.frames,
                  .noise = noise,
                  .deviation = keys.deviation,
                  .lag = pace.lag};
  for (auto key = keys.at.begin(); key != keys.at.end(); key += static_cast<std::ptrdiff_t>(recording.axes))
    found.keys.emplace_back(key, key + static_cast<std::ptrdiff_t>(recording.axes));
  return found;
}

MotionFit fit_exactly(const SmoothMotion& motion, const Recording& recording, std::span<const double> weights,
                      std::size_t max_numbers) {
  std::optional<MotionFit> best;
  std::size_t fewest = max_numbers;  // not more than these
  for (const double share : path_shares) {
    const std::size_t max_count = std::min(max_exact_keys, fewest / recording.axes);
    const std::optional<Keys> keys = recording.counted.size() == 1
                                         ? std::optional(fitted_keys(motion, recording, weights))
                                         : exact_keys(motion, recording, weights, share, max_count);
    if (!keys) continue;
    const PassedDistances along = distances_along(*keys, motion, recording, weights);
    const double left = std::sqrt(1 - share * share) * along.tolerance;
    const std::optional<Pace> pace = exact_pace(recording, along.samples, along.total, left);
    if (!pace || keys->at.size() + pace->values.size() > fewest) continue;
    fewest = keys->at.size() + pace->values.size() - 1;
    best = fit_of(*keys, *pace, recording, motion.noise);
  }
  if (!best) refuse("no path and no speed curve keep the tolerance; allow more");
  return *best;
}

}  // namespace

MotionFit fit_motion(const SampledMotion& sampled) {
  const Recording recording(sampled);
  if (recording.counted.empty()) refuse("an axis must count");
  const SmoothMotion motion = smoothed(recording);
  if (!(extent_of(motion, recording) > 1)) refuse("the motion goes nowhere; draw farther");
  if (recording.is_exact) return fit_exactly(motion, recording, sampled.weights, sampled.max_numbers);
  const Keys keys = fitted_keys(motion, recording, sampled.weights);
  const PassedDistances along = distances_along(keys, motion, recording, sampled.weights);
  const Pace pace = fitted_pace(recording, along.samples, along.total, along.tolerance);
  return fit_of(keys, pace, recording, motion.noise);
}

}  // namespace inbetween
