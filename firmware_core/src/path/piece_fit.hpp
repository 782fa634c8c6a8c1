#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "base/lanes.hpp"
#include "segment_speed.hpp"

/// The septic inverse of arc length over stretches of an anchored interval.

namespace inbetween {

/// Gauss-Legendre on [0, 1] (Abramowitz and Stegun, table 25.4), with as many points as give the length of a
/// piece at the default delta the digits of a double, measured over random paths: 2e-16 of the longest
/// piece.
struct GaussLegendre {
  static constexpr std::array<double, 7> node{
      0.025446043828620737737, 0.12923440720030278007, 0.29707742431130141655, 0.5,
      0.70292257568869858345,  0.87076559279969721993, 0.97455395617137926226};
  static constexpr std::array<double, 7> weight{
      0.064742483084434846635, 0.13985269574463833395, 0.19091502525255947248, 0.20897959183673469388,
      0.19091502525255947248,  0.13985269574463833395, 0.064742483084434846635};
};

/// The state of the inverse at one end of a piece, seen outward from the anchor: tau as a function of
/// y, where y is the distance l from the anchor, or sqrt(l) where the path stands still at the anchor.
struct PieceEnd {
  double tau = 0;
  double y = 0;
  double first = 0;   ///< d tau / d y
  double second = 0;  ///< d2 tau / d y2
  double third = 0;   ///< d3 tau / d y3
};

/// A stretch outward from the anchor and the piece that is fitted to it, or several in a row, one in each
/// lane of Number. A piece is in the order of t, u in [0, 1].
template <class Number>
struct Stretches {
  Number tau;  ///< where each of them ends
  Number y;    ///< y there, and the derivatives of tau with respect to y
  Number first;
  Number second;
  Number third;
  Number length;                   ///< l over the stretch
  Number step;                     ///< y over the stretch
  Number inverse_step;             ///< 1 / step
  std::array<Number, 8> c;         ///< the septics
  std::array<Number, 2> residual;  ///< q t'^2 - 1 at two places, see PieceFitter::fit
};

/// Consecutive stretches: four side by side take little longer than one, which would wait for its own square
/// roots and divisions.
template <std::size_t bytes = wide_register_bytes>
struct PieceBatch {
  using Number = Lanes<bytes>;
  PieceEnd near;  ///< where the first stretch begins
  Stretches<Number> row;

  [[nodiscard]] PieceEnd far_end(std::size_t i) const {
    return {row.tau[i], row.y[i], row.first[i], row.second[i], row.third[i]};
  }
  [[nodiscard]] PieceEnd near_end(std::size_t i) const { return i == 0 ? near : far_end(i - 1); }
  [[nodiscard]] std::array<double, 8> coefficients(std::size_t i) const {
    std::array<double, 8> c;
    for (std::size_t k = 0; k < c.size(); ++k) c[k] = row.c[k][i];
    return c;
  }
  /// The larger of the two residuals, by its magnitude; not a number if either is none.
  [[nodiscard]] double largest_residual(std::size_t i) const {
    const double a = std::fabs(row.residual[0][i]);
    const double b = std::fabs(row.residual[1][i]);
    return b <= a ? a : (a <= b ? b : a + b);
  }
  void set(std::size_t i, const Stretches<double>& stretch) {
    row.tau.set(i, stretch.tau);
    row.y.set(i, stretch.y);
    row.first.set(i, stretch.first);
    row.second.set(i, stretch.second);
    row.third.set(i, stretch.third);
    row.length.set(i, stretch.length);
    row.step.set(i, stretch.step);
    row.inverse_step.set(i, stretch.inverse_step);
    for (std::size_t k = 0; k < row.c.size(); ++k) row.c[k].set(i, stretch.c[k]);
    for (std::size_t k = 0; k < row.residual.size(); ++k) row.residual[k].set(i, stretch.residual[k]);
  }
};

/// Bounds the residual on the whole of a piece, from those at two places. Where the error has the shape of a
/// short piece their sum is next to nothing. Where it has not, it is about the residual in the middle, and
/// the two may show little.
template <class Number>
Number residual_bound(const std::array<Number, 2>& residual) {
  const auto& [low, high] = residual;
  return greatest(absolute(low), absolute(high)) + absolute(low + high);
}

class PieceFitter {
 public:
  explicit PieceFitter(const AnchoredInterval& interval)
      : interval_(interval), direction_(interval.forward ? 1 : -1) {
    const std::array<double, 5>& q = interval.speed_squared.q;
    half_slope_ = {q[1] / 2, q[2], 3 * q[3] / 2, 2 * q[4]};
    half_curvature_ = {q[2], 3 * q[3], 6 * q[4]};
  }

