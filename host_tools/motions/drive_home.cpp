#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/motions/home.hpp"
#include "host_tools/motions/lone_axis.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// A FreeSource whose setpoint stays where the drive was switched on, while the drive homes itself.
class HomingDrive {
 public:
  HomingDrive(can::Cia402Homing& homing, const RigInputs& lines, double position)
      : homing_(homing), lines_(lines), position_(position) {}

  void tick(std::int64_t now_ns, std::span<Setpoint> out) {
    now_ns_ = now_ns;
    out[0] = {.position = position_};
    if (homing_.state() != can::DriveHomingState::waiting) return;
    is_on_limit_ = lines_.homing_input(0).limit_hit;
    is_on_limit_ ? homing_.stop(now_ns) : static_cast<void>(homing_.start(now_ns));
  }
  void stop() {
    is_on_limit_ = is_on_limit_ || lines_.homing_input(0).limit_hit;
    homing_.stop(now_ns_);
  }
  void halt() { stop(); }
  [[nodiscard]] bool is_resting() const { return homing_.is_over(); }
  [[nodiscard]] bool is_on_limit() const { return is_on_limit_; }

 private:
  can::Cia402Homing& homing_;
  const RigInputs& lines_;
  double position_;
  std::int64_t now_ns_ = 0;
  bool is_on_limit_ = false;
};

std::string reason_of(const RigSession& session, const HomingDrive& motion, const can::Cia402Homing& homing) {
  const std::string axis = "axis " + in_quotes(session.rig().axes[0].name) + ": ";
  if (homing.failure() != can::DriveHomingFailure::none) {
    return fmt::format("{}{}; {}", axis, can::words_of(homing.failure()), can::remedy_of(homing.failure()));
  }
  if (motion.is_on_limit()) {
    return fmt::format("{}{}; {}", axis, words_of(HomingFailure::limit_hit),
                       remedy_of(HomingFailure::limit_hit));
  }
  return reason_of(session, "stopped before its end");
}

}  // namespace

SetupEnd home_by_drive(const RigFile& rig, std::size_t axis, RigReference& reference,
                       const SessionOptions& options) {
  RigFile one = lone_axis(rig, axis);
  std::get<Cia402Drive>(one.axes[0].drive).homing = rig.axes[axis].drive_home;
  RigReference none(one);
  RigSession session(one, none, lone_axis_options(options, rig, axis, reference));
  return end_of(session, [&]() -> SetupEnd {
    if (!session.arm()) return {.reason = reason_of(session, "the drives were not switched on")};
    refuse_changed_rig(rig.path, options.audience.rig_has_changed);
    can::Cia402Homing& homing = *session.drives().homing(0);
    HomingDrive motion(homing, session.lines(), session.positions()[0]);
    const std::vector<std::size_t> first{0};
    const std::vector<AxisLimits> limits{limits_of(one.axes[0])};
    ManualMotion play(session.loop(),
                      {.source = source_of(motion),
                       .drive_of = first,
                       .limits = limits,
                       .tick_seconds = session.tick_seconds()},
                      "homing");
    const DisarmAtEnd disarm(session);
    reference.is_lost(axis, "its homing was not done");
    reference.about_to_move({&axis, 1});
    const ActEnd played = session.perform(play);
    SetupEnd end{.is_done = played.begun && play.is_done() && homing.state() == can::DriveHomingState::done,
                 .reason = "the axes are home",
                 .positions = std::vector<double>(rig.axes.size())};
    if (!end.is_done)
      end.reason = played.begun ? reason_of(session, motion, homing) : played.begun.error().what;
    session.rest();
    end.positions[axis] = session.positions()[0];
    end.is_done ? reference.stands_at(axis, end.positions[axis])
                : reference.is_lost(axis, "its homing was not done");
    return end;
  });
}

}  // namespace inbetween
