#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <type_traits>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/processor_clones.hpp"

/// Four numbers side by side.

namespace inbetween {

inline constexpr std::size_t lane_count = 4;

/// The width of a register of SSE2 and NEON.
inline constexpr std::size_t register_bytes = 16;
/// ... and of the widest that hold four numbers at most, for functions that INBETWEEN_PROCESSOR_CLONES
/// compiles.
#if defined(__x86_64__)
inline constexpr std::size_t wide_register_bytes = 32;
#else
inline constexpr std::size_t wide_register_bytes = register_bytes;
#endif
template <std::size_t bytes>
struct Register {
  using Type [[gnu::vector_size(bytes)]] = double;
};

/// Arithmetic on four numbers at once, each with the bits that it would have alone. The compiler makes two or
/// four of them one instruction where the processor has such, and one after the other where it has not;
/// written as loops over arrays GCC 12 leaves half of them scalar (closed_form/240 is then a third slower).
template <std::size_t bytes = register_bytes>
class Lanes {
 public:
  Lanes() = default;
  /// The same in all lanes.
  Lanes(double value) {  // NOLINT(google-explicit-constructor): a number is as good as four of it
    for (Part& part : parts_) part = Part{} + value;
  }
  /// The first of `numbers`, which are as many or more. Part by part: GCC 12 copies all of them through
  /// memory, by halves, and waits for both.
  static Lanes from(std::span<const double> numbers) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) {
      Part part;
      __builtin_memcpy(&part, numbers.subspan(i * part_size).data(), sizeof(part));
      result.parts_[i] = part;
    }
    return result;
  }

  double operator[](std::size_t i) const { return parts_[i / part_size][i % part_size]; }
  void set(std::size_t i, double value) { parts_[i / part_size][i % part_size] = value; }

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
  friend Lanes operator+(double a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a + b.parts_[i];
    return result;
  }
  friend Lanes operator*(double a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a * b.parts_[i];
    return result;
  }
  friend Lanes operator/(double a, const Lanes& b) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) result.parts_[i] = a / b.parts_[i];
    return result;
  }

  /// `yes` where a < b, and `no` in the other lanes.
  friend Lanes if_less(const Lanes& a, const Lanes& b, const Lanes& yes, const Lanes& no) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) {
      result.parts_[i] = a.parts_[i] < b.parts_[i] ? yes.parts_[i] : no.parts_[i];
    }
    return result;
  }

  /// Without the sign, in one instruction.
  [[nodiscard]] Lanes magnitude() const {
    using Bits = decltype(Part{} < Part{});
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) {
      result.parts_[i] =
          reinterpret_cast<Part>(reinterpret_cast<Bits>(parts_[i]) & ~reinterpret_cast<Bits>(-Part{}));
    }
    return result;
  }

  /// square_root() of one number.
  friend Lanes square_root(const Lanes& a) {
    Lanes result;
    for (std::size_t i = 0; i < part_count; ++i) {
      const Part nonnegative = a.parts_[i] > 0 ? a.parts_[i] : Part{};
      for (std::size_t j = 0; j < part_size; ++j) result.parts_[i][j] = std::sqrt(nonnegative[j]);
    }
    return result;
  }
  /// `before`, and then the first three of a.
  friend Lanes shifted(double before, const Lanes& a) {
    Lanes result;
    result.set(0, before);
    for (std::size_t i = 1; i < lane_count; ++i) result.set(i, a[i - 1]);
    return result;
  }

 private:
  static constexpr std::size_t part_bytes = std::min(bytes, lane_count * sizeof(double));
  using Part = typename Register<part_bytes>::Type;
  static constexpr std::size_t part_size = part_bytes / sizeof(double);
  static constexpr std::size_t part_count = lane_count / part_size;

  std::array<Part, part_count> parts_{};
};

inline double if_less(double a, double b, double yes, double no) {
  return a < b ? yes : no;
}
/// What std::min, std::max and std::fabs are, also of what is no number; of lanes too.
template <class Number>
Number least(const Number& a, const Number& b) {
  return if_less(b, a, b, a);
}
template <class Number>
Number greatest(const Number& a, const Number& b) {
  return if_less(a, b, b, a);
}
template <class Number>
Number absolute(const Number& a) {
  if constexpr (std::is_same_v<Number, double>) {
    return std::fabs(a);
  } else {
    return a.magnitude();
  }
}

using WideLanes = Lanes<wide_register_bytes>;

/// Numbers that are computed together: four where that is quick, else one.
using Group = std::conditional_t<lanes_are_quick, WideLanes, double>;
inline constexpr std::size_t group_size = lanes_are_quick ? lane_count : 1;

inline double lane_of(double number, std::size_t /*i*/) {
  return number;
}
template <std::size_t bytes>
double lane_of(const Lanes<bytes>& numbers, std::size_t i) {
  return numbers[i];
}
inline void set_lane(double& number, std::size_t /*i*/, double value) {
  number = value;
}
template <std::size_t bytes>
void set_lane(Lanes<bytes>& numbers, std::size_t i, double value) {
  numbers.set(i, value);
}

/// Takes a group from a row of `count` numbers, from number `first` on. Lanes behind the last one are 0.
template <class Number>
Number group_of(const double* row, std::size_t count, std::size_t first) {
  if constexpr (!std::is_same_v<Number, double>) {
    if (first + group_size <= count) return Number::from({row + first, group_size});
  }
  // One after the other: in a loop GCC 12 would go through memory, and wait.
  static_assert(group_size <= 4);
  const std::size_t left = count - first;
  Number result(0);
  set_lane(result, 0, row[first]);
  if (group_size > 1 && left > 1) set_lane(result, 1, row[first + 1]);
  if (group_size > 2 && left > 2) set_lane(result, 2, row[first + 2]);
  return result;
}

/// Rounding may leave a value below 0. Its root is 0.
inline double square_root(double number) {
  return std::sqrt(number > 0 ? number : 0.0);
}
/// A row of one number, moved on by one: what was before it.
inline double shifted(double before, double /*number*/) {
  return before;
}

/// c[0] + x (c[1] + x (c[2] + ...)).
template <class Coefficients, class Number>
Number polynomial(const Coefficients& c, const Number& x) {
  Number sum = c[c.size() - 2] + c[c.size() - 1] * x;
  for (std::size_t i = c.size() - 2; i-- > 0;) sum = c[i] + x * sum;
  return sum;
}

}  // namespace inbetween
