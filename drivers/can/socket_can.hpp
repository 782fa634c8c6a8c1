#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include "drivers/can/error_frame.hpp"
#include "drivers/refusal.hpp"
#include "inbetween/can/fd_frame.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/frame_id.hpp"

namespace inbetween::can {

/// The network interface. What has gone down or away stays so until it is opened again: nothing is sent
/// because a cable was put back.
enum class LinkState : std::uint8_t {
  up,
  down,  ///< switched off, or bus-off with some drivers
  gone,  ///< unplugged or deleted; only `open` helps
};

/// The controller, as far as its error frames have told. A virtual interface sends none.
enum class ControllerState : std::uint8_t { active, warning, passive, bus_off };

/// Counters since `open`. Nothing is lost without one of these growing.
struct CanCounters {
  std::uint64_t sent = 0;           ///< frames that the kernel took; whether anybody heard them is not known
  std::uint64_t unsent = 0;         ///< frames that it did not take; they are never sent later
  std::uint64_t full_queue = 0;     ///< sends that met a full queue (ENOBUFS, EAGAIN, or a part taken)
  std::uint64_t failed_sends = 0;   ///< sends that failed in another way
  std::uint64_t received = 0;       ///< frames given to the caller
  std::uint64_t stale = 0;          ///< frames thrown away by `drain`
  std::uint64_t malformed = 0;      ///< what had not the size and length of a frame; discarded
  std::uint64_t receive_drops = 0;  ///< frames that found this socket's queue full (SO_RXQ_OVFL)
  std::uint64_t failed_receives = 0;  ///< receives that failed in another way than by the link
  std::uint64_t error_frames = 0;     ///< all of them; some kinds follow
  std::uint64_t controller_overflows = 0;
  std::uint64_t unacknowledged = 0;
  std::uint64_t passives = 0;
  std::uint64_t bus_offs = 0;
  std::uint64_t restarts = 0;
};

/// Which frames come in: data frames of one identifier, or of a block of them, or remote frames.
struct CanFilter {
  FrameId id = {};
  bool is_remote = false;
  std::uint32_t any_bits = 0;  ///< these bits of the identifier may be anything
};

/// A CAN bus through SocketCAN (CAN_RAW), for a real-time loop: a classic one with Frame, one that carries
/// CAN FD with FdFrame, where classic frames may come and go too. After `open` nothing is allocated, nothing
/// waits, and `send` and `receive` are one system call each. Of one thread.
///
/// It receives what other programs on this machine send, too, but not what it sends itself.
/// Source: Linux Documentation/networking/can.rst.
template <class Frame>
class CanSocket {
 public:
  /// The most frames of one system call, to send or to receive.
  static constexpr std::size_t max_frames = 64;

  CanSocket();
  ~CanSocket();
  CanSocket(const CanSocket&) = delete;
  CanSocket& operator=(const CanSocket&) = delete;

  /// Takes an interface, which must be there, be CAN, be up, and carry such frames. What was open before
  /// is closed first; the counters begin at 0. Frames that no filter names do not come in; no filter, none
  /// does. What was on the bus before is not in the queue, but what comes from now on waits in it: see
  /// `drain`.
  [[nodiscard]] std::optional<Refusal> open(const std::string& interface, std::span<const CanFilter> filters);
  void close();
  [[nodiscard]] bool is_open() const { return socket_ >= 0; }

  /// Gives frames to the kernel, in their order, by one sendmmsg, and says how many it took: always the first
  /// ones. The others are counted and forgotten, for a setpoint that comes late is wrong. While the link is
  /// not up, and for more than `max_frames` frames, none is sent.
  std::size_t send(std::span<const Frame> frames);

  /// Takes what has come in, by one recvmmsg, and says how many frames it put at the beginning of `frames`:
  /// at most as many as fit, and at most `max_frames`. Error frames are not among them; they show in
  /// `controller` and in `counters`, and take the place of a frame in the call.
  std::size_t receive(std::span<Frame> frames);

  struct Drained {
    std::uint64_t stale = 0;  ///< frames thrown away
    bool is_empty = false;    ///< false: they came in faster than they could be thrown away
  };
  /// Throws away what waits in the queue, before setpoints of now meet answers of then. Ends after at most
  /// `max_drained` frames, whatever comes in meanwhile. Error frames count as in `receive`.
  Drained drain();
  static constexpr std::size_t max_drained = 64 * max_frames;

  /// As `send`, `receive` and `drain` have found it; asks nobody.
  [[nodiscard]] LinkState link() const { return link_; }

  [[nodiscard]] ControllerState controller() const { return controller_; }
  [[nodiscard]] const CanCounters& counters() const { return counters_; }

 private:
  /// The kernel's frame. Both begin alike, and a classic one fits into the other.
  using Raw = std::conditional_t<std::is_same_v<Frame, FdFrame>, canfd_frame, can_frame>;

  void note_link_error(int error, std::uint64_t& otherwise);
  void note_error_frame(const ErrorFrame& error);
  void note_drops(msghdr& header);
  int receive_batch(std::size_t room);
  std::optional<Frame> take(std::size_t index);

  int socket_ = -1;
  LinkState link_ = LinkState::gone;
  ControllerState controller_ = ControllerState::active;
  CanCounters counters_;
  std::uint32_t drops_seen_ = 0;

  std::array<Raw, max_frames> out_frames_{};
  std::array<iovec, max_frames> out_parts_{};
  std::array<mmsghdr, max_frames> out_headers_{};

  struct DropCount {
    alignas(cmsghdr) std::array<unsigned char, CMSG_SPACE(sizeof(std::uint32_t))> bytes{};
  };
  /// A byte more than a frame, so that a longer one shows.
  struct InBytes {
    Raw frame{};
    std::uint8_t beyond = 0;
  };
  std::array<InBytes, max_frames> in_frames_{};
  std::array<iovec, max_frames> in_parts_{};
  std::array<DropCount, max_frames> in_drops_{};
  std::array<mmsghdr, max_frames> in_headers_{};
};
using SocketCan = CanSocket<Frame>;
using SocketCanFd = CanSocket<FdFrame>;

}  // namespace inbetween::can
