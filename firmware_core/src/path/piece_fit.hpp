#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "base/lanes.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "segment_speed.hpp"

/// The quintic inverse of arc length over stretches of an anchored interval.

namespace inbetween {

/// 6-point Gauss-Legendre on [0, 1] (Abramowitz and Stegun, table 25.4).
template <Precise Real>
struct GaussLegendre6 {
  static constexpr std::array<Real, 6> node{Real(0.033765242898423986094), Real(0.16939530676686774317),
                                            Real(0.38069040695840154568),  Real(0.61930959304159845432),
                                            Real(0.83060469323313225683),  Real(0.96623475710157601391)};
  static constexpr std::array<Real, 6> weight{Real(0.085662246189585172520), Real(0.18038078652406930378),
                                              Real(0.23395696728634552369),  Real(0.23395696728634552369),
                                              Real(0.18038078652406930378),  Real(0.085662246189585172520)};
};

/// The state of the inverse at one end of a piece, seen outward from the anchor: tau as a function of
/// y, where y is the distance l from the anchor, or sqrt(l) where the path stands still at the anchor.
template <Precise Real>
struct PieceEnd {
  Real tau = 0;
  Real y = 0;
  Real first = 0;   ///< d tau / d y
  Real second = 0;  ///< d2 tau / d y2
};

/// Consecutive stretches, outward from the anchor, and the pieces that are fitted to them: four side by side
/// take little longer than one, which would wait for its own square roots and divisions. A piece is in the
/// order of t, u in [0, 1].
template <Precise Real, std::size_t bytes = wide_register_bytes>
struct PieceBatch {
  using Number = Lanes<Real, bytes>;
  PieceEnd<Real> near;  ///< where the first stretch begins
  Number tau;           ///< where each of them ends
  Number y;             ///< y there, d tau / d y and d2 tau / d y2
  Number first;
  Number second;
  Number length;                   ///< l over the stretch
  Number step;                     ///< y over the stretch
  Number inverse_step;             ///< 1 / step
  std::array<Number, 6> c;         ///< the quintics
  std::array<Number, 2> residual;  ///< q t'^2 - 1 at two places, see PieceFitter::fit

  [[nodiscard]] PieceEnd<Real> far_end(std::size_t i) const { return {tau[i], y[i], first[i], second[i]}; }
  [[nodiscard]] PieceEnd<Real> near_end(std::size_t i) const { return i == 0 ? near : far_end(i - 1); }
  [[nodiscard]] std::array<Real, 6> coefficients(std::size_t i) const {
    return {c[0][i], c[1][i], c[2][i], c[3][i], c[4][i], c[5][i]};
  }
  /// The larger of the two residuals, by its magnitude; not a number if either is none.
  [[nodiscard]] Real largest_residual(std::size_t i) const {
    const Real a = std::fabs(residual[0][i]);
    const Real b = std::fabs(residual[1][i]);
    return b <= a ? a : (a <= b ? b : a + b);
  }
};

template <Precise Real>
class PieceFitter {
 public:
  explicit PieceFitter(const AnchoredInterval<Real>& interval)
      : interval_(interval), direction_(interval.forward ? 1 : -1) {
    for (std::size_t i = 1; i < 5; ++i) slope_[i - 1] = static_cast<Real>(i) * interval.speed_squared.q[i];
  }

  [[nodiscard]] PieceEnd<Real> at_anchor() const {
    PieceEnd<Real> end;
    const std::array<Real, 5>& q = interval_.speed_squared.q;
    if (!interval_.stands_still) {
      end.first = 1 / std::sqrt(q[0]);
      const Real inverse_q = end.first * end.first;
      end.second = -q[1] / 2 * (inverse_q * inverse_q);
      return end;
    }
    // q ~ tau^2 g and sqrt(g) = b0 + b1 tau + ..., so l = b0 tau^2 / 2 + b1 tau^3 / 3 + ...
    const Real b0 = std::sqrt(q[2]);
    const Real b1 = q[3] / (2 * b0);
    end.first = std::sqrt(2 / b0);
    end.second = -4 * b1 / (3 * (b0 * b0));
    return end;
  }

