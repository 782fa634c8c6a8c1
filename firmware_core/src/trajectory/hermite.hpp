#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "inbetween/base/processor_clones.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// Hermite's polynomials: the one that has given values and derivatives at both ends of [0, 1].

namespace inbetween {

/// What each of the numbers of two rows counts for, at one time. `begin[0]` and `end[0]` are those of the
/// positions; as they add up to 1 (and to 0 in a derivative), the first position plus end[0] times the
/// distance between both is what is meant, and begin[0] is not used.
struct HermiteWeights {
  std::array<double, 4> begin{};
  std::array<double, 4> end{};
};

constexpr PiecePolynomial multiplied(const PiecePolynomial& a, const PiecePolynomial& b) {
  PiecePolynomial product{};
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; i + k < a.size(); ++k) product[i + k] += a[i] * b[k];
  }
  return product;
}

/// Of degree 2 `Known` - 1, from so many numbers at each end: from two points' Taylor polynomials (Davis,
/// Interpolation and Approximation, 1963, section 2.5),
///   left_j(u) = u^j / j! (1 - u)^n sum_m binomial(n - 1 + m, m) u^m, m = 0 .. n - 1 - j, n = Known,
///   right_j(u) = (-1)^j left_j(1 - u).
/// All coefficients are whole numbers over j!.
template <std::size_t Known>
struct HermiteBasis {
  std::array<PiecePolynomial, Known> left{}, right{};

  constexpr HermiteBasis() {
    for (std::size_t j = 0; j < Known; ++j) {
      left[j] = from_left(j, {0, 1}, {1, -1});
      right[j] = from_left(j, {1, -1}, {0, 1});
      if (j % 2 == 1) {
        for (double& c : right[j]) c = -c;
      }
    }
  }

 private:
  static constexpr PiecePolynomial from_left(std::size_t j, const PiecePolynomial& u,
                                             const PiecePolynomial& rest) {
    PiecePolynomial sum{};
    PiecePolynomial power{1};
    double binomial = 1;
    for (std::size_t m = 0; m + j < Known; ++m) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += binomial * power[i];
      power = multiplied(power, u);
      binomial = binomial * static_cast<double>(Known + m) / static_cast<double>(m + 1);
    }
    for (std::size_t k = 0; k < Known; ++k) sum = multiplied(sum, rest);
    double factorial = 1;
    for (std::size_t k = 1; k <= j; ++k) {
      sum = multiplied(sum, u);
      factorial *= static_cast<double>(k);
    }
    for (double& c : sum) c /= factorial;
    return sum;
  }
};

template <std::size_t Known>
inline constexpr HermiteBasis<Known> hermite_basis{};

/// A derivative of a polynomial at u, by Horner's rule.
template <std::size_t Order>
constexpr double derivative_at(const PiecePolynomial& c, double u) {
  double sum = 0;
  for (std::size_t i = c.size(); i-- > Order;) {
    double factor = 1;
    for (std::size_t k = 0; k < Order; ++k) factor *= static_cast<double>(i - k);
    sum = sum * u + factor * c[i];
  }
  return sum;
}

/// How many numbers of each row a piece of a degree has.
constexpr std::size_t known_of(std::size_t degree) {
  return degree / 2 + 1;
}

/// The integral from 0 of a polynomial of degree 6 or less.
constexpr PiecePolynomial integral_of(const PiecePolynomial& c) {
  PiecePolynomial result{};
  for (std::size_t i = 0; i + 1 < c.size(); ++i) result[i + 1] = c[i] / static_cast<double>(i + 1);
  return result;
}

/// The position of an axis on a piece less the one at its begin, as a polynomial in u. `begin` and `end` are
/// its rows.
template <std::size_t Degree>
PiecePolynomial position_polynomial(const double* begin, const double* end, std::size_t axes,
                                    std::size_t axis, double seconds) {
  constexpr std::size_t first = Degree == 6 ? 1 : 0;
  constexpr auto& basis = hermite_basis<known_of(Degree) - first>;
  PiecePolynomial sum{};
  double scale = 1;
  for (std::size_t j = first; j < known_of(Degree); ++j) {
    // Both first ones add up to 1.
    const double left = j == 0 ? 0 : scale * begin[j * axes + axis];
    const double right = j == 0 ? end[axis] - begin[axis] : scale * end[j * axes + axis];
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] += left * basis.left[j - first][i] + right * basis.right[j - first][i];
    scale *= seconds;
  }
  if constexpr (Degree == 6) {
    sum = integral_of(sum);
    for (double& c : sum) c *= seconds;
  }
  return sum;
}