  [[nodiscard]] const AnchoredInterval& interval() const { return interval_; }
  [[nodiscard]] PieceEnd at_anchor() const {
    PieceEnd end;
    const std::array<double, 5>& q = interval_.speed_squared.q;
    if (!interval_.stands_still) {
      end.first = 1 / std::sqrt(q[0]);
      differentiate_on(half_slope_[0], half_curvature_[0], end.first, end.second, end.third);
      return end;
    }
    // q = tau^2 (b0 + b1 tau + b2 tau^2 + ...)^2, so l = b0 tau^2 / 2 + b1 tau^3 / 3 + b2 tau^4 / 4 + ...;
    // its inverse is tau = a1 y + a2 y^2 + a3 y^3 + ... with y^2 = l.
    const double b0 = std::sqrt(q[2]);
    const double b1 = q[3] / (2 * b0);
    const double b2 = (q[4] - b1 * b1) / (2 * b0);
    const double a1 = std::sqrt(2 / b0);
    const double a2 = -2 * b1 / (3 * (b0 * b0));
    const double square = a1 * a1;
    const double a3 = -(a2 * (b0 * a2 / 2 + b1 * square) + b2 * (square * square) / 4) / (b0 * a1);
    end.first = a1;
    end.second = 2 * a2;
    end.third = 6 * a3;
    return end;
  }

  /// Fits the pieces of a batch of which `near` and `row.tau` are given; `distance` is l at `near`. The
  /// residual is taken at the two extremes of the error of septic Hermite interpolation,
  /// u = (1 -+ 1/sqrt(7)) / 2.
  template <std::size_t bytes>
  void fit(double distance, PieceBatch<bytes>& batch) const {
    if constexpr (lanes_are_quick) {
      fit_row(distance, batch.near, batch.row);
    } else {  // one after the other: a microcontroller holds the numbers of one in its registers
      for (std::size_t i = 0; i < lane_count; ++i) {
        Stretches<double> stretch;
        stretch.tau = batch.row.tau[i];
        fit_row(distance, batch.near_end(i), stretch);
        batch.set(i, stretch);
        distance += stretch.length;
      }
    }
  }

  /// An upper bound of |q t'^2 - 1| on the whole of a piece, by the Bernstein coefficients of the polynomial.
  /// On the first piece from a still point P' counts as 0 there, which is true to 1e-12 of its maximum.
  template <std::size_t bytes>
  [[nodiscard]] double certified_residual(const PieceBatch<bytes>& batch, std::size_t index) const {
    return certified_residual(batch.near_end(index), batch.far_end(index), batch.row.step[index],
                              batch.coefficients(index));
  }

 private:
  [[nodiscard]] double certified_residual(const PieceEnd& near, const PieceEnd& far, double outward_step,
                                          const std::array<double, 8>& c) const;

  template <class Number>
  [[nodiscard]] Number lengths(const Number& begin, const Number& rise) const {
    using Rule = GaussLegendre;
    constexpr std::size_t points = Rule::node.size();
    const std::array<double, 5>& q = interval_.speed_squared.q;
    const auto speed = [&](std::size_t i) {
      return square_root(polynomial(q, begin + Rule::node[i] * rise));
    };
    Number sum = Rule::weight[points / 2] * speed(points / 2);
    for (std::size_t i = 0; i < points / 2; ++i) {
      sum = sum + Rule::weight[i] * (speed(i) + speed(points - 1 - i));
    }
    return rise * sum;
  }

  /// t'' and t''' from t' = q^(-1/2), q'/2 and q''/2, all with respect to distance.
  template <class Number>
  static void differentiate_on(const Number& half_slope, const Number& half_curvature, const Number& first,
                               Number& second, Number& third) {
    const Number inverse_q = first * first;
    const Number square = inverse_q * inverse_q;
    second = -1.0 * half_slope * square;
    third = first * square * (4.0 * (half_slope * half_slope) * inverse_q - half_curvature);
  }

  template <class Number>
  void fit_row(double distance, const PieceEnd& near, Stretches<Number>& row) const {
    const Number begin = shifted(near.tau, row.tau);
    const Number rise = row.tau - begin;
    row.length = lengths(begin, rise);
    differentiate(distance, near, row);
    const Number start = interval_.forward ? begin : row.tau;
    const Symmetries<Number> bends = interpolate(near, start, rise, row);
    judge(near, start, rise, bends, row);
  }

  template <class Number>
  void differentiate(double distance, const PieceEnd& near, Stretches<Number>& row) const {
    const Number& tau = row.tau;
    const Number first = 1 / square_root(polynomial(interval_.speed_squared.q, tau));
    row.first = first;
    differentiate_on(polynomial(half_slope_, tau), polynomial(half_curvature_, tau), first, row.second,
                     row.third);
    row.step = row.length;
    row.y = Number(0);
    if (interval_.stands_still) {
      // y = sqrt(l): dl/dy = 2 y, d2l/dy2 = 2
      for (std::size_t i = 0; i < (std::is_same_v<Number, double> ? 1 : lane_count); ++i) {
        distance += lane_of(row.length, i);
        set_lane(row.y, i, distance);
      }
      const Number square = 4 * row.y;
      row.y = square_root(row.y);
      row.third = row.y * (2 * square * row.third + 12 * row.second);
      row.second = square * row.second + 2 * first;
      row.first = 2 * row.y * first;
      // The difference of two y from the difference of their squares: no digits cancel.
      row.step = row.length / (shifted(near.y, row.y) + row.y);
    }
    row.inverse_step = 1 / row.step;
  }

