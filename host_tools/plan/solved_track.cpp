#include "host_tools/plan/solved_track.hpp"

#include <fmt/format.h>

namespace inbetween {
namespace {

/// At the default delta a segment takes about 20 pieces; what is missing is told by the core.
constexpr std::size_t usual_pieces_per_segment = 24;
/// Locked keys and holds may refine a drawn curve up to this many control values.
constexpr std::size_t max_refined_values = 4097;

}  // namespace

SolverError::SolverError(const Error& error)
    : std::runtime_error(fmt::format("{}: {}", error.what, error.remedy)), error_(error) {}

template <Precise Real>
SolvedTrack<Real>::SolvedTrack(const TrackSpec<Real>& spec, Solver solver, const OdeOptions<Real>& ode) {
  const Path<Real> path = make_path(spec.path);
  const ArcLength<Real> arc_length = make_arc_length(path, spec.arc_length);
  track_ = make_track(spec, path, arc_length);
  points_.resize(static_cast<std::size_t>(spec.frames) + 1);
  if (solver == Solver::closed_form) {
    table_ = value_or_throw(closed_form_table<Real>(*track_, points_));
  } else {
    std::vector<OdeSegment<Real>> segments(static_cast<std::size_t>(path.segment_count()) + 1);
    table_ = value_or_throw(runge_kutta_table<Real>(*track_, ode, segments, points_));
  }
}

template <Precise Real>
Track<Real> SolvedTrack<Real>::make_track(const TrackSpec<Real>& spec, const Path<Real>& path,
                                          const ArcLength<Real>& arc_length) {
  if (!spec.key_frames.empty()) {
    key_intervals_.resize(static_cast<std::size_t>(path.segment_count()));
    return value_or_throw(Track<Real>::make_with_key_frames(path, arc_length, spec.key_frames, spec.kinetic,
                                                            spec.frames, spec.fps,
                                                            {.key_intervals = key_intervals_}));
  }
  control_values_.assign(spec.control_values.begin(), spec.control_values.end());
  if (control_values_.size() == 1) control_values_.push_back(control_values_.front());
  if (!spec.locks.empty()) apply_locks(spec, arc_length);
  const SpeedProfile<Real> profile = make_profile(control_values_);
  span_distances_.resize(control_values_.size() + 1);
  portions_.resize(breaks_.size() + 1);
  return value_or_throw(
      Track<Real>::make_with_breaks(path, arc_length, profile, spec.frames, spec.fps, breaks_,
                                    {.span_distances = span_distances_, .portions = portions_}));
}

template <Precise Real>
void SolvedTrack<Real>::apply_locks(const TrackSpec<Real>& spec, const ArcLength<Real>& arc_length) {
  // The profile's own checks come first, so that a bad control value is named as such.
  static_cast<void>(make_profile(control_values_));
  std::vector<Real> key_distances;
  for (std::size_t i = 0; i < segment_begins_.size(); ++i) {
    key_distances.push_back(arc_length.segment_begin(static_cast<std::int32_t>(i)).high);
  }
  const std::size_t rows = spec.locks.size() + 1;
  std::vector<Real> adjusted(max_refined_values);
  std::vector<Real> drawn(max_refined_values);
  std::vector<Real> mobility(max_refined_values);
  std::vector<Real> ceiling(max_refined_values);
  std::vector<Real> targets(rows);
  std::vector<Real> multipliers(4 * rows);
  std::vector<Real> matrix(rows * rows);
  completed_locks_.resize(rows + 1);
  const KeyTimingSpec<Real> wishes{.control_values = control_values_,
                                   .key_distances = key_distances,
                                   .locks = spec.locks,
                                   .frames = spec.frames};
  KeyTiming<Real> timing = value_or_throw(adjust_to_locks<Real>(
      wishes, {adjusted, drawn, mobility, ceiling, completed_locks_, targets, multipliers, matrix}));
  control_values_.assign(timing.control_values.begin(), timing.control_values.end());
  timing.control_values = control_values_;
  key_timing_ = timing;
  const std::int32_t last_key = static_cast<std::int32_t>(key_distances.size()) - 1;
  for (const KeyLock& lock : timing.locks) {
    const bool inside = lock.key > 0 && lock.key < last_key;
    if (lock.breaks && inside) breaks_.push_back({lock.key, lock.frame});
  }
}

template <Precise Real>
Path<Real> SolvedTrack<Real>::make_path(const PathSpec<Real>& spec) {
  const auto axes = static_cast<std::size_t>(std::max(spec.axis_count, 1));
  cubics_.resize(spec.keys.size() + axes);
  weights_.resize(axes);
  return value_or_throw(Path<Real>::make(spec, {cubics_, weights_}));
}

template <Precise Real>
ArcLength<Real> SolvedTrack<Real>::make_arc_length(const Path<Real>& path,
                                                   const ArcLengthOptions<Real>& options) {
  const auto segments = static_cast<std::size_t>(path.segment_count());
  first_pieces_.resize(segments + 1);
  segment_begins_.resize(segments + 1);
  std::size_t pieces = usual_pieces_per_segment * std::max<std::size_t>(segments, 1);
  for (;;) {
    pieces_.resize(pieces);
    begins_.resize(pieces);
    buckets_.resize(pieces);
    const Result<ArcLength<Real>> result =
        ArcLength<Real>::make(path, options, {pieces_, begins_, buckets_, first_pieces_, segment_begins_});
    const bool too_small = !result && result.error().code == ErrorCode::capacity;
    if (!too_small) return value_or_throw(result);
    pieces = static_cast<std::size_t>(result.error().needed);
  }
}

template <Precise Real>
SpeedProfile<Real> SolvedTrack<Real>::make_profile(std::span<const Real> control_values) {
  spans_.resize(control_values.size() + 1);
  integrals_.resize(control_values.size() + 2);
  return value_or_throw(SpeedProfile<Real>::make(control_values, {spans_, integrals_}));
}

template class SolvedTrack<double>;
template class SolvedTrack<float>;

}  // namespace inbetween
