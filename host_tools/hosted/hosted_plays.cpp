// The uploaded move of a hosted rig: on the way along it, runs, and exposures in motion.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "host_tools/hosted/hosted_rig.hpp"
#include "host_tools/hosted/shot_rows.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

using namespace dragonframe;

namespace {

/// Of the move along which the rig is taken from frame to frame: how fast that is, a share of it says.
constexpr std::uint32_t travel_frames_per_1000_s = 24'000;

double steps_of(const UploadedMove& move, std::size_t axis, double frame) {
  return move.position(static_cast<std::uint8_t>(axis + 1), frame);
}

/// Frames of a time, whole within a rounding.
struct RollFrames {
  std::int32_t whole = 0;
  double rest_s = 0;
};
RollFrames frames_of(std::uint32_t ms, double fps) {
  constexpr double rounding = 1e-9;
  const double frames = ms / 1000.0 * fps;
  const double whole = std::floor(frames * (1 + rounding) + rounding);
  return {.whole = static_cast<std::int32_t>(whole), .rest_s = std::max(frames - whole, 0.0) / fps};
}

/// Whether no motor goes a step between two places.
bool is_same(const MotorPositions& roll, const UploadedMove& move, double frame,
             const std::vector<std::size_t>& axes) {
  return std::ranges::all_of(
      axes, [&](std::size_t axis) { return std::fabs(roll.at(axis) - steps_of(move, axis, frame)) < 1; });
}

/// What comes round passes its ends at rest, and has no pre-roll: no motor goes more than a step in the first
/// frame.
bool begins_slowly(const PrepareRun& run, const UploadedMove& move, const std::vector<std::size_t>& axes) {
  const double next = run.start + (run.end >= run.start ? 1.0 : -1.0);
  return std::ranges::all_of(axes, [&](std::size_t axis) {
    return std::fabs(steps_of(move, axis, next) - steps_of(move, axis, run.start)) <= 1;
  });
}

}  // namespace

std::vector<std::size_t> HostedRig::axes_of(MotorMask motors) const {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < scales_.size(); ++a) {
    if ((motors >> a & 1U) != 0) axes.push_back(a);
  }
  return axes;
}

/// The loop may still refer to it, and slow down on it.
void HostedRig::retire(std::unique_ptr<RowMove> move) {
  if (!move) return;
  retired_.push_back(std::move(move));
  forget_ = 0;
}

/// Once nothing moves the loop is asked to forget them, and when it has they go.
void HostedRig::drop_retired() {
  if (retired_.empty()) return;
  if (forget_ != 0 && now_.forgotten == forget_) {
    retired_.clear();
    forget_ = 0;
    return;
  }
  const bool is_open = forget_ != 0 && now_.heard != sent_;
  const bool rests = now_.heard == sent_ && now_.moving == 0 && !now_.plays && phase_ != Phase::running;
  if (!is_open && rests && send({.kind = MotionOrder::Kind::forget})) forget_ = sent_;
}

void HostedRig::drop_prepared() {
  retire(std::move(run_.move));
  run_ = {};
}

void HostedRig::drop_travel() {
  retire(std::move(travel_.move));
  travel_ = {};
}

void HostedRig::begin_phase(Phase phase, MotorMask motors) {
  phase_ = phase;
  phase_motors_ = motors;
}

RigAnswer HostedRig::apply(const TakeMove& order) {
  drop_prepared();
  drop_travel();
  leave_frame();
  upload_ = order.move;
  uploaded_ = order.motors;
  if (upload_ == nullptr || uploaded_ == 0) return RigAnswer::ok;
  const RigAnswer answer = prove_travel(uploaded_);
  if (answer != RigAnswer::ok) upload_ = nullptr;
  return answer;
}

