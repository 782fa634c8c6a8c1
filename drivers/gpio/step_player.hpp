#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/gpio/gpio_outputs.hpp"
#include "drivers/gpio/step_pace.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "drivers/linux/telemetry_ring.hpp"
#include "inbetween/steps/edge_instant.hpp"

namespace inbetween::gpio {

struct StepPlayerSettings {
  StepPaceLimits pace{};
  /// The lateness of an instant against its plan beyond which the rig is to be stopped.
  std::int64_t max_late_ns = 1'000'000;
  /// How long before an instant the sleep ends and the clock is watched instead: longer than waking up takes.
  /// The processor does nothing else meanwhile. 0: the sleep ends at the instant.
  std::int64_t watch_ns = 100'000;
  /// How often an empty ring is looked at, and the longest sleep. An instant is to be pushed that and
  /// `watch_ns` before its time.
  std::int64_t nap_ns = 250'000;
};

/// Since construction. Nothing is lost without one of these growing.
struct StepPlayerCounters {
  std::uint64_t played = 0;     ///< instants that the chip took
  std::uint64_t discarded = 0;  ///< instants that `discard` has taken out
  std::uint64_t refused = 0;    ///< pushes that were refused
  std::uint64_t late = 0;       ///< played instants that were late, as StepPace counts
  std::int64_t worst_late_ns =
      0;  ///< of a played instant against its plan, the shift of those before included
};

/// An instant that the chip took, for whoever wants to know.
struct PlayedInstant {
  EdgeInstant instant{};
  std::int64_t late_ns = 0;  ///< when it was given to the kernel, against its plan
};

/// An instant in the ring of a StepPlayer.
struct WaitingInstant {
  EdgeInstant instant{};
  std::uint64_t discards = 0;  ///< how many there had been when it was pushed
};

/// Plays instants, given by one thread, on the lines of a chip, in another: each at its time, by one system
/// call. Late ones are played too, as StepPace says. In `run` nothing is allocated and no lock is taken; its
/// system calls are clock_nanosleep and ioctl, and what the clock is read with where that takes one.
///
/// On every return of `run` the safe levels are set: that is how ENABLE is released. kill -9 is no return:
/// see GpioOutputs.
class StepPlayer {
 public:
  /// Instants that can wait.
  static constexpr std::size_t capacity = 4096;

  using PlayedRing = TelemetryRing<PlayedInstant, capacity>;

  /// The outputs must be open, and stay so until `run` has returned. What is played goes into `played`, if
  /// there is one, for the thread that pops it.
  StepPlayer(GpioOutputs& outputs, const StepPlayerSettings& settings, PlayedRing* played = nullptr);

  // The feeding thread calls these. All of them return at once.

  /// Adds an instant behind the others, at_ns on CLOCK_MONOTONIC, not before theirs; one that is too early
  /// for the order counts as late. false: it will not be played, for the ring is full or `run` has returned.
  bool push(const EdgeInstant& instant);
  /// Takes out all instants that wait. None of them is played any more, but one that is being given to the
  /// kernel at this moment: when `waiting` is 0, that is over. What is pushed from now on is played; a full
  /// ring has room again after a nap. A pulse that has begun is not ended: the lines stay as they are.
  void discard();
  /// Ends `run`, within a nap. Instants that wait are not played.
  void end() { is_to_end_.store(true, std::memory_order_release); }
  /// Instants that are neither played nor discarded.
  [[nodiscard]] std::uint64_t waiting() const;

  // Any thread may call these.

  /// An instant was later than `max_late_ns`. Stays true.
  [[nodiscard]] bool is_too_late() const { return is_too_late_.load(std::memory_order_relaxed); }
  /// `run` has returned: it was told to, or the chip has failed (GpioOutputs::state).
  [[nodiscard]] bool has_ended() const { return has_ended_.load(std::memory_order_acquire); }
  [[nodiscard]] StepPlayerCounters counters() const;

  /// The playing thread calls it once: plays until `end` or until the chip fails, and sets the safe levels.
  void run();

 private:
  std::int64_t wait(std::int64_t now_ns, std::int64_t due_ns) const;
  std::int64_t play(const EdgeInstant& instant, std::int64_t begun_ns);

  GpioOutputs& outputs_;
  const StepPlayerSettings settings_;
  const MonotonicClock clock_{};

  // Written by the feeding thread.
  std::atomic<std::uint64_t> pushed_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> discards_{0};
  std::atomic<bool> is_to_end_{false};

  TelemetryRing<WaitingInstant, capacity> ring_;

  // Written by the playing thread.
  PlayedRing* played_ring_;
  StepPace pace_;
  std::atomic<std::uint64_t> played_{0};
  std::atomic<std::uint64_t> discarded_{0};
  std::atomic<std::uint64_t> late_{0};
  std::atomic<std::int64_t> worst_late_ns_{0};
  std::atomic<bool> is_too_late_{false};
  std::atomic<bool> has_ended_{false};
};

}  // namespace inbetween::gpio
