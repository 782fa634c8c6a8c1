// What lies between an axis and its motor, the slow and obvious way. This is an oracle: it shares no line and
// no method with the product.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace inbetween::oracle {

/// The natural cubic spline through (x, y): a cubic in x itself for each stretch, all conditions written down
/// as one system and solved by Gaussian elimination with pivoting.
class MarkCurve {
 public:
  MarkCurve(std::vector<long double> x, const std::vector<long double>& y);

  /// The value and three derivatives. Beyond either end it goes straight on.
  [[nodiscard]] std::array<long double, 4> at(long double x) const;

 private:
  std::vector<long double> x_;
  std::vector<std::array<long double, 4>> cubics_;  ///< in powers of (x - x_[i])
};

/// A gear with play. The load is pushed by the motor on one side or the other, and stays where it is while
/// the motor crosses the play: from `motor` to `motor + play`.
class PlayedGear {
 public:
  PlayedGear(long double play, long double load) : play_(play), load_(load) {}
  long double turn(long double motor) { return load_ = std::clamp(load_, motor, motor + play_); }

 private:
  long double play_;
  long double load_;
};

}  // namespace inbetween::oracle