/// The whole upload, as far as these motors are in it, to go along it.
RigAnswer HostedRig::prove_travel(MotorMask motors) {
  if (travel_.move && travel_.motors == motors) return RigAnswer::ok;
  drop_travel();
  const std::int32_t last = upload_->end() - upload_->start();
  MoveRows rows{.axes = axes_of(motors), .frames_per_1000_s = travel_frames_per_1000_s};
  for (std::int32_t frame = 0; frame <= last; ++frame) {
    rows.frames.push_back(frame);
    for (const std::size_t axis : rows.axes) {
      double position = scales_[axis].units(steps_of(*upload_, axis, upload_->start() + frame));
      const RigAnswer answer = judge_position(axis, position);
      if (answer != RigAnswer::ok) {
        words_.back() += fmt::format(" at frame {} of the uploaded move", upload_->start() + frame);
        return answer;
      }
      rows.positions.push_back(position);
    }
  }
  travel_.axes = rows.axes;
  travel_.motors = motors;
  travel_.frames = {.first = upload_->start(), .count = last};
  if (last == 0 || rows.axes.empty()) return RigAnswer::ok;
  ProvenRows proven = prove_rows(rig_, rows, RowUse::travel);
  if (!proven.move) return refuse(proven.answer, proven.why);
  travel_.move = std::move(proven.move);
  return RigAnswer::ok;
}

/// Where the move along which the rig goes has an axis, which is within a step of the upload.
double HostedRig::position_at(std::size_t axis, std::int32_t frame) const {
  const auto found = std::ranges::find(travel_.axes, axis);
  if (!travel_.move || found == travel_.axes.end())
    return scales_[axis].units(steps_of(*upload_, axis, frame));
  std::vector<double> positions(travel_.axes.size());
  travel_.move->plan->motion().positions({frame - travel_.frames.first, 0}, positions);
  return positions[static_cast<std::size_t>(found - travel_.axes.begin())];
}

RigAnswer HostedRig::apply(const GoToFrame& order) {
  if (upload_ == nullptr || !upload_->has(order.frame)) return RigAnswer::general;
  if (const RigAnswer may = may_go(); may != RigAnswer::ok) return may;
  if (const RigAnswer proven = prove_travel(order.motors); proven != RigAnswer::ok) return proven;
  std::vector<std::pair<std::size_t, double>> targets;
  for (const std::size_t axis : axes_of(order.motors))
    targets.emplace_back(axis, position_at(axis, order.frame));
  const RigAnswer answer = go_all(targets);
  if (answer != RigAnswer::ok) return answer;
  drop_prepared();
  at_frame_.reset();
  goal_frame_ = order.frame;
  begin_phase(Phase::going, 0);
  return RigAnswer::ok;
}

/// From the frame on which the rig stands, or on its way already.
RigAnswer HostedRig::begin_travel(std::int32_t frame, double rate) {
  const std::int32_t first = travel_.frames.first;
  if (!mark(travel_.motors)) return RigAnswer::general;
  const bool is_sent = send({.kind = MotionOrder::Kind::travel,
                             .move = travel_.move->staged.get(),
                             .from_frame = at_frame_.value_or(first) - first,
                             .frame = frame - first,
                             .rate = std::min(rate, travel_.move->slow_rate)},
                            travel_.motors);
  if (!is_sent) return RigAnswer::general;
  if (!told_frames_) told_time_ = at_frame_.value_or(first) - first;
  told_frames_ = travel_.frames;
  goal_frame_ = frame;
  at_frame_.reset();
  return RigAnswer::ok;
}

RigAnswer HostedRig::apply(const JogAll& order) {
  if (upload_ == nullptr || !upload_->has(order.frame)) return RigAnswer::general;
  const bool is_along = phase_ == Phase::along || phase_ == Phase::approach;
  if (!is_along) {
    if (const RigAnswer may = may_go(); may != RigAnswer::ok) return may;
    if (phase_ == Phase::going) return RigAnswer::moving;
    if (!at_frame_) return RigAnswer::not_in_position;
    if (const RigAnswer proven = prove_travel(order.motors); proven != RigAnswer::ok) return proven;
  }
  drop_prepared();
  if (!travel_.move) return RigAnswer::ok;  // one frame, or no motor
  const double rate = static_cast<double>(order.frames_per_1000_s) / travel_frames_per_1000_s;
  const RigAnswer answer = begin_travel(order.frame, rate);
  if (answer == RigAnswer::ok) begin_phase(Phase::along, travel_.motors);
  return answer;
}

