#include "host_tools/motions/jog.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "host_tools/motions/lone_axis.hpp"
#include "host_tools/motions/transit.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

constexpr auto ns_of(double seconds) {
  return static_cast<std::int64_t>(seconds * 1e9);
}
/// How long everything rests before its place is written: whoever nudges an axis does not wait for the disk.
constexpr std::int64_t ns_until_kept = 500'000'000;

/// Number i of the series ..., 0.5, 1, 2, 5, 10, ...; number 0 is 1. Divided, not multiplied by a part, so
/// that it is the nearest number to its decimals.
double of_series(int i) {
  constexpr std::array<double, 3> digits{1, 2, 5};
  const int decade = i >= 0 ? i / 3 : -((2 - i) / 3);
  const double digit = digits[static_cast<std::size_t>(i - 3 * decade)];
  const double power = std::pow(10.0, std::abs(decade));
  return decade >= 0 ? digit * power : digit / power;
}

FreeAxisLimits jog_limits(const RigAxis& axis, double share, bool is_referenced, double position) {
  FreeAxisLimits limits = free_limits_of(axis, share);
  if (!is_referenced) limits.velocity *= unreferenced_jog_share;
  const bool is_outside = position < axis.min || position > axis.max;
  if (is_outside) limits.velocity = std::min(limits.velocity, free_limits_of(axis, transit_share).velocity);
  limits.stop_share = 1 / share;
  return limits;
}

}  // namespace

JogIncrements jog_increments(const RigAxis& axis) {
  constexpr double rounding = 1 + 1e-9;
  const double most = jog_step_share * (axis.max - axis.min) * rounding;
  int largest = 3 * static_cast<int>(std::floor(std::log10(most))) + 3;
  while (of_series(largest) > most) --largest;
  JogIncrements increments;
  for (std::size_t i = 0; i < increments.size(); ++i) {
    increments[i] =
        std::max(of_series(largest - 2 * static_cast<int>(increments.size() - 1 - i)), count_of(axis));
  }
  return increments;
}

double JogAxis::increment(std::size_t size, double position, int direction) const {
  if (calibration == nullptr) return std::max(increments[size], count);
  const double motor_step =
      calibration->slope_at(position).first > 0 ? direction * count : -direction * count;
  const double a_count_on = calibration->axis_at(calibration->motor_at(position) + motor_step);
  return std::max(increments[size], std::fabs(a_count_on - position));
}

Jog::Jog(RunLoop& loop, const FreeSpec& spec, FreeAxes& free, std::vector<JogAxis> axes, std::size_t selected,
         JogKeys keys)
    : loop_(loop),
      spec_(spec),
      free_(free),
      axes_(std::move(axes)),
      is_marked_(axes_.size()),
      states_(loop.drive_states().size()),
      keys_(loop, false),
      selected_(selected),
      wanted_(keys) {}

Status Jog::begin() {
  if (has_begun_) return Done{};
  has_begun_ = true;
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  return loop_.begin();
}

void Jog::press(TransportKey key) {
  if (key == TransportKey::let_go) {
    terminal_.release();
    return let_go();
  }
  if (key == TransportKey::tells_releases) return terminal_.tells_releases();
  if (key == TransportKey::device_gone) return keys_.say("the device is gone: leave with q, and begin again");
  if (key == TransportKey::still_held) {
    held_ns_ = now_ns_;
    return;
  }
  // Nobody attends whom a stop could wait for: whoever stops everything leaves.
  if (key == TransportKey::stop) key = TransportKey::quit;
  if (keys_.press(key)) {
    pressed_ = held_ = 0;
    terminal_.forget();
    return;
  }
  if (!keys_.is_running()) return;
  switch (key) {
    case TransportKey::repeat_forward:
    case TransportKey::repeat_backward:
      terminal_.repeat(direction_of(key), now_ns_);
      return pressed(0);
    case TransportKey::hold_forward:
    case TransportKey::hold_backward:
      return hold(direction_of(key));
    case TransportKey::detent_forward:
    case TransportKey::detent_backward:
      return turned(direction_of(key));
    case TransportKey::step_forward:
    case TransportKey::faster:
      return pressed(1);
    case TransportKey::step_backward:
    case TransportKey::slower:
      return pressed(-1);
    case TransportKey::next_axis:
      return choose((selected_ + 1) % axes_.size());
    case TransportKey::previous_axis:
      return choose((selected_ + axes_.size() - 1) % axes_.size());
    case TransportKey::size_1:
    case TransportKey::size_2:
    case TransportKey::size_3:
    case TransportKey::size_4:
    case TransportKey::size_5:
      return choose_increment(static_cast<std::size_t>(key) - static_cast<std::size_t>(TransportKey::size_1));
    case TransportKey::start:
    case TransportKey::teach_next:
    case TransportKey::teach_previous:
    case TransportKey::teach_insert:
    case TransportKey::teach_replace:
    case TransportKey::teach_undo:
      return wanted_.teach ? teach(key) : stop();
    default:
      return stop();
  }
}

