#include <array>
#include <cstdint>
#include <span>

#include "examples/firmware/board.hpp"
#include "examples/firmware/line_sink.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/count_trajectory.hpp"
#include "inbetween/trajectory/fit.hpp"

/// The move examples/reveal.toml on a controller without an operating system: solved on the controller, then
/// sent to the drives tick by tick, in counts. The "drives" are the serial port: a line per tick.

namespace {

using namespace inbetween;

/// The move and the rig, as in examples/reveal.toml and examples/camera_rig.toml.
constexpr std::size_t axis_count = 3;  // slide (mm), pan (deg), tilt (deg)
constexpr std::array keys{60.0, -62.0,  -4.0, 420.0, -58.0,  -3.0, 860.0, -30.0,
                          4.0,  1240.0, 14.0, 9.0,   1640.0, 32.0, 6.0};
constexpr std::array weights{1.0, 6.0, 6.0};
constexpr std::array speed{0.0, 0.0, 3.0, 4.0, 9.0, 12.0, 8.0, 5.0, 0.0, 0.0};
constexpr std::int32_t frames = 192;
constexpr FrameRate fps{24, 1};
constexpr std::array counts_per_unit{1000.0, 4000.0, 4000.0};
constexpr std::int32_t rate_hz = 250;

/// All memory of the move. Large objects are static: the stack is for calls. The move is solved in double on
/// every processor: that takes some hundred milliseconds on a Cortex-M4, once, and the move is the same
/// everywhere. The tick is evaluated in floats, which both have instructions for.
TrackStorage<keys.size() / axis_count, axis_count, speed.size()> storage;
std::array<PathPoint, frames + 1> rows;
std::array<SampledJoint, 60> joints;
TrajectoryStorage<axis_count, 200, 30> trajectory_storage;
std::array<CountTrajectoryPiece, 300> count_pieces;
std::array<CountPolynomial, axis_count * count_pieces.size()> count_polynomials;

bool refuse(const Error& error) {
  board::send("error: ");
  board::send(error.what);
  board::send("; ");
  board::send(error.remedy);
  board::send("\n");
  return false;
}

Result<Track> solve() {
  const auto path =
      Path::make({.spline = Spline::smooth, .axis_count = axis_count, .keys = keys, .weights = weights},
                 storage.path.memory());
  if (!path) return path.error();
  const auto arc_length = ArcLength::make(*path, {}, storage.arc_length.memory());
  if (!arc_length) return arc_length.error();
  const auto profile = SpeedProfile::make(speed, storage.profile.memory());
  if (!profile) return profile.error();
  return Track::make(*path, *arc_length, *profile, frames, fps, storage.memory());
}

/// The table of frames, and whether it keeps the rules that every table keeps.
Status check(const Track& track) {
  const auto table = closed_form_table(track, rows);
  if (!table) return table.error();
  return check_invariants(track, *table);
}

/// The motion of the track in counts.
Result<CountTrajectory> counts_of(const Track& track) {
  const auto sampler = TrackSampler::make(track, joints);
  if (!sampler) return sampler.error();
  const auto trajectory = fit_trajectory(*sampler, {}, trajectory_storage.memory());
  if (!trajectory) return trajectory.error();
  return CountTrajectory::make(*trajectory, counts_per_unit, {count_pieces, count_polynomials});
}

}  // namespace

bool inbetween::board::program() {
  const Result<Track> track = solve();
  if (!track) return refuse(track.error());
  if (const Status sound = check(*track); !sound) return refuse(sound.error());
  Result<CountTrajectory> counts = counts_of(*track);
  if (!counts) return refuse(counts.error());

  board::LineSink sink;
  std::array<std::int32_t, axis_count> position;
  const std::int64_t last = last_tick(frames, fps, rate_hz);
  board::start_tick(rate_hz);
  for (std::int64_t next = 0; next <= last; ++next) {
    const std::int64_t tick = board::wait_for_tick();
    if (tick != next) {
      board::send("error: a tick was missed; lower the rate, or make the sink faster\n");
      return false;
    }
    counts->counts(frame_time_of_tick<float>(tick, fps, rate_hz), position);
    sink.set_positions(tick, position);
  }
  return true;
}
