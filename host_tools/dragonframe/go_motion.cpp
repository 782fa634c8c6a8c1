#include "host_tools/dragonframe/go_motion.hpp"

#include <cmath>

namespace inbetween::dragonframe {
namespace {

// Hosts open the shutter so long after Go.
constexpr double ramp_s = 1;

}  // namespace

double preroll_position(const UploadedMove& move, std::uint8_t motor, const RunTimes& run) {
  const double first = move.position(motor, run.start);
  const double second = move.position(motor, static_cast<double>(std::int64_t{run.start} + run.direction()));
  return first - run.fps * (second - first) * run.preroll_s / 2;
}

double postroll_position(const UploadedMove& move, std::uint8_t motor, const RunTimes& run) {
  const double last = move.position(motor, static_cast<double>(run.behind()));
  const double before = move.position(motor, run.end);
  return last + run.fps * (last - before) * run.postroll_s / 2;
}

BlurWay blur_way(const UploadedMove& move, std::uint8_t motor, std::int32_t frame, int direction,
                 double blur) {
  const double half = direction * blur / 2;
  return {.from = move.position(motor, frame - half), .to = move.position(motor, frame + half)};
}

BlurWay shortened(const BlurWay& way, double blur) {
  const double cut = (0.5 - blur / 2) * (way.to - way.from);
  return {.from = way.from + cut, .to = way.to - cut};
}

double end_of(const ShotWay& way) {
  double position = way.start;
  for (const ShotPiece& piece : way.pieces) position += piece.seconds * (piece.from + piece.to) / 2;
  return position;
}

ShotWay constant_speed_shot(const BlurWay& way, double exposure_s) {
  const double speed = (way.to - way.from) / exposure_s;
  return {.start = way.from - speed * ramp_s / 2,
          .pieces = {{ramp_s, 0, speed}, {exposure_s, speed, speed}, {ramp_s, speed, 0}}};
}

ShotWay two_speed_shot(double from, double middle, double to, double exposure_s) {
  const double half_s = exposure_s / 2;
  const double first = (middle - from) / half_s;
  const double second = (to - middle) / half_s;
  return {
      .start = from - first * ramp_s / 2,
      .pieces = {{ramp_s, 0, first}, {half_s, first, first}, {half_s, second, second}, {ramp_s, second, 0}}};
}

ShotWay shutter_turn_shot(const BlurWay& way, const ShutterTurn& turn) {
  // Two eighths at half of the speed in the mean, six at all of it.
  const double speed = 8.0 / 7.0 * (way.to - way.from) / turn.turn_s;
  return {.start = way.from,
          .pieces = {{turn.wait_s, 0, 0},
                     {turn.turn_s / 8, 0, speed},
                     {turn.turn_s * 3 / 4, speed, speed},
                     {turn.turn_s / 8, speed, 0},
                     {turn.hold_s, 0, 0}}};
}

}  // namespace inbetween::dragonframe
