// Any frames at any time, to an RMD and a CubeMars motor that the operator uses in any way: whatever arrives,
// what is sent is well formed, no motor gets a position before it is to be switched on or without a velocity
// limit, and once targets have ceased none gets one again.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/can/cubemars.hpp"
#include "inbetween/can/rmd.hpp"
#include "inbetween/can/servo_bus.hpp"
#include "tests/fuzz/targets/drive_commands.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"
#include "tests/fuzz/targets/servo_bus_under_test.hpp"

namespace inbetween::can {
namespace {

constexpr std::int64_t ms = 1'000'000;
const RmdMotor rmd_motor = RmdMotor::make(3).value();
const CubemarsMotor cubemars_motor = CubemarsMotor::make(3).value();

struct RmdUnderTest {
  using Protocol = Rmd;
  static Rmd make() {
    return Rmd::make({.motor = rmd_motor, .max_deg_per_s = 100, .hold_deg_per_s = 5}).value();
  }
  static std::uint32_t id(std::uint8_t which) {
    constexpr std::array<std::uint32_t, 4> ids{0x243, 0x143, 0x280, 0x403};
    return ids.at(which % ids.size());
  }
  static constexpr bool is_extended = false;
  static Frame sensible(std::uint8_t what) {
    switch (what & 7U) {
      case 0:
      case 1:
        return rmd_angle_frame(rmd_motor, what);
      case 2:
        return rmd_status_frame(rmd_motor, {.errors = what > 250 ? std::uint16_t{2} : std::uint16_t{0}});
      case 3:
        return rmd_motion_frame(rmd_motor, {});
      default: {
        constexpr std::array answered{RmdCommand::shut_down, RmdCommand::stop, RmdCommand::read_acceleration,
                                      RmdCommand::host_timeout};
        Frame frame = rmd_command_frame(rmd_motor, answered.at(what & 3U));
        frame.id = rmd_answer_id(rmd_motor);
        if ((what & 3U) == 3) frame.data[4] = 100;
        return frame;
      }
    }
  }
  /// Its velocity limit, if it is a position.
  static std::optional<int> limit_in(const Frame& frame) {
    fuzz_require(frame.length == 8 && frame.id == rmd_command_id(rmd_motor), "for it");
    const auto position = read_rmd_position(frame, rmd_motor);
    return position ? std::optional<int>(position->max_deg_per_s) : std::nullopt;
  }
};

struct CubemarsUnderTest {
  using Protocol = Cubemars;
  static Cubemars make() {
    return Cubemars::make({.motor = cubemars_motor,
                           .scale = {.electric_turns_per_turn = 189},
                           .max_velocity = 100,
                           .hold_velocity = 5,
                           .max_acceleration = 100})
        .value();
  }
  static std::uint32_t id(std::uint8_t which) { return (which % 2 == 0 ? 0x2900U : which % 16 * 0x100U) + 3; }
  static constexpr bool is_extended = true;
  static Frame sensible(std::uint8_t what) {
    return cubemars_feedback_frame(cubemars_motor,
                                   {.decidegrees = static_cast<std::int16_t>(what & 3U),
                                    .centiamperes = static_cast<std::int16_t>((what & 4U) * 20),
                                    .error = what > 250 ? std::uint8_t{5} : std::uint8_t{0}});
  }
  static std::optional<int> limit_in(const Frame& frame) {
    fuzz_require(frame.id.is_extended() && (frame.id.number() & 0xFFU) == cubemars_motor.value(), "for it");
    const auto position = read_cubemars_position(frame, cubemars_motor);
    // A speed gives power as a position does, and 0 is the only one.
    if (read_cubemars_speed(frame, cubemars_motor) == 0) return 1;
    fuzz_require(position || read_cubemars_current(frame, cubemars_motor) == 0, "a position, or no current");
    return position ? std::optional<int>(position->max_velocity) : std::nullopt;
  }
};

template <class Motor>
class BusUnderTest {
 public:
  using Drive = ServoDrive<typename Motor::Protocol>;
  using Bus = ServoBus<typename Motor::Protocol>;

  void run(Bytes bytes) {
    while (!bytes.empty()) {
      switch (bytes.next() % 8) {
        case 0:
          bus_.receive(any_frame(bytes), now_);
          break;
        case 1:
          command(bytes.next());
          break;
        case 2:
        case 3:
          bus_.receive(Motor::sensible(bytes.next()), now_);
          break;
        default:
          tick(bytes.next());
      }
    }
  }

 private:
  static Frame any_frame(Bytes& bytes) {
    const std::uint8_t kind = bytes.next();
    const bool is_extended = Motor::is_extended != ((kind & 0x20) != 0);
    const std::uint32_t number = Motor::id(kind);
    Frame frame{.id = is_extended ? FrameId::extended(number) : FrameId::standard(number & 0x7FF)};
    frame.is_remote = (kind & 0x40) != 0;
    frame.length = (kind & 0x10) != 0 ? 7 : 8;
    for (std::uint8_t& byte : frame.data) byte = bytes.next();
    return frame;
  }
  void command(std::uint8_t what) {
    Drive& drive = drives_.front();
    command_drive(drive, what, now_, [&] { drive.leave(now_); });
  }
  void tick(std::uint8_t how) {
    now_ += (1 + how % 16) * ms;
    const std::array<ServoTarget, 1> targets{ServoTarget{.turns = (how & 3) * 1e-4}};
    const bool has_targets = (how & 0x80) != 0;
    std::array<Frame, Bus::frames_per_tick(1)> frames;
    const bool was_commanded = drives_.front().is_commanded();
    const auto count = bus_.tick(
        now_, has_targets ? std::span<const ServoTarget>(targets) : std::span<const ServoTarget>(), frames);
    const Drive& drive = drives_.front();
    const DrivePhase phase = drive.phase();
    if (phase == DrivePhase::enabling) has_ceased_ = false;
    if (was_commanded && drive.is_commanded() && !has_targets) has_ceased_ = true;
    fuzz_require(count && *count <= frames.size(), "the frames of a tick fit");
    for (std::size_t i = 0; i < *count; ++i) {
      const std::optional<int> limit = Motor::limit_in(frames.at(i));
      if (!limit) continue;
      fuzz_require(*limit > 0 && *limit <= 100, "a velocity limit");
      const bool is_held = phase == DrivePhase::disabling && drive.status().is_on;  // until it rests
      const bool may_have_power = phase == DrivePhase::enabling || phase == DrivePhase::following ||
                                  phase == DrivePhase::stopping || is_held;
      fuzz_require(may_have_power, "a position switches a motor on that shall be off");
      fuzz_require(!(phase == DrivePhase::following && has_ceased_), "targets have ceased");
    }
  }

  std::vector<Drive> drives_{Drive::make(Motor::make(), fuzzed_servo).value()};
  Bus bus_ = Bus::make(drives_).value();
  bool has_ceased_ = false;  ///< since it was switched on
  std::int64_t now_ = 1;
};

}  // namespace
}  // namespace inbetween::can

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace inbetween::can;
  BusUnderTest<RmdUnderTest>().run(Bytes({data, size}));
  BusUnderTest<CubemarsUnderTest>().run(Bytes({data, size}));
  return 0;
}
