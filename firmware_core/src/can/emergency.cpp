#include "inbetween/can/emergency.hpp"

#include <algorithm>

#include "inbetween/can/little_endian.hpp"
#include "words.hpp"

namespace inbetween::can {
namespace {

constexpr std::array codes{
    Words{0x0000, "no error"},
    Words{0x2310, "over-current"},
    Words{0x2320, "short circuit"},
    Words{0x3210, "over-voltage of the DC link"},
    Words{0x3220, "under-voltage of the DC link"},
    Words{0x4210, "the drive is too hot"},
    Words{0x4310, "the motor or drive is too hot"},
    Words{0x6320, "a parameter is wrong"},
    Words{0x7121, "the motor is blocked"},
    Words{0x7300, "the position sensor"},
    Words{0x7305, "the incremental encoder"},
    Words{0x7320, "the position"},
    Words{0x8110, "CAN messages were lost"},
    Words{0x8120, "CAN is error-passive"},
    Words{0x8130, "the heartbeat of the host is missing"},
    Words{0x8140, "recovered from bus-off"},
    Words{0x8210, "a PDO was too short"},
    Words{0x8220, "a PDO was too long"},
    Words{0x8240, "SYNC has another length"},
    Words{0x8250, "setpoints are missing"},
    Words{0x8400, "the velocity controller"},
    Words{0x8500, "the position controller"},
    Words{0x8611, "following error"},
    Words{0x8612, "a position beyond its limit"},
    Words{0x8700, "the synchronisation with SYNC"},
};

/// By the first digits of the code, longest first.
struct ClassOfCodes {
  std::uint16_t mask;
  std::uint16_t code;
  const char* words;
};
constexpr std::array classes{
    ClassOfCodes{0xFF00, 0x8100, "communication"},
    ClassOfCodes{0xFF00, 0x8200, "the CANopen protocol"},
    ClassOfCodes{0xFF00, 0xFF00, "an error of this manufacturer's own"},
    ClassOfCodes{0xF000, 0x0000, "an error that was reset"},
    ClassOfCodes{0xF000, 0x1000, "an error without a kind"},
    ClassOfCodes{0xF000, 0x2000, "the current"},
    ClassOfCodes{0xF000, 0x3000, "the voltage"},
    ClassOfCodes{0xF000, 0x4000, "the temperature"},
    ClassOfCodes{0xF000, 0x5000, "the hardware of the drive"},
    ClassOfCodes{0xF000, 0x6000, "the software of the drive"},
    ClassOfCodes{0xF000, 0x7000, "a module of the drive, such as motor, sensor or brake"},
    ClassOfCodes{0xF000, 0x8000, "the supervision of the drive"},
    ClassOfCodes{0xF000, 0x9000, "something outside the drive"},
    ClassOfCodes{0xF000, 0xF000, "an additional function of the drive"},
};

}  // namespace

Frame emergency_frame(NodeId node, const Emergency& emergency) {
  Frame frame{.id = emergency_id(node), .length = 8};
  store(frame.data, 0, emergency.code);
  frame.data[2] = emergency.error_register;
  std::ranges::copy(emergency.manufacturer, frame.data.begin() + 3);
  return frame;
}

std::optional<Emergency> read_emergency(const Frame& frame, NodeId node) {
  if (!is_canopen(frame) || frame.id != emergency_id(node) || frame.length != 8) return {};
  Emergency emergency{.code = load<std::uint16_t>(frame.data, 0), .error_register = frame.data[2]};
  std::copy(frame.data.begin() + 3, frame.data.end(), emergency.manufacturer.begin());
  return emergency;
}

const char* words_of_emergency(std::uint16_t code) {
  if (const char* const known = words_in(codes, code, nullptr); known != nullptr) return known;
  for (const ClassOfCodes& one : classes) {
    if ((code & one.mask) == one.code) return one.words;
  }
  return "an error that CiA 301 does not name";
}

bool is_of_communication(std::uint16_t code) {
  const unsigned group = code >> 8U;
  return group == 0x81 || group == 0x82 || group == 0x87;
}

}  // namespace inbetween::can