/// The same of the septic, which nearly all pieces are, as products: near an end what is small there stays
/// precise. right_j(u) is left_j(1 - u) but for its sign, so that both are computed at once.
template <std::size_t Order>
INBETWEEN_PART_OF_CLONES HermiteWeights septic_weights(double u, double seconds) {
  using Both [[gnu::vector_size(2 * sizeof(double))]] = double;
  const Both x{u, 1 - u};
  const Both y{1 - u, u};
  const Both xx = x * x;
  std::array<Both, 4> w;
  if constexpr (Order == 0) {
    const Both yyyy = (y * y) * (y * y);
    w = {yyyy * (1 + x * (4 + x * (10 + 20 * x))), yyyy * (x * (1 + x * (4 + 10 * x))),
         yyyy * (xx * (0.5 + 2 * x)), yyyy * (xx * x) * (1.0 / 6)};
  } else if constexpr (Order == 1) {
    const Both yyy = y * y * y;
    w = {-140 * (xx * x) * yyy, yyy * (1 + x * (3 + x * (6 - 70 * x))), yyy * (x * (1 + x * (3 - 14 * x))),
         yyy * (xx * (0.5 - (7.0 / 6) * x))};
  } else if constexpr (Order == 2) {
    const Both yy = y * y;
    w = {(xx * yy) * (840 * x - 420), (xx * yy) * (420 * x - 240), yy * (1 + x * (2 + x * (84 * x - 57))),
         yy * (x * (1 + x * (7 * x - 6)))};
  } else {
    const Both xy = x * y;
    w = {xy * (x * (4200 - 4200 * x) - 840), xy * (x * (2220 - 2100 * x) - 480),
         xy * (x * (480 - 420 * x) - 120), y * (1 + x * (x * (45 - 35 * x) - 15))};
  }
  HermiteWeights weights;
  double scale = 1;
  for (std::size_t k = 0; k < Order; ++k) scale /= seconds;
  for (std::size_t j = 0; j < w.size(); ++j) {
    weights.begin[j] = scale * w[j][0];
    weights.end[j] = (j + Order) % 2 == 0 ? scale * w[j][1] : -(scale * w[j][1]);
    scale *= seconds;
  }
  return weights;
}

/// The weights of a derivative in time on a piece that lasts `seconds`. Of degree 6 is the one whose velocity
/// is the quintic with the velocities, accelerations and jerks of both ends, from the position at its begin:
/// end[0] is 0.
template <std::size_t Degree, std::size_t Order>
INBETWEEN_PART_OF_CLONES HermiteWeights hermite_weights(double u, double seconds) {
  if constexpr (Degree == 7) return septic_weights<Order>(u, seconds);
  constexpr bool is_by_velocity = Degree == 6;
  constexpr std::size_t first = is_by_velocity ? 1 : 0;
  constexpr auto& basis = hermite_basis<known_of(Degree) - first>;
  HermiteWeights weights;
  double scale = 1;
  for (std::size_t k = first; k < Order; ++k) scale /= seconds;
  if constexpr (is_by_velocity && Order == 0) scale = seconds;
  for (std::size_t j = first; j < known_of(Degree); ++j) {
    if constexpr (is_by_velocity && Order == 0) {
      weights.begin[j] = scale * derivative_at<0>(integral_of(basis.left[j - first]), u);
      weights.end[j] = scale * derivative_at<0>(integral_of(basis.right[j - first]), u);
    } else {
      weights.begin[j] = scale * derivative_at<Order - first>(basis.left[j - first], u);
      weights.end[j] = scale * derivative_at<Order - first>(basis.right[j - first], u);
    }
    scale *= seconds;
  }
  return weights;
}

/// The weights of the position as products: near an end what is small there stays precise.
template <std::size_t Degree>
INBETWEEN_PART_OF_CLONES HermiteWeights position_weights(double u, double seconds) {
  if constexpr (Degree == 7) return septic_weights<0>(u, seconds);
  const double r = 1 - u;
  HermiteWeights weights;
  if constexpr (Degree == 6) {
    weights = hermite_weights<6, 0>(u, seconds);
  } else if constexpr (Degree == 1) {
    weights.end[0] = u;
  } else if constexpr (Degree == 3) {
    weights.begin[1] = seconds * (r * r * u);
    weights.end[0] = u * u * (1 + 2 * r);
    weights.end[1] = -(seconds * (u * u * r));
  } else if constexpr (Degree == 5) {
    const double before = r * r * r;
    const double behind = u * u * u;
    weights.begin[1] = seconds * (before * u * (1 + 3 * u));
    weights.begin[2] = seconds * seconds * (before * (u * u) / 2);
    weights.end[0] = behind * (1 + r * (3 + 6 * r));
    weights.end[1] = -(seconds * (behind * r * (1 + 3 * r)));
    weights.end[2] = seconds * seconds * (behind * (r * r) / 2);
  }
  return weights;
}

/// A look at a piece reads these.
struct PieceRows {
  const double* begin;
  const double* end;
  std::size_t axes;
};

inline PieceRows rows_of(const TrajectoryPiece& piece, std::span<const double> values, std::size_t axes) {
  return {&values[piece.begin_row], &values[piece.end_row], axes};
}

/// The sum of an axis' numbers in both rows: one order of operations, whatever the lanes.
template <std::size_t Known>
INBETWEEN_PART_OF_CLONES double sum_of(const HermiteWeights& w, const PieceRows& rows, std::size_t axis) {
  double sum = w.end[0] * (rows.end[axis] - rows.begin[axis]);
  for (std::size_t j = 1; j < Known; ++j)
    sum += w.begin[j] * rows.begin[j * rows.axes + axis] + w.end[j] * rows.end[j * rows.axes + axis];
  return sum;
}

/// Calls `work` with the degree as a constant.
template <class Work>
void with_degree(std::size_t degree, const Work& work) {
  switch (degree) {
    case 1:
      return work(std::integral_constant<std::size_t, 1>());
    case 3:
      return work(std::integral_constant<std::size_t, 3>());
    case 5:
      return work(std::integral_constant<std::size_t, 5>());
    case 6:
      return work(std::integral_constant<std::size_t, 6>());
    default:
      return work(std::integral_constant<std::size_t, 7>());
  }
}

}  // namespace inbetween
