// One move of every way of timing, for what holds for all of them.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "host_tools/move_model/move_file.hpp"

namespace inbetween {

struct TimingKind {
  std::string name, track;
  bool rolls = false;    ///< it begins and ends at a speed
  bool is_drawn = true;  ///< it has a speed curve that can be fitted
};

const std::vector<TimingKind>& timing_kinds();

/// Axes x and y, 48 frames at 24 fps.
MoveFile move_of(const TimingKind& kind);

/// How a test shows it.
void PrintTo(const TimingKind& kind, std::ostream* out);

}  // namespace inbetween
