// Any frames at any time, to a bus with two ODrives that the operator uses in any way: whatever arrives, what
// is sent is well formed, no drive is told to go anywhere but where it is or where it was told before, and
// without targets nothing is sent to a drive that has followed some.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/can/odrive.hpp"
#include "inbetween/can/servo_bus.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween::can {
namespace {

using Drive = ServoDrive<Odrive>;
constexpr std::int64_t ms = 1'000'000;
constexpr std::array families{OdriveFamily::firmware_06, OdriveFamily::firmware_05};

OdriveNode node_of(std::size_t axis) {
  return OdriveNode::make(static_cast<std::int64_t>(axis) + 3).value();
}
std::vector<Drive> make_drives() {
  const ServoSettings settings{.max_step_turns = 1,
                               .max_turns_per_s = 30,
                               .hold_tolerance_turns = 0.5,
                               .first_step_turns = 0.5,
                               .max_following_error_turns = 2,
                               .rest_turns = 0.1,
                               .boot_timeout_ns = 400 * ms,
                               .enable_timeout_ns = 400 * ms};
  std::vector<Drive> drives;
  for (std::size_t axis = 0; axis < families.size(); ++axis) {
    drives.push_back(Drive::make({node_of(axis), families.at(axis)}, settings).value());
  }
  return drives;
}

class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  std::uint8_t next() {
    if (bytes_.empty()) return 0;
    const std::uint8_t byte = bytes_[0];
    bytes_ = bytes_.subspan(1);
    return byte;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

class BusUnderTest {
 public:
  void run(Bytes& bytes) {
    while (!bytes.empty()) {
      switch (bytes.next() % 8) {
        case 0:
          deliver(any_frame(bytes));
          break;
        case 1:
          command(bytes.next());
          break;
        case 2:
        case 3:
          tell(bytes.next());
          break;
        default:
          tick(bytes.next());
      }
    }
  }

 private:
  static Frame any_frame(Bytes& bytes) {
    const std::uint8_t kind = bytes.next();
    Frame frame{.id = (3U + (kind & 1U)) << 5 | (bytes.next() & odrive_message_bits)};
    frame.is_remote = (kind & 0x40) != 0;
    frame.is_extended = (kind & 0x20) != 0;
    frame.length = (kind & 0x10) != 0 ? 7 : 8;
    for (std::uint8_t& byte : frame.data) byte = bytes.next();
    return frame;
  }
  void deliver(const Frame& frame) { bus_.receive(frame, now_); }

  void command(std::uint8_t what) {
    Drive& drive = drives_.at(what & 1);
    switch ((what >> 1) % 6) {
      case 0:
        drive.connect(now_);
        break;
      case 1:
        fuzz_require(!drive.enable(now_) || drive.findings().empty(), "enabled over findings");
        break;
      case 2:
        drive.disable(now_);
        break;
      case 3:
        drive.quick_stop(now_);
        break;
      case 4:
        drive.acknowledge();
        break;
      default:
        drive.leave(now_);
    }
  }
  /// What a drive tells every now and then, most of it sensible.
  void tell(std::uint8_t what) {
    const std::size_t axis = what & 1;
    switch ((what >> 1) & 3) {
      case 0:
        return deliver(odrive_version_frame(node_of(axis), {.firmware = {0, 6, what}}));
      case 1:
        return deliver(odrive_estimates_frame(node_of(axis), static_cast<float>(what >> 5) * 0.125F, 0));
      default: {
        const bool has_missed = (what & 0x10) != 0;
        const std::uint8_t state = (what & 0x08) != 0 ? odrive_closed_loop : odrive_idle;
        const std::uint32_t errors = has_missed ? odrive_watchdog_error(families.at(axis)) : 0;
        deliver(odrive_heartbeat_frame(node_of(axis), families.at(axis), {.errors = errors, .state = state}));
      }
    }
  }

  void tick(std::uint8_t how) {
    now_ += (1 + how % 16) * ms;
    const std::array<ServoTarget, 2> targets{ServoTarget{.turns = how * 0.01},
                                             ServoTarget{.turns = how * 0.02}};
    const bool has_targets = (how & 0x80) != 0;
    std::array<bool, 2> has_followed{};
    for (std::size_t axis = 0; axis < 2; ++axis) has_followed.at(axis) = drives_[axis].is_commanded();
    std::array<Frame, ServoBus<Odrive>::frames_per_tick(2)> frames;
    const auto count = bus_.tick(
        now_, has_targets ? std::span<const ServoTarget>(targets) : std::span<const ServoTarget>(), frames);
    fuzz_require(count && *count <= frames.size(), "the frames of a tick fit");
    for (std::size_t i = 0; i < *count; ++i) {
      const Frame& frame = frames.at(i);
      const std::size_t axis = (frame.id >> 5) - 3;
      fuzz_require(axis < 2 && frame.length <= 8 && !frame.is_extended, "a frame for a drive of the bus");
      const Drive& drive = drives_.at(axis);
      const bool is_silent = !has_targets && has_followed.at(axis) && drive.is_commanded();
      fuzz_require(!is_silent, "a drive was fed without targets");
      const auto position = read_odrive_position(frame, node_of(axis));
      if (!position) continue;
      const double turns = static_cast<double>(position->turns);
      const bool is_its_own = turns == static_cast<double>(static_cast<float>(drive.place().turns));
      fuzz_require(is_its_own || is_known(axis, turns), "a target out of nowhere");
      if (drive.phase() == DrivePhase::following || is_its_own) told_.at(axis).push_back(turns);
    }
    if (has_targets) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        told_.at(axis).push_back(static_cast<double>(static_cast<float>(targets.at(axis).turns)));
      }
    }
  }
  [[nodiscard]] bool is_known(std::size_t axis, double turns) const {
    for (const double known : told_.at(axis)) {
      if (known == turns) return true;
    }
    return turns == 0;
  }

  std::vector<Drive> drives_ = make_drives();
  ServoBus<Odrive> bus_ = ServoBus<Odrive>::make(drives_).value();
  std::array<std::vector<double>, 2> told_;  ///< where each was, and where it was to go
  std::int64_t now_ = 1;
};

}  // namespace
}  // namespace inbetween::can

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  inbetween::can::Bytes bytes({data, size});
  inbetween::can::BusUnderTest().run(bytes);
  return 0;
}
