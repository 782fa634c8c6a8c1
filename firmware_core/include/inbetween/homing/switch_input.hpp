#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/homing/line_event.hpp"

/// A switch on an input line, told by the edges and by the level that is read on every tick.

namespace inbetween {

/// A switch, and what is still a switch that bounces.
struct SwitchSettings {
  std::uint8_t line = 0;              ///< its place in the request of its reader
  bool active_level = true;           ///< the level of the line while the switch is actuated
  std::int64_t quiet_ns = 2'000'000;  ///< a level counts once no edge has come for so long; 1 to 3 ms
};

/// What the last tick has told of a switch.
enum class SwitchChange : std::uint8_t {
  none,
  edge,       ///< the first edge: it may become a change, or turn out as noise
  noise,      ///< after one or more edges the level is what it was before
  activated,  ///< it is actuated; since edge_ns()
  released,   ///< it is not actuated any more; since edge_ns()
};

/// An edge has the time of the first event; whether there was one is said by the level, read again after
/// quiet_ns without any other. Levels in events are not trusted where another edge follows before that: the
/// kernel reads them late, so that a short pulse may tell the same level twice. The kernel's own debouncing
/// is not to be used: it stamps its decision, not the edge (linux/gpio.h; gpiolib-cdev). A noise spike that
/// ends less than quiet_ns before a change is taken for its first bounce, so that its edge is early by no
/// more than that and the spike.
class SwitchInput {
 public:
  /// A switch that bounces has fewer edges than this in the window. What never is quiet for 3 ms has more, so
  /// that every switch settles or is found to be chattering.
  static constexpr std::size_t max_edges = 32;
  static constexpr std::int64_t window_ns = 100'000'000;

  /// Errors: out_of_range (quiet_ns is not 1 to 3 ms).
  static Result<SwitchInput> make(const SwitchSettings& settings);

  /// From now on, with the level that is read at `now_ns`; what was before is forgotten, also events that are
  /// told later. It is changing until that level has stayed, which is no change that is told.
  void start(std::int64_t now_ns, bool level);
  /// Once a tick, at `now_ns`: the level that was read then or up to 0.5 ms later, after the events since the
  /// last tick. They come in the order of their times; those of other lines are passed over. O(events).
  SwitchChange update(std::int64_t now_ns, bool level, std::span<const LineEvent> events);

  [[nodiscard]] bool is_active() const { return is_active_; }
  /// Edges have come and the level has not settled yet.
  [[nodiscard]] bool is_changing() const { return is_changing_; }
  /// When the change that is under way, or the last, began: by its first event, or, where the level alone has
  /// told it (is_timed() is false), by when that was read.
  [[nodiscard]] std::int64_t edge_ns() const { return edge_ns_; }
  [[nodiscard]] bool is_timed() const { return is_timed_; }
  /// Has had more edges than a switch that bounces, since the start.
  [[nodiscard]] bool is_chattering() const { return is_chattering_; }
  /// Events of some line were lost since the start: one of them may have been this one's.
  [[nodiscard]] bool has_lost_events() const { return has_lost_events_; }
  /// Times that a level turned out to be what it was before, since the start.
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

  /// Whether the rig has to stop: the level read now is not the healthy one, or was not for a moment since
  /// the last tick (any edge of the line), or events were lost, any of which may have been that. To be asked
  /// on every tick; the supervisor keeps the answer until somebody acknowledges it.
  [[nodiscard]] bool asks_to_stop(bool level, std::span<const LineEvent> events) const;
};

}  // namespace inbetween
