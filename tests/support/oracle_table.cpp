#include "tests/support/oracle_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>

namespace inbetween::oracle {
namespace {

/// Time line of a move: frames to a, and the factor K from drawn to real speed.
struct Timing {
  long double spans_per_frame;
  long double k;
};

Timing timing_of(const Path& path, const Profile& profile, int frames) {
  if (frames < 1) throw std::invalid_argument("oracle: a move needs at least one frame");
  const long double phi_total = profile.integral(static_cast<long double>(profile.spans()));
  const long double length = path.total_length();
  if (length > 0 && !(phi_total > 0))
    throw std::invalid_argument("oracle: nothing moves under a speed curve of zeros");
  return {static_cast<long double>(profile.spans()) / static_cast<long double>(frames),
          length > 0 ? length / phi_total : 0};
}

long double alpha_of(const Profile& profile, int frames, long double frame) {
  return frame * static_cast<long double>(profile.spans()) / static_cast<long double>(frames);
}

long double distance_at(const Path& path, const Profile& profile, const Timing& timing, long double alpha) {
  if (alpha == static_cast<long double>(profile.spans())) return path.total_length();
  return std::min(timing.k * profile.integral(alpha), path.total_length());
}

Row row_of(const Path& path, const Profile& profile, const Timing& timing, long double alpha) {
  Row row{.alpha = alpha,
          .distance = distance_at(path, profile, timing, alpha),
          .speed = timing.k * timing.spans_per_frame * profile.value(alpha),
          .acceleration =
              timing.k * timing.spans_per_frame * timing.spans_per_frame * profile.derivative(1, alpha),
          .place = {}};
  row.place = path.place(row.distance);
  return row;
}

long double ratio(long double error, long double allowed) {
  if (error == 0) return 0;
  return allowed > 0 ? error / allowed : std::numeric_limits<long double>::infinity();
}

Place place_of(const Path& path, std::pair<int, double> point, std::size_t frame) {
  const auto [segment, t] = point;
  if (segment < 0 || segment >= path.segments() || !(t >= 0 && t <= 1))
    throw std::out_of_range("oracle: frame " + std::to_string(frame) + " is at segment " +
                            std::to_string(segment) + ", t = " + std::to_string(t) +
                            ", which is not on the path");
  return {segment, static_cast<long double>(t)};
}

/// Largest step s such that [alpha - 2 s, alpha + 2 s] keeps clear of everything where the motion is not
/// smooth.
long double smooth_step(const Path& path, const Profile& profile, const Timing& timing, long double alpha) {
  const auto place_at = [&](long double a) { return path.place(distance_at(path, profile, timing, a)); };
  const Place here = place_at(alpha);
  const int piece = path.piece(here.segment, here.t);
  const long double span = std::floor(alpha);
  const long double to_knot = std::min(alpha - span, span + 1 - alpha);
  long double step = std::min(to_knot / 2, 0.1L);
  while (step >= 0.5e-3L) {
    bool smooth = true;
    for (const long double a : {alpha - 2 * step, alpha + 2 * step}) {
      const Place there = place_at(a);
      smooth = smooth && there.segment == here.segment && path.piece(there.segment, there.t) == piece;
    }
    if (smooth) return step;
    step /= 1.25L;
  }
  throw std::domain_error("oracle: a = " + std::to_string(alpha) +
                          " is too near a key, a control value or a cusp");
}

struct Derivative {
  long double value = 0;
  long double error = std::numeric_limits<long double>::infinity();
};

/// A difference quotient: its value, and what the rounding of the positions makes of it.
struct Quotient {
  long double value;
  long double rounding;
};

/// Ridders, "Accurate computation of F'(x) and F'(x)F''(x)" (1982): Neville's table in the squared step, and
/// of its entries the one whose neighbours agree best. quotients[k] belongs to the step h / 2^k. The entry
/// that agrees best flatters itself, hence the ten (OracleMotion.OnAParabolaAtConstantSpeedIsTheFormula).
Derivative extrapolated(const std::vector<Quotient>& quotients) {
  Derivative best;
  std::vector<long double> before;
  for (const Quotient& quotient : quotients) {
    std::vector<long double> row = {quotient.value};
    long double factor = 1;
    for (std::size_t k = 0; k < before.size(); ++k) {
      factor *= 4;
      row.push_back((factor * row[k] - before[k]) / (factor - 1));
      const long double difference =
          std::max(std::fabs(row[k + 1] - row[k]), std::fabs(row[k + 1] - before[k]));
      const long double error = 10 * (difference + quotient.rounding);
      if (error < best.error) best = {row[k + 1], error};
    }
    before = row;
  }
  return best;
}

/// Positions of one axis around the middle of the stencil: left[k] and right[k] at 2 h / 2^k.
struct Stencil {
  long double middle = 0;
  long double rounding = 0;
  std::vector<long double> left, right;
};

/// Derivatives 1 to 3 of the stencil whose widest reach is 2 h.
std::array<Derivative, 3> derivatives(const Stencil& stencil, long double h) {
  std::array<std::vector<Quotient>, 3> quotients;
  for (std::size_t k = 1; k < stencil.left.size(); ++k) {
    const long double odd = stencil.right[k] - stencil.left[k];
    const long double odd_wide = stencil.right[k - 1] - stencil.left[k - 1];
    const long double even = (stencil.right[k] - stencil.middle) + (stencil.left[k] - stencil.middle);
    quotients[0].push_back({odd / (2 * h), stencil.rounding / h});
    quotients[1].push_back({even / (h * h), stencil.rounding / (h * h)});
    quotients[2].push_back({(odd_wide - 2 * odd) / (2 * h * h * h), stencil.rounding / (h * h * h)});
    h /= 2;
  }
  return {extrapolated(quotients[0]), extrapolated(quotients[1]), extrapolated(quotients[2])};
}

/// Rounding of a position, from that of the cubic and from that of the distance it was found at.
long double rounding_of_position(const Path& path, Place place, int axis) {
  const long double slope = std::fabs(path.derivative(1, place.segment, place.t, axis));
  const long double along = slope == 0 ? 0 : path.total_length() * slope / path.speed(place.segment, place.t);
  const long double offset = std::fabs(path.offset(place.segment, place.t, axis));
  return std::numeric_limits<long double>::epsilon() * (offset + along);
}

}  // namespace

Row row_at(const Path& path, const Profile& profile, int frames, long double frame) {
  return row_of(path, profile, timing_of(path, profile, frames), alpha_of(profile, frames, frame));
}

std::vector<Row> frame_table(const Path& path, const Profile& profile, int frames) {
  const Timing timing = timing_of(path, profile, frames);
  std::vector<Row> table;
  for (int frame = 0; frame <= frames; ++frame)
    table.push_back(
        row_of(path, profile, timing, alpha_of(profile, frames, static_cast<long double>(frame))));
  return table;
}

SpeedError worst_speed_error(const Path& path, const Profile& profile, int frames,
                             std::span<const std::pair<int, double>> segment_and_t, long double delta,
                             long double epsilon) {
  const Timing timing = timing_of(path, profile, frames);
  if (segment_and_t.size() != static_cast<std::size_t>(frames) + 1)
    throw std::invalid_argument("oracle: " + std::to_string(segment_and_t.size()) +
                                " places for frames 0 to " + std::to_string(frames));
  const long double length = path.total_length();
  SpeedError result{.worst = -1};
  Place from = place_of(path, segment_and_t[0], 0);
  long double off = path.distance(from.segment, from.t);
  result.worst_distance = std::fabs(off);
  for (std::size_t j = 0; j + 1 < segment_and_t.size(); ++j) {
    const Place to = place_of(path, segment_and_t[j + 1], j + 1);
    const long double travelled = path.travelled(from, to);
    const auto frame = static_cast<long double>(j);
    const long double wanted =
        timing.k * profile.integral(alpha_of(profile, frames, frame), alpha_of(profile, frames, frame + 1));
    const long double rounding = wanted > 1e-6L * length ? 0 : 8 * epsilon * length;
    const long double allowed = delta * wanted + rounding;
    const long double worst = ratio(std::fabs(travelled - wanted), allowed);
    off += travelled - wanted;
    const long double worst_distance = std::max(result.worst_distance, std::fabs(off));
    if (worst > result.worst)
      result = {.worst = worst,
                .frame = static_cast<int>(j),
                .travelled = travelled,
                .wanted = wanted,
                .allowed = allowed};
    result.worst_distance = worst_distance;
    from = to;
  }
  if (length > 0) result.worst_distance /= length;
  return result;
}

Motion motion_at(const Path& path, const Profile& profile, int frames, long double frames_per_second,
                 long double seconds) {
  const Timing timing = timing_of(path, profile, frames);
  const long double spans_per_second = timing.spans_per_frame * frames_per_second;
  const long double alpha = seconds * spans_per_second;
  const long double step = smooth_step(path, profile, timing, alpha);
  const auto place_at = [&](long double a) { return path.place(distance_at(path, profile, timing, a)); };

  const Place here = place_at(alpha);
  std::vector<std::array<Place, 2>> around;
  for (long double reach = 2 * step; around.size() < 12; reach /= 2)
    around.push_back({place_at(alpha - reach), place_at(alpha + reach)});

  Motion motion;
  for (int axis = 0; axis < path.axes(); ++axis) {
    // Offsets from the key, all of one segment: far from zero the positions themselves have too few digits.
    const auto offset = [&](Place place) { return path.offset(place.segment, place.t, axis); };
    Stencil stencil{
        .middle = offset(here), .rounding = rounding_of_position(path, here, axis), .left = {}, .right = {}};
    for (const auto& [left, right] : around) {
      stencil.left.push_back(offset(left));
      stencil.right.push_back(offset(right));
    }
    const std::array<Derivative, 3> d = derivatives(stencil, step);
    const long double s = spans_per_second;
    motion.position.push_back(path.position(here.segment, here.t, axis));
    motion.velocity.push_back(s * d[0].value);
    motion.acceleration.push_back(s * s * d[1].value);
    motion.jerk.push_back(s * s * s * d[2].value);
    motion.velocity_error.push_back(s * d[0].error);
    motion.acceleration_error.push_back(s * s * d[1].error);
    motion.jerk_error.push_back(s * s * s * d[2].error);
  }
  return motion;
}

}  // namespace inbetween::oracle
