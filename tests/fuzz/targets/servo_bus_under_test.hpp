// A bus with two servo drives of one protocol, which hears any frames at any time and is used in any way:
// whatever arrives, what is sent is well formed, no drive is told to go anywhere but where it is or where it
// was told before, and without targets nothing is sent that feeds a drive which has followed some.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/can/servo_bus.hpp"
#include "tests/fuzz/targets/drive_commands.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween::can {

/// How every servo drive under test may go.
inline constexpr ServoSettings fuzzed_servo{.max_step_turns = 1,
                                            .max_turns_per_s = 30,
                                            .hold_tolerance_turns = 0.5,
                                            .first_step_turns = 0.5,
                                            .max_following_error_turns = 2,
                                            .rest_turns = 0.1,
                                            .boot_timeout_ns = 400'000'000,
                                            .enable_timeout_ns = 400'000'000};

/// `Dialect` says how frames of the protocol look: a Protocol for each axis, any_frame, told (what a drive
/// says every now and then), axis_of (none: not well formed), target_of and feeds.
template <class Dialect>
class ServoBusUnderTest {
 public:
  void run(Bytes bytes) {
    while (!bytes.empty()) {
      switch (bytes.next() % 8) {
        case 0:
          deliver(Dialect::any_frame(bytes));
          break;
        case 1:
          command(bytes.next());
          break;
        case 2:
        case 3: {
          const std::uint8_t what = bytes.next();
          deliver(Dialect::told(what & 1, what));
          break;
        }
        default:
          tick(bytes.next());
      }
    }
  }

 private:
  using Protocol = typename Dialect::Protocol;
  using Frame = typename Protocol::Frame;
  using Drive = ServoDrive<Protocol>;
  static constexpr std::int64_t ms = 1'000'000;

  static std::vector<Drive> make_drives() {
    std::vector<Drive> drives;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      drives.push_back(Drive::make(Dialect::protocol(axis), fuzzed_servo).value());
    }
    return drives;
  }
  void deliver(const Frame& frame) { bus_.receive(frame, now_); }

  void command(std::uint8_t what) {
    Drive& drive = drives_.at(what & 1);
    command_drive(drive, static_cast<std::uint8_t>(what >> 1), now_, [&] { drive.leave(now_); });
  }

  void tick(std::uint8_t how) {
    now_ += (1 + how % 16) * ms;
    const std::array<ServoTarget, 2> targets{ServoTarget{.turns = how * 0.01},
                                             ServoTarget{.turns = how * 0.02}};
    const bool has_targets = (how & 0x80) != 0;
    std::array<bool, 2> has_followed{};
    for (std::size_t axis = 0; axis < 2; ++axis) has_followed.at(axis) = drives_[axis].is_commanded();
    std::array<Frame, ServoBus<Protocol>::frames_per_tick(2)> frames;
    const auto count = bus_.tick(
        now_, has_targets ? std::span<const ServoTarget>(targets) : std::span<const ServoTarget>(), frames);
    fuzz_require(count && *count <= frames.size(), "the frames of a tick fit");
    for (std::size_t i = 0; i < *count; ++i) {
      const Frame& frame = frames.at(i);
      const std::optional<std::size_t> its_axis = Dialect::axis_of(frame);
      fuzz_require(its_axis.has_value(), "a frame for a drive of the bus");
      const std::size_t axis = *its_axis;
      const Drive& drive = drives_.at(axis);
      const bool is_silent = !has_targets && has_followed.at(axis) && drive.is_commanded();
      fuzz_require(!is_silent || !Dialect::feeds(frame), "a drive was fed without targets");
      const std::optional<double> target = Dialect::target_of(frame, axis);
      if (!target) continue;
      const double turns = *target;
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
  ServoBus<Protocol> bus_ = ServoBus<Protocol>::make(drives_).value();
  std::array<std::vector<double>, 2> told_;  ///< where each was, and where it was to go
  std::int64_t now_ = 1;
};

}  // namespace inbetween::can