/// A direction came from the terminal; 0 for one that it has repeated, and says so.
void Jog::pressed(int direction) {
  if (wanted_.device) return keys_.say("the keys of the device move it");
  if (direction != 0) terminal_.press(direction, now_ns_);
  if (terminal_.is_refused()) keys_.say(refused_keys_in_words);
}

void Jog::turned(int direction) {
  if (pressed_ != 0 || held_ != 0 || !free_.is_resting()) {
    return keys_.say("the wheel turns faster than the axis goes: some detents moved nothing");
  }
  pressed_ = direction;
  pressed_ns_ = now_ns_;
}

/// Where the rig stands is known when it rests.
void Jog::teach(TransportKey key) {
  pressed_ = 0;
  terminal_.forget();
  if (held_ != 0 || !free_.is_resting()) return keys_.say("it still moves: press again");
  if (ask_ == Ask::teach) return keys_.say("the key before is not done: press again");
  taught_ = key;
  ask_ = Ask::teach;
}

void Jog::look_at_terminal() {
  if (const int direction = terminal_.take_press(now_ns_); direction != 0) {
    pressed_ = direction;
    pressed_ns_ = terminal_.pressed_ns();
  }
  if (wanted_.device) return;
  const int held = terminal_.held(now_ns_);
  if (held_ != 0 && held != held_) return let_go();
  if (held == 0) return;
  if (held_ == 0) hold(held);
  held_ns_ = now_ns_;
}

void Jog::take_press() {
  if (pressed_ == 0) return;
  if (!free_.is_resting()) {
    keys_.say("it still moves: one step at a time");
  } else if (now_ns_ - pressed_ns_ >= ns_of(jog_press_waits_s)) {
    keys_.say("the press came long ago: press again");
  } else if (!is_marked_[selected_]) {
    ask_ = Ask::mark;
    return;
  } else {
    step(pressed_);
  }
  pressed_ = 0;
}

/// An axis that does not know where it is has no limits but its step. One that stands outside its limits
/// comes no further out.
void Jog::step(int direction) {
  const JogAxis& stepped = axes_[selected_];
  const double here = axis().position();
  const double increment = stepped.increment(size_, here, direction);
  const double target = here + direction * increment;
  const bool is_bounded = stepped.is_referenced;
  const Status ranged = axis().set_range(is_bounded ? std::min(stepped.min, here) : here - increment,
                                         is_bounded ? std::max(stepped.max, here) : here + increment);
  if (!ranged) return keys_.say(ranged);
  if (axis().go_to(target)) return keys_.say("");
  keys_.say("its limit is nearer than that: choose a smaller step");
}

void Jog::stop() {
  pressed_ = 0;
  held_ = 0;
  terminal_.forget();
  axis().stop();
}

void Jog::hold(int direction) {
  held_ = direction;
  has_begun_hold_ = false;
  held_ns_ = now_ns_;
}

void Jog::let_go() {
  if (held_ != 0 && has_begun_hold_) axis().stop();
  held_ = 0;
}

/// One that could not begin at once, or has come to its end, must be let go and pressed anew. The key of a
/// terminal waits for the step that its press has begun.
void Jog::take_hold() {
  if (held_ == 0) return;
  if (now_ns_ - held_ns_ >= ns_of(jog_silence_s)) {
    let_go();
    return keys_.say("it is not told to be held any more: press again");
  }
  if (has_begun_hold_) {
    const bool is_over = free_.is_resting() && *keys_.words() == 0;
    return is_over ? keys_.say("as far as a held key goes: let go, and press again") : void();
  }
  if (free_.is_resting() && !is_marked_[selected_]) {
    ask_ = Ask::mark;  // comes back while it is held
    return;
  }
  if (!free_.is_resting() && !wanted_.device) return;
  has_begun_hold_ = true;
  if (free_.is_resting()) return begin_hold();
  held_ = 0;
  keys_.say("it still moves: press again");
}

void Jog::begin_hold() {
  const JogAxis& moved = axes_[selected_];
  const double here = axis().position();
  const double low = moved.is_referenced ? std::min(moved.min, here) : here - moved.reach;
  const double high = moved.is_referenced ? std::max(moved.max, here) : here + moved.reach;
  Status goes = axis().set_range(low, high);
  if (goes) goes = axis().go_to(std::clamp(here + held_ * moved.reach, low, high));
  keys_.say(goes);
}

void Jog::choose(std::size_t axis) {
  stop();
  if (axes_.size() == 1) return keys_.say("it moves alone, until it knows where it is");
  selected_ = axis;
}

void Jog::choose_increment(std::size_t size) {
  pressed_ = 0;
  terminal_.forget();
  size_ = size;
}

