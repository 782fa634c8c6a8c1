// A rig on chips of the kernel's gpio-sim: the program on one side of the lines, on the other somebody who
// writes down every change of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {

/// An axis that goes 33 mm/s, with pulses so long that whoever looks every 0.4 ms sees each of them. `lines`
/// are those of its drive, `more` what else it has.
inline AxisText gpio_axis(const std::string& name, RangeText range, const std::string& lines,
                          const std::string& more = "") {
  return axis_text(name, "mm", range, {.velocity = 33, .acceleration = 100}, "unpowered = \"holds\"\n" + more,
                   "type = \"step-dir\", " + lines +
                       ", steps_per_unit = 10, max_step_rate = 333, pulse_us = 1000, pause_us = 1000");
}

/// On the line that a pressed stop leaves high.
inline const std::string emergency_stop_of_head = R"([emergency_stop]
chip = "head"
line = 6
stops_at = "high"
bias = "none"
)";

/// x and y go from 0 to 50 and to -20.
inline const std::string move_of_both = R"(name = "there"
fps = 25
frames = 100
[[track]]
axes = ["x", "y"]
keys = [ { at = [0, 0] }, { at = [50, -20] } ]
speed = [0, 0, 10, 10, 0, 0]
)";

/// Watching the clock before every edge takes the kernel of the bench a system call for each look: rigs here
/// have step_watch_us = 0, and sleep until the edge.
///
/// All bash in here runs in the folder with rig.toml, move.toml and the position file `positions`.
/// `pull LINE up` and `pull LINE down` are a switch at a line of the watched chip, $chips/LABEL is the folder
/// in which a chip's lines are driven.
struct GpioSceneOptions {
  std::string rig;
  std::string move = "";
  std::vector<std::string> at_zero = {};  ///< axes that are said to be at 0
  std::string before = "";                ///< bash, before the program
  std::string command = "run move.toml --rig rig.toml --positions positions";
  std::string during = "";  ///< bash beside it, two seconds after its start; $run is the program
  std::vector<std::string> bench = {"--gpio", "head:8"};
  std::vector<std::string> more_of_bench = {};
  std::string watched = "head";
  /// These lines of the watched chip are recorded. Looking at them takes most of the time of a scene.
  std::vector<unsigned> lines = {0, 1, 2, 3, 4, 5, 6, 7};
};

/// On virtual time, so that nothing depends on how loaded this machine is.
struct GpioScene {
  ProgramRun run;
  std::string positions;  ///< the position file afterwards
  struct Levels {
    std::int64_t at_ns = 0;
    unsigned levels = 0;
  };
  std::vector<Levels> record;  ///< of the watched chip: how it was, and every change

  explicit GpioScene(const GpioSceneOptions& options);

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  /// When a line rose.
  [[nodiscard]] std::vector<std::int64_t> rises(unsigned line) const;
  /// When a line fell.
  [[nodiscard]] std::vector<std::int64_t> falls(unsigned line) const;
  [[nodiscard]] bool is_high(std::size_t entry, unsigned line) const {
    return (record[entry].levels >> line & 1U) != 0;
  }
  [[nodiscard]] bool has_ever_been_high(unsigned line) const;
  [[nodiscard]] bool is_high_at_the_end(unsigned line) const {
    return !record.empty() && is_high(record.size() - 1, line);
  }

 private:
  [[nodiscard]] std::vector<std::int64_t> changes_to(bool level, unsigned line) const;

  TemporaryFolder folder_;
};

}  // namespace inbetween
