#include "drivers/gpio/step_player.hpp"

#include <algorithm>

namespace inbetween::gpio {
namespace {

/// Adds to a number that only one thread writes: no read-modify-write is needed.
void count(std::atomic<std::uint64_t>& number) {
  number.store(number.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

}  // namespace

StepPlayer::StepPlayer(GpioOutputs& outputs, const StepPlayerSettings& settings, PlayedRing* played)
    : outputs_(outputs), settings_(settings), played_ring_(played), pace_(settings.pace) {}

bool StepPlayer::push(const EdgeInstant& instant) {
  const bool is_taken =
      !has_ended() && ring_.push({.instant = instant, .discards = discards_.load(std::memory_order_relaxed)});
  count(is_taken ? pushed_ : refused_);
  return is_taken;
}

void StepPlayer::discard() {
  count(discards_);
}

std::uint64_t StepPlayer::waiting() const {
  return pushed_.load(std::memory_order_acquire) - played_.load(std::memory_order_acquire) -
         discarded_.load(std::memory_order_acquire);
}

StepPlayerCounters StepPlayer::counters() const {
  return {.played = played_.load(std::memory_order_acquire),
          .discarded = discarded_.load(std::memory_order_acquire),
          .refused = refused_.load(std::memory_order_acquire),
          .late = late_.load(std::memory_order_acquire),
          .worst_late_ns = worst_late_ns_.load(std::memory_order_relaxed)};
}

/// Returns the time after having waited, for at most a nap: between naps somebody may have something to say.
std::int64_t StepPlayer::wait(std::int64_t now_ns, std::int64_t due_ns) const {
  const std::int64_t wake_ns = std::min(due_ns - settings_.watch_ns, now_ns + settings_.nap_ns);
  if (wake_ns > now_ns) clock_.sleep_until_ns(wake_ns);
  return clock_.now_ns();
}

/// Returns the time after it.
std::int64_t StepPlayer::play(const EdgeInstant& instant, std::int64_t begun_ns) {
  const bool is_taken = outputs_.set(instant.levels, instant.mask);
  const std::int64_t ended_ns = clock_.now_ns();
  if (!is_taken) return ended_ns;
  if (pace_.note_played(instant.at_ns, begun_ns, ended_ns)) count(late_);
  const std::int64_t late_ns = begun_ns - instant.at_ns;
  if (late_ns > worst_late_ns_.load(std::memory_order_relaxed)) {
    worst_late_ns_.store(late_ns, std::memory_order_relaxed);
    if (late_ns > settings_.max_late_ns) is_too_late_.store(true, std::memory_order_relaxed);
  }
  if (played_ring_ != nullptr) played_ring_->push({.instant = instant, .late_ns = late_ns});
  count(played_);
  return ended_ns;
}

void StepPlayer::run() {
  std::optional<WaitingInstant> next;
  std::int64_t now_ns = clock_.now_ns();
  while (!is_to_end_.load(std::memory_order_acquire) && outputs_.state() == ChipState::there) {
    if (!next) next = ring_.pop();
    if (!next) {
      pace_.end_series();
      clock_.sleep_until_ns(now_ns + settings_.nap_ns);
      now_ns = clock_.now_ns();
      continue;
    }
    if (next->discards != discards_.load(std::memory_order_acquire)) {
      next.reset();
      count(discarded_);
      continue;
    }
    const std::int64_t due_ns = pace_.due_ns(next->instant.at_ns);
    if (now_ns < due_ns) {
      now_ns = wait(now_ns, due_ns);
      continue;
    }
    now_ns = play(next->instant, now_ns);
    next.reset();
  }
  outputs_.set_safe();
  has_ended_.store(true, std::memory_order_release);
}

}  // namespace inbetween::gpio
