#include "host_tools/hosted/shot_rows.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace inbetween {
namespace {

using dragonframe::ShotMotor;
using dragonframe::ShotPiece;

constexpr double rows_per_s = 50;
constexpr double most_rows = 3000;

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

}  // namespace

ShotRows rows_of(const dragonframe::PrepareShot& shot, std::span<const StepScale> scales) {
  double seconds = shot.close_s;
  for (const ShotMotor& motor : shot.motors) seconds = std::max(seconds, seconds_of(motor));
  const double rate = std::min(rows_per_s, std::max(most_rows / std::max(seconds, 1e-3), 1.0));
  ShotRows made;
  made.rows.frames_per_1000_s = static_cast<std::uint32_t>(rate * 1000);
  const double row_s = 1000.0 / made.rows.frames_per_1000_s;
  std::vector<const ShotMotor*> moved(scales.size(), nullptr);
  for (const ShotMotor& motor : shot.motors) moved.at(motor.motor - 1U) = &motor;
  for (std::size_t axis = 0; axis < scales.size(); ++axis) {
    if (moved[axis] != nullptr || (shot.resting >> axis & 1U) != 0) made.rows.axes.push_back(axis);
  }
  const auto last = std::max(static_cast<std::int32_t>(std::ceil(seconds / row_s - 1e-9)), 1);
  for (std::int32_t row = 0; row <= last; ++row) {
    made.rows.frames.push_back(row);
    for (const std::size_t axis : made.rows.axes) {
      const double steps = moved[axis] != nullptr ? steps_at(*moved[axis], row * row_s) : shot.rest.at(axis);
      made.rows.positions.push_back(scales[axis].units(steps));
    }
  }
  made.closed_at = std::min(static_cast<std::int32_t>(std::ceil(shot.close_s / row_s - 1e-9)), last);
  return made;
}

}  // namespace inbetween
