#include "tests/embedded/target/play_report.hpp"

#include <array>
#include <cstdint>
#include <span>

#include "inbetween/base/hash.hpp"
#include "inbetween/play/playhead.hpp"
#include "tests/embedded/target/played_move.hpp"
#include "tests/embedded/target/report_line.hpp"
#include "tests/embedded/target/solved_move.hpp"

namespace inbetween::embedded {
namespace {

void print_bounds(const PlayedMove& played) {
  Fnv1a cells;
  for (const StopCell& cell : played.cells()) {
    for (const double bound : {cell.rate_change, cell.rate_jerk, cell.release_jerk}) cells.add(bound);
  }
  print_hash("cells", cells.value());
  Fnv1a longest;
  const LongestStop& stop = played.bounds().longest_in_time();
  for (const double number : {stop.length.seconds, stop.length.frames, stop.from_frame}) longest.add(number);
  longest.add(static_cast<std::int32_t>(stop.forward));
  for (const AxisPeaks& axis : played.stop_peaks()) {
    for (const Peak& peak : {axis.velocity, axis.acceleration, axis.jerk}) {
      longest.add(peak.value);
      longest.add(peak.frame);
    }
  }
  print_hash("longest", longest.value());
}

/// What somebody does with a move, and where that brings it on every tick.
class PlaySession {
 public:
  PlaySession(const PlayedMove& played, const Move& move)
      : played_(played), move_(move), playhead_(played.move(), played.bounds(), move.rate_hz) {}

  /// False where a command is refused, or something does not come to rest.
  bool play() {
    const std::int32_t middle = move_.frames / 2;
    bool is_well = playhead_.play(Direction::forward).has_value();
    ticks(move_.rate_hz / 2);
    playhead_.stop();
    is_well = is_well && ticks_until_rest() && playhead_.play(Direction::forward);
    ticks(move_.rate_hz / 3);
    is_well = is_well && playhead_.set_override(0.4);
    ticks(move_.rate_hz / 2);
    is_well = is_well && playhead_.set_override(1) && playhead_.play(Direction::backward);
    ticks(move_.rate_hz / 4);
    is_well = is_well && playhead_.go_to(middle) && ticks_until_rest() && is_on(middle);
    is_well = is_well && playhead_.step(Direction::backward) && ticks_until_rest() && is_on(middle - 1);
    playhead_.set_repeat(Repeat::ping_pong);
    is_well = is_well && playhead_.play(Direction::backward);
    // There and back, once and a little more.
    const std::int32_t line = played_.move().last_frame() - played_.move().first_frame();
    const std::int64_t turns = repeats_;
    ticks(static_cast<int>(last_tick(5 * line / 2, move_.fps, move_.rate_hz)));
    playhead_.stop();
    return is_well && ticks_until_rest() && repeats_ - turns >= 2;
  }
  [[nodiscard]] std::uint64_t places() const { return places_.value(); }
  [[nodiscard]] std::uint64_t positions() const { return positions_.value(); }

 private:
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }
  bool ticks_until_rest() {
    constexpr int patience = 10'000;
    for (int i = 0; i < patience && !playhead_.is_resting(); ++i) tick();
    return playhead_.is_resting();
  }
  void tick() {
    const PlayheadEvent event = playhead_.tick();
    if (event == PlayheadEvent::repeated) ++repeats_;
    places_.add(static_cast<std::int32_t>(event));
    places_.add(playhead_.time().frame);
    places_.add(playhead_.time().fraction);
    places_.add(playhead_.rate());
    places_.add(playhead_.rate_change());
    std::array<double, max_axes> at{};
    played_.positions(playhead_.time(), std::span(at).first(played_.move().axis_count()));
    for (const double position : at) positions_.add(position);
  }
  [[nodiscard]] bool is_on(std::int32_t frame) const {
    return playhead_.time().frame == frame && playhead_.time().fraction == 0;
  }

  const PlayedMove& played_;
  const Move& move_;
  Playhead playhead_;
  std::int64_t repeats_ = 0;
  Fnv1a places_, positions_;
};

}  // namespace

void report_play(const Move& move) {
  static SolvedMove solved;
  static PlayedMove played;
  const Result<Track> track = solved.solve(move);
  if (!track) return fail("double", move, track.error());
  if (const Status made = played.make(*track, move.rate_hz); !made) {
    return fail("double", move, made.error());
  }
  print("double_stops ");
  print(move.name);
  print_bounds(played);
  PlaySession session(played, move);
  const bool is_well = session.play();
  print_hash("places", session.places());
  print_hash("positions", session.positions());
  print("\n");
  if (!is_well) {
    fail("double", move,
         {.code = ErrorCode::no_solution,
          .what = "a command was refused, or there was no rest",
          .remedy = "see PlaySession::play"});
  }
}

}  // namespace inbetween::embedded
