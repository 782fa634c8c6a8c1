#pragma once

#include <array>
#include <cmath>

#include "segment_speed.hpp"

/// The quintic inverse of arc length over one stretch of an anchored interval.

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

/// A fitted piece in the order of t, u in [0, 1].
template <Precise Real>
struct PieceFit {
  std::array<Real, 6> c;
  Real step;           ///< y over the piece
  Real inverse_step;   ///< 1 / step
  Real near_y;         ///< y at the end towards the anchor
  Real length;         ///< l over the piece
  PieceEnd<Real> far;  ///< the end away from the anchor
};

template <Precise Real>
class PieceFitter {
 public:
  explicit PieceFitter(const AnchoredInterval<Real>& interval) : interval_(interval) {}

  [[nodiscard]] PieceEnd<Real> at_anchor() const {
    PieceEnd<Real> end;
    if (!interval_.stands_still) {
      differentiate(end);
      return end;
    }
    // q ~ tau^2 g and sqrt(g) = b0 + b1 tau + ..., so l = b0 tau^2 / 2 + b1 tau^3 / 3 + ...
    const std::array<Real, 5>& q = interval_.speed_squared.q;
    const Real b0 = std::sqrt(q[2]);
    const Real b1 = q[3] / (2 * b0);
    end.first = std::sqrt(2 / b0);
    end.second = -4 * b1 / (3 * (b0 * b0));
    return end;
  }

  /// The piece from `near` to tau; `distance` is l at `near`.
  void fit(const PieceEnd<Real>& near, Real distance, Real tau, PieceFit<Real>& piece) const {
    piece.near_y = near.y;
    piece.length = length(near.tau, tau);
    piece.far.tau = tau;
    piece.far.y = interval_.stands_still ? std::sqrt(distance + piece.length) : distance + piece.length;
    differentiate(piece.far);
    // Where y = sqrt(l), the difference of two y from the difference of their squares: no digits cancel.
    piece.step = interval_.stands_still ? piece.length / (piece.far.y + near.y) : piece.length;
    piece.inverse_step = 1 / piece.step;
    if (interval_.forward) {
      piece.c = quintic(interval_.t(near.tau), tau - near.tau, near, piece.far, piece.step, 1);
    } else {
      piece.c = quintic(interval_.t(tau), tau - near.tau, piece.far, near, piece.step, -1);
    }
  }

  /// The largest |q t'^2 - 1| at the two extremes of the error of quintic Hermite interpolation,
  /// u = (1 -+ 1/sqrt(5)) / 2.
  [[nodiscard]] Real estimated_residual(const PieceEnd<Real>& near, const PieceFit<Real>& piece) const {
    Real worst = 0;
    for (const Real u : {Real(0.27639320225002103), Real(0.72360679774997897)}) {
      const Real residual = std::fabs(residual_at(near, piece, u));
      if (!(residual <= worst)) worst = residual;
    }
    return worst;
  }

  /// An upper bound of |q t'^2 - 1| on the whole piece, by the Bernstein coefficients of the polynomial.
  /// On the first piece from a still point P' counts as 0 there, which is true to 1e-12 of its maximum.
  [[nodiscard]] Real certified_residual(const PieceEnd<Real>& near, const PieceFit<Real>& piece) const;

  /// Arc length from tau a to tau b.
  [[nodiscard]] Real length(Real a, Real b) const {
    using Rule = GaussLegendre6<Real>;
    // Node by node in lock step, so that the compiler finds the vectors.
    const std::array<Real, 5>& q = interval_.speed_squared.q;
    std::array<Real, 6> tau;
    std::array<Real, 6> sigma;
    for (std::size_t i = 0; i < 6; ++i) tau[i] = a + (b - a) * Rule::node[i];
    for (std::size_t i = 0; i < 6; ++i) {
      sigma[i] = q[0] + tau[i] * (q[1] + tau[i] * (q[2] + tau[i] * (q[3] + tau[i] * q[4])));
    }
    for (std::size_t i = 0; i < 6; ++i) sigma[i] = std::sqrt(nonnegative(sigma[i]));
    const Real sum = Rule::weight[0] * (sigma[0] + sigma[5]) + Rule::weight[1] * (sigma[1] + sigma[4]) +
                     Rule::weight[2] * (sigma[2] + sigma[3]);
    return (b - a) * sum;
  }

 private:
  /// Rounding may take a zero of q below zero.
  static Real nonnegative(Real q) { return q > 0 ? q : Real(0); }

  void differentiate(PieceEnd<Real>& end) const {
    const Real q = nonnegative(interval_.speed_squared.value(end.tau));
    const Real slope = interval_.speed_squared.derivative(end.tau);
    const Real first = 1 / std::sqrt(q);
    const Real inverse_q = first * first;
    const Real second = -slope / 2 * (inverse_q * inverse_q);
    if (!interval_.stands_still) {
      end.first = first;
      end.second = second;
    } else {  // y = sqrt(l): dl/dy = 2 y, d2l/dy2 = 2
      end.first = 2 * end.y * first;
      end.second = 4 * (end.y * end.y) * second + 2 * first;
    }
  }

  /// Hermite data at both ends to monomials. `side` -1: the interval is seen backwards, tau falls as
  /// t rises, so that second derivatives change sign and first ones keep theirs.
  static std::array<Real, 6> quintic(Real start, Real rise, const PieceEnd<Real>& begin,
                                     const PieceEnd<Real>& end, Real step, Real side) {
    const Real d0 = step * begin.first;
    const Real d1 = step * end.first;
    const Real square = side * step * step / 2;
    const Real s0 = square * begin.second;
    const Real s1 = square * end.second;
    return {start,
            d0,
            s0,
            10 * rise - 6 * d0 - 4 * d1 - 3 * s0 + s1,
            -15 * rise + 8 * d0 + 7 * d1 + 3 * s0 - 2 * s1,
            6 * rise - 3 * (d0 + d1) - s0 + s1};
  }

  [[nodiscard]] Real residual_at(const PieceEnd<Real>& near, const PieceFit<Real>& piece, Real u) const {
    const std::array<Real, 6>& c = piece.c;
    const Real travelled = u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))));
    const Real slope = c[1] + u * (2 * c[2] + u * (3 * c[3] + u * (4 * c[4] + u * (5 * c[5]))));
    const Real tau = interval_.forward ? near.tau + travelled : piece.far.tau - travelled;
    Real rate = slope * piece.inverse_step;
    if (interval_.stands_still) {
      const Real y = near.y + piece.step * (interval_.forward ? u : 1 - u);
      rate /= 2 * y;
    }
    return interval_.speed_squared.value(tau) * rate * rate - 1;
  }

  const AnchoredInterval<Real>& interval_;
};

}  // namespace inbetween
