// Pulses that have been given to a chip, until it is known when it gave them out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "inbetween/steps/cue_timer.hpp"

namespace inbetween {

/// A pulse, and how much after its time its line was switched on: nothing where it was not, because the chip
/// had gone, or because the line was on already.
struct PlayedPulse {
  BegunPulse begun{};
  std::int64_t late_ns = 0;
  bool is_played = false;
};

/// In the order in which they begin. Allocates only when it is made.
class AwaitedPulses {
 public:
  explicit AwaitedPulses(std::size_t capacity) : awaited_(capacity) {}

  /// The pulse goes to line `bit` of a chip. false: there is no room.
  bool add(const BegunPulse& begun, std::size_t chip, std::uint64_t bit);
  /// A chip has switched the lines `on` on, `late_ns` after `at_ns`.
  void note_played(std::size_t chip, std::int64_t at_ns, std::uint64_t on, std::int64_t late_ns);
  /// Takes out the oldest, if it is known what became of it.
  std::optional<PlayedPulse> next();
  /// Takes out the oldest.
  std::optional<PlayedPulse> rest();

 private:
  struct Awaited {
    PlayedPulse pulse{};
    std::size_t chip = 0;
    std::uint64_t bit = 0;
    bool is_known = false;
  };
  Awaited& at(std::uint64_t number) { return awaited_[number % awaited_.size()]; }

  std::vector<Awaited> awaited_;
  std::uint64_t first_ = 0, end_ = 0;
};

}  // namespace inbetween
