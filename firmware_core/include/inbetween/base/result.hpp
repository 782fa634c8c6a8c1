#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

namespace inbetween {

/// Why a function of the core refused. The text for people is in `Error::what` and `Error::remedy`.
enum class ErrorCode : std::uint8_t {
  not_finite,     ///< a NaN or an infinity
  out_of_range,   ///< a number outside its stated domain
  wrong_count,    ///< too few, too many, or not as many as something else
  capacity,       ///< a fixed memory is too small; `Error::needed` would suffice
  unmeasured,     ///< an axis moves where the weighted length of the path does not grow
  no_distance,    ///< the speed curve covers no distance, but the path has length
  accuracy,       ///< the accuracy asked for is beyond this floating-point type
  not_bracketed,  ///< the root finder found no interval that holds the solution
  not_converged,  ///< an iteration ended without the accuracy asked for
  no_solution,    ///< the requests contradict each other or the range of the speed curve
  singular,       ///< the path stands still at a point where the method must divide by its speed
  wrong_state,    ///< not possible now: something moves, is not ready, or does not run
};

/// The mistake and its place. An error is plain data: the texts are string literals, and it owns nothing. A
/// place without meaning is -1.
struct Error {
  ErrorCode code{};
  const char* what = "";    ///< one clause, no full stop: "a control value is negative"
  const char* remedy = "";  ///< what to do about it: "use values from 0 to 100"
  std::int32_t key = -1;
  std::int32_t axis = -1;
  std::int32_t control_value = -1;
  std::int32_t frame = -1;
  std::int64_t needed = -1;  ///< the capacity that would suffice
};

/// A value or the reason why there is none. T is trivially destructible, as every value of the core is.
template <class T>
class [[nodiscard]] Result {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  constexpr Result(T value) : value_(std::move(value)), holds_value_(true) {}
  constexpr Result(const Error& error) : error_(error), holds_value_(false) {}

  [[nodiscard]] constexpr bool has_value() const { return holds_value_; }
  [[nodiscard]] constexpr explicit operator bool() const { return holds_value_; }

  /// The value. Asking an error for its value is a defect of the caller and ends the program.
  [[nodiscard]] constexpr const T& value() const {
    if (!holds_value_) __builtin_trap();
    return value_;
  }
  [[nodiscard]] constexpr T& value() {
    if (!holds_value_) __builtin_trap();
    return value_;
  }
  [[nodiscard]] constexpr const T& operator*() const { return value(); }
  [[nodiscard]] constexpr T& operator*() { return value(); }
  [[nodiscard]] constexpr const T* operator->() const { return &value(); }
  [[nodiscard]] constexpr T* operator->() { return &value(); }

  /// The error. Asking a value for its error ends the program.
  [[nodiscard]] constexpr const Error& error() const {
    if (holds_value_) __builtin_trap();
    return error_;
  }

 private:
  union {
    T value_;
    Error error_;
  };
  bool holds_value_;
};

/// The result of an action that returns nothing: done, or an error.
struct Done {};
using Status = Result<Done>;

}  // namespace inbetween
