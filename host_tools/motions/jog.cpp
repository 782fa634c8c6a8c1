#include "host_tools/motions/jog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host_tools/files/diagnostics.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

constexpr double ns_per_s = 1e9;
constexpr auto key_missed_ns = static_cast<std::int64_t>(jog_key_missed_s * ns_per_s);
/// From when a key comes to when the loop's thread has it.
constexpr double key_way_s = 0.01;
/// One until it is noticed that the key is missed, one until the stop has ended on a tick, one until the
/// drive is where its setpoint was, and one more for a drive that begins with the next.
constexpr double ticks_beside_stop = 4;
/// How long everything rests before its place is written: whoever nudges an axis does not wait for the disk.
constexpr std::int64_t ns_until_kept = 500'000'000;

FreeAxisLimits<double> jog_limits(const RigAxis& axis, double share) {
  FreeAxisLimits<double> limits = free_limits_of(axis, 1);
  limits.velocity *= share;
  return limits;
}

}  // namespace

double jog_speed(const RigAxis& axis, double share, double tick_seconds) {
  const double left = jog_stops_within_s - jog_key_missed_s - key_way_s - ticks_beside_stop * tick_seconds;
  return free_axis_of(axis, jog_limits(axis, share), axis.min, tick_seconds).velocity_that_stops_within(left);
}

Jog::Jog(RunLoop& loop, const FreeSpec<double>& spec, FreeAxes& free, std::vector<JogAxis> axes,
         std::size_t selected)
    : loop_(loop),
      spec_(spec),
      free_(free),
      axes_(std::move(axes)),
      is_marked_(axes_.size()),
      states_(loop.drive_states().size()),
      keys_(loop, false),
      selected_(selected) {}

Status Jog::begin() {
  if (!has_begun_) {
    has_begun_ = true;
    if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
    return loop_.begin();
  }
  if (held_ != 0 && is_marked_[selected_]) set_off();
  return Done{};
}

void Jog::press(TransportKey key) {
  if (keys_.press(key) || !keys_.is_running()) return;
  switch (key) {
    case TransportKey::step_forward:
    case TransportKey::faster:
      return hold(1);
    case TransportKey::step_backward:
    case TransportKey::slower:
      return hold(-1);
    case TransportKey::next_axis:
      return choose((selected_ + 1) % axes_.size());
    case TransportKey::previous_axis:
      return choose((selected_ + axes_.size() - 1) % axes_.size());
    default:
      return let_go();
  }
}

void Jog::hold(int direction) {
  const bool is_new = held_ == 0;
  held_ = direction;
  key_ns_ = now_ns_;
  if (!is_marked_[selected_]) {
    ask_ = Ask::mark;
    return;
  }
  if (is_new) {
    set_off();
  } else {
    drive();
  }
}

void Jog::set_off() {
  // An axis that does not know where it is has a short way, until the key is let go.
  const double here = axis().position();
  const double way = axes_[selected_].way;
  if (!axes_[selected_].is_referenced && axis().is_resting()) {
    keys_.say(axis().set_range(here - way, here + way));
  }
  drive();
}

void Jog::drive() {
  const Status driven = axis().drive(held_ * axes_[selected_].speed);
  if (!driven && !axes_[selected_].is_referenced) {
    keys_.say("no further at once: let go, and press again");
  } else {
    keys_.say(driven);
  }
}

void Jog::let_go() {
  held_ = 0;
  axis().stop();
}

void Jog::choose(std::size_t axis) {
  let_go();
  selected_ = axis;
}

void Jog::tick(std::int32_t ticks, std::int64_t now_ns) {
  if (held_ != 0 && now_ns - key_ns_ >= key_missed_ns) let_go();
  keys_.note(loop_.tick(ticks, now_ns));
  std::ranges::copy(loop_.drive_states(), states_.begin());
  now_ns_ = now_ns;
  if (held_ != 0 || !free_.is_resting()) rested_ns_ = now_ns;
  const bool has_moved = std::ranges::find(is_marked_, true) != is_marked_.end();
  if (has_moved && keys_.is_running() && now_ns - rested_ns_ >= ns_until_kept) ask_ = Ask::keep;
}

