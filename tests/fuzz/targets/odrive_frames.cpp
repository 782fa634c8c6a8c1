// Any frames to a bus with two ODrives, one of each family.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/can/odrive.hpp"
#include "tests/fuzz/targets/servo_bus_under_test.hpp"

namespace inbetween::can {
namespace {

constexpr std::array families{OdriveFamily::firmware_06, OdriveFamily::firmware_05};

OdriveNode node_of(std::size_t axis) {
  return OdriveNode::make(static_cast<std::int64_t>(axis) + 3).value();
}

struct OdriveDialect {
  using Protocol = Odrive;
  static Odrive protocol(std::size_t axis) { return {node_of(axis), families.at(axis)}; }
  static Frame any_frame(Bytes& bytes) {
    const std::uint8_t kind = bytes.next();
    const std::uint32_t number = (3U + (kind & 1U)) << 5 | (bytes.next() & odrive_message_bits);
    Frame frame{.id = (kind & 0x20) != 0 ? FrameId::extended(number) : FrameId::standard(number)};
    frame.is_remote = (kind & 0x40) != 0;
    frame.length = (kind & 0x10) != 0 ? 7 : 8;
    for (std::uint8_t& byte : frame.data) byte = bytes.next();
    return frame;
  }
  /// Most of it sensible.
  static Frame told(std::size_t axis, std::uint8_t what) {
    switch ((what >> 1) & 3) {
      case 0:
        return odrive_version_frame(node_of(axis), {.firmware = {0, 6, what}});
      case 1:
        return odrive_estimates_frame(node_of(axis), static_cast<float>(what >> 5) * 0.125F, 0);
      default: {
        const bool has_missed = (what & 0x10) != 0;
        const std::uint8_t state = (what & 0x08) != 0 ? odrive_closed_loop : odrive_idle;
        const std::uint32_t errors = has_missed ? odrive_watchdog_error(families.at(axis)) : 0;
        return odrive_heartbeat_frame(node_of(axis), families.at(axis), {.errors = errors, .state = state});
      }
    }
  }
  static std::optional<std::size_t> axis_of(const Frame& frame) {
    const std::size_t axis = (frame.id.number() >> 5) - 3;
    if (axis >= 2 || frame.length > 8 || frame.id.is_extended()) return {};
    return axis;
  }
  static bool feeds(const Frame& /*frame*/) { return true; }
  static std::optional<double> target_of(const Frame& frame, std::size_t axis) {
    const auto position = read_odrive_position(frame, node_of(axis));
    if (!position) return {};
    return static_cast<double>(position->turns);
  }
};

}  // namespace
}  // namespace inbetween::can

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace inbetween::can;
  ServoBusUnderTest<OdriveDialect>().run(Bytes({data, size}));
  return 0;
}
