#include "host_tools/hosted/hosted_motion.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace inbetween {
namespace {

Error busy() {
  return {.code = ErrorCode::wrong_state,
          .what = "the rig moves, or is not ready",
          .remedy = "wait until it rests, and agree again"};
}

}  // namespace

HostedMotion::HostedMotion(RunLoop& loop, std::vector<FreeAxis> axes, std::vector<AxisLimits> limits,
                           double tick_seconds, LevelOutputs* outputs)
    : loop_(loop),
      keys_(loop, true),
      free_(std::move(axes)),
      drive_of_(free_.axes().size()),
      limits_(std::move(limits)),
      tick_seconds_(tick_seconds),
      outputs_(outputs) {
  for (const FreeAxis& axis : free_.axes()) free_limits_.push_back(axis.limits());
  std::iota(drive_of_.begin(), drive_of_.end(), std::size_t{0});
}

FreeSpec HostedMotion::free_spec() {
  return {
      .source = source_of(free_), .drive_of = drive_of_, .limits = limits_, .tick_seconds = tick_seconds_};
}

Status HostedMotion::begin() {
  return loop_.load(free_spec());
}

void HostedMotion::obey(const MotionOrder& order) {
  using Kind = MotionOrder::Kind;
  told_.heard = order.number;
  Status done = Done{};
  switch (order.kind) {
    case Kind::limit:
      free_limits_[order.axis] = order.limits;
      break;
    case Kind::go:
      done = go(order);
      break;
    case Kind::stop_axis:
      if (move_ == nullptr) free_.axes()[order.axis].stop();
      break;
    case Kind::stop:
      stop();
      break;
    case Kind::travel:
      done = travel(order);
      break;
    case Kind::play:
      done = play(order);
      break;
    case Kind::end_repeats:
      if (move_ != nullptr) move_->playhead().set_repeat(Repeat::none);
      break;
    case Kind::forget:
      if (is_moving() || delay_ticks_ > 0) break;
      move_ = nullptr;
      done = loop_.load(free_spec());
      if (done) told_.forgotten = order.number;
      break;
    case Kind::acknowledge:
      loop_.post(SupervisorEvent::acknowledge);
      break;
    case Kind::switch_outputs:
      wanted_outputs_ = order.outputs;
      break;
    case Kind::none:
      break;
  }
  if (done) return;
  told_.refused = order.number;
  told_.why = done.error().what;
}

/// Every axis begins where its drive was told to be last: a move may have been played meanwhile.
Status HostedMotion::begin_free() {
  if (loop_.state() != SupervisorState::ready) return busy();
  for (std::size_t a = 0; a < free_limits_.size(); ++a) {
    const auto made = FreeAxis::make(free_limits_[a], loop_.setpoints()[a].position, tick_seconds_);
    if (!made) return made.error();
    free_.axes()[a] = *made;
  }
  move_ = nullptr;
  if (const Status loaded = loop_.load(free_spec()); !loaded) return loaded;
  return loop_.begin();
}

Status HostedMotion::go(const MotionOrder& order) {
  if (!is_running()) {
    if (const Status begun = begin_free(); !begun) return begun;
  } else if (move_ != nullptr) {
    return busy();
  }
  FreeAxis& axis = free_.axes()[order.axis];
  return axis.go_to(order.position, std::min(order.velocity, axis.limits().velocity));
}

Status HostedMotion::load(StagedMove& move) {
  move_ = nullptr;
  if (const Status loaded = loop_.load(move.loop_spec()); !loaded) return loaded;
  move_ = &move;
  repeats_ = 0;
  return Done{};
}

Status HostedMotion::travel(const MotionOrder& order) {
  Playhead& playhead = order.move->playhead();
  if (is_running() && move_ == order.move && delay_ticks_ == 0) return playhead.go_to(order.frame);
  if (is_moving() || delay_ticks_ > 0) return busy();
  if (const Status placed = playhead.place_on(order.from_frame); !placed) return placed;
  if (const Status set = playhead.set_override(order.rate); !set) return set;
  if (const Status loaded = load(*order.move); !loaded) return loaded;
  if (const Status begun = loop_.begin(); !begun) return begun;
  return playhead.go_to(order.frame);
}