/// The frames of the host in the order of playing, from rest at the pre-roll to rest at the post-roll.
RigAnswer HostedRig::prove_run(const PrepareRun& order, Prepared& run) {
  const double fps = order.frames_per_1000_s / 1000.0;
  const int direction = order.end >= order.start ? 1 : -1;
  const std::int32_t count = std::abs(order.end - order.start) + 1;
  run.axes = axes_of(order.motors);
  run.motors = order.motors;
  if (run.axes.empty()) return refuse(RigAnswer::general, "no motor that is enabled has positions");
  RollFrames before = frames_of(order.preroll_ms, fps);
  RollFrames after = frames_of(order.postroll_ms, fps);
  const bool comes_round = order.is_loop || order.is_ping_pong;
  const bool starts_at_rest = comes_round ? begins_slowly(order, *upload_, run.axes)
                                          : is_same(order.preroll, *upload_, order.start, run.axes);
  const bool ends_at_rest =
      is_same(order.postroll, *upload_, static_cast<double>(order.end) + direction, run.axes);
  if (starts_at_rest) before = {.whole = 0, .rest_s = order.preroll_ms / 1000.0};
  if (ends_at_rest) after = {};
  if (comes_round) {
    if (!starts_at_rest) return refuse(RigAnswer::preroll, "what comes round again begins at rest");
    after = {};
  }
  if (!starts_at_rest && before.whole == 0)
    return refuse(RigAnswer::preroll, "the pre-roll is shorter than a frame, and the move begins in motion");
  if (!ends_at_rest && after.whole == 0 && order.postroll_ms > 0)
    return refuse(RigAnswer::postroll, "the post-roll is shorter than a frame, and the move ends in motion");
  MoveRows rows{.axes = run.axes, .frames_per_1000_s = order.frames_per_1000_s};
  const auto add = [&](std::int32_t at, const auto& steps) {
    rows.frames.push_back(at);
    for (const std::size_t axis : run.axes) rows.positions.push_back(scales_[axis].units(steps(axis)));
  };
  if (before.whole > 0) add(0, [&](std::size_t axis) { return order.preroll.at(axis); });
  for (std::int32_t k = 0; k <= count; ++k) {
    const double frame = order.start + static_cast<double>(direction) * k;
    add(before.whole + k, [&](std::size_t axis) { return steps_of(*upload_, axis, frame); });
  }
  const std::int32_t behind = before.whole + count;
  if (after.whole > 0) add(behind + after.whole, [&](std::size_t axis) { return order.postroll.at(axis); });
  run.frames = {.first = order.start, .before = before.whole, .direction = direction, .count = count};
  run.delay_s = before.rest_s;
  run.comes_round = comes_round;
  ProvenRows proven = prove_rows(rig_, rows, RowUse::play);
  if (proven.move) {
    run.move = std::move(proven.move);
    return RigAnswer::ok;
  }
  // The first and the last frame are those of the rolls where there is none.
  const bool is_in_preroll = proven.frame < std::max(before.whole, 1);
  const bool is_in_postroll = proven.frame > behind - (after.whole > 0 ? 0 : 1);
  if (is_in_preroll) proven.answer = RigAnswer::preroll;
  if (is_in_postroll) proven.answer = RigAnswer::postroll;
  return refuse(proven.answer,
                fmt::format("frame {:.1f} of the host: {}",
                            order.start + direction * (proven.frame - before.whole), proven.why));
}

