#include "drivers/can/error_frame.hpp"

#include <linux/can.h>
#include <linux/can/error.h>

namespace inbetween::can {

ErrorFrame decode_error_frame(std::uint32_t id, const std::array<std::uint8_t, 8>& data) {
  const auto has = [&](std::uint32_t error_class) { return (id & CAN_ERR_MASK & error_class) != 0; };
  // The second byte says what a controller problem is, and is without meaning otherwise.
  const auto controller = [&](unsigned bits) { return has(CAN_ERR_CRTL) && (data[1] & bits) != 0; };
  return {
      .is_receive_overflow = controller(CAN_ERR_CRTL_RX_OVERFLOW),
      .is_transmit_overflow = controller(CAN_ERR_CRTL_TX_OVERFLOW),
      .is_warning = controller(CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING),
      .is_passive = controller(CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE),
      .is_active = controller(CAN_ERR_CRTL_ACTIVE),
      .is_unacknowledged = has(CAN_ERR_ACK),
      .is_bus_off = has(CAN_ERR_BUSOFF),
      .is_restarted = has(CAN_ERR_RESTARTED),
  };
}

}  // namespace inbetween::can
