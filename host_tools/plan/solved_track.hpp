#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "host_tools/plan/ode_frame_table.hpp"
#include "host_tools/plan/waypoints.hpp"
#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"

/// The core's track with memory from the heap, as large as it needs to be.

namespace inbetween {

/// Locked keys, holds and touches may refine a drawn curve up to this many control values: three doublings of
/// the longest curve that a file holds. The memory of a solution grows with them.
inline constexpr std::size_t max_lock_values = 16385;

/// An error of the core on its way through code that uses exceptions.
class SolverError : public std::runtime_error {
 public:
  explicit SolverError(const Error& error);
  [[nodiscard]] const Error& error() const { return error_; }

 private:
  Error error_;
};

/// The value of a result. Throws SolverError if it is an error.
template <class T>
const T& value_or_throw(const Result<T>& result) {
  if (!result) throw SolverError(result.error());
  return *result;
}

struct TrackSpec {
  PathSpec path;
  /// In its place a path that is solved already, through as many keys.
  std::optional<CubicPathSpec> cubics = {};
  std::span<const double> control_values;
  CurveEnds ends = CurveEnds::natural;
  std::int32_t frames = 0;
  FrameRate fps;
  ArcLengthOptions arc_length;
  /// Keys with a frame, a hold or a break, in the order of the keys.
  std::span<const KeyLock> locks = {};
  /// Instead of control values: a frame for every key (of a closed path one more).
  std::span<const std::int32_t> key_frames = {};
  Kinetic kinetic = Kinetic::linear;
  /// Instead of `kinetic`: the smoothest speed curve that meets the key frames (smoothest_pace).
  bool pace = false;
  /// For curves and a pace: at rest at that end. The control values of a drawn curve say so themselves.
  bool rests_at_start = true;
  bool rests_at_end = true;
  /// The speed touches 0 wherever the path turns at once. Locks of a pace are its touches.
  bool ease_corners = false;
};

/// A path with memory of its own. Throws SolverError.
class PathOnHeap {
 public:
  explicit PathOnHeap(const PathSpec& spec);
  [[nodiscard]] const Path& path() const { return path_; }

 private:
  std::vector<double> weights_;
  std::vector<Cubic> cubics_;
  Path path_;
};

/// A path and its arc length with memory of their own, to which they refer. Throws SolverError.
class MeasuredPath {
 public:
  explicit MeasuredPath(const TrackSpec& spec);
  MeasuredPath(const MeasuredPath&) = delete;
  MeasuredPath& operator=(const MeasuredPath&) = delete;

  [[nodiscard]] const Path& path() const { return *path_; }
  [[nodiscard]] const ArcLength& arc_length() const { return *arc_length_; }

 private:
  [[nodiscard]] Path make_path(const TrackSpec& spec);
  [[nodiscard]] ArcLength make_arc_length(const ArcLengthOptions& options);

  std::vector<Cubic> cubics_;
  std::vector<double> weights_;
  std::vector<FrameKnot> knots_;
  std::vector<ArcPiece> pieces_;
  std::vector<double> begins_;
  std::vector<std::int32_t> buckets_;
  std::vector<std::int32_t> first_pieces_;
  std::vector<TwoSum> segment_begins_;
  std::optional<Path> path_;
  std::optional<ArcLength> arc_length_;
};

/// Path, arc length, speed profile, track and frame table of one spec. Movable, not copyable: its
/// parts refer to its memory, which a move does not displace.
class SolvedTrack {
 public:
  /// `same_keys`, if there is one, is solved from the same keys, of which only the frames may differ: its
  /// path is shared where that does not depend on them. Throws SolverError.
  SolvedTrack(const TrackSpec& spec, Solver solver, const OdeOptions& ode = {},
              const SolvedTrack* same_keys = nullptr);
  SolvedTrack(SolvedTrack&&) noexcept = default;
  SolvedTrack& operator=(SolvedTrack&&) noexcept = default;

  [[nodiscard]] const Track& track() const { return *track_; }
  [[nodiscard]] const FrameTable& table() const { return *table_; }
  /// How table() came about by integration; nothing where it is in closed form.
  [[nodiscard]] const std::optional<OdeTable>& integrated() const { return integrated_; }
  /// The f + 1 control values that are played: the drawn ones, or what the locks made of them.
  [[nodiscard]] const std::vector<double>& control_values() const { return control_values_; }
  /// The changes of the drawn curve by its locks; nothing without locks other than breaks.
  [[nodiscard]] const std::optional<KeyTiming>& key_timing() const { return key_timing_; }

 private:
  [[nodiscard]] Track make_track(const TrackSpec& spec);
  /// Fills control_values_, and breaks_ with the locks that are breaks.
  void apply_locks(const TrackSpec& spec);
  void apply_pace(const TrackSpec& spec);
  void find_waypoints(const TrackSpec& spec);
  [[nodiscard]] SpeedProfile make_profile(std::span<const double> control_values, CurveEnds ends);

  std::shared_ptr<const MeasuredPath> measured_;
  std::vector<Waypoint> waypoints_;  ///< empty where nobody has asked for them
  std::vector<SpeedSpan> spans_;
  std::vector<TwoSum> integrals_;
  std::vector<SpanDistance> span_distances_;
  std::vector<Portion> portions_;
  std::vector<KeyInterval> key_intervals_;
  std::vector<double> control_values_;
  std::vector<BreakKey> breaks_;
  std::vector<KeyLock> completed_locks_;
  std::optional<KeyTiming> key_timing_;
  std::vector<PathPoint> points_;
  std::optional<Track> track_;
  std::optional<FrameTable> table_;
  std::optional<OdeTable> integrated_;
};

}  // namespace inbetween
