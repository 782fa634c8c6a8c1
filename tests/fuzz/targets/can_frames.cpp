// Any frames at any time, to a bus with two drives that the operator uses in any way: whatever arrives, what
// is sent is well formed and in order, and no drive is told to follow anything but its own position or the
// target that was given.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/can/cia402_bus.hpp"
#include "inbetween/can/emergency.hpp"
#include "inbetween/can/sdo.hpp"
#include "inbetween/can/sync.hpp"
#include "tests/fuzz/targets/drive_commands.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"
#include "tests/support/drive_frames.hpp"

namespace inbetween::can {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::array<std::uint8_t, 2> nodes{5, 3};

NodeId node_of(std::size_t axis) {
  return NodeId::make(nodes.at(axis)).value();
}
std::vector<Cia402Drive> make_drives() {
  std::vector<Cia402Drive> drives;
  for (std::size_t axis = 0; axis < nodes.size(); ++axis) {
    drives.push_back(Cia402Drive::make({.setup = {.node = node_of(axis), .host = NodeId::make(127).value()},
                                        .max_step_counts = 1000,
                                        .boot_timeout_ns = 200 * ms,
                                        .sdo_timeout_ns = 40 * ms,
                                        .enable_timeout_ns = 100 * ms})
                         .value());
  }
  return drives;
}

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
          answer_request(bytes);
          break;
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
    constexpr std::array<std::uint32_t, 10> ids{0x000, 0x080, 0x085, 0x185, 0x205,
                                                0x585, 0x605, 0x705, 0x77F, 0x7E4};
    std::uint32_t number = ids.at(bytes.next() % ids.size());
    const std::uint8_t kind = bytes.next();
    if ((kind & 0x80) != 0) number += 0x1FFFFE & (std::uint32_t{bytes.next()} << 3);
    const bool is_extended = (kind & 0x20) != 0;
    Frame frame{.id = is_extended ? FrameId::extended(number) : FrameId::standard(number & 0x7FF)};
    frame.is_remote = (kind & 0x40) != 0;
    frame.length = kind & 0x1F;
    for (std::uint8_t& byte : frame.data) byte = bytes.next();
    return frame;
  }
  void deliver(const Frame& frame) {
    read_and_write_again(frame);
    bus_.receive(frame, now_);
  }
  /// What has been understood means the same when it is written again.
  static void read_and_write_again(const Frame& frame) {
    if (const auto order = read_nmt(frame)) fuzz_require(nmt_frame(*order) == shorten(frame), "NMT");
    if (const auto mark = read_sync(frame)) fuzz_require(frame.length == (mark->counter ? 1 : 0), "SYNC");
    if (const auto request = read_sdo_request(frame)) {
      fuzz_require(read_sdo_request(sdo_frame(frame.id, *request)) == request, "a request");
    }
    if (const auto answer = read_sdo_answer(frame)) {
      fuzz_require(read_sdo_answer(sdo_frame(frame.id, *answer)) == answer, "an answer");
    }
    if (const auto emergency = read_emergency(frame, node_of(0))) {
      fuzz_require(emergency_frame(node_of(0), *emergency) == frame, "EMCY");
    }
    if (const auto feedback = read_feedback(frame, node_of(0))) {
      fuzz_require(feedback_frame(node_of(0), *feedback) == shorten(frame), "feedback");
    }
    if (const auto command = read_command(frame, node_of(0))) {
      fuzz_require(command_frame(node_of(0), *command) == shorten(frame), "a command");
    }
  }
  static Frame shorten(Frame frame) {
    for (std::size_t i = frame.length; i < frame.data.size(); ++i) frame.data.at(i) = 0;
    return frame;
  }

  void command(std::uint8_t what) {
    Cia402Drive& drive = drives_.at(what & 1);
    command_drive(drive, static_cast<std::uint8_t>(what >> 1), now_, [&] { drive.disconnect(now_); });
  }
  /// The drive answers its last request as it should, or with a value of its own.
  void answer_request(Bytes& bytes) {
    const std::uint8_t how = bytes.next();
    if (!request_ || (request_->id != 0x605 && request_->id != 0x603)) return;
    const auto request = read_sdo_request(*request_);
    if (!request) return;
    SdoMessage answer{.object = request->object};
    if (request->kind == SdoKind::download) {
      written_ = request->value;
      answer.kind = SdoKind::download_done;
    } else if (request->kind == SdoKind::upload) {
      answer.kind = SdoKind::upload_value;
      answer.value = how < 0xF0 ? expected(request->object, how) : how;
    } else {
      return;
    }
    deliver(sdo_frame(FrameId::standard(request_->id.number() - 0x80), answer));
  }
  [[nodiscard]] std::uint32_t expected(ObjectAddress object, std::uint8_t how) const {
    if (object.index == 0x1000) return 402;
    if (object.index == 0x1005) return 0x80;
    if (object.index == 0x6502) return 0x80;
    if (object.index == 0x6065 && how < 0x80) return 2000;
    return written_;
  }
  /// What a drive tells every now and then, most of it sensible.
  void tell(std::uint8_t what) {
    constexpr std::array<std::uint16_t, 8> words{0x0250, 0x0231, 0x0233, 0x0237,
                                                 0x1237, 0x0217, 0x0218, 0x3A37};
    const NodeId node = node_of(what & 1);
    if ((what & 2) != 0) {
      constexpr std::array<NmtState, 4> states{NmtState::operational, NmtState::pre_operational,
                                               NmtState::boot_up, NmtState::stopped};
      deliver(heartbeat_frame(node, states.at((what >> 2) & 3)));
    } else {
      const auto mode = static_cast<std::int8_t>((what & 0x40) != 0 ? 1 : 8);
      deliver(feedback_frame(node, {.statusword = words.at((what >> 3) & 7), .actual = what, .mode = mode}));
    }
  }

  void tick(std::uint8_t how) {
    now_ += (1 + how % 16) * ms;
    const std::array<std::int32_t, 2> targets{how, how / 2};
    const bool has_targets = (how & 0x80) != 0;
    const std::array<std::int32_t, 2> before{drives_[0].target(), drives_[1].target()};
    std::array<Frame, Cia402Bus::frames_per_tick(2)> frames;
    const auto count = bus_.tick(
        now_, has_targets ? std::span<const std::int32_t>(targets) : std::span<const std::int32_t>(), frames);
    fuzz_require(count && *count <= frames.size(), "the frames of a tick fit");
    request_.reset();
    for (std::size_t i = 0; i < *count; ++i) {
      const Frame& frame = frames.at(i);
      fuzz_require(is_canopen(frame), "a frame of CANopen");
      fuzz_require(frame.id != sync_id || i == 0, "SYNC is first");
      if (frame.id == 0x605 || frame.id == 0x603) request_ = frame;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const auto command = read_command(frame, node_of(axis));
        if (!command) continue;
        const Cia402Drive& drive = drives_.at(axis);
        const bool is_its_own =
            command->target == drive.feedback().actual || command->target == before.at(axis);
        const bool is_given = has_targets && command->target == targets.at(axis);
        const bool follows = drive.phase() == DrivePhase::following;
        fuzz_require(is_its_own || (is_given && follows), "a target out of nowhere");
        fuzz_require(command->controlword != control_enable_operation || follows ||
                         drive.phase() == DrivePhase::enabling,
                     "switched on unasked");
      }
    }
  }

  std::vector<Cia402Drive> drives_ = make_drives();
  Cia402Bus bus_ = Cia402Bus::make(drives_, {.host = NodeId::make(127).value()}).value();
  std::int64_t now_ = 0;
  std::uint32_t written_ = 0;
  std::optional<Frame> request_;
};

}  // namespace
}  // namespace inbetween::can

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  inbetween::can::Bytes bytes({data, size});
  inbetween::can::BusUnderTest().run(bytes);
  return 0;
}
