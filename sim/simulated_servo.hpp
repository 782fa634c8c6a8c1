#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "sim/drive_trouble.hpp"
#include "sim/simulated_can_drive.hpp"
#include "sim/simulated_motor.hpp"

namespace inbetween {

/// What drives with a position controller and an incremental encoder have in common: the time, the motor in
/// units of the drive, troubles, and the record.
template <class Frame>
class SimulatedServo : public SimulatedDriveOn<Frame> {
 public:
  void advance(std::int64_t now_ns) override {
    while (now_ns_ < now_ns) advance_a_step(now_ns);
  }
  void add_trouble(const DriveTrouble& trouble) final { troubles_.add(trouble); }
  [[nodiscard]] bool has_been_moved() const final { return has_been_moved_; }
  [[nodiscard]] double position() const final { return motor_.position(); }
  [[nodiscard]] double velocity() const final { return motor_.velocity(); }
  DriveRecord take_record() final { return std::exchange(record_, {}); }

 protected:
  using Kind = DriveTrouble::Kind;
  /// The motor is integrated in steps that are short against the 30 Hz of the position controller.
  static constexpr std::int64_t step_ns = 250'000;

  /// Powered on at `now_ns`, where the motor stands at `position`.
  template <class Settings>
  SimulatedServo(const Settings& settings, double position, std::int64_t now_ns, std::int64_t boot_delay_ns)
      : motor_(settings.motor, position),
        now_ns_(now_ns),
        boot_delay_ns_(boot_delay_ns),
        boot_ns_(now_ns + boot_delay_ns),
        keeps_record_(settings.keeps_record) {}

  /// Moves for `seconds`, and does what is due at now_ns_.
  virtual void live(double seconds) = 0;
  /// As after power-on at boot_ns_: what was set is forgotten.
  virtual void start_anew() = 0;
  /// A trouble of another kind than those that are the same for all drives begins.
  virtual void meet(const DriveTrouble& trouble) = 0;

  /// At most until `now_ns`.
  void advance_a_step(std::int64_t now_ns) {
    const std::int64_t ns = std::min(step_ns, now_ns - now_ns_);
    now_ns_ += ns;
    while (const std::optional<DriveTrouble> trouble = troubles_.begin_next(now_ns_)) begin(*trouble);
    live(static_cast<double>(ns) * 1e-9);
  }
  void send(const Frame& frame) {
    if (!takes_frame(Kind::lose_sent)) this->put_frame(frame);
  }
  /// Moves for `seconds` without power.
  void coast(double seconds) {
    motor_.coast(seconds);
    if (!has_trouble(Kind::sink)) return;
    motor_.put(motor_.position() + troubles_.value(Kind::sink, now_ns_) * seconds);
  }
  [[nodiscard]] bool has_trouble(Kind kind) const {
    return troubles_.has_any() && troubles_.has(kind, now_ns_);
  }
  bool takes_frame(Kind kind) { return troubles_.has_any() && troubles_.takes_frame(kind, now_ns_); }
  /// By its encoder.
  [[nodiscard]] double here() const { return motor_.position() - zero_; }

  /// A target, in any unit. It is told where it is, by its own estimate, until it is known to be on: noise.
  void note_target(double target) {
    constexpr double of_noise = 1e-4;
    if (!first_target_) first_target_ = target;
    has_been_moved_ = has_been_moved_ || std::fabs(target - *first_target_) > of_noise;
  }
  void record_applied(double target) {
    if (keeps_record_) record_.applied.push_back({now_ns_, target});
  }
  void record_entered() {
    if (keeps_record_) record_.entered.push_back({now_ns_, this->state_name(), motor_.velocity()});
  }
  void record_reported(std::uint32_t code) {
    if (keeps_record_) record_.reported.push_back({now_ns_, code});
  }

  SimulatedMotor motor_;
  std::int64_t now_ns_;
  std::int64_t boot_delay_ns_;
  std::int64_t boot_ns_;
  double zero_ = 0;  ///< where its encoder counts from
  DriveTroubles troubles_;
  DriveRecord record_;
  bool has_been_moved_ = false;

 private:
  void begin(const DriveTrouble& trouble) {
    if (trouble.kind == Kind::put_by_hand) return motor_.put(trouble.place);
    if (trouble.kind != Kind::reboot) return meet(trouble);
    zero_ = motor_.position();  // an incremental encoder calls 0 where it is
    boot_ns_ = now_ns_ + boot_delay_ns_;
    start_anew();
  }

  bool keeps_record_;
  std::optional<double> first_target_;
};

}  // namespace inbetween
