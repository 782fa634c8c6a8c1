#include "sim/can_bus.hpp"

#include <algorithm>
#include <cstddef>

namespace inbetween {

template <class Frame>
void SimulatedBus<Frame>::post(const Waiting& sent, std::int64_t now_ns) {
  if (!fate_) return wire_.push_back(sent);
  const FrameFate fate = fate_(sent.frame, now_ns);
  for (int i = 0; i < fate.copies; ++i) {
    wire_.push_back({.frame = sent.frame, .sender = sent.sender, .due_ns = now_ns + fate.delay_ns});
  }
}

template <class Frame>
void SimulatedBus<Frame>::collect(std::size_t drive, std::int64_t now_ns) {
  drives_[drive]->hand_frames(
      [&](const Frame& frame) { post({.frame = frame, .sender = static_cast<int>(drive)}, now_ns); });
}

/// The first of those with the lowest identifier: one sender's frames stay in order. False where none is due.
template <class Frame>
bool SimulatedBus<Frame>::deliver_next(std::int64_t now_ns) {
  auto next = wire_.end();
  for (auto it = wire_.begin(); it != wire_.end(); ++it) {
    if (it->due_ns > now_ns) continue;
    if (next == wire_.end() || it->frame.id.number() < next->frame.id.number()) next = it;
  }
  if (next == wire_.end()) return false;
  const Waiting delivered = *next;
  wire_.erase(next);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (delivered.sender == static_cast<int>(i)) continue;
    drives_[i]->receive(delivered.frame);
    collect(i, now_ns);
  }
  if (delivered.sender != host) heard_.push_back(delivered.frame);
  return true;
}

template <class Frame>
const std::vector<Frame>& SimulatedBus<Frame>::run(std::int64_t now_ns) {
  for (SimulatedDriveOn<Frame>* drive : drives_) drive->advance(now_ns);
  for (const Waiting& sent : outbox_) post(sent, now_ns);
  outbox_.clear();
  for (std::size_t i = 0; i < drives_.size(); ++i) collect(i, now_ns);
  heard_.clear();
  while (deliver_next(now_ns)) {
  }
  return heard_;
}

template class SimulatedBus<can::Frame>;
template class SimulatedBus<can::FdFrame>;

}  // namespace inbetween
