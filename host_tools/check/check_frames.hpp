// How few frames a move could have on its rig.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host_tools/check/check.hpp"

namespace inbetween {

/// The same move in so many frames: locked keys, holds, ease_in, ease_out and listed cues are scaled by the
/// same factor and rounded to whole frames, a hold and an ease to one at least. Frames 0 and N stay the first
/// and the last. Throws InputError where the frames are fixed and others are asked for.
MoveFile with_frames(const MoveFile& move, std::int32_t frames);

/// Why this move cannot be tried in another number of frames; nothing where it can.
std::optional<std::string> why_frames_are_fixed(const MoveFile& move);

/// What changes along with the frames of the move, to be said behind their number: ", with the frames and
/// holds of the keys in proportion". Empty where nothing does.
std::string in_proportion(const MoveFile& move);

struct SmallestFrames {
  std::optional<std::int32_t> frames;
  std::string reason;      ///< why there is none
  bool was_ended = false;  ///< there may be one: it was not looked for to the end
  /// Found by fit_in_fewest_frames, where it was asked: as few as another speed curve needs.
  std::optional<std::int32_t> with_other_curve = {};
  bool may_be_refined = false;  ///< that curve may have more control values than the played one
};

/// A number of frames, at most max_frames, at which the move as a whole is solved again and fits, while at
/// one frame less it does not. Without locked keys and holds that is the smallest there is; with them the
/// rounding of frames may let a much smaller one fit by chance. None where no slowing helps: positions, steps
/// of the velocity, steps of the acceleration where none is allowed, peaks without bound; and none where the
/// frames are fixed.
///
/// Method: v ~ 1/T, a ~ 1/T^2, j ~ 1/T^3 give the first guess from the peaks, and the next one from the peaks
/// of every number tried, a few times; from there in steps of 1, 2, 4 ... to a number on the other side, then
/// bisection. Cost: 2 or 3 solutions as a rule, about 40 where locked frames and their rounding mislead.
///
/// `report` is that of the plan. `progress` is told the share of the work, roughly, and each number tried.
/// `is_over` is asked before each; once it is true there is none.
SmallestFrames smallest_frames(const Plan& plan, const CheckReport& report,
                               const std::function<void(double share, std::int32_t frames)>& progress,
                               const std::function<bool()>& is_over = {});

}  // namespace inbetween
