// Where the ticks of a loop go: a record, a take.
#pragma once

#include <array>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {

/// The thread of the loop alone calls its functions. They allocate nothing and make no system call, unless
/// the loop has time and may wait.
class TickSink {
 public:
  virtual ~TickSink() = default;
  /// After a tick of an act; null: of none.
  virtual void take(const RunLoop& loop, const LoopTask* act) = 0;
  /// Before the next tick the act was given a key.
  virtual void press(TransportKey /*key*/) {}
};

/// Each may be null.
using TickSinks = std::array<TickSink*, 2>;

}  // namespace inbetween
