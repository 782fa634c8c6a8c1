#pragma once

#include <sched.h>

#include <cstddef>
#include <optional>
#include <vector>

#include "drivers/refusal.hpp"

namespace inbetween {

/// A thread requests this of Linux, so that it wakes up when it should.
struct RealTimeRequest {
  int priority = 80;                      ///< SCHED_FIFO, 1 to 99
  std::optional<int> cpu = std::nullopt;  ///< the only processor to run on; none: any
  std::size_t stack_bytes = 256 * 1024;   ///< below the caller's frame, in memory before it is needed
  bool locks_memory = true;  ///< false where another thread of the process holds the lock, and for longer
};

/// One thing that was asked for, and whether it was given.
struct RealTimeRight {
  const char* name = "";  ///< "SCHED_FIFO priority"
  bool is_needed = true;  ///< false: without it the loop is later, but keeps its deadlines
  std::optional<Refusal> refusal = std::nullopt;  ///< none: obtained
};

/// Makes the thread that constructs it a real-time thread, as far as the machine allows, until it is
/// destroyed by the same thread, which gives everything back. Locked memory is the process's: of several in a
/// process one locks it, and outlives the others.
///
/// It locks all memory of the process, now and later (mlockall), touches the stack, binds the thread to its
/// processor, keeps processors from sleeping deeply (/dev/cpu_dma_latency at 0 us), makes the thread
/// SCHED_FIFO, and looks whether the kernel throttles real-time threads. Nothing is retried and nothing
/// replaced: what was refused stands in `rights`. Takes milliseconds, and as long as it takes to bring the
/// process's memory in.
class RealTimeThread {
 public:
  explicit RealTimeThread(const RealTimeRequest& request);
  ~RealTimeThread();
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;

  /// They stand in the order in which they were asked for; processor and locked memory only if requested.
  [[nodiscard]] const std::vector<RealTimeRight>& rights() const { return rights_; }
  /// Whether everything was obtained that a loop which drives motors needs.
  [[nodiscard]] bool is_fit() const;

 private:
  void lock_memory();
  void touch_stack(std::size_t bytes, bool is_memory_locked);
  void bind_to(int cpu);
  void keep_awake();
  void take_priority(int priority);
  void look_for_throttling();
  void note(const char* name, bool is_needed, std::optional<Refusal> refusal);

  std::vector<RealTimeRight> rights_;
  bool has_locked_memory_ = false;
  int latency_file_ = -1;
  std::optional<int> policy_before_;
  int priority_before_ = 0;
  std::optional<cpu_set_t> processors_before_;
};

}  // namespace inbetween
