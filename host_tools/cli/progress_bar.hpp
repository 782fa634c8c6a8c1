// A progress bar on a terminal, and nothing in a pipe.
#pragma once

#include <string>

namespace inbetween {

/// Rewrites one line of standard error. Silent when that is not a terminal.
class ProgressBar {
 public:
  ProgressBar();
  /// Ends the line that show() has left open.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `share` of the work, 0..1, drawn as a bar, with a few words behind it, as far as the line has room.
  void show(double share, const std::string& words);

 private:
  bool on_terminal_;
  bool line_open_ = false;
};

}  // namespace inbetween
