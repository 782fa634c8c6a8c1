#include "inbetween/motion_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "interval.hpp"
#include "time_pieces.hpp"

namespace inbetween {
namespace {

/// What is proven may be this much above the largest value found: half of what is promised.
template <Precise Real>
inline constexpr Real closeness = Real(0.005);
/// Rounding of a bound as a whole, and of the place in time at which the factors of a product are taken.
template <Precise Real>
inline constexpr Real bound_rounding = std::numeric_limits<Real>::digits > 30 ? Real(1e-6) : Real(1e-3);
/// A stretch halved so often is given as it is.
constexpr std::int32_t most_halvings = 44;
/// So small that most of the width of a bound can be rounding.
constexpr std::int32_t halvings_before_rounding = 10;
/// Of a stretch, before any of it is proven: a peak found early saves work on all that is lower.
constexpr int samples_per_stretch = 6;

/// Velocity, acceleration and jerk.
constexpr std::size_t quantities = 3;
template <Precise Real>
using Triple = std::array<Real, quantities>;

/// One factor and its derivatives: T, T', T'' along the path, or w, w', w'' in time.
template <Precise Real>
struct Factor {
  std::array<Centred<Real>, quantities> part;
};

template <Precise Real>
Triple<Real> product_at(const Triple<Real>& t, const Triple<Real>& w) {
  return {t[0] * w[0], t[1] * w[0] * w[0] + t[0] * w[1],
          t[2] * w[0] * w[0] * w[0] + 3 * t[1] * w[0] * w[1] + t[0] * w[2]};
}

/// 0 times infinity is anything.
template <Precise Real>
Real or_infinity(Real bound) {
  return bound >= 0 ? bound : std::numeric_limits<Real>::infinity();
}

template <Precise Real>
class MotionBounds {
 public:
  MotionBounds(const Track<Real>& track, std::span<const PeakSlack<Real>> slack,
               std::span<AxisTurn<Real>> turns, std::span<AxisPeaks<Real>> out)
      : track_(track),
        axes_(static_cast<std::size_t>(track.path().axis_count())),
        slack_(slack),
        turns_(turns.first(axes_)),
        out_(out.first(axes_)),
        walk_(track) {}

  void run() {
    for (std::size_t d = 0; d < axes_; ++d) bound_position(d);
    walk_.run([this](const Stretch<Real>& stretch) { sample(stretch); });
    walk_.run([this](const Stretch<Real>& stretch) { prove(stretch); });
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto peaks = peaks_of(out_[d]);
      for (std::size_t i = 0; i < quantities; ++i) {
        peaks[i]->value = std::max(peaks[i]->value, best_[d][i]) * (1 + bound_rounding<Real>);
      }
    }
  }

 private:
  struct Box {
    Real begin = 0, end = 1;
    Real tau_begin = 0, tau_end = 0;
    std::uint64_t open = 0;  ///< axes of which something is not proven yet
    std::int32_t halvings = 0;
  };

  static std::array<Peak<Real>*, quantities> peaks_of(AxisPeaks<Real>& axis) {
    return {&axis.velocity, &axis.acceleration, &axis.jerk};
  }

  // --- position

  void bound_position(std::size_t d) {
    AxisPeaks<Real>& axis = out_[d];
    axis = {};
    const Path<Real>& path = track_.path();
    PathPoint<Real> lowest;
    PathPoint<Real> highest;
    const Real start = path.segment(0)[d].c0;
    axis.lowest.value = axis.highest.value = start;
    const auto take = [&](Real value, const PathPoint<Real>& point) {
      if (value < axis.lowest.value) {
        axis.lowest.value = value;
        lowest = point;
      }
      if (value > axis.highest.value) {
        axis.highest.value = value;
        highest = point;
      }
    };
    for (std::int32_t i = 0; i < path.segment_count(); ++i) {
      const Cubic<Real>& cubic = path.segment(i)[d];
      for (const Real t : turning_points(cubic)) {
        if (t > 0 && t < 1) take(cubic.value(t), {i, t});
      }
      take(path.segment(i + 1)[d].c0, {i + 1, 0});
    }
    axis.lowest.frame = frame_of(lowest);
    axis.highest.frame = frame_of(highest);
  }
  /// Where the derivative is 0; what is outside (0, 1) does not matter.
  static std::array<Real, 2> turning_points(const Cubic<Real>& cubic) {
    const Real a = 3 * cubic.c3;
    const Real b = 2 * cubic.c2;
    const Real discriminant = b * b - 4 * a * cubic.c1;
    if (discriminant < 0) return {-1, -1};
    const Real r = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
    return {a != 0 ? r / a : Real(-1), r != 0 ? cubic.c1 / r : Real(-1)};
  }
  /// The frame on which the move reaches a point of the path.
  [[nodiscard]] Real frame_of(const PathPoint<Real>& point) const {
    Real low = 0;
    auto high = static_cast<Real>(track_.frames());
    for (int i = 0; i < std::numeric_limits<Real>::digits; ++i) {
      const Real middle = low + (high - low) / 2;
      const auto whole = static_cast<std::int32_t>(middle);
      const PathPoint<Real> here = track_.locate({whole, middle - static_cast<Real>(whole)});
      const bool is_there =
          here.segment > point.segment || (here.segment == point.segment && here.t >= point.t);
      (is_there ? high : low) = middle;
    }
    return high;
  }

