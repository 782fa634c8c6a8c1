// A rig behind a port of Dragonframe's, in a virtual time of 20 ms ticks. It has no mass: a motor has its
// full speed at once, and rests at once. What it is asked for it keeps, and answers as a test wants.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "host_tools/dragonframe/rig_port.hpp"
#include "host_tools/dragonframe/uploaded_move.hpp"

namespace inbetween::dragonframe {

class PretendRig {
 public:
  static constexpr std::int64_t tick_ns = 20'000'000;

  /// What it is asked for, in order.
  std::vector<RigOrder> orders;
  /// Answers instead of `ok`, where it has one.
  std::function<RigAnswer(const RigOrder&)> judge;

  RigAnswer take(const RigOrder& order);
  /// A tick; the events that it brings.
  std::vector<RigEvent> tick();
  [[nodiscard]] const RigState& state() const { return state_; }
  void set_inputs(std::uint32_t bits) { state_.inputs = bits; }

  template <class Order>
  [[nodiscard]] std::vector<Order> taken() const {
    std::vector<Order> found;
    for (const RigOrder& order : orders) {
      if (const auto* one = std::get_if<Order>(&order)) found.push_back(*one);
    }
    return found;
  }
  /// Whether an order was given that moves a motor.
  [[nodiscard]] bool was_moved() const;

 private:
  enum class Phase : std::uint8_t {
    none,
    along,
    approach,
    to_start,
    waiting,
    preroll,
    playing,
    postroll,
    shot
  };

  void apply(const SetMotor& order) { settings_.at(order.motor - 1U) = order.settings; }
  void apply(const PlaceMotor& order) { state_.positions.at(order.motor - 1U) = order.position; }
  void apply(const MoveMotor& order);
  void apply(const JogMotor& order);
  void apply(const StopMotor& order) { targets_.at(order.motor - 1U).reset(); }
  void apply(const StopAll& order);
  void apply(const TakeMove& order) { move_ = order.move; }
  void apply(const GoToFrame& order);
  void apply(const JogAll& order);
  void apply(const PrepareRun& order);
  void apply(const PrepareShot& order);
  void apply(const Go& order);
  void apply(const StopLoop& order);
  void apply(const SetOutputs& /*order*/) {}
  void apply(const SetCamera& /*order*/) {}
  void apply(const ForgetHost& /*order*/) { move_ = nullptr; }

  void follow_targets();
  void tick_along(std::vector<RigEvent>& events);
  void tick_playing(std::vector<RigEvent>& events);
  void tick_go(std::vector<RigEvent>& events);
  void stand_at(double frame);
  void begin(Phase phase);

  RigState state_;
  std::array<MotorSettings, max_motors> settings_{};
  std::array<std::optional<std::int32_t>, max_motors> targets_{};
  std::array<double, max_motors> speeds_{};
  const UploadedMove* move_ = nullptr;
  Phase phase_ = Phase::none;
  MotorMask motors_ = 0;
  std::optional<PrepareRun> run_;
  std::optional<PrepareShot> shot_;
  double frame_ = 0;
  double frame_from_ = 0;
  double frame_to_ = 0;
  double fps_ = 24;
  double phase_s_ = 0;
  bool says_rest_ = false;
};

}  // namespace inbetween::dragonframe
