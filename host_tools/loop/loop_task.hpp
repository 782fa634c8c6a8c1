// A task that a motion loop does for a while, as its runner sees it.
#pragma once

#include <cstdint>
#include <optional>

#include "host_tools/loop/run_snapshot.hpp"
#include "host_tools/loop/transport_keys.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

/// Where a drawn move was in a tick, and its axes were told to be.
struct PlayedPlace {
  PlayheadPlace at;
  std::int64_t turn = 0;  ///< by so many the playhead of a move that goes round was carried back
};

/// None of its functions allocates. The thread of the loop alone calls them.
class LoopTask {
 public:
  virtual ~LoopTask() = default;
  virtual Status begin() { return Done{}; }
  virtual void press(TransportKey /*key*/) {}
  /// `ticks` have passed since the last, usually 1.
  virtual void tick(std::int32_t ticks, std::int64_t now_ns) = 0;
  [[nodiscard]] virtual bool is_over() const = 0;
  [[nodiscard]] virtual RunSnapshot snapshot() const = 0;
  /// Where a drawn move is on its time line, below 0 in a pre-roll; nothing where none is played.
  [[nodiscard]] virtual std::optional<double> frame() const { return std::nullopt; }
  /// The same exactly, whose setpoints these are to the last bit; nothing in a tick that made none.
  [[nodiscard]] virtual std::optional<PlayedPlace> played() const { return std::nullopt; }
  /// What is typed ahead is for the move that follows.
  [[nodiscard]] virtual bool is_preparation() const { return false; }
};

}  // namespace inbetween
