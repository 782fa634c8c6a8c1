#include "host_tools/plan/ode_frame_table.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "inbetween/base/zeroin.hpp"

namespace inbetween {
namespace {

/// How far beyond its end the path is extended, in s (design: the paper's slack).
constexpr double slack = 0.5;
/// The last frame may miss the end of the path by this much in s and is then put on it:
/// RungeKutta.RefusesATableThatMissesTheLastKey.
constexpr double end_tolerance = 1e-6;
/// A table whose speed is off by more is refused, with more steps a frame as the remedy:
/// RungeKutta.RefusesASpeedMoreThanTwoPercentOffAndAsksForMoreSteps.
constexpr double worst_speed_error_allowed = 0.02;
/// Of the search for K: ZEROIN halves its interval at least every few trials, and a hundred are far more than
/// the digits of K. It also ends the search for an interval.
constexpr std::int32_t max_integrations = 100;

/// The speed of one segment, precomputed for the integration: sigma(t) = sqrt(q(t)) / scale.
struct OdeSegment {
  double q0 = 0, q1 = 0, q2 = 0, q3 = 0, q4 = 0;
  double scale = 1;  ///< a power of two, so that no square overflows or vanishes
};

/// q = |W P'|^2, a quartic in t; nothing where the segment stays in one place.
OdeSegment speed_of(std::span<const Cubic> cubics, std::span<const double> weights) {
  double largest = 0;
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    for (const double slope : {cubics[d].c1, 2 * cubics[d].c2, 3 * cubics[d].c3})
      largest = std::max(largest, std::fabs(weights[d] * slope));
  }
  if (largest == 0) return {};
  int exponent = 0;
  static_cast<void>(std::frexp(largest, &exponent));
  OdeSegment speed{.scale = std::ldexp(1.0, -exponent)};
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    const double weight = weights[d] * speed.scale;
    const double a = weight * cubics[d].c1;
    const double b = weight * 2 * cubics[d].c2;
    const double c = weight * 3 * cubics[d].c3;
    speed.q0 += a * a;
    speed.q1 += 2 * a * b;
    speed.q2 += b * b + 2 * a * c;
    speed.q3 += 2 * b * c;
    speed.q4 += c * c;
  }
  return speed;
}

/// One integration of the whole move after another.
class Integration {
 public:
  Integration(const Track& track, std::int32_t substeps, std::span<const OdeSegment> segments)
      : track_(track),
        segments_(segments),
        end_(static_cast<double>(track.path().segment_count())),
        limit_(end_ + slack),
        substeps_(substeps) {}

  /// s(f) - n for a trial K; a trial that runs beyond the slack stops there.
  double overshoot(double constant) {
    ++count_;
    return run(constant, [](std::int32_t, double) {}) - end_;
  }
  /// s at every frame.
  template <class Record>
  double run(double constant, Record record) {
    const std::int32_t f = track_.profile().span_count();
    const std::int64_t steps_per_span_line = static_cast<std::int64_t>(track_.frames()) * substeps_;
    const double h = static_cast<double>(f) / static_cast<double>(steps_per_span_line);
    const double k_h = constant * h;
    const double half = h / 2;
    double s = 0;
    std::int64_t phase = 0;  // a = (span * N k + phase) / (N k), in steps of f
    std::int32_t span = 0;
    double phi = track_.profile().span(0).value(0);
    for (std::int32_t frame = 1; frame <= track_.frames(); ++frame) {
      for (std::int32_t i = 0; i < substeps_; ++i) {
        const double t = static_cast<double>(phase) / static_cast<double>(steps_per_span_line);
        phase += f;
        const double phi_middle = phi_at(span, t + half);
        while (phase >= steps_per_span_line && span + 1 < f) {
          phase -= steps_per_span_line;
          ++span;
        }
        const double phi_end = track_.profile().span(span).value(static_cast<double>(phase) /
                                                                 static_cast<double>(steps_per_span_line));
        const double s1 = k_h * phi * slowness(s);
        const double s2 = k_h * phi_middle * slowness(s + s1 / 2);
        const double s3 = k_h * phi_middle * slowness(s + s2 / 2);
        const double s4 = k_h * phi_end * slowness(s + s3);
        s += (s1 + 2 * (s2 + s3) + s4) / 6;
        phi = phi_end;
      }
      if (!(s <= limit_)) return std::isfinite(s) ? limit_ : s;
      record(frame, s);
    }
    return s;
  }
  [[nodiscard]] std::int32_t count() const { return count_; }

