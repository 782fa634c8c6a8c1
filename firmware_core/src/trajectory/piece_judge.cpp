#include "trajectory/piece_judge.hpp"

#include <array>

#include "base/lanes.hpp"

namespace inbetween::judging {
namespace {

/// The error of a septic is e = u^4 (1 - u)^4 g(u), where g is as smooth as what is asked: with x = u - 1/2
///   256 e = (1 - 4 x^2)^4 (g0 + g1 x + g2 x^2 + g3 x^3 + ...),
/// and e with its first three derivatives in the middle gives g0 to g3, as (1 - 4 x^2)^4 begins with
/// 1 - 16 x^2. On the piece (1 - 4 x^2)^4 x^k is reach<k> at most, and its derivative slope<k>.
template <std::size_t k>
constexpr double reach = std::array<double, 4>{1, 0.10405, 0.02048, 0.00499}[k];
template <std::size_t k>
constexpr double slope = std::array<double, 4>{3.8083, 1, 0.1438, 0.0392}[k];

}  // namespace

[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES bool is_near_by_middle(const MiddleLook& look) {
  using Number = Group;
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
    const Number distance = end[0] - begin[0];
    const auto played = [&](const HermiteWeights& w) {
      Number sum = w.end[0] * distance;
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
                                         group(look.min_speeds.data()), look.speed, look.path_rate);
    const Number noise = noise_of(position, velocity, look.path_seconds) + group(look.off.data());
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

}  // namespace inbetween::judging
