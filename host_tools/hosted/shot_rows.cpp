#include "host_tools/hosted/shot_rows.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace inbetween {
namespace {

using dragonframe::ShotMotor;
using dragonframe::ShotPiece;

constexpr double longest_row_s = 0.02;
/// Of a piece of one speed, on which a curve through few rows lies anyway. Between two such speeds there is a
/// corner, round which it goes with a jerk that is in inverse proportion to the square of this.
constexpr double longest_even_row_s = 0.04;
constexpr double max_shot_rows = 3000;
/// Of the time line of the rows: milliseconds, in which hosts give their times, as far as a move has frames.
constexpr double frames_per_s = 1000;
constexpr double most_frames = 900'000;

/// How far a piece has come after so many seconds of it.
double way_of(const ShotPiece& piece, double seconds) {
  if (piece.seconds <= 0) return 0;
  const double u = std::clamp(seconds / piece.seconds, 0.0, 1.0);
  const double risen = u * u * u * (1 - u / 2);  // the integral of 3u^2 - 2u^3
  return piece.seconds * (piece.from * u + (piece.to - piece.from) * risen);
}

double steps_at(const ShotMotor& motor, double seconds) {
  double steps = motor.start;
  for (const ShotPiece& piece : motor.pieces) {
    steps += way_of(piece, std::max(seconds, 0.0));
    seconds -= piece.seconds;
  }
  return steps;
}

double seconds_of(const ShotMotor& motor) {
  double seconds = 0;
  for (const ShotPiece& piece : motor.pieces) seconds += piece.seconds;
  return seconds;
}

/// Where a piece ends there is a row: a corner between two speeds is met, not cut. In between they are even.
std::vector<std::int32_t> frames_of_rows(const dragonframe::PrepareShot& shot, double seconds, double rate) {
  std::vector<std::int32_t> frames{0,
                                   std::max(static_cast<std::int32_t>(std::ceil(seconds * rate - 1e-9)), 1)};
  for (const ShotMotor& motor : shot.motors) {
    double begins_s = 0;
    for (const ShotPiece& piece : motor.pieces) {
      const double row_s = piece.from == piece.to ? longest_even_row_s : longest_row_s;
      const double wanted = std::ceil(piece.seconds / std::max(row_s, seconds / max_shot_rows) - 1e-9);
      const int rows = std::max(static_cast<int>(wanted), 1);
      for (int row = 1; row <= rows; ++row) {
        const double at_s = begins_s + piece.seconds * row / rows;
        frames.push_back(std::min(static_cast<std::int32_t>(std::lround(at_s * rate)), frames[1]));
      }
      begins_s += piece.seconds;
    }
  }
  std::ranges::sort(frames);
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

}  // namespace

ShotRows rows_of(const dragonframe::PrepareShot& shot, std::span<const StepScale> scales) {
  double seconds = shot.close_s;
  for (const ShotMotor& motor : shot.motors) seconds = std::max(seconds, seconds_of(motor));
  const double rate = std::floor(std::clamp(most_frames / std::max(seconds, 1e-3), 1.0, frames_per_s));
  ShotRows made;
  made.rows.frames_per_1000_s = static_cast<std::uint32_t>(rate) * 1000;
  made.rows.frames = frames_of_rows(shot, seconds, rate);
  std::vector<const ShotMotor*> moved(scales.size(), nullptr);
  for (const ShotMotor& motor : shot.motors) moved.at(motor.motor - 1U) = &motor;
  for (std::size_t axis = 0; axis < scales.size(); ++axis) {
    if (moved[axis] != nullptr || (shot.resting >> axis & 1U) != 0) made.rows.axes.push_back(axis);
  }
  for (const std::int32_t frame : made.rows.frames) {
    for (const std::size_t axis : made.rows.axes) {
      const double steps = moved[axis] != nullptr ? steps_at(*moved[axis], frame / rate) : shot.rest.at(axis);
      made.rows.positions.push_back(scales[axis].units(steps));
    }
  }
  made.closed_at =
      std::min(static_cast<std::int32_t>(std::ceil(shot.close_s * rate - 1e-9)), made.rows.frames.back());
  return made;
}

}  // namespace inbetween