  // --- the path near a point

  void prepare(const PathPiece<Real>& piece) {
    if (prepared_.segment == piece.segment && prepared_.index == piece.index) return;
    prepared_ = piece;
    scale_ = std::ldexp(Real(1), piece.exponent);
    inverse_scale_ = std::ldexp(Real(1), -piece.exponent);
    const std::span<const Cubic<Real>> cubics = track_.path().segment(piece.segment);
    if (!track_.has_profile()) {
      for (std::size_t d = 0; d < axes_; ++d) {
        const Cubic<Real>& c = cubics[d];
        turns_[d] = {};
        turns_[d].first = {c.c1, 2 * c.c2, 3 * c.c3};
        turns_[d].second = {2 * c.c2, 6 * c.c3, 0, 0, 0};
        turns_[d].third = {6 * c.c3, 0, 0, 0, 0, 0, 0, 0};
      }
      return;
    }
    const Real scale = inverse_scale_;
    const Real side = piece.interval.forward ? 1 : -1;
    const Real anchor = piece.interval.anchor;
    for (std::size_t d = 0; d < axes_; ++d) {
      const Cubic<Real>& c = cubics[d];
      turns_[d] = {};
      turns_[d].first = {scale * (c.c1 + anchor * (2 * c.c2 + 3 * c.c3 * anchor)),
                         side * scale * (2 * c.c2 + 6 * c.c3 * anchor), 3 * scale * c.c3};
      turns_[d].size = scale * (std::fabs(c.c1) + 2 * std::fabs(c.c2) + 3 * std::fabs(c.c3));
    }
    for (std::size_t d = 0; d < axes_; ++d) turn(d);
  }

