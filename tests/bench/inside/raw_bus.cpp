#include "tests/bench/inside/raw_bus.hpp"

#include <gtest/gtest.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace inbetween {
namespace {

void check(bool is_good, const char* what) {
  if (!is_good) throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

RawBus::RawBus(const std::string& interface) : socket_(::socket(PF_CAN, SOCK_RAW, CAN_RAW)) {
  check(socket_ >= 0, "socket");
  const std::uint32_t every_error = CAN_ERR_MASK;
  check(::setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &every_error, sizeof every_error) == 0,
        "error filter");
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  check(address.can_ifindex != 0, "if_nametoindex");
  check(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0, "bind");
}

RawBus::~RawBus() {
  ::close(socket_);
}

void RawBus::send(std::uint32_t id_and_flags, const std::vector<std::uint8_t>& data) {
  can_frame frame{};
  frame.can_id = id_and_flags;
  frame.len = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), std::begin(frame.data));
  check(::write(socket_, &frame, sizeof frame) == sizeof frame, "write");
}

std::optional<can_frame> RawBus::read_within(int milliseconds) {
  pollfd wait{.fd = socket_, .events = POLLIN, .revents = 0};
  can_frame frame{};
  if (::poll(&wait, 1, milliseconds) != 1) return std::nullopt;
  if (::read(socket_, &frame, sizeof frame) != sizeof frame) return std::nullopt;
  return frame;
}

std::optional<can_frame> RawBus::next() {
  return read_within(5000);
}

std::optional<can_frame> RawBus::waiting() {
  return read_within(0);
}

void shell(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

}  // namespace inbetween
