#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/homing/line_event.hpp"

/// Reads a switch on an input line from its edges and from the level on every tick.

namespace inbetween {

/// The line of a switch, and the time for which it may bounce.
struct SwitchSettings {
  std::uint8_t line = 0;              ///< its place in the request of its reader
  bool active_level = true;           ///< the level of the line while the switch is actuated
  std::int64_t quiet_ns = 2'000'000;  ///< a level counts once no edge has come for so long; 1 to 3 ms
};

/// The news of a switch on the last tick.
enum class SwitchChange : std::uint8_t {
  none,
  edge,       ///< the first edge: it may prove to be a change, or noise
  noise,      ///< after one or more edges the level is what it was before
  activated,  ///< it is actuated; since edge_ns()
  released,   ///< it is not actuated any more; since edge_ns()
};

/// An edge has the time of its first event. The level, read again after quiet_ns without another event,
/// decides whether the switch has changed. Levels in events do not count if another edge follows before that:
/// the kernel reads them late, so that a short pulse may show the same level twice. Do not use the kernel's
/// debouncing: it stamps its decision, not the edge (linux/gpio.h; gpiolib-cdev). A noise spike that ends
/// less than quiet_ns before a change counts as its first bounce; the edge is then early by at most quiet_ns
/// and the spike.
class SwitchInput {
 public:
  /// A switch that bounces has fewer edges than this in the window. A switch that is never quiet for 3 ms has
  /// more. So every switch settles or proves to be chattering.
  static constexpr std::size_t max_edges = 32;
  static constexpr std::int64_t window_ns = 100'000'000;

  /// Errors: out_of_range (quiet_ns is not 1 to 3 ms).
  static Result<SwitchInput> make(const SwitchSettings& settings);

  /// Starts anew with the level that is read at `now_ns`. Everything before is dropped, also events that are
  /// reported later. The switch is changing until that level has stayed; this does not count as a change.
  void start(std::int64_t now_ns, bool level);
  /// The caller calls this once a tick, at `now_ns`, with the events since the last tick in the order of
  /// their times, and the level that it read after them, at most 0.5 ms after `now_ns`. Events of other lines
  /// are skipped. O(events).
  SwitchChange update(std::int64_t now_ns, bool level, std::span<const LineEvent> events);

  [[nodiscard]] bool is_active() const { return is_active_; }
  /// Edges have come and the level has not settled yet.
  [[nodiscard]] bool is_changing() const { return is_changing_; }
  /// The time at which the present change, or the last one, began: that of its first event. If only the level
  /// has shown the change (is_timed() is false), it is the time at which the level was read.
  [[nodiscard]] std::int64_t edge_ns() const { return edge_ns_; }
  [[nodiscard]] bool is_timed() const { return is_timed_; }
  /// Whether the switch has had more edges since the start than one that bounces.
  [[nodiscard]] bool is_chattering() const { return is_chattering_; }
  /// Events of some line were lost since the start: one of them may have been this one's.
  [[nodiscard]] bool has_lost_events() const { return has_lost_events_; }
  /// The number of times since the start that the level proved to be the same as before.
  [[nodiscard]] std::uint32_t noise_count() const { return noise_count_; }

 private:
  explicit SwitchInput(const SwitchSettings& settings) : settings_(settings) {}
  void take_edge(std::int64_t at_ns, bool is_active, bool is_timed);
  SwitchChange settle(bool is_active);

  SwitchSettings settings_;
  bool is_active_ = false;
  bool was_read_active_ = false;  ///< by the last tick
  bool was_active_ = false;       ///< after the last edge
  bool is_changing_ = false;
  bool is_starting_ = false;
  bool is_timed_ = false;
  bool is_chattering_ = false;
  bool has_lost_events_ = false;
  std::uint32_t noise_count_ = 0;
  std::int64_t started_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t edge_ns_ = 0;
  std::int64_t last_edge_ns_ = 0;
  std::array<std::int64_t, max_edges> edges_ns_{};
  std::size_t edge_count_ = 0;
};

/// An emergency stop button with its wiring.
struct EmergencyInput {
  std::uint8_t line = 0;
  bool healthy_level = true;  ///< of the closed circuit: a broken wire has the other one

  /// Whether the rig has to stop. It has to if the level is not the healthy one now, if the line had any edge
  /// since the last tick, or if events were lost, because one of them may have been such an edge. Ask on
  /// every tick; the supervisor keeps the answer until somebody acknowledges it.
  [[nodiscard]] bool asks_to_stop(bool level, std::span<const LineEvent> events) const;
};

}  // namespace inbetween