RigAnswer HostedRig::apply(const PrepareRun& order) {
  if (upload_ == nullptr) return RigAnswer::general;
  if (order.camera != CameraKind::none) return RigAnswer::unsupported;
  if (phase_ == Phase::going || phase_ == Phase::running || phase_ == Phase::stopping)
    return RigAnswer::moving;
  const bool is_along = phase_ == Phase::along || phase_ == Phase::approach;
  if (const RigAnswer may = is_along ? may_move() : may_go(); may != RigAnswer::ok) return may;
  Prepared run;
  if (const RigAnswer proven = prove_run(order, run); proven != RigAnswer::ok) return proven;
  if (order.is_loop || order.is_ping_pong) {
    try {
      run.move->staged->set_repeat(order.is_ping_pong ? Repeat::ping_pong : Repeat::loop);
    } catch (const InputError& error) {
      return refuse(RigAnswer::general, error.message());
    }
  }
  if (!is_along) {
    if (const RigAnswer proven = prove_travel(order.motors); proven != RigAnswer::ok) return proven;
  }
  drop_prepared();
  run_ = std::move(run);
  const bool is_there = at_frame_ == order.start || !travel_.move;
  if (!is_along && !is_there && !at_frame_) return RigAnswer::not_in_position;
  if (is_along || !is_there) {
    const RigAnswer answer = begin_travel(order.start, 1);
    if (answer != RigAnswer::ok) return answer;
  }
  goal_frame_ = order.start;
  begin_phase(Phase::approach, order.motors);
  return RigAnswer::ok;
}

/// Every axis of what is prepared goes by itself to where that begins.
RigAnswer HostedRig::go_to_start() {
  std::vector<double> start(run_.axes.size());
  run_.move->plan->motion().positions({0, 0}, start);
  std::vector<std::pair<std::size_t, double>> targets;
  for (std::size_t i = 0; i < start.size(); ++i) targets.emplace_back(run_.axes[i], start[i]);
  leave_frame();
  const RigAnswer answer = go_all(targets);
  if (answer == RigAnswer::ok) begin_phase(Phase::to_start, run_.motors);
  return answer;
}

RigAnswer HostedRig::apply(const PrepareShot& order) {
  if (phase_ != Phase::none && phase_ != Phase::waiting) return RigAnswer::moving;
  if (const RigAnswer may = may_go(); may != RigAnswer::ok) return may;
  const ShotRows shot = rows_of(order, scales_);
  ProvenRows proven = prove_rows(rig_, shot.rows, RowUse::play);
  if (!proven.move) return refuse(proven.answer, "the exposure: " + proven.why);
  drop_prepared();
  run_.move = std::move(proven.move);
  run_.axes = shot.rows.axes;
  run_.frames = {.count = shot.closed_at, .are_told = false};
  for (const std::size_t axis : run_.axes) run_.motors |= MotorMask{1} << axis;
  const RigAnswer answer = go_to_start();
  if (answer != RigAnswer::ok) drop_prepared();
  return answer;
}

RigAnswer HostedRig::apply(const Go& /*order*/) {
  if (phase_ != Phase::waiting || !run_.move) return RigAnswer::not_in_position;
  if (const RigAnswer may = may_move(); may != RigAnswer::ok) return may;
  if (!mark(run_.motors)) return RigAnswer::general;
  const bool is_sent = send({.kind = MotionOrder::Kind::play,
                             .move = run_.move->staged.get(),
                             .delay_ticks = std::llround(run_.delay_s * rig_.rate_hz)},
                            run_.motors);
  if (!is_sent) return RigAnswer::general;
  told_frames_ = run_.frames;
  told_time_ = run_.frames.before == 0 ? -1 : 0;
  told_repeats_ = 0;
  has_ended_ = false;
  begin_phase(Phase::running, run_.motors);
  return RigAnswer::ok;
}

RigAnswer HostedRig::apply(const StopLoop& /*order*/) {
  run_.comes_round = false;
  return send({.kind = MotionOrder::Kind::end_repeats}) ? RigAnswer::ok : RigAnswer::general;
}

}  // namespace inbetween
