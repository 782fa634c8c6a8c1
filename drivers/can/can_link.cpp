#include "drivers/can/can_link.hpp"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>

namespace inbetween::can {
namespace {

/// A struct at the beginning of bytes; nothing where they are fewer.
template <class Value>
std::optional<Value> value_in(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(Value)) return {};
  Value value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + 3) & ~std::size_t{3};
}

/// Calls `take(type, content)` for each attribute. What is behind one with a wrong length is not looked at.
template <class Take>
void for_each_attribute(std::span<const std::byte> bytes, Take&& take) {
  while (const auto header = value_in<rtattr>(bytes)) {
    if (header->rta_len < sizeof(rtattr) || header->rta_len > bytes.size()) return;
    take(header->rta_type & 0x3FFF, bytes.subspan(sizeof(rtattr), header->rta_len - sizeof(rtattr)));
    bytes = bytes.subspan(std::min(aligned(header->rta_len), bytes.size()));
  }
}

ControllerState state_of(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE:
      return ControllerState::active;
    case CAN_STATE_ERROR_WARNING:
      return ControllerState::warning;
    case CAN_STATE_ERROR_PASSIVE:
      return ControllerState::passive;
    default:
      return ControllerState::bus_off;  // or it does not run at all
  }
}

void take_controller(std::span<const std::byte> data, CanLink& link) {
  for_each_attribute(data, [&](int type, std::span<const std::byte> content) {
    if (type == IFLA_CAN_BITTIMING) {
      const auto timing = value_in<can_bittiming>(content);
      if (!timing || timing->bitrate == 0) return;
      link.bitrate = timing->bitrate;
      link.sample_point_permille = timing->sample_point;
    } else if (type == IFLA_CAN_DATA_BITTIMING) {
      const auto timing = value_in<can_bittiming>(content);
      if (timing && timing->bitrate != 0) link.data_bitrate = timing->bitrate;
    } else if (type == IFLA_CAN_STATE) {
      if (const auto state = value_in<std::uint32_t>(content)) link.controller = state_of(*state);
    }
  });
}

void take_kind(std::span<const std::byte> info, CanLink& link) {
  for_each_attribute(info, [&](int type, std::span<const std::byte> content) {
    if (type == IFLA_INFO_DATA) take_controller(content, link);
  });
}

struct Socket {
  int number = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  Socket() = default;
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() {
    if (number >= 0) ::close(number);
  }
};

}  // namespace

std::optional<CanLink> parse_can_link(std::span<const std::byte> answer) {
  const auto header = value_in<nlmsghdr>(answer);
  if (!header || header->nlmsg_type != RTM_NEWLINK || header->nlmsg_len > answer.size() ||
      header->nlmsg_len < sizeof(nlmsghdr)) {
    return {};
  }
  answer = answer.subspan(sizeof(nlmsghdr), header->nlmsg_len - sizeof(nlmsghdr));
  const auto interface = value_in<ifinfomsg>(answer);
  if (!interface || interface->ifi_type != ARPHRD_CAN) return {};
  CanLink link{.is_up = (interface->ifi_flags & IFF_UP) != 0};
  for_each_attribute(answer.subspan(sizeof(ifinfomsg)), [&](int type, std::span<const std::byte> content) {
    if (type == IFLA_TXQLEN) link.queue_frames = value_in<std::uint32_t>(content).value_or(0);
    if (type == IFLA_MTU) link.carries_fd = value_in<std::uint32_t>(content) == CANFD_MTU;
    if (type == IFLA_LINKINFO) take_kind(content, link);
  });
  return link;
}

std::optional<CanLink> read_can_link(const std::string& interface) {
  struct Question {
    nlmsghdr header{};
    ifinfomsg interface {};
  } question;
  question.header.nlmsg_len = sizeof question;
  question.header.nlmsg_type = RTM_GETLINK;
  question.header.nlmsg_flags = NLM_F_REQUEST;
  question.interface.ifi_index = static_cast<int>(::if_nametoindex(interface.c_str()));
  const Socket socket;
  if (question.interface.ifi_index == 0 || socket.number < 0) return {};
  if (::send(socket.number, &question, sizeof question, 0) != sizeof question) return {};
  std::array<std::byte, 32768> answer;
  const ssize_t bytes = ::recv(socket.number, answer.data(), answer.size(), 0);
  if (bytes <= 0) return {};
  return parse_can_link(std::span(answer).first(static_cast<std::size_t>(bytes)));
}

}  // namespace inbetween::can
