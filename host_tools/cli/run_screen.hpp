// The screen of whoever sits before a rig that moves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host_tools/cli/progress_bar.hpp"
#include "host_tools/loop/run_snapshot.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// On a terminal a screen (screen_text.hpp) that follows its size and uses no colours; on one that cannot
/// place its cursor a line that is written over; elsewhere, in a file or a pipe, a plain line whenever
/// something else happens. All on standard error. The keys are read elsewhere.
class RunScreen {
 public:
  /// Refers to the rig.
  RunScreen(std::string title, const RigFile& rig);
  /// The terminal is as it was.
  ~RunScreen();
  RunScreen(const RunScreen&) = delete;
  RunScreen& operator=(const RunScreen&) = delete;

  /// Standard error is a terminal.
  [[nodiscard]] bool has_terminal() const { return kind_ != Kind::plain; }
  void show(const RunSnapshot& snapshot);
  /// From now on the terminal sends what the wheel of its mouse does, as long as the screen is shown. Text is
  /// marked with Shift meanwhile.
  void take_wheel() { takes_wheel_ = true; }
  /// Notes on the screen from now on (screen_text.hpp). Elsewhere they are lines, whenever they are others.
  void tell(std::vector<std::string> notes);
  /// Gives the terminal back for a question; the next show() takes it again.
  void leave();

 private:
  class Curses;
  enum class Kind { screen, line, plain };

  std::string title_;
  const RigFile& rig_;
  Kind kind_;
  bool takes_wheel_ = false;
  ProgressBar bar_;
  std::unique_ptr<Curses> curses_;
  std::vector<std::string> notes_;
  std::string phase_;  ///< the last that a plain line told
};

}  // namespace inbetween
