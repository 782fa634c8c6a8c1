#include "host_tools/plan/drawn_curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace {

/// Below 0 by less than this share of the largest value is rounding, and 0.
constexpr double curve_rounding = 1e-12;
/// A ramp between rest and the curve as drawn takes this many spans at least.
constexpr double min_ramp_spans = 4;

/// A sweep over the equations of a periodic curve leaves a quarter of the error: 27 leave its rounding, and
/// more change nothing.
constexpr int max_sweeps = 40;

std::vector<double> on_twice_as_many(std::vector<double> values, CurveEnds ends = CurveEnds::natural) {
  const std::size_t f = values.size() - 1;
  values.resize(2 * f + 1);
  refine_control_values(values, f, ends);
  return values;
}

bool may_be_finer(const std::vector<double>& values) {
  return 2 * values.size() - 1 <= max_lock_values;
}

/// The control values of the curve that passes through p_i at a = i: (v_i-1 + 4 v_i + v_i+1) / 6 = p_i, and
/// at the ends v = p (de Boor, A Practical Guide to Splines, ch. IV).
std::vector<double> interpolating(const std::vector<double>& p) {
  if (p.size() < 3) return p;
  std::vector<double> v = p;
  std::vector<double> upper(p.size());
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const double pivot = 4 - (i > 1 ? upper[i - 1] : 0);
    upper[i] = 1 / pivot;
    v[i] = (6 * p[i] - v[i - 1]) / pivot;
  }
  for (std::size_t i = p.size() - 2; i > 0; --i) v[i] -= upper[i] * v[i + 1];
  return v;
}

/// The same all round, v_f being v_0. No row of the equations begins the elimination, and the diagonal is
/// twice the rest of its row: sweeps over them (Gauss and Seidel) are as exact and shorter.
std::vector<double> interpolating_periodic(const std::vector<double>& p) {
  std::vector<double> v = p;
  const std::size_t f = p.size() - 1;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    for (std::size_t i = 0; i < f; ++i) v[i] = (6 * p[i] - v[(i + f - 1) % f] - v[(i + 1) % f]) / 4;
  }
  v.back() = v.front();
  return v;
}

/// The lowest place of the curve, looked at closely: a and phi.
struct Lowest {
  double a = 0, value = 0;
};
Lowest lowest_of(const std::vector<double>& values, std::size_t drawn_spans, CurveEnds ends) {
  Lowest lowest{0, speed_span(values, 0, ends).b0};
  const double per_value = static_cast<double>(drawn_spans) / static_cast<double>(values.size() - 1);
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    const double phi = (values[i - 1] + 4 * values[i] + values[i + 1]) / 6;
    if (phi < lowest.value) lowest = {static_cast<double>(i) * per_value, phi};
  }
  return lowest;
}

/// Control values may lie below a curve that does not: refined, they come near to it.
std::vector<double> through_values(const MoveTrack& track, const std::vector<double>& drawn,
                                   std::int32_t frames) {
  const CurveEnds ends = ends_of(track);
  std::vector<double> values =
      ends == CurveEnds::periodic ? interpolating_periodic(drawn) : interpolating(drawn);
  const std::size_t drawn_spans = values.size() - 1;
  const double largest = *std::ranges::max_element(drawn);
  const auto is_below = [&](double value) { return value < -curve_rounding * largest; };
  while (std::ranges::any_of(values, is_below) && may_be_finer(values)) {
    values = on_twice_as_many(values, ends);
    if (is_below(lowest_of(values, drawn_spans, ends).value)) break;
  }
  if (std::ranges::any_of(values, is_below)) {
    const Lowest lowest = lowest_of(values, drawn_spans, ends);
    throw InputError(
        track.speed_place,
        fmt::format("the curve through these values goes below 0, to {:.4g} at frame {:.1f}; raise "
                    "the values beside it, add one between them, or leave out through",
                    lowest.value, lowest.a * frames / static_cast<double>(drawn_spans)));
  }
  const double highest = *std::ranges::max_element(values);
  const double scale = highest > max_control_value ? max_control_value / highest : 1;
  for (double& value : values) value = std::clamp(value * scale, 0.0, max_control_value);
  return values;
}

/// How many frames an end takes between rest and the curve; 0 where it is as drawn.
double ramp_frames(const std::optional<EaseRequest>& ease, bool rests, double frames_per_drawn_span) {
  if (ease && ease->frames > 0) return ease->frames;
  return rests ? frames_per_drawn_span : 0;
}

}  // namespace

CurveEnds ends_of(const MoveTrack& track) {
  return track.periodic ? CurveEnds::periodic : CurveEnds::natural;
}

std::vector<double> drawn_curve(const MoveTrack& track, std::int32_t frames) {
  std::vector<double> values = track.speed;
  if (values.size() == 1) values.push_back(values.front());
  const double frames_per_drawn_span = static_cast<double>(frames) / static_cast<double>(values.size() - 1);
  if (track.through) values = through_values(track, values, frames);
  const RestingEnds rest = track.rest.value_or(RestingEnds{false, false});
  const double in = ramp_frames(track.ease_in, rest.start, frames_per_drawn_span);
  const double out = ramp_frames(track.ease_out, rest.end, frames_per_drawn_span);
  if (in == 0 && out == 0) return values;
  const double shortest = in == 0 ? out : out == 0 ? in : std::min(in, out);
  const auto spans_of = [&](double ramp) { return ramp * static_cast<double>(values.size() - 1) / frames; };
  while (spans_of(shortest) < min_ramp_spans && may_be_finer(values)) values = on_twice_as_many(values);
  if (spans_of(shortest) < min_ramp_spans) {
    const bool is_in = shortest == in;
    const std::optional<EaseRequest>& request = is_in ? track.ease_in : track.ease_out;
    throw InputError(
        request ? request->place : track.speed_place,
        fmt::format("an {} of {:g} frames is too short for the speed curve of {} frames; give it more "
                    "frames, or draw fewer control values",
                    is_in ? "ease_in" : "ease_out", shortest, frames));
  }
  const std::size_t last = values.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    // Full two values before the end of the ramp: from there on the curve knows nothing of it.
    const auto ramp = [&](double length, std::size_t away) {
      return length == 0 ? 1.0 : smooth_step((static_cast<double>(away) - 1) / (spans_of(length) - 3));
    };
    values[i] *= ramp(in, i) * ramp(out, last - i);
  }
  return values;
}

}  // namespace inbetween
