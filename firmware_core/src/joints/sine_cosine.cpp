#include "inbetween/joints/sine_cosine.hpp"

#include <array>
#include <cstdint>

namespace inbetween {
namespace {

/// pi/2 as a sum. All parts but the last have so few digits that their product with the number of quarter
/// turns in max_angle is exact: 33 digits and a count below 2^20. With one part less, the last digits are
/// lost beside the zeros (SineCosine.IsWithinAUnitInTheLastPlace).
constexpr std::array<double, 4> quarter_turn = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69,
                                                0x1.b839a252049c1p-104};

constexpr double two_over_pi = 0.63661977236758134308;

/// 1/3!, 1/5!, ... and 1/4!, 1/6!, ..., with the signs of the series. The first one left out is below 2^-57
/// of the result at pi/4.
constexpr std::array<double, 8> sine_terms = {
    -1.0 / 6,        1.0 / 120,        -1.0 / 5040,          1.0 / 362880,
    -1.0 / 39916800, 1.0 / 6227020800, -1.0 / 1307674368000, 1.0 / 355687428096000};
constexpr std::array<double, 8> cosine_terms = {
    1.0 / 24,        -1.0 / 720,         1.0 / 40320,          -1.0 / 3628800,
    1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000, -1.0 / 6402373705728000};

constexpr double series(const std::array<double, 8>& terms, double square) {
  double sum = 0;
  for (std::size_t i = terms.size(); i-- > 0;) sum = sum * square + terms[i];
  return sum;
}

/// |angle.high + angle.low| <= pi/4. What is small is added last, so that the sum is rounded once.
SineCosine near_zero(const TwoSum& angle) {
  const double h = angle.high;
  const double square = h * h;
  const double half = square / 2;
  const double sine = h + (h * square * series(sine_terms, square) + angle.low * (1 - half));
  const double rough = 1 - half;
  const double lost = (1 - rough) - half;
  const double cosine = rough + (lost + (square * square * series(cosine_terms, square) - h * angle.low));
  return {sine, cosine};
}

}  // namespace

SineCosine sine_cosine(double angle) {
  const double turns = angle * two_over_pi;
  const auto count = static_cast<std::int32_t>(turns + (turns < 0 ? -0.5 : 0.5));
  const auto quarters = static_cast<double>(count);
  // The first difference is exact: both sides are multiples of the last digit of one of them, and close.
  TwoSum rest{angle - quarters * quarter_turn[0], 0};
  for (std::size_t part = 1; part < quarter_turn.size(); ++part) rest.add(-quarters * quarter_turn[part]);
  rest.renormalize();
  const SineCosine near = near_zero(rest);
  switch (static_cast<std::uint32_t>(count) & 3U) {
    case 1:
      return {near.cosine, -near.sine};
    case 2:
      return {-near.sine, -near.cosine};
    case 3:
      return {-near.cosine, near.sine};
    default:
      return near;
  }
}

}  // namespace inbetween
