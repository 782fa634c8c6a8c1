#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "inbetween/path/path.hpp"

/// |P'(t)|^2 of one segment as polynomials that keep their relative precision near a cusp.

namespace inbetween {

/// q(tau) = q[0] + q[1] tau + ... + q[4] tau^4.
struct Quartic {
  std::array<double, 5> q{};

  [[nodiscard]] double value(double x) const {
    return q[0] + x * (q[1] + x * (q[2] + x * (q[3] + x * q[4])));
  }
  [[nodiscard]] double derivative(double x) const {
    return q[1] + x * (2 * q[2] + x * (3 * q[3] + x * (4 * q[4])));
  }
  /// Bezier ordinates over [0, 1]: their least and largest bound q there.
  [[nodiscard]] std::array<double, 5> ordinates() const {
    return {q[0], q[0] + q[1] / 4, q[0] + q[1] / 2 + q[2] / 6, q[0] + 3 * q[1] / 4 + q[2] / 2 + q[3] / 4,
            value(1.0)};
  }
};

/// An interval of a segment seen from its anchor, the end where the path is slowest: t = anchor +-
/// tau, tau in [0, extent]. There q has no cancellation where it is small.
struct AnchoredInterval {
  double anchor = 0;
  double extent = 1;
  bool forward = true;        ///< t = anchor + tau, else anchor - tau
  bool stands_still = false;  ///< P' = 0 at the anchor: q = tau^2 g(tau)
  Quartic speed_squared;

  [[nodiscard]] double t(double tau) const { return forward ? anchor + tau : anchor - tau; }
  [[nodiscard]] double tau(double t) const { return forward ? t - anchor : anchor - t; }
};

/// The derivative of one segment, scaled by 2^-exponent so that its largest coefficient is near 1.
class SegmentSpeed {
 public:
  SegmentSpeed() = default;
  SegmentSpeed(std::span<const Cubic> cubics, std::span<const double> weights)
      : cubics_(cubics), weights_(weights) {
    for (std::size_t d = 0; d < cubics.size(); ++d) {
      const Cubic& c = cubics[d];
      for (const double part : {c.c1, 2 * c.c2, 3 * c.c3}) {
        if (const double magnitude = weights[d] * std::fabs(part); magnitude > largest_) largest_ = magnitude;
      }
    }
    // Below the normal numbers there are neither digits nor a reciprocal.
    if (largest_ < std::numeric_limits<double>::min()) return;
    static_cast<void>(std::frexp(largest_, &exponent_));
    scale_ = std::ldexp(1.0, -exponent_);
    unit_ = std::ldexp(1.0, exponent_);
  }

  /// The segment has no length.
  [[nodiscard]] bool is_still() const { return scale_ == 0; }
  /// The largest coefficient of the derivative, in the units of the path.
  [[nodiscard]] double largest() const { return largest_; }
  /// Lengths of this class times 2^exponent are lengths of the path.
  [[nodiscard]] int exponent() const { return exponent_; }
  /// 2^exponent: no path is so large that it were infinite.
  [[nodiscard]] double unit() const { return unit_; }

  /// |P'(t)| from its components: near a cusp the quartic about a distant point has no digits left.
  [[nodiscard]] double at(double t) const {
    double sum = 0;
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      const double component = scale_ * (weights_[d] * cubics_[d].derivative(t));
      sum += component * component;
    }
    return std::sqrt(sum);
  }

  /// at() of so many t, to the last bit: their sums are side by side in lanes.
  template <std::size_t Count>
  [[nodiscard]] std::array<double, Count> at(const std::array<double, Count>& t) const {
    std::array<double, Count> sums{};
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      const Cubic& cubic = cubics_[d];
      for (std::size_t k = 0; k < Count; ++k) {
        const double component = scale_ * (weights_[d] * cubic.derivative(t[k]));
        sums[k] += component * component;
      }
    }
    for (double& sum : sums) sum = std::sqrt(sum);
    return sums;
  }

  /// q about t = anchor, in tau = +-(t - anchor).
  [[nodiscard]] Quartic about(double anchor, bool forward) const {
    Quartic result;
    std::array<double, 5>& q = result.q;
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      // Weighted first: the weight of a segment that is next to nothing overflows when scaled alone.
      const auto scaled = [&](double part) { return scale_ * (weights_[d] * part); };
      const double c = scaled(3 * cubics_[d].c3);
      const double linear = scaled(2 * cubics_[d].c2);
      const double a = scaled(cubics_[d].c1) + anchor * (linear + anchor * c);
      const double outward = linear + 2 * anchor * c;
      const double b = forward ? outward : -outward;
      q[0] += a * a;
      q[1] += 2 * (a * b);
      q[2] += b * b + 2 * (a * c);
      q[3] += 2 * (b * c);
      q[4] += c * c;
    }
    return result;
  }

 private:
  std::span<const Cubic> cubics_;
  std::span<const double> weights_;
  double largest_ = 0;
  double scale_ = 0;
  double unit_ = 1;
  int exponent_ = 0;
};

/// A segment is cut at the minima of q that are below this share of its maximum ...
inline constexpr double slow_share = 1e-2;
/// ... and at a minimum below this share the path is taken to stand still. The two shares were found
/// by measurement (numerics: near-cusps of 1e-2 to 1e-12 of the speed); HardCases holds them.
inline constexpr double still_share = 1e-24;

/// The same as a share of |P'|.
inline constexpr double still_speed_share = 1e-12;

/// At most two minima inside and two at the ends, each seen from both sides.
struct AnchoredIntervals {
  std::array<AnchoredInterval, 8> intervals;  // not cleared: `count` are set
  std::size_t count = 0;
};

/// The intervals of one segment in the order of t.
AnchoredIntervals split_where_slow(const SegmentSpeed& speed);

}  // namespace inbetween
