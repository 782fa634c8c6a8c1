#include "inbetween/can/cia402_bus.hpp"

#include <algorithm>

#include "inbetween/can/bus_tick.hpp"

namespace inbetween::can {
namespace {

bool is_from(const Cia402Drive& drive, FrameId id) {
  const NodeId node = drive.node();
  return id == tpdo1_id(node) || id == heartbeat_id(node) || id == emergency_id(node) ||
         id == sdo_answer_id(node);
}

bool is_to(const Cia402Drive& drive, FrameId id) {
  return id == rpdo_id(drive.node(), drive.rpdo()) || id == sdo_request_id(drive.node());
}

}  // namespace

Result<Cia402Bus> Cia402Bus::make(std::span<Cia402Drive> drives, const Settings& settings) {
  if (drives.empty()) {
    return Error{.code = ErrorCode::wrong_count, .what = "a bus has no drive", .remedy = "give it one"};
  }
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const auto axis = static_cast<std::int32_t>(i);
    const std::int64_t timeout_ns = drives[i].host_timeout_ns();
    if (drives[i].host() != settings.host || drives[i].sync_overflow() != settings.sync_overflow ||
        timeout_ns < 3 * settings.heartbeat_period_ns) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "a drive expects another host, SYNC counter or heartbeat than its bus has",
                   .remedy = "set both up alike, with three heartbeats in the drive's timeout",
                   .axis = axis};
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (drives[j].node() != drives[i].node()) continue;
      return Error{.code = ErrorCode::no_solution,
                   .what = "two drives of a bus have the same node",
                   .remedy = "give each drive its own number",
                   .axis = axis};
    }
  }
  const Result<SyncProducer> sync = SyncProducer::make(settings.sync_overflow);
  if (!sync) return sync.error();
  const Result<HeartbeatProducer> heartbeat =
      HeartbeatProducer::make(settings.host, settings.heartbeat_period_ns);
  if (!heartbeat) return heartbeat.error();
  return Cia402Bus(drives, *sync, *heartbeat, settings.host);
}

void Cia402Bus::receive(const Frame& frame, std::int64_t now_ns) {
  if (!is_canopen(frame)) return;
  const bool is_to_all = frame.id == nmt_id || frame.id == sync_id || frame.id == heartbeat_id(host_);
  for (Cia402Drive& drive : drives_) {
    if (is_to_all || is_to(drive, frame.id)) {
      drive.note_foreign_frame();
    } else if (is_from(drive, frame.id)) {
      drive.receive(frame, now_ns);
    }
  }
}

/// When setpoints cease, the frames that feed the watchdogs of drives cease too. SYNC goes on: by it some
/// drives measure how long they have had no setpoint.
bool Cia402Bus::wants_heartbeat(std::span<const std::int32_t> targets) const {
  const bool has_ceased = targets.empty() && std::ranges::any_of(drives_, &Cia402Drive::is_commanded);
  return !has_ceased && std::ranges::any_of(drives_, &Cia402Drive::is_in_use);
}

std::optional<Frame> Cia402Bus::next_service(std::int64_t now_ns) {
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    Cia402Drive& drive = drives_[next_served_];
    next_served_ = next_served_ + 1 < drives_.size() ? next_served_ + 1 : 0;
    if (!drive.wants_service()) continue;
    if (const std::optional<Frame> frame = drive.service(now_ns)) return frame;
  }
  return {};
}

Result<std::size_t> Cia402Bus::tick(std::int64_t now_ns, std::span<const std::int32_t> targets,
                                    std::span<Frame> frames) {
  const Status is_possible = check_tick({.drives = drives_.size(),
                                         .targets = targets.size(),
                                         .room = frames.size(),
                                         .frames = frames_per_tick(drives_.size())});
  if (!is_possible) return is_possible.error();
  std::size_t count = 0;
  const auto send = [&](const std::optional<Frame>& frame) {
    if (frame) frames[count++] = *frame;
  };
  for (Cia402Drive& drive : drives_) drive.tick(now_ns);
  if (std::ranges::any_of(drives_, &Cia402Drive::needs_sync)) send(sync_.next());
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    send(drives_[i].command(targets.empty() ? std::optional<std::int32_t>{} : targets[i]));
  }
  if (const auto heartbeat =
          wants_heartbeat(targets) ? heartbeat_.poll(now_ns, NmtState::operational) : std::nullopt) {
    send(heartbeat);
    for (Cia402Drive& drive : drives_) send(drive.note_host_heartbeat());
  }
  send(next_service(now_ns));
  return count;
}

}  // namespace inbetween::can
