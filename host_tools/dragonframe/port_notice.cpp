#include "host_tools/dragonframe/port_notice.hpp"

#include <fmt/format.h>

#include "host_tools/dragonframe/rig_port.hpp"

namespace inbetween::dragonframe {
namespace {

const char* reason_of(std::int64_t answer) {
  switch (static_cast<RigAnswer>(answer)) {
    case RigAnswer::ok:
      return "";
    case RigAnswer::moving:
      return "something moves";
    case RigAnswer::unsupported:
      return "the rig has no such thing";
    case RigAnswer::range:
      return "a number is outside of what the rig has";
    case RigAnswer::general:
      return "it is not possible now";
    case RigAnswer::not_in_position:
      return "the rig stands elsewhere";
    case RigAnswer::preroll:
      return "the way into the move would break a limit";
    case RigAnswer::postroll:
      return "the way out of the move would break a limit";
    case RigAnswer::soft_upper:
      return "the upper limit would be passed";
    case RigAnswer::soft_lower:
      return "the lower limit would be passed";
    case RigAnswer::hard_upper:
      return "the switch of the upper limit is pressed";
    case RigAnswer::hard_lower:
      return "the switch of the lower limit is pressed, or the rig was stopped";
  }
  return "";
}

std::string with_motor(const PortNotice& notice, const std::string& text) {
  return notice.motor == 0 ? text : fmt::format("motor {}: {}", notice.motor, text);
}

}  // namespace

std::string text_of(const PortNotice& notice) {
  using Kind = PortNotice::Kind;
  switch (notice.kind) {
    case Kind::connected:
      return "a host is connected; nothing moves until you agree";
    case Kind::disconnected:
      return "the host is gone; everything stops";
    case Kind::host_stopped:
      return "the host stopped the rig; agree again before it moves";
    case Kind::rig_stopped:
      return "the rig was stopped; agree again before it moves";
    case Kind::consent_missing:
      return with_motor(notice, "the host asks for a motion, and nobody has agreed");
    case Kind::rig_refused:
      return with_motor(notice, fmt::format("refused: {}", reason_of(notice.value)));
    case Kind::jog_not_repeated:
      return with_motor(notice, "the host no longer repeats the jog; the motor stops");
    case Kind::stop_in_play:
      return with_motor(notice, "the host stops one motor of a move; all stop");
    case Kind::half_dropped:
      return "half a message came and no more; it is dropped";
    case Kind::frame_narrowed:
      return fmt::format("a frame outside of the move: the rig goes to frame {}", notice.value);
    case Kind::speed_raised:
      return with_motor(notice, "a speed below 10 steps/s counts as 10");
    case Kind::override_ignored:
      return with_motor(notice, "there is no such motor; what was said of it for this shot is ignored");
    case Kind::unknown_flags:
      return with_motor(notice, fmt::format("unknown flags {:#x} are ignored", notice.value));
    case Kind::unknown_line:
      return "a line that is no command is ignored";
  }
  return "";
}

}  // namespace inbetween::dragonframe
