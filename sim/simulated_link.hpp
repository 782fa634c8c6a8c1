#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/can_bus.hpp"

namespace inbetween {

/// The host's interface to a simulated bus (can::FrameLink), with what can happen to one.
template <class Frame>
class SimulatedLinkTo {
 public:
  /// The bus stays the caller's.
  explicit SimulatedLinkTo(SimulatedBus<Frame>& bus) : bus_(&bus) {}

  [[nodiscard]] bool is_up() const { return is_up_; }
  /// Brings the bus to `now_ns`. What is not taken waits.
  std::size_t receive(std::span<Frame> in, std::int64_t now_ns) {
    const std::vector<Frame>& heard = bus_->run(now_ns);
    if (is_up_) waiting_.insert(waiting_.end(), heard.begin(), heard.end());
    const std::size_t count = std::min(in.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, in.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  std::size_t send(std::span<const Frame> out) {
    if (!is_up_) return 0;
    const std::size_t count = std::min(out.size(), room_);
    for (const Frame& frame : out.first(count)) bus_->send(frame);
    return count;
  }
  std::size_t drain() {
    const std::size_t stale = waiting_.size();
    waiting_.clear();
    return stale;
  }

  /// The link goes down or is unplugged, or comes back.
  void set_up(bool is_up) { is_up_ = is_up; }
  /// How many frames the interface takes in a send: fewer where its queue is full.
  void set_room(std::size_t frames) { room_ = frames; }
  /// Frames that were there before.
  void put_stale(const Frame& frame) { waiting_.push_back(frame); }

 private:
  SimulatedBus<Frame>* bus_;
  std::vector<Frame> waiting_;
  std::size_t room_ = SIZE_MAX;
  bool is_up_ = true;
};
using SimulatedLink = SimulatedLinkTo<can::Frame>;

}  // namespace inbetween
