// A speed curve that lets a move fit in the fewest frames in which one is found.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host_tools/check/check_frames.hpp"
#include "host_tools/fit/speed_fit.hpp"

namespace inbetween {

struct FewestFit {
  MoveFile move;  ///< in so many frames (with_frames), its curves as drawn; its `frames` say how many
  SpeedFit fit;   ///< what changes them; not found: no number of frames was found in which a curve fits
};

/// Bisects between the frames that any curve needs (fewest_frames, proven) and a number at which the drawn
/// curve fits, or else the frames of the move: in one frame less than the answer it was tried and no curve
/// was found. Locked keys, holds, ease_in, ease_out and listed cues move in proportion.
///
/// `report` and `smallest` are those of the plan; `progress` takes the place of that of the options. Cost:
/// that of fit_speed about ten times, until it is over.
FewestFit fit_in_fewest_frames(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest,
                               const FitOptions& told,
                               const std::function<void(double, std::int32_t)>& progress);

/// The text of a move in other frames: of `move`, which with_frames made of it.
std::string with_frames_of(std::string_view text, const std::string& file_name, const MoveFile& move);

/// Whether there is a drawn curve, and such a search without refinements takes a second or two: no curve has
/// more than 32 control values, and no track more than 200 segments and control values, counted for each
/// axis.
bool is_quick_to_fit(const Plan& plan);

}  // namespace inbetween