 private:
  [[nodiscard]] double phi_at(std::int32_t span, double t) const {
    while (t >= 1 && span + 1 < track_.profile().span_count()) {
      t -= 1;
      ++span;
    }
    return track_.profile().span(span).value(t);
  }
  /// 1 / |P'(s)|; beyond the end that of the last tangent.
  [[nodiscard]] double slowness(double s) const {
    // Not std::clamp: a NaN must not become an index. It stays in t, and so in the result.
    const auto index = static_cast<std::size_t>(s > 0 ? std::min(s, end_) : 0.0);
    const OdeSegment& g = segments_[index];
    const double t = s - static_cast<double>(index);
    return g.scale / std::sqrt(g.q0 + t * (g.q1 + t * (g.q2 + t * (g.q3 + t * g.q4))));
  }

  const Track& track_;
  std::span<const OdeSegment> segments_;
  double end_;
  double limit_;
  std::int32_t substeps_;
  std::int32_t count_ = 0;
};

/// The last entry is the extension along the last tangent: constant speed.
Status prepare(const Path& path, std::vector<OdeSegment>& segments) {
  const auto singular = [&](const char* what) {
    return Error{.code = ErrorCode::singular,
                 .what = what,
                 .remedy = "use the closed-form solver",
                 .key = static_cast<std::int32_t>(segments.size())};
  };
  for (std::int32_t i = 0; i <= path.segment_count(); ++i) {
    const OdeSegment speed = speed_of(path.segment(i), path.weights());
    const bool is_still = speed.q0 == 0 && speed.q2 == 0 && speed.q4 == 0;
    if (is_still) {
      return singular(
          "the path stands still after this key, and the Runge-Kutta solver divides by its speed");
    }
    if (!(speed.q0 > 0))
      return singular("the path has no speed at this key, and the Runge-Kutta solver divides by it");
    const bool is_extension = i == path.segment_count();
    segments.push_back(is_extension ? OdeSegment{.q0 = speed.q0, .scale = speed.scale} : speed);
  }
  return Done{};
}

/// The sum of the chords in weighted space over Phi(f): K of the polygon, below that of the path.
double polygon_constant(const Track& track) {
  const Path& path = track.path();
  double sum = 0;
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    double square = 0;
    for (std::size_t d = 0; d < path.weights().size(); ++d) {
      const double chord = path.weights()[d] * (path.segment(i + 1)[d].c0 - path.segment(i)[d].c0);
      square += chord * chord;
    }
    sum += std::sqrt(square);
  }
  return sum / track.profile().total_integral();
}

/// Two values of K whose moves end before and behind the end of the path.
struct ConstantBracket {
  Sample low;
  Sample high;
};

Result<ConstantBracket> bracket(Integration& integration, double guess) {
  Sample low{0, 0};
  Sample trial{guess, integration.overshoot(guess)};
  double factor = 1.125;
  while (integration.count() < max_integrations && std::isfinite(trial.y)) {
    if (trial.y >= 0 && low.x > 0) return ConstantBracket{low, trial};
    if (trial.y < 0) {
      low = trial;
      trial.x *= factor;
    } else {
      trial.x /= 2;
    }
    trial.y = integration.overshoot(trial.x);
    factor *= factor;
  }
  return Error{
      .code = std::isfinite(trial.y) ? ErrorCode::not_bracketed : ErrorCode::singular,
      .what = "the trial integrations of the Runge-Kutta solver found no speed that ends the move in time",
      .remedy = "use the closed-form solver"};
}