Status HostedMotion::play(const MotionOrder& order) {
  if (loop_.state() != SupervisorState::ready || delay_ticks_ > 0) return busy();
  if (const Status placed = order.move->playhead().place_on(0); !placed) return placed;
  if (const Status loaded = load(*order.move); !loaded) return loaded;
  delay_ticks_ = order.delay_ticks + 1;
  return Done{};
}

void HostedMotion::stop() {
  delay_ticks_ = 0;
  if (!is_running()) return;
  if (move_ != nullptr) {
    move_->playhead().stop();
  } else {
    free_.stop();
  }
}

void HostedMotion::tick(std::int32_t ticks, std::int64_t now_ns) {
  while (const std::optional<MotionOrder> order = orders_.pop()) obey(*order);
  if (outputs_ != nullptr) outputs_->set(wanted_outputs_, now_ns);
  if (loop_.state() != SupervisorState::ready) delay_ticks_ = 0;
  if (delay_ticks_ > 0) {
    delay_ticks_ = std::max<std::int64_t>(delay_ticks_ - ticks, 0);
    if (delay_ticks_ == 0) {
      if (const Status started = loop_.start(Direction::forward); !started) {
        told_.refused = told_.heard;
        told_.why = started.error().what;
      }
    }
  }
  const bool was_moving = is_moving();
  const LoopTick tick = loop_.tick(ticks, now_ns);
  keys_.note(tick);
  if (tick.event == PlayheadEvent::repeated) ++repeats_;
  played_.reset();
  if (move_ != nullptr && was_moving && loop_.sends_setpoints())
    played_ = {place_of(move_->playhead()), repeats_};
  // It rests where its last setpoint is, which has just been written.
  const bool rests = move_ != nullptr ? move_->playhead().is_resting() : free_.is_resting();
  if (is_running() && rests) static_cast<void>(loop_.finish());
  tell(now_ns, tick);
}

void HostedMotion::tell(std::int64_t now_ns, const LoopTick& tick) {
  told_.now_ns = now_ns;
  told_.state = loop_.state();
  told_.plays = move_ != nullptr && (is_moving() || delay_ticks_ > 0);
  told_.time = move_ != nullptr ? move_->playhead().time() : FrameTime{};
  told_.repeats = repeats_;
  told_.lost_time = told_.lost_time || tick.lost_time;
  told_.moving = 0;
  const std::span<const FreeAxis> axes = std::as_const(free_).axes();
  for (std::size_t a = 0; a < axes.size() && a < max_hosted_axes; ++a) {
    const bool is_of_move =
        move_ != nullptr && std::ranges::count(move_->loop_spec().drive_of, a) > 0 && told_.plays;
    const bool is_free = move_ == nullptr && is_moving() && !axes[a].is_resting();
    if (is_of_move || is_free) told_.moving |= 1U << a;
    told_.commanded.at(a) =
        loop_.sends_setpoints() ? loop_.setpoints()[a].position : loop_.drive_states()[a].actual;
    told_.drives.at(a) = loop_.drive_states()[a];
  }
  // One that finds no room is made up for by the next, a tick later.
  states_.push(told_);
}

std::optional<double> HostedMotion::frame() const {
  if (move_ == nullptr || !is_moving()) return std::nullopt;
  const FrameTime time = move_->playhead().time();
  return time.frame + time.fraction;
}

RunSnapshot HostedMotion::snapshot() const {
  const bool is_ready = loop_.state() == SupervisorState::ready;
  const char* const doing = !is_moving()       ? ""
                            : move_ != nullptr ? "following the uploaded move"
                                               : "moving axes";
  return {.state = loop_.state(),
          .doing = is_ready && delay_ticks_ > 0 ? "about to play" : doing,
          .is_resting = !is_moving(),
          .keys = "Enter agrees, Esc stops, q leaves"};
}

}  // namespace inbetween
