#include "drivers/can/socket_can.hpp"

#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

namespace inbetween::can {
namespace {

constexpr std::uint32_t flags_and_id = CAN_EFF_FLAG | CAN_RTR_FLAG;
/// Before tools and SDO transfers in the queue of the interface; the highest that needs no right.
constexpr int frame_priority = 6;

std::uint32_t raw_id(FrameId id) {
  return id.number() | (id.is_extended() ? CAN_EFF_FLAG : 0U);
}

bool can_be_sent(const Frame& frame) {
  return frame.length <= CAN_MAX_DLEN;
}
bool can_be_sent(const FdFrame& frame) {
  return is_fd_length(frame.length) && (!frame.is_classic || frame.length <= CAN_MAX_DLEN);
}

/// How many bytes the kernel takes for it.
std::size_t raw_size(const Frame& /*frame*/) {
  return CAN_MTU;
}
std::size_t raw_size(const FdFrame& frame) {
  return frame.is_classic ? CAN_MTU : CANFD_MTU;
}

template <class Raw, class AnyFrame>
Raw begin_raw(const AnyFrame& frame) {
  Raw raw{};
  raw.can_id = raw_id(frame.id);
  raw.len = frame.length;
  std::copy_n(frame.data.begin(), frame.length, std::begin(raw.data));
  return raw;
}
can_frame to_kernel(const Frame& frame) {
  auto raw = begin_raw<can_frame>(frame);
  if (frame.is_remote) raw.can_id |= CAN_RTR_FLAG;
  return raw;
}
canfd_frame to_kernel(const FdFrame& frame) {
  auto raw = begin_raw<canfd_frame>(frame);
  if (!frame.is_classic && frame.has_fast_data) raw.flags = CANFD_BRS;
  return raw;
}

template <class AnyFrame, class Raw>
AnyFrame begin_frame(const Raw& raw) {
  AnyFrame frame;
  const bool is_extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.id = is_extended ? FrameId::extended(raw.can_id & CAN_EFF_MASK)
                         : FrameId::standard(raw.can_id & CAN_SFF_MASK);
  frame.length = raw.len;
  // The kernel does not promise what stands in the bytes that do not count.
  std::copy_n(std::begin(raw.data), raw.len, frame.data.begin());
  return frame;
}
/// Nothing where the size or the length is not that of a frame.
std::optional<Frame> from_kernel(const can_frame& raw, std::size_t size) {
  if (size != CAN_MTU || raw.len > CAN_MAX_DLEN) return {};
  auto frame = begin_frame<Frame>(raw);
  frame.is_remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  return frame;
}
std::optional<FdFrame> from_kernel(const canfd_frame& raw, std::size_t size) {
  const bool is_classic = size == CAN_MTU;
  if ((!is_classic && size != CANFD_MTU) || !is_fd_length(raw.len)) return {};
  if (is_classic && raw.len > CAN_MAX_DLEN) return {};
  auto frame = begin_frame<FdFrame>(raw);
  frame.is_classic = is_classic;
  frame.has_fast_data = !is_classic && (raw.flags & CANFD_BRS) != 0;
  return frame;
}

ifreq request_for(const std::string& interface) {
  ifreq request{};
  interface.copy(std::begin(request.ifr_name), IFNAMSIZ - 1);
  return request;
}

std::string reason_of(int error) {
  return std::strerror(error);
}

std::optional<Refusal> refuse_interface(int socket, const std::string& interface, bool needs_fd) {
  ifreq request = request_for(interface);
  if (interface.empty() || interface.size() >= IFNAMSIZ || ::ioctl(socket, SIOCGIFINDEX, &request) != 0) {
    return Refusal{.what = "there is no interface " + interface,
                   .remedy = "plug the adapter in, or look at the names with: ip link"};
  }
  request = request_for(interface);
  if (::ioctl(socket, SIOCGIFHWADDR, &request) != 0 || request.ifr_hwaddr.sa_family != ARPHRD_CAN) {
    return Refusal{.what = interface + " is not a CAN interface",
                   .remedy = "look at the names with: ip link"};
  }
  request = request_for(interface);
  if (::ioctl(socket, SIOCGIFMTU, &request) != 0 ||
      (request.ifr_mtu != CAN_MTU && request.ifr_mtu != CANFD_MTU)) {
    return Refusal{.what = interface + " does not carry classic CAN frames",
                   .remedy = "ip link set " + interface + " down mtu 16"};
  }
  if (needs_fd && request.ifr_mtu != CANFD_MTU) {
    return Refusal{
        .what = interface + " does not carry CAN FD frames",
        .remedy = "ip link set " + interface + " down; ip link set " + interface +
                  " up type can bitrate BITRATE dbitrate DATA_BITRATE fd on (a virtual one: ip link "
                  "set " +
                  interface + " mtu 72; ip link set " + interface + " up)"};
  }
  request = request_for(interface);
  if (::ioctl(socket, SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0) {
    return Refusal{
        .what = interface + " is down",
        .remedy = "ip link set " + interface + " up type can bitrate BITRATE (a virtual one: no bitrate)"};
  }
  return std::nullopt;
}

template <class Value>
bool set_option(int socket, int level, int option, const Value& value) {
  return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

bool set_filters(int socket, std::span<const CanFilter> filters) {
  std::vector<can_filter> raw;
  for (const CanFilter& filter : filters) {
    raw.push_back({.can_id = raw_id(filter.id) | (filter.is_remote ? CAN_RTR_FLAG : 0U),
                   .can_mask = flags_and_id |
                               ((filter.id.is_extended() ? CAN_EFF_MASK : CAN_SFF_MASK) & ~filter.any_bits)});
  }
  return ::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, raw.data(),
                      static_cast<socklen_t>(raw.size() * sizeof(can_filter))) == 0;
}

/// Everything but the interface.
bool set_options(int socket, std::span<const CanFilter> filters, bool needs_fd) {
  const int on = 1;
  const int off = 0;
  const can_err_mask_t all_errors = CAN_ERR_MASK;
  return set_filters(socket, filters) && set_option(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, all_errors) &&
         (!needs_fd || set_option(socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on)) &&
         set_option(socket, SOL_CAN_RAW, CAN_RAW_LOOPBACK, on) &&  // so that candump sees what is sent
         set_option(socket, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, off) &&
         set_option(socket, SOL_SOCKET, SO_RXQ_OVFL, on) &&
         set_option(socket, SOL_SOCKET, SO_PRIORITY, frame_priority);
}

}  // namespace

template <class Frame>
CanSocket<Frame>::CanSocket() {
  for (std::size_t i = 0; i < max_frames; ++i) {
    out_parts_[i] = {.iov_base = &out_frames_[i], .iov_len = sizeof(Raw)};
    out_headers_[i].msg_hdr.msg_iov = &out_parts_[i];
    out_headers_[i].msg_hdr.msg_iovlen = 1;
    in_parts_[i] = {.iov_base = &in_frames_[i], .iov_len = sizeof(Raw) + sizeof(InBytes::beyond)};
    in_headers_[i].msg_hdr.msg_iov = &in_parts_[i];
    in_headers_[i].msg_hdr.msg_iovlen = 1;
    in_headers_[i].msg_hdr.msg_control = in_drops_[i].bytes.data();
  }
}

template <class Frame>
CanSocket<Frame>::~CanSocket() {
  close();
}

template <class Frame>
void CanSocket<Frame>::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  link_ = LinkState::gone;
}

template <class Frame>
std::optional<Refusal> CanSocket<Frame>::open(const std::string& interface,
                                              std::span<const CanFilter> filters) {
  constexpr bool is_fd = std::is_same_v<Frame, FdFrame>;
  close();
  counters_ = {};
  drops_seen_ = 0;
  controller_ = ControllerState::active;

  const int created = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (created < 0) {
    return Refusal{.what = "this kernel gives no CAN socket: " + reason_of(errno),
                   .remedy = "modprobe can_raw"};
  }
  socket_ = created;
  std::optional<Refusal> refusal = refuse_interface(socket_, interface, is_fd);
  if (!refusal) {
    ifreq request = request_for(interface);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    // Filters before the interface: nothing comes in that no filter has let through.
    const bool is_bound = set_options(socket_, filters, is_fd) &&
                          ::ioctl(socket_, SIOCGIFINDEX, &request) == 0 &&
                          (address.can_ifindex = request.ifr_ifindex) > 0 &&
                          ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    if (!is_bound) {
      refusal = Refusal{.what = interface + " cannot be used: " + reason_of(errno),
                        .remedy = "look at the interface with: ip -details link show " + interface};
    }
  }
  if (refusal) {
    close();
    return refusal;
  }
  link_ = LinkState::up;
  return std::nullopt;
}

template <class Frame>
void CanSocket<Frame>::note_link_error(int error, std::uint64_t& otherwise) {
  switch (error) {
    case ENETDOWN:
      if (link_ == LinkState::up) link_ = LinkState::down;
      break;
    case ENODEV:
    case ENXIO:
      link_ = LinkState::gone;
      break;
    default:
      ++otherwise;
  }
}

template <class Frame>
std::size_t CanSocket<Frame>::send(std::span<const Frame> frames) {
  if (frames.empty()) return 0;
  if (link_ != LinkState::up || frames.size() > max_frames ||
      !std::ranges::all_of(frames, [](const Frame& frame) { return can_be_sent(frame); })) {
    counters_.unsent += frames.size();
    ++counters_.failed_sends;
    return 0;
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    out_frames_[i] = to_kernel(frames[i]);
    out_parts_[i].iov_len = raw_size(frames[i]);
  }
  const int taken =
      ::sendmmsg(socket_, out_headers_.data(), static_cast<unsigned>(frames.size()), MSG_DONTWAIT);
  const int error = errno;
  const std::size_t sent = taken > 0 ? static_cast<std::size_t>(taken) : 0;
  counters_.sent += sent;
  counters_.unsent += frames.size() - sent;
  if (taken < 0 && error != ENOBUFS && error != EAGAIN) {
    note_link_error(error, counters_.failed_sends);
  } else if (sent < frames.size()) {
    // Why it stopped half-way the kernel does not say: nearly always the queue, else the next send tells.
    ++counters_.full_queue;
  }
  return sent;
}

template <class Frame>
void CanSocket<Frame>::note_error_frame(const ErrorFrame& error) {
  ++counters_.error_frames;
  if (error.is_receive_overflow || error.is_transmit_overflow) ++counters_.controller_overflows;
  if (error.is_unacknowledged) ++counters_.unacknowledged;
  if (error.is_passive) ++counters_.passives;
  if (error.is_bus_off) ++counters_.bus_offs;
  if (error.is_restarted) ++counters_.restarts;
  // One frame may say several things; the worst of them holds.
  if (error.is_bus_off) {
    controller_ = ControllerState::bus_off;
  } else if (controller_ == ControllerState::bus_off && !error.is_restarted) {
    // The controller sent this before it left the bus.
  } else if (error.is_passive) {
    controller_ = ControllerState::passive;
  } else if (error.is_warning) {
    controller_ = ControllerState::warning;
  } else if (error.is_active || error.is_restarted) {
    controller_ = ControllerState::active;
  }
}

template <class Frame>
void CanSocket<Frame>::note_drops(msghdr& header) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t drops = 0;
    std::memcpy(&drops, CMSG_DATA(part), sizeof drops);
    counters_.receive_drops += static_cast<std::uint32_t>(drops - drops_seen_);  // it goes round at 2^32
    drops_seen_ = drops;
  }
}