void Jog::tick(std::int32_t ticks, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (keys_.is_running() && ask_ == Ask::none) look_at_terminal();
  if (keys_.is_running() && ask_ == Ask::none) take_press();
  if (keys_.is_running() && ask_ == Ask::none) take_hold();
  keys_.note(loop_.tick(ticks, now_ns));
  std::ranges::copy(loop_.drive_states(), states_.begin());
  if (!free_.is_resting()) rested_ns_ = now_ns;
  const bool has_moved = std::ranges::find(is_marked_, true) != is_marked_.end();
  const bool has_rested = has_moved && now_ns - rested_ns_ >= ns_until_kept;
  if (has_rested && keys_.is_running() && ask_ == Ask::none) ask_ = Ask::keep;
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
  const FreeAxis& free = std::as_const(free_).axes()[selected_];
  const JogAxis& axis = axes_[selected_];
  const double increment = axis.increment(size_, free.position(), 1);
  return {.state = loop_.state(),
          .is_resting = free_.is_resting(),
          .words = keys_.words(),
          .jog = JogSnapshot{.axis = axis.name,
                             .unit = axis.unit,
                             .position = free.position(),
                             .velocity = free.state().velocity,
                             .stop_distance = std::fabs(free.stop_distance()),
                             .min = axis.min,
                             .max = axis.max,
                             .size = static_cast<int>(size_) + 1,
                             .increment = increment,
                             .is_count = increment == axis.count || increment > axis.increments[size_],
                             .reach = axis.reach,
                             .by_device = wanted_.device,
                             .is_alone = axes_.size() == 1,
                             .is_referenced = axis.is_referenced}};
}

namespace {

/// All axes of a rig, ready to be moved by hand.
struct JogRig {
  std::vector<std::size_t> drive_of;
  std::vector<AxisLimits> limits;
  std::vector<FreeAxis> free;
  std::vector<JogAxis> axes;
};

JogRig jog_rig(const RigSession& session, const RigReference& reference, double share, double reach) {
  JogRig rig;
  for (std::size_t a = 0; a < session.rig().axes.size(); ++a) {
    const RigAxis& axis = session.rig().axes[a];
    const bool is_referenced = reference.is_referenced(a);
    rig.drive_of.push_back(a);
    rig.limits.push_back(limits_of(slow_enough_everywhere(axis)));
    rig.free.push_back(free_axis_of(axis, jog_limits(axis, share, is_referenced, session.positions()[a]),
                                    session.positions()[a], session.tick_seconds()));
    rig.axes.push_back({.name = axis.name.c_str(),
                        .unit = to_string(axis.unit).data(),
                        .increments = jog_increments(axis),
                        .min = axis.min,
                        .max = axis.max,
                        .count = count_of(axis.drive),
                        .calibration = axis.calibration ? &axis.calibration->motor() : nullptr,
                        .is_referenced = is_referenced,
                        .reach = reach * (axis.max - axis.min)});
  }
  return rig;
}

SetupEnd jog_session(RigSession& session, std::size_t selected, RigReference& reference,
                     const JogOptions& options) {
  if (!session.arm()) return {.reason = reason_of(session, "the drives were not switched on")};
  JogRig axes = jog_rig(session, reference, options.share, options.reach);
  FreeAxes free(std::move(axes.free));
  Jog jog(session.loop(),
          {.source = source_of(free),
           .drive_of = axes.drive_of,
           .limits = axes.limits,
           .tick_seconds = session.tick_seconds()},
          free, axes.axes, selected,
          {.teach = static_cast<bool>(options.teach), .device = options.has_device});
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
    } else if (jog.asks() == Jog::Ask::teach) {
      std::vector<double> positions;
      for (const FreeAxis& axis : free.axes()) positions.push_back(axis.position());
      options.teach(jog.taught(), jog.selected(), positions);
      jog.has_taught();
    }
  }
  const std::string unreached = session.rest();
  if (jog.was_left() && !unreached.empty()) {
    return {.is_done = false, .reason = unreached, .positions = session.positions()};
  }
  const bool was_left = jog.was_left();
  const std::string reason = end.begun ? reason_of(session, "the rig was stopped") : end.begun.error().what;
  return {.is_done = was_left, .reason = was_left ? "left" : reason, .positions = session.positions()};
}

}  // namespace

std::vector<std::size_t> jogged_axes(const RigFile& rig, std::size_t selected,
                                     const RigReference& reference) {
  if (!reference.is_referenced(selected)) return {selected};
  std::vector<std::size_t> all(rig.axes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

SetupEnd jog(const RigFile& rig, std::size_t selected, RigReference& reference, const JogOptions& options) {
  if (!reference.is_referenced(selected)) {
    if (options.teach) reference.refuse_unreferenced({&selected, 1});
    return use_alone(rig, selected, reference, options.session,
                     [&](RigSession& session, RigReference& unknown) {
                       return jog_session(session, 0, unknown, options);
                     });
  }
  RigSession session(rig, reference, options.session);
  return end_of(session, [&] { return jog_session(session, selected, reference, options); });
}

}  // namespace inbetween
