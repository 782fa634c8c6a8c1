#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "inbetween/base/setpoint.hpp"
#include "inbetween/homing/line_event.hpp"

namespace inbetween {

/// A switch at a place of an axis, with what real ones do: hysteresis, bounce, noise on its wire, and faults.
/// Between two ticks the axis moves as the cubic that joins their positions and velocities; an edge has the
/// time at which that passes the place. The same seed gives the same edges.
class SimulatedSwitch {
 public:
  enum class Fault : std::uint8_t {
    none,
    stuck,    ///< actuated from the first time that it was on
    open,     ///< never actuated: a broken wire
    chatter,  ///< while actuated it opens every 0.2 to 1.5 ms for a moment
  };
  /// Positions in axis units.
  struct Settings {
    std::uint8_t line = 0;
    bool active_level = true;
    bool is_above = true;  ///< actuated at `closes` and above; otherwise there and below
    double closes = 0;
    double hysteresis = 0;          ///< opens so far before the place where it closes
    double bounce_s = 0;            ///< after a change it bounces for no longer than this
    std::uint32_t max_bounces = 0;  ///< times that it opens and closes meanwhile
    double noise_hz = 0;            ///< spikes a second, at random
    double longest_noise_s = 1e-4;
    Fault fault = Fault::none;
  };

  /// With the axis at rest at `position`.
  SimulatedSwitch(const Settings& settings, double position, std::uint32_t seed);

  /// The axis moves from one setpoint to the next, and the edges on the way are added to `events`, in order.
  void move(std::int64_t from_ns, const Setpoint& from, std::int64_t to_ns, const Setpoint& to,
            std::vector<LineEvent>& events);
  /// The level of the line at the end of the last motion.
  [[nodiscard]] bool level() const { return level_; }
  /// From now on.
  void set_fault(Fault fault) { settings_.fault = fault; }

 private:
  [[nodiscard]] bool is_on_at(double position) const;
  /// How far beyond the place where it closes.
  [[nodiscard]] double past(double position) const;
  void add_change(std::int64_t at_ns);
  void add_pulse(std::int64_t at_ns, std::int64_t length_ns);
  [[nodiscard]] double random(double min, double max);

  Settings settings_;
  std::mt19937 random_;
  bool is_on_ = false;  ///< what the place of the axis says
  bool level_ = false;  ///< what the line says
  std::int64_t next_noise_ns_ = -1;
  std::int64_t next_chatter_ns_ = -1;
  std::vector<std::int64_t> toggles_ns_;  ///< of the line, still to come
};

}  // namespace inbetween
