#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "inbetween/can/fd_frame.hpp"
#include "inbetween/can/frame.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {

/// The fate of a frame on a simulated bus.
struct FrameFate {
  int copies = 1;  ///< 0: lost
  std::int64_t delay_ns = 0;
};

/// A bus with simulated drives and one host, without time of its own: of all frames that wait, the one
/// with the lowest identifier is heard next, by everybody but its sender, and may be answered at once.
template <class Frame>
class SimulatedBus {
 public:
  /// The drive stays the caller's.
  void attach(SimulatedDriveOn<Frame>& drive) { drives_.push_back(&drive); }
  /// Asked once for every frame, when it is to be sent.
  void set_fate(std::function<FrameFate(const Frame&, std::int64_t now_ns)> fate) { fate_ = std::move(fate); }

  /// From the host; heard with the next run().
  void send(const Frame& frame) { outbox_.push_back({.frame = frame, .sender = host}); }
  /// From somebody who does not belong here: the host hears it, too.
  void inject(const Frame& frame) { outbox_.push_back({.frame = frame, .sender = stranger}); }
  /// The drives are advanced to `now_ns`, and everything that waits is delivered. What the host hears, in
  /// order, until the next run().
  const std::vector<Frame>& run(std::int64_t now_ns);

 private:
  static constexpr int host = -1;
  static constexpr int stranger = -2;
  struct Waiting {
    Frame frame;
    int sender = host;
    std::int64_t due_ns = 0;
  };
  void post(const Waiting& sent, std::int64_t now_ns);
  void collect(std::size_t drive, std::int64_t now_ns);
  bool deliver_next(std::int64_t now_ns);

  std::vector<SimulatedDriveOn<Frame>*> drives_;
  std::function<FrameFate(const Frame&, std::int64_t)> fate_;
  std::vector<Waiting> outbox_;
  std::vector<Waiting> wire_;
  std::vector<Frame> heard_;
};
using SimulatedCanBus = SimulatedBus<can::Frame>;
using SimulatedFdBus = SimulatedBus<can::FdFrame>;

}  // namespace inbetween
