// What a move must do, worked out from the equation L(s) = K Phi(a) alone, and the judge of a product's
// answer.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"

namespace inbetween::oracle {

/// A move at one frame, which need not be a whole one. Speed and acceleration are along the path, through the
/// weights.
struct Row {
  long double alpha = 0;
  long double distance = 0;
  long double speed = 0;         ///< path units per frame
  long double acceleration = 0;  ///< path units per frame^2
  Place place;
};

// `frames` is N >= 1; frame j stands at a = j f / N, at distance L Phi(a) / Phi(f). Every function here
// throws std::invalid_argument where N < 1 or where Phi(f) = 0 although the path has a length, and
// std::out_of_range for a frame outside [0, N].

Row row_at(const Path& path, const Profile& profile, int frames, long double frame);

/// Rows of frames 0..N.
std::vector<Row> frame_table(const Path& path, const Profile& profile, int frames);

/// How far the worst frame step is from the drawn speed.
struct SpeedError {
  long double worst = 0;  ///< |error| / allowed; infinite where a step is wrong that may not be; good is <= 1
  int frame = 0;          ///< the step from this frame to the next; the fields below are of this step
  long double travelled = 0;  ///< along the path, negative going back
  long double wanted = 0;     ///< K (Phi(a_j+1) - Phi(a_j))
  long double allowed = 0;
  long double worst_distance = 0;  ///< over all frames: |distance from the start - wanted| / L
};

/// Judges the places of frames 0..N (N + 1 of them, otherwise std::invalid_argument): a step longer than 1e-6
/// L may be off by delta times its length, a shorter one by `epsilon` times 8 L more. epsilon is the relative
/// spacing of the precision under test, 2^-52 for double and 2^-23 for float. Throws std::out_of_range, with
/// the frame, for a place that is not on the path. The place of frame 0 is not held against the start of the
/// path, nor that of frame N against its end, except in worst_distance.
SpeedError worst_speed_error(const Path& path, const Profile& profile, int frames,
                             std::span<const std::pair<int, double>> segment_and_t, long double delta,
                             long double epsilon = 0x1p-52L);

/// Position and its time derivatives per axis, in axis units and seconds. The errors are estimates that were
/// never exceeded on thousands of random moves; a test adds them to its tolerance.
struct Motion {
  std::vector<long double> position, velocity, acceleration, jerk;
  std::vector<long double> velocity_error, acceleration_error, jerk_error;
};

/// Derivatives by Ridders' extrapolation of central differences of the exact position, without any formula
/// for them. Typical errors are 1e-16, 1e-14 and 1e-12 of the value, a thousand times more in a narrow bend.
/// The stencil needs a stretch in which the move is smooth: inside one span of the speed curve, one segment
/// and one side of a cusp; where that reaches less than 1e-3 spans to either side it throws
/// std::domain_error. About thirty inversions of arc length, under a millisecond.
Motion motion_at(const Path& path, const Profile& profile, int frames, long double frames_per_second,
                 long double seconds);

}  // namespace inbetween::oracle
