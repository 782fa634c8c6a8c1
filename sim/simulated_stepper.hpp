#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/steps/edge_instant.hpp"
#include "inbetween/steps/step_merge.hpp"

namespace inbetween {

/// A point of a motor's torque-speed curve (pull-out torque).
struct TorquePoint {
  double steps_per_s = 0;
  double torque_nm = 0;
};

/// How often a minimum was not kept.
struct StepViolations {
  std::int64_t pulse = 0;
  std::int64_t pause = 0;
  std::int64_t dir_setup = 0;
  std::int64_t dir_hold = 0;  ///< also where DIR changes while STEP is high

  friend bool operator==(const StepViolations&, const StepViolations&) = default;
};

/// A driver with its stepper motor and load, on two lines of a chip. Every rising edge of STEP is a step, up
/// if DIR is high, and so is one that violates the timing: a real driver might miss it, which is what the
/// violation tells.
///
/// The motor follows any steps up to `start_rate`. Above it, it must have the torque for what the steps ask:
/// inertia * acceleration + friction, friction against the motion, at most what the curve gives at this rate
/// (straight between its points, none behind the last). Rate and acceleration are those of the last four
/// periods, two against two, because the periods of steps made by a program vary a little; after a turn, or
/// a period of start_rate or slower, those since then, as if it had been at start_rate. Otherwise it stalls:
/// it stands still, and loses steps until they come at start_rate or more slowly again. Not modelled:
/// resonance, and that a real one slips by whole electrical turns.
class SimulatedStepper {
 public:
  static constexpr std::size_t max_points = 16;

  struct Settings {
    StepLines lines;
    double steps_per_unit = 0;  ///< as the generator's
    double steps_per_turn = 200;
    double inertia_kg_m2 = 0;  ///< of rotor and load, at the motor
    double friction_nm = 0;
    double start_rate = 0;                        ///< steps/s
    FixedVector<TorquePoint, max_points> torque;  ///< by growing rate; empty: never stalls
  };

  /// At `position`, in units, both lines low.
  /// Errors: out_of_range (lines that StepMerge refuses, steps_per_unit 0, steps_per_turn not above 0,
  /// something negative or not finite, a curve without a start_rate above 0 at or behind its beginning, or
  /// whose rates do not grow).
  static Result<SimulatedStepper> make(const Settings& settings, double position);

  /// The lines change. Instants come in the order of time; lines that are not its own do not concern it.
  /// Errors: out_of_range (an instant before the last one).
  Status take(const EdgeInstant& instant);

  /// The position of the shaft, in units.
  [[nodiscard]] double position() const {
    return start_ + static_cast<double>(made_) / settings_.steps_per_unit;
  }
  /// Steps by STEP and DIR since the start, with sign, whether the motor made them or not.
  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] std::int64_t lost_steps() const { return lost_; }
  [[nodiscard]] bool is_stalled() const { return is_stalled_; }
  [[nodiscard]] std::int64_t stalls() const { return stalls_; }
  [[nodiscard]] const StepViolations& violations() const { return violations_; }

 private:
  SimulatedStepper(const Settings& settings, double position) : settings_(settings), start_(position) {}
  void step(std::int64_t at_ns);
  [[nodiscard]] bool follows() const;
  [[nodiscard]] double available_nm(double steps_per_s) const;

  static constexpr std::int64_t long_ago_ns = -4'000'000'000'000'000'000;
  Settings settings_;
  double start_;
  std::int64_t made_ = 0;
  std::int64_t count_ = 0;
  std::int64_t lost_ = 0;
  std::int64_t stalls_ = 0;
  StepViolations violations_;
  bool is_stalled_ = false;
  bool step_level_ = false;
  bool dir_level_ = false;
  bool run_up_ = false;
  std::int64_t last_ns_ = long_ago_ns;
  std::int64_t rise_ns_ = long_ago_ns;
  std::int64_t fall_ns_ = long_ago_ns;
  std::int64_t dir_ns_ = long_ago_ns;
  std::int64_t step_ns_ = long_ago_ns;
  std::array<std::int64_t, 5> run_ns_{};  ///< the last fast steps in one direction, newest first
  std::size_t run_ = 0;                   ///< how many of them
};

}  // namespace inbetween
