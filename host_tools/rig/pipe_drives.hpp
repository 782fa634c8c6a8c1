// Hobby servos behind a microcontroller, to which a line of text goes every tick.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "drivers/linux/line_pipe.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// A DrivePort for the pipe axes of a rig. Axes with the same path share a line (docs/formats.md, "Lines to a
/// pipe"). Nothing reports where an axis is: it is where it was told to be.
///
/// A reader that does not read for a tenth of a second, or leaves, is a fault that lasts until the drives are
/// opened anew: lines cease, and the other axes stop on the path.
class PipeDrives final : public AxisDrives {
 public:
  /// `axes` of the rig are its pipe axes. Throws InputError at the place of an axis whose pipe cannot be
  /// opened or is too slow, or whose rig file does not say that it has no watchdog. Refers to the rig.
  PipeDrives(const RigFile& rig, std::span<const std::size_t> axes);

  void read(std::span<DriveState> states, std::int64_t now_ns) override;
  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns) override;
  void enable() override;
  /// The last line is "off".
  void disable() override;
  /// Lines cease.
  void quick_stop() override { is_enabled_ = false; }
  void place(std::size_t drive, double position) override { lanes_[drive].told = position; }
  [[nodiscard]] bool has_lost_position(std::size_t drive) const override {
    return pipes_[lanes_[drive].pipe].has_failed;
  }
  [[nodiscard]] std::string trouble() const override;
  void count(Counters& counts) const override;

 private:
  struct Lane {
    std::size_t pipe = 0;
    std::string before;  ///< " NAME="
    const PipeDrive* drive = nullptr;
    double told = 0;  ///< position in axis units
    std::int64_t lines = 0;
  };
  struct Pipe {
    std::string path;
    std::vector<std::size_t> lanes;
    LinePipe pipe{};
    std::vector<char> line{};
    bool has_failed = false;
  };
  void open(Pipe& pipe);
  void send_line(Pipe& pipe, std::int64_t now_ns);

  const RigFile& rig_;
  std::vector<std::size_t> axes_;
  std::vector<Lane> lanes_;
  std::deque<Pipe> pipes_;
  std::size_t max_waiting_lines_ = 0;
  bool is_enabled_ = false;
  std::int64_t now_ns_ = 0;
  std::int64_t opened_ns_ = 0;  ///< 0: not read yet
  std::int64_t ready_after_ns_ = 0;
  std::int64_t first_line_ns_ = 0;
  std::int64_t line_ = 0;  ///< the number of the next line
};

}  // namespace inbetween