  /// Fits the pieces of a batch of which `near` and `tau` are given; `distance` is l at `near`. The residual
  /// is taken at the two extremes of the error of quintic Hermite interpolation, u = (1 -+ 1/sqrt(5)) / 2.
  /// Flat, so that the lanes stay in registers from one step to the next.
  [[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void fit(Real distance, PieceBatch<Real>& batch) const {
    using Narrow = PieceBatch<Real, register_bytes>;
    if (std::is_same_v<Narrow, PieceBatch<Real>> || has_wide_registers()) {
      fit_lanes(distance, batch);
    } else {
      auto narrow = std::bit_cast<Narrow>(batch);
      fit_lanes(distance, narrow);
      batch = std::bit_cast<PieceBatch<Real>>(narrow);
    }
  }

  /// An upper bound of |q t'^2 - 1| on the whole of a piece, by the Bernstein coefficients of the polynomial.
  /// On the first piece from a still point P' counts as 0 there, which is true to 1e-12 of its maximum.
  [[nodiscard]] Real certified_residual(const PieceBatch<Real>& batch, std::size_t index) const;

 private:
  template <std::size_t bytes>
  void fit_lanes(Real distance, PieceBatch<Real, bytes>& batch) const {
    using Number = Lanes<Real, bytes>;
    const Number begin = Number::shifted(batch.near.tau, batch.tau);
    const Number rise = batch.tau - begin;
    const Number& start = interval_.forward ? begin : batch.tau;
    batch.length = lengths(begin, rise);
    differentiate(distance, batch);
    interpolate(start, rise, batch);
    batch.residual[0] = residuals_at(Real(0.27639320225002103), start, batch);
    batch.residual[1] = residuals_at(Real(0.72360679774997897), start, batch);
  }

  template <class Number>
  [[nodiscard]] Number lengths(const Number& begin, const Number& rise) const {
    using Rule = GaussLegendre6<Real>;
    const std::array<Real, 5>& q = interval_.speed_squared.q;
    Number sum;
    for (std::size_t i = 0; i < 3; ++i) {
      const Number low = polynomial(q, begin + Rule::node[i] * rise);
      const Number high = polynomial(q, begin + Rule::node[5 - i] * rise);
      sum = sum + Rule::weight[i] * (low.square_root() + high.square_root());
    }
    return rise * sum;
  }

  template <std::size_t bytes>
  void differentiate(Real distance, PieceBatch<Real, bytes>& batch) const {
    using Number = Lanes<Real, bytes>;
    const Number first = 1 / polynomial(interval_.speed_squared.q, batch.tau).square_root();
    const Number inverse_q = first * first;
    const Number second = Real(-0.5) * polynomial(slope_, batch.tau) * (inverse_q * inverse_q);
    for (std::size_t i = 0; i < lane_count; ++i) {
      distance += batch.length[i];
      batch.y.set(i, distance);
    }
    if (!interval_.stands_still) {
      batch.first = first;
      batch.second = second;
      batch.step = batch.length;
    } else {  // y = sqrt(l): dl/dy = 2 y, d2l/dy2 = 2
      batch.y = batch.y.square_root();
      batch.first = 2 * batch.y * first;
      batch.second = 4 * (batch.y * batch.y) * second + 2 * first;
      // The difference of two y from the difference of their squares: no digits cancel.
      batch.step = batch.length / (Number::shifted(batch.near.y, batch.y) + batch.y);
    }
    batch.inverse_step = 1 / batch.step;
  }

  /// Hermite data at both ends to monomials. Where the interval is seen backwards, tau falls as t rises:
  /// second derivatives change sign and first ones keep theirs.
  template <std::size_t bytes>
  void interpolate(const Lanes<Real, bytes>& start, const Lanes<Real, bytes>& rise,
                   PieceBatch<Real, bytes>& batch) const {
    using Number = Lanes<Real, bytes>;
    const Number near_first = Number::shifted(batch.near.first, batch.first);
    const Number near_second = Number::shifted(batch.near.second, batch.second);
    const bool forward = interval_.forward;
    const Number square = direction_ / 2 * batch.step * batch.step;
    const Number d0 = batch.step * (forward ? near_first : batch.first);
    const Number d1 = batch.step * (forward ? batch.first : near_first);
    const Number s0 = square * (forward ? near_second : batch.second);
    const Number s1 = square * (forward ? batch.second : near_second);
    batch.c = {interval_.anchor + direction_ * start,
               d0,
               s0,
               10 * rise - 6 * d0 - 4 * d1 - 3 * s0 + s1,
               -15 * rise + 8 * d0 + 7 * d1 + 3 * s0 - 2 * s1,
               6 * rise - 3 * (d0 + d1) - s0 + s1};
  }

  template <std::size_t bytes>
  [[nodiscard]] Lanes<Real, bytes> residuals_at(Real u, const Lanes<Real, bytes>& start,
                                                const PieceBatch<Real, bytes>& batch) const {
    using Number = Lanes<Real, bytes>;
    const std::array<Number, 6>& c = batch.c;
    const Number travelled = u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))));
    const Number slope = c[1] + u * (2 * c[2] + u * (3 * c[3] + u * (4 * c[4] + u * (5 * c[5]))));
    const Number tau = start + direction_ * travelled;
    Number rate = slope * batch.inverse_step;
    if (interval_.stands_still) {
      const Number near_y = Number::shifted(batch.near.y, batch.y);
      rate = rate / (2 * (near_y + (interval_.forward ? u : 1 - u) * batch.step));
    }
    return Real(-1) + polynomial(interval_.speed_squared.q, tau) * rate * rate;
  }

  const AnchoredInterval<Real>& interval_;
  Real direction_;               ///< of t as tau rises
  std::array<Real, 4> slope_{};  ///< q'(tau)
};

}  // namespace inbetween