void Jog::marked() {
  is_marked_[selected_] = true;
  ask_ = Ask::none;
}

void Jog::kept() {
  is_marked_.assign(is_marked_.size(), false);
  ask_ = Ask::none;
}

RunSnapshot Jog::snapshot() const {
  const FreeAxis<double>& free = std::as_const(free_).axes()[selected_];
  const JogAxis& axis = axes_[selected_];
  return {.state = loop_.state(),
          .is_resting = free_.is_resting(),
          .words = keys_.words(),
          .jog = JogSnapshot{.axis = axis.name,
                             .unit = axis.unit,
                             .position = free.position(),
                             .velocity = free.state().velocity,
                             .is_referenced = axis.is_referenced}};
}

namespace {

/// All axes of a rig, ready to be moved by hand.
struct JogRig {
  std::vector<std::size_t> drive_of;
  std::vector<AxisLimits<double>> limits;
  std::vector<FreeAxis<double>> free;
  std::vector<JogAxis> axes;
};

JogRig jog_rig(const RigSession& session, const RigReference& reference, double share) {
  JogRig rig;
  for (std::size_t a = 0; a < session.rig().axes.size(); ++a) {
    const RigAxis& axis = session.rig().axes[a];
    const bool is_referenced = reference.is_referenced(a);
    rig.drive_of.push_back(a);
    rig.limits.push_back(limits_of(axis));
    rig.free.push_back(
        free_axis_of(axis, jog_limits(axis, share), session.positions()[a], session.tick_seconds()));
    rig.axes.push_back({.name = axis.name.c_str(),
                        .unit = to_string(axis.unit).data(),
                        .speed = jog_speed(axis, is_referenced ? share : unreferenced_jog_share * share,
                                           session.tick_seconds()),
                        .is_referenced = is_referenced,
                        .way = unreferenced_way_share * (axis.max - axis.min)});
  }
  return rig;
}

void refuse_long_ticks(const RigFile& rig) {
  for (const RigAxis& axis : rig.axes) {
    if (jog_speed(axis, 1, 1.0 / rig.rate_hz) > 0) continue;
    throw InputError(axis.place,
                     fmt::format("axis {} cannot rest {:g} ms after a key was let go, with ticks of {:g} ms; "
                                 "raise rate_hz, or use inbetween goto",
                                 in_quotes(axis.name), jog_stops_within_s * 1000, 1000.0 / rig.rate_hz));
  }
}

SetupEnd jog_session(RigSession& session, std::size_t selected, RigReference& reference,
                     const JogOptions& options) {
  if (!session.arm()) return {.reason = reason_of(session, "the drives were not switched on")};
  JogRig axes = jog_rig(session, reference, options.share);
  FreeAxes free(std::move(axes.free));
  Jog jog(session.loop(),
          {.source = source_of<double>(free),
           .drive_of = axes.drive_of,
           .limits = axes.limits,
           .tick_seconds = session.tick_seconds()},
          free, axes.axes, selected);
  const DisarmAtEnd disarm(session);
  ActEnd end;
  for (bool goes_on = true; goes_on;) {
    end = session.perform(jog);
    goes_on = end.begun && jog.asks() != Jog::Ask::none;
    if (jog.asks() == Jog::Ask::mark) {
      refuse_changed_rig(session.rig().path, options.session.audience.rig_has_changed);
      const std::size_t axis = jog.selected();
      reference.about_to_move({&axis, 1});
      jog.marked();
    } else if (jog.asks() == Jog::Ask::keep) {
      session.keep(jog.states());
      jog.kept();
    }
  }
  session.rest();
  const bool was_left = jog.was_left();
  const std::string reason = end.begun ? reason_of(session, "the rig was stopped") : end.begun.error().what;
  return {.is_done = was_left, .reason = was_left ? "left" : reason, .positions = session.positions()};
}

}  // namespace

SetupEnd jog(const RigFile& rig, std::size_t selected, RigReference& reference, const JogOptions& options) {
  refuse_long_ticks(rig);
  RigSession session(rig, reference, options.session);
  return end_of(session, [&] { return jog_session(session, selected, reference, options); });
}

}  // namespace inbetween