  /// The numerators of the second and third derivative by distance.
  void turn(std::size_t d) {
    AxisTurn<Real>& axis = turns_[d];
    const auto [a, b, c] = axis.first;
    const std::span<const Real> weights = track_.path().weights();
    axis.straight = true;
    for (std::size_t e = 0; e < axes_; ++e) {
      const auto [A, B, C] = turns_[e].first;
      const Real weight = weights[e] * weights[e];
      // T' q^(3/2) = sum of w^2 P_e' (P_d'' P_e' - P_d' P_e''): exactly 0 for the axis itself.
      const std::array<Real, 3> cross{b * A - a * B, 2 * (c * A - a * C), c * B - b * C};
      // On a line nothing but the rounding of the coefficients is left of it.
      const Real rounding = 32 * std::numeric_limits<Real>::epsilon() * (axis.size * turns_[e].size);
      for (std::size_t j = 0; j < 3; ++j) {
        if (weight > 0 && std::fabs(cross[j]) > rounding) axis.straight = false;
        for (std::size_t i = 0; i < 3; ++i) axis.second[i + j] += weight * (turns_[e].first[i] * cross[j]);
      }
    }
    const Quartic<Real>& q = prepared_.interval.speed_squared;
    if (axis.straight) {
      const Real far = prepared_.interval.extent;
      axis.direction = (a + far * (b + far * c)) / std::sqrt(q.value(far));
      return;
    }
    const std::array<Real, 4> slope = derivative(axis.second);
    const std::array<Real, 4> q_slope = derivative(q.q);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 5; ++j) {
        axis.third[i + j] += slope[i] * q.q[j] - 2 * (q_slope[i] * axis.second[j]);
      }
    }
  }

  /// dP/dL and its derivatives by distance about tau (by t, if timed by frames).
  [[nodiscard]] Factor<Real> path_factor(std::size_t d, const Centred<Real>& q, Real tau, Real radius) const {
    const AxisTurn<Real>& axis = turns_[d];
    if (!track_.has_profile()) {
      return {centred(axis.first, tau, radius), centred(axis.second, tau, radius),
              centred(axis.third, tau, radius)};
    }
    if (axis.straight) return {{{{axis.direction, 0}, {}, {}}}};
    const Real side = prepared_.interval.forward ? 1 : -1;
    const Interval<Real> range = q.range();
    const Real root = std::sqrt(q.value);
    const Real low = range.low > 0 ? std::sqrt(range.low) : Real(0);
    const Real high = std::sqrt(range.high);
    const Real square = q.value * q.value;
    return {quotient(centred(axis.first, tau, radius), Real(1), root, low, high),
            quotient(centred(axis.second, tau, radius), side, square,
                     range.low > 0 ? range.low * range.low : Real(0), range.high * range.high),
            quotient(centred(axis.third, tau, radius), Real(1), square * (q.value * root),
                     low * low * low * (low * low * low) * low,
                     high * high * high * (high * high * high) * high)};
  }
  /// scale * a / b, with b from `low` to `high` and `value` in the middle.
  static Centred<Real> quotient(const Centred<Real>& a, Real scale, Real value, Real low, Real high) {
    const Real middle = scale * a.value / value;
    if (!(low > 0)) return {middle, std::numeric_limits<Real>::infinity()};
    const Interval<Real> range = (scale * a.range()) * Interval<Real>{1 / high, 1 / low};
    return {middle, std::max(range.high - middle, middle - range.low)};
  }

  /// The speed in the units of the path's piece, and its derivatives.
  [[nodiscard]] Factor<Real> time_factor(const TimePiece<Real>& time, Real x, Real radius) const {
    Factor<Real> result{centred(time.speed, x, radius), centred(time.change, x, radius),
                        centred(time.bend, x, radius)};
    for (Centred<Real>& part : result.part)
      part = {part.value * inverse_scale_, part.spread * inverse_scale_};
    return result;
  }
  /// In the units of the track.
  [[nodiscard]] Triple<Real> scaled_up(const Triple<Real>& values) const {
    return {values[0] * scale_, values[1] * scale_, values[2] * scale_};
  }
  static Triple<Real> middle(const Factor<Real>& factor) {
    return {factor.part[0].value, factor.part[1].value, factor.part[2].value};
  }

  // --- the largest values found

  void sample(const Stretch<Real>& stretch) {
    prepare(stretch.path);
    take_reversal(stretch);
    for (int i = 0; i <= samples_per_stretch; ++i) {
      const Real share = static_cast<Real>(i) / samples_per_stretch;
      const Real x = stretch.begin + share * (stretch.end - stretch.begin);
      const Real tau = i == 0                     ? stretch.tau_begin
                       : i == samples_per_stretch ? stretch.tau_end
                                                  : walk_.tau_at(stretch.time, stretch.path, x);
      const Centred<Real> q = centred(stretch.path.interval.speed_squared.q, tau, Real(0));
      const Factor<Real> w = time_factor(stretch.time, x, 0);
      for (std::size_t d = 0; d < axes_; ++d) {
        raise(d, scaled_up(product_at(middle(path_factor(d, q, tau, 0)), middle(w))), stretch.time.frame(x));
      }
    }
  }
  /// Inside a segment the path stands still and is passed at a speed: the direction turns to its opposite.
  void take_reversal(const Stretch<Real>& stretch) {
    const AnchoredInterval<Real>& interval = stretch.path.interval;
    if (!interval.stands_still || interval.anchor <= 0 || interval.anchor >= 1) return;
    for (const bool at_end : {false, true}) {
      if ((at_end ? stretch.tau_end : stretch.tau_begin) > 0) continue;
      const Real x = at_end ? stretch.end : stretch.begin;
      if (!(centred(stretch.time.speed, x, Real(0)).value > 0)) continue;
      for (std::size_t d = 0; d < axes_; ++d) {
        if (turns_[d].first[1] == 0) continue;
        const Real unbounded = std::numeric_limits<Real>::infinity();
        out_[d].acceleration = {unbounded, stretch.time.frame(x)};
        out_[d].jerk = {unbounded, stretch.time.frame(x)};
      }
    }
  }

  void raise(std::size_t d, const Triple<Real>& values, Real frame) {
    const auto peaks = peaks_of(out_[d]);
    for (std::size_t i = 0; i < quantities; ++i) {
      const Real value = std::fabs(values[i]);
      if (!(value > best_[d][i]) || !std::isfinite(value)) continue;
      best_[d][i] = value;
      if (std::isfinite(peaks[i]->value)) peaks[i]->frame = frame;
    }
  }

  // --- the proof

  void prove(const Stretch<Real>& stretch) {
    prepare(stretch.path);
    std::array<Box, most_halvings + 2> stack;
    std::size_t count = 0;
    Box whole{.begin = stretch.begin, .end = stretch.end};
    whole.tau_begin = stretch.tau_begin;
    whole.tau_end = stretch.tau_end;
    whole.open = axes_ < most_bounded_axes ? (std::uint64_t{1} << axes_) - 1 : ~std::uint64_t{0};
    stack[count++] = whole;
    while (count > 0) {
      const Box box = stack[--count];
      const Real x = box.begin + (box.end - box.begin) / 2;
      const Real tau = walk_.tau_at(stretch.time, stretch.path, x);
      const std::uint64_t open = prove_box(stretch, box, x, tau);
      if (open == 0) continue;
      stack[count++] = {x, box.end, tau, box.tau_end, open, box.halvings + 1};
      stack[count++] = {box.begin, x, box.tau_begin, tau, open, box.halvings + 1};
    }
  }

  /// Bounds every open axis on a box and returns those that have to be halved.
  std::uint64_t prove_box(const Stretch<Real>& stretch, const Box& box, Real x, Real tau) {
    const Real tau_radius = std::max(std::fabs(box.tau_end - tau), std::fabs(tau - box.tau_begin)) +
                            tau_rounding(stretch.path, tau);
    const Real x_radius = std::max(box.end - x, x - box.begin);
    const Centred<Real> q = centred(stretch.path.interval.speed_squared.q, tau, tau_radius);
    const Factor<Real> w = time_factor(stretch.time, x, x_radius);
    const Real seconds = x_radius * stretch.time.seconds;
    const bool is_last = box.halvings >= most_halvings || x <= box.begin || x >= box.end;
    std::uint64_t still_open = 0;
    for (std::size_t d = 0; d < axes_; ++d) {
      const std::uint64_t bit = std::uint64_t{1} << d;
      if ((box.open & bit) == 0) continue;
      const Factor<Real> t = path_factor(d, q, tau, tau_radius);
      const Triple<Real> here = product_at(middle(t), middle(w));
      raise(d, scaled_up(here), stretch.time.frame(x));
      const Triple<Real> bounds = scaled_up(bounds_of(t, steepest(d), w, here, seconds));
      if (is_last || is_close(d, bounds) ||
          (box.halvings >= halvings_before_rounding && is_rounding(d, bounds, stretch.time, x, tau))) {
        accept(d, bounds, stretch.time.frame(x));
      } else {
        still_open |= bit;
      }
    }
    return still_open;
  }

  /// How far the place at a time may be off in tau, because a distance is known to some roundings of the
  /// length.
  [[nodiscard]] Real tau_rounding(const PathPiece<Real>& path, Real tau) const {
    if (!track_.has_profile()) return 0;
    const Real sigma = std::sqrt(std::max(path.interval.speed_squared.value(tau), Real(0)));
    const Real distance =
        4 * std::numeric_limits<Real>::epsilon() * track_.arc_length().total() * inverse_scale_;
    // Where the path is that slow the place follows the square root of the distance.
    return std::min(sigma > 0 ? distance / sigma : path.interval.extent, std::sqrt(distance));
  }

  /// |dP/dL| of an axis that counts is no more than this, even where the path stands still and turns.
  [[nodiscard]] Real steepest(std::size_t d) const {
    const Real weight = track_.path().weights()[d];
    return track_.has_profile() && weight > 0 ? 1 / weight : std::numeric_limits<Real>::infinity();
  }

  static Triple<Real> bounds_of(const Factor<Real>& t, Real steepest, const Factor<Real>& w,
                                const Triple<Real>& here, Real seconds) {
    Interval<Real> speed = w.part[0].range();
    if (speed.low == 0 && speed.high == 0) return {};  // a rest, wherever it is
    speed.low = std::max(speed.low, Real(0));
    const Interval<Real> square{speed.low * speed.low, speed.high * speed.high};
    const Interval<Real> cube{square.low * speed.low, square.high * speed.high};
    const Interval<Real> change = w.part[1].range();
    Interval<Real> first = t.part[0].range();
    if (!(first.low >= -steepest)) first.low = -steepest;
    if (!(first.high <= steepest)) first.high = steepest;
    const Interval<Real> second = t.part[1].range();
    Triple<Real> bound;
    bound[2] = or_infinity(
        (t.part[2].range() * cube + Real(3) * (second * (speed * change)) + first * w.part[2].range())
            .magnitude());
    // By the mean value theorem from the middle, or directly.
    bound[1] = std::min(or_infinity((second * square + first * change).magnitude()),
                        or_infinity(std::fabs(here[1]) + seconds * bound[2]));
    bound[0] = std::min(or_infinity((first * speed).magnitude()),
                        or_infinity(std::fabs(here[0]) + seconds * bound[1]));
    return bound;
  }

  /// What is found without a bound needs no proof of another.
  [[nodiscard]] Real allowed(std::size_t d, std::size_t quantity) const {
    const std::array<Real, quantities> values{out_[d].velocity.value, out_[d].acceleration.value,
                                              out_[d].jerk.value};
    if (values[quantity] > std::numeric_limits<Real>::max()) return values[quantity];
    const Triple<Real> slack{slack_[d].velocity, slack_[d].acceleration, slack_[d].jerk};
    return best_[d][quantity] * (1 + closeness<Real>)+slack[quantity] / 2;
  }
  [[nodiscard]] bool is_close(std::size_t d, const Triple<Real>& bounds) const {
    for (std::size_t i = 0; i < quantities; ++i) {
      if (!(bounds[i] <= allowed(d, i))) return false;
    }
    return true;
  }
  /// Halving does not help any more: at the very point rounding alone takes the bound half as far.
  [[nodiscard]] bool is_rounding(std::size_t d, const Triple<Real>& bounds, const TimePiece<Real>& time,
                                 Real x, Real tau) const {
    const Centred<Real> q = centred(prepared_.interval.speed_squared.q, tau, Real(0));
    const Factor<Real> t = path_factor(d, q, tau, 0);
    const Factor<Real> w = time_factor(time, x, 0);
    const Triple<Real> floor = scaled_up(bounds_of(t, steepest(d), w, product_at(middle(t), middle(w)), 0));
    for (std::size_t i = 0; i < quantities; ++i) {
      if (!(bounds[i] <= allowed(d, i)) && !(bounds[i] <= 2 * floor[i] && floor[i] > allowed(d, i)))
        return false;
    }
    return true;
  }
  void accept(std::size_t d, const Triple<Real>& bounds, Real frame) {
    const auto peaks = peaks_of(out_[d]);
    for (std::size_t i = 0; i < quantities; ++i) {
      if (!(bounds[i] > peaks[i]->value)) continue;
      peaks[i]->value = bounds[i];
      if (!(bounds[i] <= allowed(d, i))) peaks[i]->frame = frame;
    }
  }

  const Track<Real>& track_;
  std::size_t axes_;
  std::span<const PeakSlack<Real>> slack_;
  std::span<AxisTurn<Real>> turns_;
  std::span<AxisPeaks<Real>> out_;
  StretchWalk<Real> walk_;
  PathPiece<Real> prepared_{.segment = -1, .index = -1, .exponent = 0, .interval = {}};
  Real scale_ = 1;
  Real inverse_scale_ = 1;
  std::array<Triple<Real>, most_bounded_axes> best_{};
};

}  // namespace

template <Precise Real>
Status bound_motion(const Track<Real>& track, std::span<const PeakSlack<Real>> slack,
                    const MotionBoundsMemory<Real>& memory, std::span<AxisPeaks<Real>> out) {
  const auto axes = static_cast<std::size_t>(track.path().axis_count());
  if (axes > most_bounded_axes || memory.turns.size() < axes || slack.size() < axes || out.size() < axes) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the track has more axes than the memory of its bounds",
                 .remedy = "give it a larger capacity; 64 axes at most",
                 .needed = static_cast<std::int64_t>(axes)};
  }
  MotionBounds<Real>(track, slack, memory.turns, out).run();
  return Done{};
}

template Status bound_motion(const Track<double>&, std::span<const PeakSlack<double>>,
                             const MotionBoundsMemory<double>&, std::span<AxisPeaks<double>>);
template Status bound_motion(const Track<float>&, std::span<const PeakSlack<float>>,
                             const MotionBoundsMemory<float>&, std::span<AxisPeaks<float>>);

}  // namespace inbetween
