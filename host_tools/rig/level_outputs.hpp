// The outputs of a rig, each switched on and off by another program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The lines are idle until they are switched, and whenever this object does not exist.
class LevelOutputs {
 public:
  /// As many as have a bit.
  static constexpr std::size_t max_outputs = 32;

  /// Takes the outputs of the rig in their order, a request a chip; null where it has none. Throws InputError
  /// at the place of what is not there; then nothing has changed.
  static std::unique_ptr<LevelOutputs> open(const RigFile& rig, RigHardware& hardware);

  /// By the loop's thread, at most once a tick: bit 0 is the first output. They change when the axes are
  /// where this tick sends them, as pulses do. Nothing waits, nothing is allocated.
  void set(std::uint32_t bits, std::int64_t now_ns);
  [[nodiscard]] std::uint32_t bits() const { return bits_; }
  /// Says the first thing that is wrong and what to do; "" if nothing is.
  [[nodiscard]] std::string trouble() const;

 private:
  struct Line : PulseLine {
    std::string chip;
    std::uint32_t bit = 0;
  };
  /// A chip has the lines first..first+lines-1 of lines_.
  struct Chip {
    std::string label;
    std::size_t first = 0, lines = 0;
    std::unique_ptr<ChipOutputs> outputs;
  };

  LevelOutputs(const RigFile& rig, RigHardware& hardware);

  std::vector<Line> lines_;
  std::vector<Chip> chips_;
  std::int64_t lead_ns_;
  std::uint32_t bits_ = 0;
  bool has_refused_ = false;
};

}  // namespace inbetween
