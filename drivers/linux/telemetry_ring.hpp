#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace inbetween {

/// Carries records from one thread to one other, in their order: from the real-time loop to whoever writes
/// files. Both ends are wait-free: a push or a pop copies one record and touches two atomic numbers, whatever
/// the other thread does; nothing is allocated after construction. A push into a full ring is dropped and
/// counted.
///
/// One thread pushes, one thread pops; `dropped` may be asked by anybody. Lamport's queue ("Specifying
/// concurrent program modules", 1983) with acquire and release in place of sequential consistency.
template <class Record, std::size_t capacity>
class TelemetryRing {
  static_assert(std::is_trivially_copyable_v<Record> && std::is_default_constructible_v<Record>);
  static_assert(capacity >= 2 && (capacity & (capacity - 1)) == 0, "the capacity is a power of two");
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

 public:
  TelemetryRing() = default;
  TelemetryRing(const TelemetryRing&) = delete;
  TelemetryRing& operator=(const TelemetryRing&) = delete;

  /// The pushing thread calls it. false: the ring is full, and the record is counted in `dropped`.
  bool push(const Record& record) {
    const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
    if (at - popped_.load(std::memory_order_acquire) == capacity) {
      // Only this thread writes it: no read-modify-write is needed.
      dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      return false;
    }
    records_[at % capacity] = record;
    pushed_.store(at + 1, std::memory_order_release);
    return true;
  }

  /// The popping thread calls it: the oldest record, or none.
  [[nodiscard]] std::optional<Record> pop() {
    const std::uint64_t at = popped_.load(std::memory_order_relaxed);
    if (at == pushed_.load(std::memory_order_acquire)) return std::nullopt;
    const Record record = records_[at % capacity];
    popped_.store(at + 1, std::memory_order_release);
    return record;
  }

  /// Records that found the ring full, since construction.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  // Each thread's own numbers on a cache line of their own, so that neither slows the other down.
  static constexpr std::size_t cache_line = 64;
  alignas(cache_line) std::atomic<std::uint64_t> pushed_{0};
  std::atomic<std::uint64_t> dropped_{0};
  alignas(cache_line) std::atomic<std::uint64_t> popped_{0};
  alignas(cache_line) std::array<Record, capacity> records_{};
};

}  // namespace inbetween