/// How many messages wait in in_headers_; 0 where none has come, or the link or the call has failed.
template <class Frame>
int CanSocket<Frame>::receive_batch(std::size_t room) {
  if (socket_ < 0) return 0;
  for (std::size_t i = 0; i < room; ++i) {
    in_headers_[i].msg_hdr.msg_controllen = sizeof(DropCount::bytes);
    in_headers_[i].msg_hdr.msg_flags = 0;
  }
  const int count =
      ::recvmmsg(socket_, in_headers_.data(), static_cast<unsigned>(room), MSG_DONTWAIT, nullptr);
  if (count >= 0) return count;
  if (errno != EAGAIN && errno != EINTR) note_link_error(errno, counters_.failed_receives);
  return 0;
}

template <class Frame>
std::optional<Frame> CanSocket<Frame>::take(std::size_t index) {
  const Raw& raw = in_frames_[index].frame;
  note_drops(in_headers_[index].msg_hdr);
  const std::optional<Frame> frame = from_kernel(raw, in_headers_[index].msg_len);
  if (!frame) {
    ++counters_.malformed;
    return std::nullopt;
  }
  if ((raw.can_id & CAN_ERR_FLAG) == 0) return frame;
  std::array<std::uint8_t, CAN_MAX_DLEN> data{};
  std::copy_n(std::begin(raw.data), data.size(), data.begin());
  note_error_frame(decode_error_frame(raw.can_id, data));
  return std::nullopt;
}

template <class Frame>
std::size_t CanSocket<Frame>::receive(std::span<Frame> frames) {
  const std::size_t room = std::min(frames.size(), max_frames);
  const int count = room > 0 ? receive_batch(room) : 0;
  std::size_t given = 0;
  for (int i = 0; i < count; ++i) {
    if (const std::optional<Frame> frame = take(static_cast<std::size_t>(i))) frames[given++] = *frame;
  }
  counters_.received += given;
  return given;
}

template <class Frame>
auto CanSocket<Frame>::drain() -> Drained {
  Drained drained;
  for (std::size_t thrown_away = 0; thrown_away < max_drained; thrown_away += max_frames) {
    const LinkState before = link_;
    const int count = receive_batch(max_frames);
    for (int i = 0; i < count; ++i) {
      if (take(static_cast<std::size_t>(i))) ++drained.stale;
    }
    // The call that tells of the link tells nothing of the queue.
    if (count == 0 && link_ == before) {
      drained.is_empty = true;
      break;
    }
  }
  counters_.stale += drained.stale;
  return drained;
}

template class CanSocket<Frame>;
template class CanSocket<FdFrame>;

}  // namespace inbetween::can
