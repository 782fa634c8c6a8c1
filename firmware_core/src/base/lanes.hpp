#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "inbetween/base/precision.hpp"

/// Four numbers side by side.

namespace inbetween {

inline constexpr std::size_t lane_count = 4;

/// The width of a register of SSE2 and NEON.
inline constexpr std::size_t register_bytes = 16;
template <Precise Real>
struct Register;
template <>
struct Register<double> {
  using Type [[gnu::vector_size(register_bytes)]] = double;
};
template <>
struct Register<float> {
  using Type [[gnu::vector_size(register_bytes)]] = float;
};

/// Arithmetic on four numbers at once, each with the bits that it would have alone. The compiler makes two or
/// four of them one instruction where the processor has such, and one after the other where it has not;
/// written as loops over arrays GCC 12 leaves half of them scalar (closed_form/240 is then a third slower).
template <Precise Real>
class Lanes {
 public:
  Lanes() = default;
  /// `first`, then the first three of `others`.
  static Lanes shifted(Real first, const Lanes& others) {
    Lanes result;
    result.set(0, first);
    for (std::size_t i = 1; i < lane_count; ++i) result.set(i, others[i - 1]);
    return result;
  }

  Real operator[](std::size_t i) const { return parts_[i / part_size][i % part_size]; }
  void set(std::size_t i, Real value) { parts_[i / part_size][i % part_size] = value; }

  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a.parts_[i] + b.parts_[i];
    return result;
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a.parts_[i] - b.parts_[i];
    return result;
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a.parts_[i] * b.parts_[i];
    return result;
  }
  friend Lanes operator/(const Lanes& a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a.parts_[i] / b.parts_[i];
    return result;
  }
  friend Lanes operator+(Real a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a + b.parts_[i];
    return result;
  }
  friend Lanes operator*(Real a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a * b.parts_[i];
    return result;
  }
  friend Lanes operator/(Real a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a / b.parts_[i];
    return result;
  }

  /// Rounding may leave a value below 0. Its root is 0.
  [[nodiscard]] Lanes square_root() const {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) {
      const Part nonnegative = parts_[i] > 0 ? parts_[i] : Part{};
      for (std::size_t j = 0; j < part_size; ++j) result.parts_[i][j] = std::sqrt(nonnegative[j]);
    }
    return result;
  }

 private:
  using Part = typename Register<Real>::Type;
  static constexpr std::size_t part_size = register_bytes / sizeof(Real);
  static constexpr std::size_t part_count = lane_count / part_size;

  std::array<Part, part_count> parts_{};
};

/// c[0] + x (c[1] + x (c[2] + ...)).
template <Precise Real, class Coefficients>
Lanes<Real> polynomial(const Coefficients& c, const Lanes<Real>& x) {
  Lanes<Real> sum = c[c.size() - 2] + c[c.size() - 1] * x;
  for (std::size_t i = c.size() - 2; i-- > 0;) sum = c[i] + x * sum;
  return sum;
}

}  // namespace inbetween
