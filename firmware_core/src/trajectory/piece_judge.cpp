#include "trajectory/piece_judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/lanes.hpp"

namespace inbetween {
namespace {

/// A piece is compared with what is asked at these places: the derivative of the error of a septic,
/// u^4 (1 - u)^4, is largest at the first two, and the speed may be that of a rest near the others.
constexpr std::array<double, 4> compared_at{0.31, 0.69, 0.88, 0.12};
/// Between the places at which a piece is compared it may be further off: in the middle 1.9 times, beside the
/// others its velocity.
constexpr double margin = 0.4;
/// If the first two looks find no more than this share, the other two are left out, but not at the ends of a
/// stretch.
constexpr double sure_share = 0.25;
/// The estimate from the middle may take this share of a tolerance: it knows more than single looks do.
constexpr double margin_of_middle = 0.7;
/// The speed is even if both ends have this share of that in the middle; otherwise a tolerance is much
/// smaller at an end.
constexpr double even_share = 0.5;
constexpr double min_speed_share = 1e-6;
constexpr double rounding = distance_roundings * std::numeric_limits<double>::epsilon();
constexpr double tiny = std::numeric_limits<double>::min();

/// A number that is none is beyond all.
double share_of(double off, double tolerance) {
  if (off <= 0) return 0;
  const double share = off / tolerance;
  return share <= std::numeric_limits<double>::max() ? share : std::numeric_limits<double>::infinity();
}

/// This is known of all axes at the middle of a septic.
struct MiddleLook {
  PieceRows rows;
  const double* middle;
  double seconds;
  double speed;                        ///< asked, along the path
  double way_rate;                     ///< of the whole way, in a second
  double way_seconds;                  ///< for the whole way at that speed
  double position_share, speed_share;  ///< with their margin
  std::span<const double> travel, min_speeds, inverse_weights;
  std::span<const double> off;  ///< of the position, beside rounding
};

/// The error of a septic is e = u^4 (1 - u)^4 g(u), where g is as smooth as what is asked: with x = u - 1/2
///   256 e = (1 - 4 x^2)^4 (g0 + g1 x + g2 x^2 + g3 x^3 + ...),
/// and e with its first three derivatives in the middle gives g0 to g3, as (1 - 4 x^2)^4 begins with
/// 1 - 16 x^2. On the piece (1 - 4 x^2)^4 x^k is reach<k> at most, and its derivative slope<k>.
template <std::size_t k>
constexpr double reach = std::array<double, 4>{1, 0.10405, 0.02048, 0.00499}[k];
template <std::size_t k>
constexpr double slope = std::array<double, 4>{3.8083, 1, 0.1438, 0.0392}[k];

/// The tolerance of an axis' velocity is a share of this: the drawn speed; of an axis that does not count
/// along the path its own velocity, and its share of the way, so that it may stand still. A way of less than
/// a millionth in a frame is as good as a rest. Of one axis or of a group.
template <class Number>
Number counted_speed(const Number& velocity, const Number& travel, const Number& inverse_weight,
                     const Number& min_speed, double speed, double way_rate) {
  const Number by_weight = speed * inverse_weight;
  const Number by_way = absolute(velocity) + way_rate * travel;
  return greatest(if_less(Number(0), inverse_weight, by_weight, by_way), min_speed);
}
/// Rounding leaves this open of a position: that of the number itself, and of the distance along the path. No
/// piece is so short that this were a speed. Of one axis or of a group.
template <class Number>
Number noise_of(const Number& position, const Number& velocity, double way_seconds) {
  return rounding * (absolute(position) + way_seconds * absolute(velocity));
}

[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES bool is_near_by_middle(const MiddleLook& look) {
  using Number = Group<double>;
  constexpr double u = 0.5;
  const double h = look.seconds;
  const HermiteWeights w0 = septic_weights<0>(u, h);
  const HermiteWeights w1 = septic_weights<1>(u, h);
  const HermiteWeights w2 = septic_weights<2>(u, h);
  const HermiteWeights w3 = septic_weights<3>(u, h);
  const std::size_t axes = look.rows.axes;
  for (std::size_t d = 0; d < axes; d += group_size) {
    const auto group = [&](const double* row) { return group_of<Number>(row, axes, d); };
    const auto asked = [&](std::size_t j) { return group(look.middle + j * axes); };
    std::array<Number, 4> begin, end;
    for (std::size_t j = 0; j < begin.size(); ++j) {
      begin[j] = group(look.rows.begin + j * axes);
      end[j] = group(look.rows.end + j * axes);
    }
    const Number way = end[0] - begin[0];
    const auto played = [&](const HermiteWeights& w) {
      Number sum = w.end[0] * way;
      for (std::size_t j = 1; j < begin.size(); ++j) sum = sum + (w.begin[j] * begin[j] + w.end[j] * end[j]);
      return sum;
    };
    const Number position = asked(0);
    const Number velocity = asked(1);
    const Number e0 = begin[0] + played(w0) - position;
    const Number e1 = h * (played(w1) - velocity);
    const Number e2 = (h * h) * (played(w2) - asked(2));
    const Number e3 = (h * h * h) * (played(w3) - asked(3));
    const Number g1 = absolute(e1);
    const Number g2 = absolute(0.5 * e2 + 16 * e0);
    const Number g3 = absolute((1.0 / 6) * e3 + 16 * e1);
    const Number off_position = absolute(e0) + reach<1> * g1 + reach<2> * g2 + reach<3> * g3;
    const Number off_velocity = slope<0> * absolute(e0) + g1 + slope<2> * g2 + slope<3> * g3;

    const Number travel = group(look.travel.data());
    const Number counted = counted_speed(velocity, travel, group(look.inverse_weights.data()),
                                         group(look.min_speeds.data()), look.speed, look.way_rate);
    const Number noise = noise_of(position, velocity, look.way_seconds) + group(look.off.data());
    // What rounds the positions of both ends and of the middle rounds the estimate of the velocity, too.
    const Number near_position = look.position_share * travel + noise + Number(tiny);
    const Number near_velocity = (h * look.speed_share) * counted + 4 * noise + Number(tiny);
    const Number zero(0);
    const Number one(1);
    // A number that is none is not less.
    const Number bad =
        if_less(off_position, near_position, zero, one) + if_less(off_velocity, near_velocity, zero, one);
    for (std::size_t k = 0; k < group_size; ++k) {
      if (lane_of(bad, k) > 0) return false;
    }
  }
  return true;
}

}  // namespace

PieceJudge::PieceJudge(const TrackSampler& sampler, const FitTolerances& tolerances,
                       std::span<AxisMotion<double>> samples, std::span<double> memory)
    : sampler_(sampler), tolerances_(tolerances), asked_(samples) {
  const std::size_t axes = samples.size();
  std::size_t taken = 0;
  for (std::span<double>* own :
       {&travel_, &min_speeds_, &inverse_weights_, &off_at_begin_, &off_at_end_, &off_})
    *own = memory.subspan(axes * taken++, axes);
  if (tolerances.travel.empty()) {
    measure_travel(sampler, asked_, travel_);
  } else {
    std::copy_n(tolerances.travel.begin(), axes, travel_.begin());
  }
  const FrameRate fps = sampler.frame_rate();
  const double seconds_per_frame = static_cast<double>(fps.denominator) / static_cast<double>(fps.numerator);
  for (std::size_t d = 0; d < axes; ++d) {
    min_speeds_[d] = min_speed_share * travel_[d] / seconds_per_frame;
    inverse_weights_[d] = sampler.weight(d) > 0 ? 1 / sampler.weight(d) : 0;
  }
  std::ranges::fill(off_, 0.0);
  whole_seconds_ =
      seconds_per_frame * frames_between(sampler.joints().front().time, sampler.joints().back().time);
}

void PieceJudge::end_at(const SampledSpeed& known) {
  end_is_off_ = known.off > 0;
  if (end_is_off_) sampler_.write_reach(known.point, known.off, off_at_end_);
  const bool is_off = begin_is_off_ || end_is_off_;
  if (!is_off && !has_off_) return;  // all are 0, as they were
  for (std::size_t d = 0; d < off_.size(); ++d)
    off_[d] = (begin_is_off_ ? off_at_begin_[d] : 0) + (end_is_off_ ? off_at_end_[d] : 0);
  has_off_ = is_off;
}

void PieceJudge::go_on() {
  begin_is_off_ = end_is_off_;
  if (begin_is_off_) std::ranges::copy(off_at_end_, off_at_begin_.begin());
}

bool PieceJudge::is_near(const JudgedPiece& judged, const SampledRow& middle) {
  const double speed = middle.known.speed;
  const double share = margin_of_middle * judged.loosened;
  if (!is_near_by_middle({.rows = judged.rows,
                          .middle = middle.values,
                          .seconds = judged.piece->seconds,
                          .speed = speed,
                          .way_rate = way_rate(speed),
                          .way_seconds = way_seconds(speed),
                          .position_share = share * tolerances_.position_share,
                          .speed_share = share * tolerances_.speed_share,
                          .travel = travel_,
                          .min_speeds = min_speeds_,
                          .inverse_weights = inverse_weights_,
                          .off = off_}))
    return false;
  if (!(judged.slowest >= even_share * speed)) return is_near(judged);
  // Beside a joint the path may turn sharply.
  return !(judged.is_first && worst_share(judged, compared_at[3]) > 1) &&
         !(judged.is_last && worst_share(judged, compared_at[2]) > 1);
}

bool PieceJudge::is_near(const JudgedPiece& judged) {
  double worst = 0;
  for (const double u : compared_at) {
    const bool is_sure = worst <= sure_share && !judged.is_first && !judged.is_last;
    if (u == compared_at[2] && is_sure) break;
    worst = std::max(worst, worst_share(judged, u));
    if (worst > 1) return false;
  }
  return true;
}

void PieceJudge::mark_off(const JudgedPiece& judged, std::span<bool> axes) {
  for (const double u : compared_at)
    visit_shares(judged, u, [&](std::size_t d, double share) { axes[d] = axes[d] || share > 1; });
}

double PieceJudge::worst_share(const JudgedPiece& judged, double u) {
  double worst = 0;
  visit_shares(judged, u, [&](std::size_t, double share) { worst = std::max(worst, share); });
  return worst;
}

/// Calls visit(axis, share): how far off it is at u, as a share of what it may be.
template <class Visit>
void PieceJudge::visit_shares(const JudgedPiece& judged, double u, const Visit& visit) {
  const TrajectoryPiece& piece = *judged.piece;
  const SampledSpeed known = sampler_.sample(moved_by(piece.begin, u / piece.inverse_frames), known_, asked_);
  with_degree(piece.degree, [&](auto degree) {
    const HermiteWeights at = position_weights<degree>(u, piece.seconds);
    const HermiteWeights rate = hermite_weights<degree, 1>(u, piece.seconds);
    for (std::size_t d = 0; d < asked_.size(); ++d) {
      const double position = judged.rows.begin[d] + sum_of<known_of(degree)>(at, judged.rows, d);
      const double velocity = sum_of<known_of(degree)>(rate, judged.rows, d);
      visit(d, share_of_axis(judged, known, d, position, velocity));
    }
  });
}

/// How far a position and a velocity are off what was asked last, as a share of what they may be.
double PieceJudge::share_of_axis(const JudgedPiece& judged, const SampledSpeed& known, std::size_t d,
                                 double position, double velocity) const {
  const AxisMotion<double>& asked = asked_[d];
  const double share = margin * judged.loosened;
  const double noise = noise_of(asked.position, asked.velocity, way_seconds(known.speed)) + off_[d];
  const double of_position =
      share_of(std::fabs(position - asked.position) - noise, share * tolerances_.position_share * travel_[d]);
  if (known.order == 0) return of_position;
  const double counted = counted_speed(asked.velocity, travel_[d], inverse_weights_[d], min_speeds_[d],
                                       known.speed, way_rate(known.speed));
  return std::max(of_position, share_of(std::fabs(velocity - asked.velocity) - noise / judged.piece->seconds,
                                        share * tolerances_.speed_share * counted));
}

/// The share of the whole way that is passed in a second.
double PieceJudge::way_rate(double speed) const {
  const double length = sampler_.length();
  return length > 0 ? speed / length : 1 / whole_seconds_;
}
/// The seconds that the whole way takes at a speed; 0 at rest.
double PieceJudge::way_seconds(double speed) const {
  return speed > tiny ? sampler_.length() / speed : 0;
}

}  // namespace inbetween