Status check_request(const Track& track, const OdeOptions& options, std::size_t point_memory) {
  const std::size_t count = static_cast<std::size_t>(track.frames()) + 1;
  if (options.substeps < 1 || options.substeps > 10'000) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the number of Runge-Kutta steps a frame is not between 1 and 10000",
                 .remedy = "use 10, the paper's value"};
  }
  if (point_memory < count) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more frames than the memory of the table",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(count)};
  }
  if (!track.has_profile() || !track.portions().empty()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what =
                     "the Runge-Kutta solver knows one speed curve for the whole move, no breaks and no move "
                     "timed by frames",
                 .remedy = "use the closed-form solver"};
  }
  return Done{};
}

/// Refuses a table that is too far off the drawn speed.
Status judge(const SpeedDeviation& deviation) {
  if (!(deviation.relative <= worst_speed_error_allowed)) {
    return Error{.code = ErrorCode::accuracy,
                 .what = "the Runge-Kutta solver is more than 2 % off the drawn speed",
                 .remedy = "use more steps a frame, or the closed-form solver",
                 .frame = deviation.frame};
  }
  if (!(deviation.absolute <= end_tolerance)) {
    return Error{.code = ErrorCode::accuracy,
                 .what = "the Runge-Kutta solver moves where the drawn speed is next to nothing",
                 .remedy = "use more steps a frame, or the closed-form solver",
                 .frame = deviation.absolute_frame};
  }
  return Done{};
}

}  // namespace

Result<OdeTable> runge_kutta_table(const Track& track, const OdeOptions& options,
                                   std::span<PathPoint> memory) {
  const Path& path = track.path();
  const std::size_t count = static_cast<std::size_t>(track.frames()) + 1;
  if (const Status valid = check_request(track, options, memory.size()); !valid) {
    return valid.error();
  }
  Provenance provenance;
  OdeTable made{.table = {{}, {}}, .substeps = options.substeps};
  if (track.arc_length().total() == 0) {
    std::ranges::fill(memory.first(count), PathPoint{0, 0});
    memory[count - 1] = {path.segment_count(), 0};
    made.table = FrameTable(memory.first(count), provenance);
    return made;
  }
  std::vector<OdeSegment> segments;
  if (const Status ready = prepare(path, segments); !ready) return ready.error();

  Integration integration(track, options.substeps, segments);
  const Result<ConstantBracket> bracketed = bracket(integration, polygon_constant(track));
  if (!bracketed) return bracketed.error();
  const Sample best = zeroin([&](double k) { return integration.overshoot(k); }, bracketed->low,
                             bracketed->high, options.tolerance * bracketed->high.x, max_integrations);
  provenance.constant = best.x;

  const double end = static_cast<double>(path.segment_count());
  const double tolerance = std::max(end_tolerance, 100 * options.tolerance * end);
  memory[0] = {0, 0};
  const double reached = integration.run(best.x, [&](std::int32_t frame, double s) {
    const auto segment = static_cast<std::int32_t>(std::min(s, end));
    const bool at_end = segment == path.segment_count();
    memory[static_cast<std::size_t>(frame)] = {segment, at_end ? 0.0 : s - static_cast<double>(segment)};
  });
  made.integrations = integration.count() + 1;
  if (!(std::fabs(reached - end) <= tolerance)) {
    return Error{.code = ErrorCode::not_converged,
                 .what = "the Runge-Kutta solver does not end at the last key",
                 .remedy = "use more steps a frame, or the closed-form solver"};
  }
  // A dwell at the end stands where the last step ended, and that is the end.
  const PathPoint last = memory[count - 1];
  for (std::size_t i = count; i-- > 0 && memory[i] == last;) memory[i] = {path.segment_count(), 0};

  const SpeedDeviation deviation =
      measure_speed_deviation(track, std::span<const PathPoint>(memory.first(count)));
  provenance.speed_error = deviation.relative;
  made.speed_error_frame = deviation.frame;
  provenance.short_step_error = deviation.absolute;
  if (const Status good = judge(deviation); !good) return good.error();
  made.table = FrameTable(memory.first(count), provenance);
  return made;
}

}  // namespace inbetween
