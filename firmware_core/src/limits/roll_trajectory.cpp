#include "inbetween/limits/roll_trajectory.hpp"

namespace inbetween {

Result<Trajectory> roll_trajectory(std::span<const RollAxis> rolls, const TrajectoryMemory& memory) {
  const std::size_t axes = rolls.size();
  constexpr std::size_t numbers = 3;  // position, velocity, acceleration
  if (memory.pieces.empty() || memory.values.size() < 2 * numbers * axes) {
    return Error{.code = ErrorCode::capacity,
                 .what = "a roll has more values than the memory of its trajectory",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(2 * numbers * axes)};
  }
  const RollSpan span = axes > 0 ? rolls.front().span() : RollSpan{};
  const std::int32_t first = span.joint_frame - (span.end == RollEnd::before ? span.frames : 0);
  const std::int32_t last = first + span.frames;
  for (std::size_t d = 0; d < axes; ++d) {
    const auto write = [&](std::int32_t frame, std::size_t row) {
      const AxisMotion motion = rolls[d].motion({frame, 0});
      memory.values[(numbers * row + 0) * axes + d] = motion.position;
      memory.values[(numbers * row + 1) * axes + d] = motion.velocity;
      memory.values[(numbers * row + 2) * axes + d] = motion.acceleration;
    };
    write(first, 0);
    write(last, 1);
  }
  memory.pieces[0] = {.begin = {first, 0},
                      .inverse_frames = 1 / static_cast<double>(span.frames),
                      .seconds = static_cast<double>(span.frames) / span.fps.frames_per_second(),
                      .begin_row = 0,
                      .end_row = static_cast<std::uint32_t>(numbers * axes),
                      .degree = 5,
                      .is_exact = true};
  return Trajectory::make({.axis_count = axes,
                           .fps = span.fps,
                           .end = {last, 0},
                           .pieces = memory.pieces.first(1),
                           .values = memory.values.first(2 * numbers * axes)},
                          memory.buckets);
}

}  // namespace inbetween
