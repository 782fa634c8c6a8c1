#include "inbetween/track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scaled_norm.hpp"
#include "segment_speed.hpp"

namespace inbetween {
namespace {

template <Precise Real>
Status check_time_line(const SpeedProfile<Real>& profile, std::int32_t frames, FrameRate fps) {
  if (frames < 1 || frames > most_frames) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the number of frames is not between 1 and 1000000",
                 .remedy = "the move lasts frames / fps seconds"};
  }
  if (fps.numerator < 1 || fps.denominator < 1) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the frame rate is not positive",
                 .remedy = "use a fraction like 24/1 or 24000/1001"};
  }
  if (static_cast<std::int64_t>(frames) * profile.span_count() > std::numeric_limits<std::int32_t>::max()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "frames times control values does not fit 31 bits",
                 .remedy = "draw the speed curve with fewer control values"};
  }
  return Done{};
}

/// K as a rounded value and the rest, so that K Phi(f) is the length to about twice the precision.
template <Precise Real>
TwoSum<Real> solve_constant(const TwoSum<Real>& length, const TwoSum<Real>& integral) {
  TwoSum<Real> constant{length.high / integral.high, 0};
  const TwoSum<Real> product = two_product(constant.high, integral.high);
  const Real rest = (length.high - product.high) + (length.low - product.low - constant.high * integral.low);
  constant.low = rest / integral.high;
  return constant;
}

/// Derivatives of s in time, given speed, acceleration and jerk along the path.
template <Precise Real>
struct ParameterRates {
  Real first = 0, second = 0, third = 0;
};

/// sigma = |W P'| and its derivatives in t, W = diag(weights).
template <Precise Real>
struct ParametricSpeed {
  Real sigma = 0, first = 0, second = 0;
};

template <Precise Real>
ParametricSpeed<Real> parametric_speed(std::span<const Cubic<Real>> cubics, std::span<const Real> weights,
                                       Real t, Real sigma) {
  ParametricSpeed<Real> result{.sigma = sigma};
  Real along_third = 0;
  Real second_squared = 0;
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    const Real tangent = weights[d] * cubics[d].derivative(t) / sigma;
    const Real second = weights[d] * cubics[d].second(t);
    result.first += tangent * second;
    along_third += tangent * (weights[d] * cubics[d].third());
    second_squared += second * (second / sigma);
  }
  result.second = second_squared - result.first * (result.first / sigma) + along_third;
  return result;
}

/// From sigma s' = v by differentiating twice in time.
template <Precise Real>
ParameterRates<Real> parameter_rates(const AlongPath<Real>& along, const ParametricSpeed<Real>& speed) {
  ParameterRates<Real> s;
  s.first = along.speed / speed.sigma;
  s.second = (along.acceleration - speed.first * s.first * s.first) / speed.sigma;
  s.third = (along.jerk - speed.second * s.first * s.first * s.first - 3 * speed.first * s.first * s.second) /
            speed.sigma;
  return s;
}

}  // namespace

template <Precise Real>
Result<Track<Real>> Track<Real>::make(const Path<Real>& path, const ArcLength<Real>& arc_length,
                                      const SpeedProfile<Real>& profile, std::int32_t frames, FrameRate fps,
                                      const TrackMemory<Real>& memory) {
  if (const Status valid = check_time_line(profile, frames, fps); !valid) return valid.error();
  const auto f = static_cast<std::size_t>(profile.span_count());
  if (memory.span_distances.size() < f + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the speed curve has more control values than the memory of the track",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(f) + 1};
  }
  const TwoSum<Real> length = arc_length.segment_begin(path.segment_count());
  if (profile.total_integral() <= 0 && length.high > 0) {
    return Error{.code = ErrorCode::no_distance,
                 .what = "the speed curve is zero everywhere, but the path has length",
                 .remedy = "raise a control value above 0"};
  }
  TwoSum<Real> constant;
  if (length.high > 0) constant = solve_constant(length, profile.integral_before(profile.span_count()));
  for (std::size_t i = 0; i <= f; ++i) {
    const TwoSum<Real>& integral = profile.integral_before(static_cast<std::int32_t>(i));
    TwoSum<Real> distance = two_product(constant.high, integral.high);
    distance.low += constant.high * integral.low + constant.low * integral.high;
    distance.renormalize();
    memory.span_distances[i] = distance;
  }
  Track track(path, arc_length, profile);
  track.span_distances_ = memory.span_distances.first(f + 1);
  track.frames_ = frames;
  track.fps_ = fps;
  track.constant_ = constant.high;
  return track;
}

template <Precise Real>
AlongPath<Real> Track<Real>::along(const FrameTime<Real>& time) const {
  AlongPath<Real> result{.point = locate(time)};
  if (time.frame < 0 || time.frame > frames_ || (time.frame == frames_ && time.fraction > 0)) return result;
  const CurvePlace where = place(time);
  const SpeedSpan<Real>& span = profile_.span(where.span);
  // da/dt: control values a second
  const Real rate = static_cast<Real>(profile_.span_count()) * static_cast<Real>(fps_.numerator) /
                    (static_cast<Real>(frames_) * static_cast<Real>(fps_.denominator));
  const Real scale = constant_ * rate;
  result.speed = scale * span.value(where.t);
  result.acceleration = scale * rate * span.derivative(where.t);
  result.jerk = scale * rate * rate * span.second(where.t);
  return result;
}

template <Precise Real>
Derivatives Track<Real>::motion(const FrameTime<Real>& time, std::span<AxisMotion<Real>> out) const {
  const AlongPath<Real> where = along(time);
  const std::span<const Cubic<Real>> cubics = path_.segment(where.point.segment);
  const std::span<const Real> weights = path_.weights();
  const Real t = where.point.t;
  const Real sigma = path_.parametric_speed(where.point);
  const Real second =
      scaled_norm<Real>(cubics.size(), [&](std::size_t d) { return weights[d] * cubics[d].second(t); });
  const Real third =
      scaled_norm<Real>(cubics.size(), [&](std::size_t d) { return weights[d] * cubics[d].third(); });

  if (sigma * sigma <= still_share<Real> * (second + third) * (second + third)) {
    // P' = 0: the direction is the limit of P' / |P'|, +-P'' on either side.
    const Real side = where.point.segment == path_.segment_count() ? Real(-1) : Real(1);
    for (std::size_t d = 0; d < cubics.size(); ++d) {
      const Real direction = second > 0 ? side * cubics[d].second(t) / second : Real(0);
      out[d] = {cubics[d].value(t), direction * where.speed, direction * where.acceleration, 0};
    }
    const bool stays = where.speed == 0 && where.acceleration == 0 && where.jerk == 0;
    return stays ? Derivatives::exact : Derivatives::one_sided;
  }
  const ParameterRates<Real> s = parameter_rates(where, parametric_speed(cubics, weights, t, sigma));
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    const Real p1 = cubics[d].derivative(t);
    const Real p2 = cubics[d].second(t);
    const Real p3 = cubics[d].third();
    out[d] = {cubics[d].value(t), p1 * s.first, p2 * s.first * s.first + p1 * s.second,
              p3 * s.first * s.first * s.first + 3 * p2 * s.first * s.second + p1 * s.third};
  }
  return Derivatives::exact;
}

template class Track<double>;
template class Track<float>;

}  // namespace inbetween
