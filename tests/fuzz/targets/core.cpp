// Any bytes as keys, control values and frames: a table that keeps the invariants, or an error that says why.
// Nothing that comes out of a move that could be made is a NaN or an infinity.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "host_tools/plan/ode_frame_table.hpp"
#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/fuzz/targets/any_move.hpp"

namespace inbetween {
namespace {

/// The Runge-Kutta solver takes up to a hundred integrations of the whole move.
constexpr std::int32_t max_frames_by_runge_kutta = 300;
constexpr std::int32_t max_frames_here = 2000;
/// How far a curve with locked keys may be refined.
constexpr std::size_t max_values = 200;
/// Of a path over frames, or with rounded corners.
constexpr std::size_t max_segments_between_keys = 5;
/// Far above what is needed at the smallest delta (about 80) even with cusps; a count that runs away is a
/// find.
constexpr std::size_t max_pieces_per_segment = 4000;

class MoveUnderTest {
 public:
  explicit MoveUnderTest(const AnyMove& move) : move_(move) {}

  void run() {
    const auto axes = static_cast<std::size_t>(move_.axis_count);
    const std::size_t keys = move_.keys.size() / axes;
    // Memory is as large as documented and not an entry more, so that the sanitizer sees the first one too
    // many.
    std::size_t segments = move_.closed && keys > 1 ? keys : keys - 1;
    if (move_.has_knots()) {
      segments *= max_segments_between_keys;
      knots_.resize(segments);
    }
    cubics_.resize((segments + 1) * axes);
    weights_.resize(axes);
    const auto path = Path::make(move_.path_spec(), {cubics_, weights_, knots_});
    if (!checked(path)) return;
    if (move_.has_knots()) {
      require(static_cast<std::size_t>(path->segment_count()) <= segments,
              "a path with knots has its segments");
      segments = static_cast<std::size_t>(path->segment_count());
    }
    require(static_cast<std::size_t>(path->segment_count()) == segments, "a path has its segments");
    const auto arc_length = measure(*path, segments);
    if (!checked(arc_length)) return;
    require_finite(arc_length->total());

    const auto track = time(*path, *arc_length);
    if (!checked(track)) return;
    require_finite(track->constant());
    if (move_.frames > max_frames_here) {
      evaluate(*track, move_.frames - 3, move_.frames);
      return;
    }
    solve_closed_form(*track);
    evaluate(*track, -1, move_.frames + 1);
    if (move_.substeps > 0 && move_.frames <= max_frames_by_runge_kutta) solve_runge_kutta(*track);
  }

 private:
  void require(bool holds, const char* what) const {
    if (holds) return;
    print(move_);
    std::fprintf(stderr, "fuzz: broken: %s\n", what);
    std::abort();
  }
  void require_finite(double number) const {
    require(std::isfinite(number), "what comes out is a finite number");
  }

  template <class T>
  bool checked(const Result<T>& result) const {
    if (result) return true;
    require(result.error().what[0] != '\0' && result.error().remedy[0] != '\0', "an error says what to do");
    require(result.error().code != ErrorCode::capacity, "memory as large as documented suffices");
    return false;
  }

  Result<ArcLength> measure(const Path& path, std::size_t segments) {
    first_pieces_.resize(segments + 1);
    segment_begins_.resize(segments + 1);
    const auto with_room = [&](std::size_t pieces) {
      pieces_.resize(pieces);
      begins_.resize(pieces);
      buckets_.resize(pieces);
      pieces_.shrink_to_fit();
      begins_.shrink_to_fit();
      buckets_.shrink_to_fit();
      return ArcLength::make(path, move_.options,
                             {pieces_, begins_, buckets_, first_pieces_, segment_begins_});
    };
    const auto small = with_room(1);
    if (small || small.error().code != ErrorCode::capacity) return small;
    const auto needed = static_cast<std::size_t>(small.error().needed);
    require(needed > 1 && needed <= max_pieces_per_segment * segments, "the number of pieces stays bounded");
    return with_room(needed);
  }

  Result<Track> time(const Path& path, const ArcLength& arc_length) {
    if (!move_.key_frames.empty()) {
      key_intervals_.resize(static_cast<std::size_t>(path.segment_count()));
      return Track::make_with_key_frames(path, arc_length, move_.key_frames, move_.kinetic, move_.frames,
                                         move_.fps, {.key_intervals = key_intervals_});
    }
    std::vector<double> values = move_.control_values;
    if (values.size() == 1) values.push_back(values.front());
    const std::size_t f = values.size() - 1;
    spans_.resize(f);
    integrals_.resize(f + 1);
    const auto drawn = SpeedProfile::make(values, {spans_, integrals_}, move_.ends);
    if (!checked(drawn)) return drawn.error();
    if (move_.locks.empty()) {
      span_distances_.resize(f + 1);
      return Track::make(path, arc_length, *drawn, move_.frames, move_.fps, {span_distances_});
    }
    if (move_.frames > max_frames_here) return no_need();
    const auto timing = adjust(values, path, arc_length);
    if (!timing) return timing.error();
    return time_with_locks(path, arc_length, *timing);
  }

