#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "inbetween/base/result.hpp"

namespace inbetween {

/// A sequence of at most `Capacity` values that owns its memory and never allocates.
/// Growing beyond the capacity is an error that states the capacity needed; nothing is dropped.
/// Indexing outside [0, size) ends the program: it is a defect of the caller, not an input.
template <class T, std::size_t Capacity>
class FixedVector {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;

  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
  [[nodiscard]] static constexpr std::size_t capacity() { return Capacity; }

  [[nodiscard]] constexpr T& operator[](std::size_t index) {
    if (index >= size_) __builtin_trap();
    return values_[index];
  }
  [[nodiscard]] constexpr const T& operator[](std::size_t index) const {
    if (index >= size_) __builtin_trap();
    return values_[index];
  }

  [[nodiscard]] constexpr T* begin() { return values_.data(); }
  [[nodiscard]] constexpr T* end() { return values_.data() + size_; }
  [[nodiscard]] constexpr const T* begin() const { return values_.data(); }
  [[nodiscard]] constexpr const T* end() const { return values_.data() + size_; }
  [[nodiscard]] constexpr std::span<const T> span() const { return {values_.data(), size_}; }

  constexpr void clear() { size_ = 0; }

  constexpr Status push_back(const T& value) { return insert(size_, value); }

  /// Puts `value` before position `index` (0..size). Cost: linear in what stands behind it.
  constexpr Status insert(std::size_t index, const T& value) {
    if (index > size_) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the position to insert at is behind the end",
                   .remedy = "insert at a position from 0 to the number of values"};
    }
    if (size_ == Capacity) {
      return Error{.code = ErrorCode::capacity,
                   .what = "a fixed memory is full",
                   .remedy = "give it a larger capacity",
                   .needed = static_cast<std::int64_t>(Capacity) + 1};
    }
    const T inserted = value;  // `value` may be one of those that move
    for (std::size_t i = size_; i > index; --i) values_[i] = values_[i - 1];
    values_[index] = inserted;
    ++size_;
    return Done{};
  }

  /// Takes the value at `index` (0..size-1) out. Cost: linear in what stands behind it.
  constexpr Status erase(std::size_t index) {
    if (index >= size_) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "there is no value at the position to erase",
                   .remedy = "erase a position from 0 to the number of values less one"};
    }
    for (std::size_t i = index; i + 1 < size_; ++i) values_[i] = values_[i + 1];
    --size_;
    return Done{};
  }

 private:
  std::array<T, Capacity> values_{};
  std::size_t size_ = 0;
};

}  // namespace inbetween
