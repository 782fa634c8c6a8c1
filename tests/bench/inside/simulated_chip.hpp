// A GPIO chip of the kernel's gpio-sim, with somebody at the other end of its lines.
#pragma once

#include <string>
#include <vector>

namespace inbetween {

class SimulatedChip {
 public:
  struct Line {
    unsigned offset = 0;
    std::string name;  ///< none if empty
    std::string user;  ///< of the kernel's own, that keeps it busy; none if empty
  };

  SimulatedChip(const std::string& label, unsigned line_count, const std::vector<Line>& lines = {});
  ~SimulatedChip();
  SimulatedChip(const SimulatedChip&) = delete;
  SimulatedChip& operator=(const SimulatedChip&) = delete;

  /// What a resistor or a switch at the line does. Edges of a line that is listened to come some time later:
  /// see `settle`.
  void pull(unsigned line, bool is_up) const;
  [[nodiscard]] bool level(unsigned line) const;
  /// Lines as bits.
  [[nodiscard]] unsigned levels() const;
  void unplug();

  /// On virtual time: until the kernel has told of every edge.
  static void settle();

 private:
  std::string folder_;  ///< where it is made
  std::string lines_;   ///< where its lines are driven
  unsigned line_count_;
  bool is_plugged_ = false;
};

/// Whether waiting takes no time here. Tests that need it skip themselves elsewhere.
bool is_on_virtual_time();

}  // namespace inbetween