  Result<KeyTiming> adjust(const std::vector<double>& values, const Path& path, const ArcLength& arc_length) {
    for (std::int32_t i = 0; i <= path.segment_count(); ++i) {
      key_distances_.push_back(arc_length.segment_begin(i).high);
    }
    const std::size_t rows = move_.locks.size() + 1;
    for (std::vector<double>* part : {&adjusted_, &drawn_, &mobility_, &ceiling_}) part->resize(max_values);
    locks_.resize(rows + 1);
    targets_.resize(rows);
    multipliers_.resize(4 * rows);
    rows_.resize(rows);
    lock_weights_.resize(lock_weight_count(move_.locks.size(), max_values));
    matrix_.resize(lock_entry_count(move_.locks.size()));
    const auto timing = adjust_to_locks({.control_values = values,
                                         .key_distances = key_distances_,
                                         .locks = move_.locks,
                                         .frames = move_.frames},
                                        {adjusted_, drawn_, mobility_, ceiling_, locks_, targets_,
                                         multipliers_, rows_, lock_weights_, matrix_});
    if (!timing) {
      require(timing.error().what[0] != '\0' && timing.error().remedy[0] != '\0', "an error says what to do");
    }
    return timing;
  }

  Result<Track> time_with_locks(const Path& path, const ArcLength& arc_length, const KeyTiming& timing) {
    for (const KeyLock& lock : timing.locks) {
      const bool inside = lock.key > 0 && lock.key < path.segment_count();
      if (lock.breaks && inside) breaks_.push_back({lock.key, lock.frame});
    }
    const std::size_t f = timing.control_values.size() - 1;
    spans_.resize(f);
    integrals_.resize(f + 1);
    span_distances_.resize(f + 1);
    portions_.resize(breaks_.size() + 1);
    const auto profile = SpeedProfile::make(timing.control_values, {spans_, integrals_});
    require(profile.has_value(), "an adjusted curve is a speed curve");
    const auto track = Track::make_with_breaks(path, arc_length, *profile, move_.frames, move_.fps, breaks_,
                                               {span_distances_, portions_});
    if (!track) return track;
    for (const KeyLock& lock : timing.locks) {
      if (lock.knot >= 0) continue;  // met on a knot of the curve, which need not be a frame
      const double early = arc_length.segment_begin(lock.key).minus(track->distance({lock.frame, 0}));
      require(std::fabs(early) <= lock_tolerance * arc_length.total(), "a locked key is met on its frame");
    }
    return track;
  }

  void require_motion(const Track& track, const FrameTime& time) {
    std::vector<double> position(static_cast<std::size_t>(move_.axis_count));
    std::vector<AxisMotion> motion(position.size());
    track.positions(time, position);
    track.motion(time, motion);
    const AlongPath along = track.along(time);
    for (const double number : {along.speed, along.acceleration, along.jerk}) require_finite(number);
    for (std::size_t axis = 0; axis < position.size(); ++axis) {
      require_finite(position[axis]);
      require(motion[axis].position == position[axis], "the motion is at the position");
      require_finite(motion[axis].velocity);
      require_finite(motion[axis].acceleration);
      require_finite(motion[axis].jerk);
    }
  }

  void evaluate(const Track& track, std::int32_t first, std::int32_t last) {
    for (std::int32_t frame = first; frame <= last; ++frame) {
      for (const double fraction : {0.0, 0.375, 1 - std::numeric_limits<double>::epsilon()}) {
        require_motion(track, {frame, fraction});
      }
    }
  }

  void require_invariants(const Track& track, const FrameTable& table) {
    for (std::int32_t frame = 0; frame <= table.frames(); ++frame) {
      const FrameRow row = frame_row(track, table, frame);
      for (const double number : {row.alpha, row.point.t, row.distance, row.speed, row.acceleration}) {
        require_finite(number);
      }
      require(row.speed >= 0, "no speed is negative");
    }
    const Status invariants = check_invariants(track, table);
    if (!invariants) std::fprintf(stderr, "fuzz: frame %d\n", invariants.error().frame);
    require(invariants.has_value(), invariants ? "" : invariants.error().what);
  }

  void solve_closed_form(const Track& track) {
    std::vector<PathPoint> points(static_cast<std::size_t>(move_.frames) + 1);
    const auto table = closed_form_table(track, points);
    require(table.has_value(), "a track has a table in closed form");
    require_invariants(track, *table);
  }

  void solve_runge_kutta(const Track& track) {
    std::vector<PathPoint> points(static_cast<std::size_t>(move_.frames) + 1);
    const OdeOptions options{.substeps = move_.substeps};
    const auto table = runge_kutta_table(track, options, points);
    if (checked(table)) require_invariants(track, table->table);
  }

  static Error no_need() { return {.code = ErrorCode::out_of_range, .what = "too long", .remedy = "none"}; }

  /// Ten times what adjust_to_locks promises.
  static constexpr double lock_tolerance = 1e-11;

  const AnyMove& move_;
  std::vector<Cubic> cubics_;
  std::vector<double> weights_;
  std::vector<FrameKnot> knots_;
  std::vector<ArcPiece> pieces_;
  std::vector<double> begins_;
  std::vector<std::int32_t> buckets_;
  std::vector<std::int32_t> first_pieces_;
  std::vector<TwoSum> segment_begins_;
  std::vector<SpeedSpan> spans_;
  std::vector<TwoSum> integrals_;
  std::vector<SpanDistance> span_distances_;
  std::vector<Portion> portions_;
  std::vector<KeyInterval> key_intervals_;
  std::vector<BreakKey> breaks_;
  std::vector<double> key_distances_;
  std::vector<double> adjusted_, drawn_, mobility_, ceiling_, targets_, multipliers_, lock_weights_, matrix_;
  std::vector<LockRow> rows_;
  std::vector<KeyLock> locks_;
};

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedDataProvider bytes(data, size);
  const inbetween::AnyMove move = inbetween::MoveFromBytes(bytes).draw();
  inbetween::MoveUnderTest(move).run();
  return 0;
}
