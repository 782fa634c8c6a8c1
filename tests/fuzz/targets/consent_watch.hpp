#pragma once

#include <array>
#include <variant>

#include "host_tools/dragonframe/rig_port.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween::dragonframe {

/// A rig that holds its port to what it promises: nothing moves without consent, no motor is one that is not
/// there, and none is sent beyond the limits that the host itself has set.
struct ConsentWatch {
  std::uint8_t motors = 4;
  bool is_armed = false;
  std::array<MotorSettings, max_motors> settings{};

  void require_motor(std::uint8_t motor) const {
    fuzz_require(motor >= 1 && motor <= motors, "a motor that is there");
  }
  void require_place(std::uint8_t motor, std::int64_t position) const {
    require_motor(motor);
    fuzz_require(is_armed, "a motion with consent");
    const MotorSettings& limits = settings.at(motor - 1U);
    fuzz_require(!limits.upper || position <= *limits.upper, "a motion below the upper limit");
    fuzz_require(!limits.lower || position >= *limits.lower, "a motion above the lower limit");
  }

  void judge(const SetMotor& order) {
    require_motor(order.motor);
    settings.at(order.motor - 1U) = order.settings;
  }
  void judge(const PlaceMotor& order) const { require_motor(order.motor); }
  void judge(const StopMotor& order) const { require_motor(order.motor); }
  void judge(const MoveMotor& order) const { require_place(order.motor, order.target); }
  void judge(const JogMotor& order) const {
    require_motor(order.motor);
    fuzz_require(is_armed, "a jog with consent");
  }
  void judge(const GoToFrame& /*order*/) const { fuzz_require(is_armed, "a frame with consent"); }
  void judge(const JogAll& /*order*/) const { fuzz_require(is_armed, "a jog of all with consent"); }
  void judge(const Go& /*order*/) const { fuzz_require(is_armed, "a beginning with consent"); }
  void judge(const PrepareRun& order) const {
    for (std::uint8_t motor = 1; motor <= motors; ++motor) {
      if ((order.motors & mask_of(motor)) == 0) continue;
      require_place(motor, order.preroll.at(motor - 1U));
      require_place(motor, order.postroll.at(motor - 1U));
    }
  }
  void judge(const PrepareShot& order) const {
    fuzz_require(is_armed, "a shot with consent");
    for (const ShotMotor& motor : order.motors) require_place(motor.motor, motor.start);
  }
  void judge(const ForgetHost& /*order*/) { settings = {}; }
  template <class Other>
  void judge(const Other& /*order*/) const {}

  RigAnswer take(const RigOrder& order) {
    std::visit([&](const auto& what) { judge(what); }, order);
    return RigAnswer::ok;
  }
};

}  // namespace inbetween::dragonframe