  /// Sums or differences of the derivatives at both ends: they determine an even or an odd function of u -
  /// 1/2.
  template <class Number>
  struct Symmetry {
    Number first, second, third;
    [[nodiscard]] Number with(double a, double b, double c) const {
      return a * first + b * second + c * third;
    }
  };
  template <class Number>
  struct Symmetries {
    Symmetry<Number> even, odd;
  };

  /// Hermite data at both ends to monomials. What is interpolated is t less the straight line between the
  /// ends: it is 0 at both, and its first derivatives are small, so that the large numbers by which the high
  /// coefficients multiply them round little. Where the interval is seen backwards, tau falls as t rises:
  /// second derivatives change sign, first and third ones keep theirs.
  template <class Number>
  Symmetries<Number> interpolate(const PieceEnd& near, const Number& start, const Number& rise,
                                 Stretches<Number>& row) const {
    const Number near_first = shifted(near.first, row.first);
    const Number near_second = shifted(near.second, row.second);
    const Number near_third = shifted(near.third, row.third);
    const bool forward = interval_.forward;
    const Number square = row.step * row.step;
    const Number half = direction_ / 2 * square;
    const Number sixth = 1.0 / 6 * square * row.step;
    const Number d0 = row.step * (forward ? near_first : row.first);
    const Number d1 = row.step * (forward ? row.first : near_first);
    const Number s0 = half * (forward ? near_second : row.second);
    const Number s1 = half * (forward ? row.second : near_second);
    const Number p0 = sixth * (forward ? near_third : row.third);
    const Number p1 = sixth * (forward ? row.third : near_third);
    const Number e0 = d0 - rise;
    const Number e1 = d1 - rise;
    const Symmetry<Number> odd{e0 + e1, s0 - s1, p0 + p1};
    const Symmetry<Number> even{e0 - e1, s0 + s1, p0 - p1};
    const Number c7 = 10 * odd.first + 4 * odd.second + odd.third;
    const Number rest = even.first + even.second + 0.5 * even.third;
    const Number c6 = -3.5 * c7 - rest;
    const Number c5 = 4.5 * c7 + 3 * (rest - odd.first) - odd.second;
    const Number c4 = -1.0 * (e0 + s0 + p0) - (c5 + c6 + c7);
    row.c = {interval_.anchor + direction_ * start, d0, s0, p0, c4, c5, c6, c7};
    return {even, odd};
  }

  /// The residuals, from t less the straight line at two places that are symmetric: its even and its odd part
  /// are sums of the derivatives at the ends with fixed weights.
  template <class Number>
  void judge(const PieceEnd& near, const Number& start, const Number& rise, const Symmetries<Number>& bends,
             Stretches<Number>& row) const {
    constexpr auto h = 0.37796447300922722721;  // 1 / sqrt(7)
    const auto& [even, odd] = bends;
    const Number even_bend = even.with(48.0 / 343, 45.0 / 1372, 27.0 / 5488);
    const Number odd_bend = odd.with(h * 309 / 1372, h * 117 / 2744, h * 27 / 5488);
    const Number even_slope = even.with(h * 167 / 196, h * 69 / 196, h * 27 / 392);
    const Number odd_slope = rise - (37.0 / 196 * odd.first + 3.0 / 196 * odd.second);
    const double u0 = (1 - h) / 2;
    const double u1 = (1 + h) / 2;
    row.residual[0] =
        residual_at(u0, near, start, u0 * rise + (even_bend + odd_bend), odd_slope + even_slope, row);
    row.residual[1] =
        residual_at(u1, near, start, u1 * rise + (even_bend - odd_bend), odd_slope - even_slope, row);
  }

  template <class Number>
  [[nodiscard]] Number residual_at(double u, const PieceEnd& near, const Number& start,
                                   const Number& travelled, const Number& slope,
                                   const Stretches<Number>& row) const {
    const Number tau = start + direction_ * travelled;
    Number rate = slope * row.inverse_step;
    if (interval_.stands_still) {
      const Number near_y = shifted(near.y, row.y);
      rate = rate / (2 * (near_y + (interval_.forward ? u : 1 - u) * row.step));
    }
    return -1.0 + polynomial(interval_.speed_squared.q, tau) * (rate * rate);
  }

  const AnchoredInterval& interval_;
  double direction_;                        ///< of t as tau rises
  std::array<double, 4> half_slope_{};      ///< q'(tau) / 2
  std::array<double, 3> half_curvature_{};  ///< q''(tau) / 2
};

}  // namespace inbetween
