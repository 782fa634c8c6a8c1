// A track of the page's move with memory of its own, solved as the program on the host solves it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween::editor {

inline constexpr std::size_t max_tracks = 8;
inline constexpr std::size_t max_keys = 1000;  ///< of a track
inline constexpr std::size_t max_axes = 16;    ///< of a track
inline constexpr std::size_t max_segments = 4 * max_keys;
inline constexpr std::size_t max_pieces = 32 * max_keys;  ///< of arc length: about 20 a segment
inline constexpr std::size_t max_values = 4097;           ///< that locked keys may refine a curve to
inline constexpr std::size_t max_locks = 200;
inline constexpr std::size_t max_table_frames = 50'000;

/// What a track is solved from. Every span may go when solve() returns.
struct TrackInput {
  PathSpec path;
  std::optional<CubicPathSpec> cubics;     ///< in place of `path`
  std::span<const double> control_values;  ///< empty with key_frames
  CurveEnds ends = CurveEnds::natural;
  std::span<const KeyLock> locks;
  std::span<const std::int32_t> key_frames;
  Kinetic kinetic = Kinetic::curves;
  std::int32_t frames = 1;
  FrameRate fps;
};

/// About 10 MB. Nothing of it moves once it is solved.
class TrackSlot {
 public:
  /// Errors: those of Path::make, ArcLength::make, adjust_to_locks, SpeedProfile::make, Track::make and
  /// closed_form_table; capacity where the track is larger than a slot. After an error the slot holds no
  /// track.
  Status solve(const TrackInput& input);

  [[nodiscard]] bool is_solved() const { return table_.has_value(); }
  [[nodiscard]] const Track& track() const { return *track_; }
  [[nodiscard]] const FrameTable& table() const { return *table_; }
  /// The control values that are played: the drawn ones, or what locked keys made of them. None of a track
  /// that is timed by frames.
  [[nodiscard]] std::span<const double> played_values() const { return played_; }
  /// The frame on which a key is met, where a rest begins: a locked one's own, and otherwise that on which
  /// the segment begins which is the key's.
  [[nodiscard]] double frame_of_key(std::int32_t key, std::int32_t segment) const;

 private:
  Result<Path> make_path(const TrackInput& input);
  Result<Track> make_track(const TrackInput& input, const Path& path, const ArcLength& arc_length);
  Status adjust(const TrackInput& input, const Path& path, const ArcLength& arc_length);

  std::array<Cubic, (max_segments + 1) * (max_axes + max_guides)> cubics_;
  std::array<double, max_axes + max_guides> weights_;
  std::array<FrameKnot, max_segments> knots_;
  ArcLengthStorage<max_segments, max_pieces> arc_length_;
  SpeedProfileStorage<max_values> profile_;
  std::array<SpanDistance, max_values> span_distances_;
  std::array<Portion, max_locks + 1> portions_;
  std::array<KeyInterval, max_segments> key_intervals_;
  std::array<double, max_segments + 1> distances_;
  KeyTimingStorage<max_locks, max_values> key_timing_;
  std::array<BreakKey, max_locks> breaks_;
  std::size_t break_count_ = 0;
  std::optional<KeyTiming> timing_;  ///< what locked keys made of the drawn curve
  std::array<PathPoint, max_table_frames + 1> points_;
  std::array<double, max_values> values_;
  std::span<const double> played_;
  std::optional<Track> track_;
  std::optional<FrameTable> table_;
};

}  // namespace inbetween::editor
