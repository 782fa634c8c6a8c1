#include "inbetween/homing/switch_input.hpp"

#include <algorithm>

namespace inbetween {
namespace {

/// A tick reads its lines at most this long after its time. An edge that comes after the events were read and
/// before the level is read shows its level now and its event on the next tick.
constexpr std::int64_t max_reading_ns = 500'000;

}  // namespace

Result<SwitchInput> SwitchInput::make(const SwitchSettings& settings) {
  if (settings.quiet_ns < 1'000'000 || settings.quiet_ns > 3'000'000) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the time after which the level of a switch counts is not 1 to 3 ms",
                 .remedy = "give one from 1 to 3 ms"};
  }
  return SwitchInput(settings);
}

void SwitchInput::start(std::int64_t now_ns, bool level) {
  *this = SwitchInput(settings_);
  is_active_ = level == settings_.active_level;
  was_read_active_ = is_active_;
  is_changing_ = true;
  is_starting_ = true;
  was_active_ = is_active_;
  started_ns_ = now_ns;
  edge_ns_ = now_ns;
  last_edge_ns_ = now_ns;
}

SwitchChange SwitchInput::update(std::int64_t now_ns, bool level, std::span<const LineEvent> events) {
  const bool was_changing = is_changing_;
  bool had_event = false;
  for (const LineEvent& event : events) {
    if (event.at_ns < started_ns_) continue;
    has_lost_events_ = has_lost_events_ || event.lost_before;
    if (event.line != settings_.line) continue;
    take_edge(event.at_ns, event.level == settings_.active_level, true);
    had_event = true;
  }
  const bool is_active = level == settings_.active_level;
  // The event of an edge may be read a tick after the level that it made.
  if (is_active != was_read_active_ && !had_event) take_edge(now_ns, is_active, false);
  was_read_active_ = is_active;
  if (is_changing_ && now_ns - last_edge_ns_ >= settings_.quiet_ns) return settle(is_active);
  return is_changing_ && !was_changing ? SwitchChange::edge : SwitchChange::none;
}

void SwitchInput::take_edge(std::int64_t at_ns, bool is_active, bool is_timed) {
  const bool is_told_by_level = is_changing_ && !is_starting_ && !is_timed_;
  if (is_told_by_level && is_timed && at_ns < edge_ns_ + max_reading_ns) {
    edge_ns_ = at_ns;
    last_edge_ns_ = std::max(last_edge_ns_, at_ns);
    is_timed_ = true;
    return;
  }
  // The edge before was a spike that ended long before this edge, although no tick came in between.
  const bool was_quiet = at_ns - last_edge_ns_ >= settings_.quiet_ns;
  if (is_changing_ && was_quiet && was_active_ == is_active_) settle(is_active_);
  if (!is_changing_) {
    edge_ns_ = at_ns;
    is_timed_ = is_timed;
    is_changing_ = true;
  }
  last_edge_ns_ = std::max(last_edge_ns_, at_ns);
  was_active_ = is_active;
  std::int64_t& oldest_ns = edges_ns_[edge_count_ % max_edges];
  if (edge_count_ >= max_edges && at_ns - oldest_ns <= window_ns) is_chattering_ = true;
  oldest_ns = at_ns;
  ++edge_count_;
}

SwitchChange SwitchInput::settle(bool is_active) {
  const bool was_starting = is_starting_;
  const bool has_changed = is_active != is_active_;
  is_changing_ = false;
  is_starting_ = false;
  is_active_ = is_active;
  if (was_starting) return SwitchChange::none;
  if (has_changed) return is_active ? SwitchChange::activated : SwitchChange::released;
  ++noise_count_;
  return SwitchChange::noise;
}

bool EmergencyInput::asks_to_stop(bool level, std::span<const LineEvent> events) const {
  return level != healthy_level || std::ranges::any_of(events, [&](const LineEvent& event) {
           return event.line == line || event.lost_before;
         });
}

}  // namespace inbetween
