// What the page and the solver hand to each other: records with named fields, and two arrays for what there
// is any number of, in the memory of the WebAssembly module.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "editor/solver/records.hpp"
#include "inbetween/base/result.hpp"

namespace inbetween::editor {

inline constexpr std::size_t max_numbers = 1U << 19U;
inline constexpr std::size_t max_integers = 1U << 17U;

/// A call reads its arguments from its record and from the beginning of both arrays, and leaves its answer
/// there.
struct Exchange {
  Records records;
  std::array<double, max_numbers> numbers;
  std::array<std::int32_t, max_integers> integers;
  Error error;
};

/// Takes the arguments one after the other. What is beyond the end of the arrays reads as missing, and then
/// is_complete() is false.
class Reader {
 public:
  explicit Reader(const Exchange& exchange) : numbers_(exchange.numbers), integers_(exchange.integers) {}

  std::span<const double> numbers(std::int32_t count) { return take(numbers_, count); }
  std::span<const std::int32_t> integers(std::int32_t count) { return take(integers_, count); }
  double number() { return one(numbers(1)); }
  std::int32_t integer() { return one(integers(1)); }
  [[nodiscard]] bool is_complete() const { return complete_; }

 private:
  template <class T>
  std::span<const T> take(std::span<const T>& left, std::int32_t count) {
    if (count < 0 || static_cast<std::size_t>(count) > left.size()) {
      complete_ = false;
      return {};
    }
    const std::span<const T> taken = left.first(static_cast<std::size_t>(count));
    left = left.subspan(taken.size());
    return taken;
  }
  template <class T>
  static T one(std::span<const T> taken) {
    return taken.empty() ? T{} : taken.front();
  }

  std::span<const double> numbers_;
  std::span<const std::int32_t> integers_;
  bool complete_ = true;
};

/// Writes an answer, as much as there is room for.
class Writer {
 public:
  explicit Writer(Exchange& exchange) : numbers_(exchange.numbers), integers_(exchange.integers) {}

  void number(double value) {
    if (next_number_ < numbers_.size()) numbers_[next_number_++] = value;
  }
  void integer(std::int32_t value) {
    if (next_integer_ < integers_.size()) integers_[next_integer_++] = value;
  }

 private:
  std::span<double> numbers_;
  std::span<std::int32_t> integers_;
  std::size_t next_number_ = 0;
  std::size_t next_integer_ = 0;
};

}  // namespace inbetween::editor
