#include "host_tools/solved_track.hpp"

#include <fmt/format.h>

namespace inbetween {
namespace {

/// At the default delta a segment takes about 20 pieces; what is missing is told by the core.
constexpr std::size_t usual_pieces_per_segment = 24;

template <class T>
const T& value_or_throw(const Result<T>& result) {
  if (!result) throw SolverError(result.error());
  return *result;
}

}  // namespace

SolverError::SolverError(const Error& error)
    : std::runtime_error(fmt::format("{}: {}", error.what, error.remedy)), error_(error) {}

template <Precise Real>
SolvedTrack<Real>::SolvedTrack(const TrackSpec<Real>& spec, Solver solver, const OdeOptions<Real>& ode) {
  const Path<Real> path = make_path(spec.path);
  const ArcLength<Real> arc_length = make_arc_length(path, spec.arc_length);
  const SpeedProfile<Real> profile = make_profile(spec.control_values);
  span_distances_.resize(spec.control_values.size() + 1);
  track_ = value_or_throw(Track<Real>::make(path, arc_length, profile, spec.frames, spec.fps,
                                            {.span_distances = span_distances_}));
  points_.resize(static_cast<std::size_t>(spec.frames) + 1);
  if (solver == Solver::closed_form) {
    table_ = value_or_throw(closed_form_table<Real>(*track_, points_));
  } else {
    std::vector<OdeSegment<Real>> segments(static_cast<std::size_t>(path.segment_count()) + 1);
    table_ = value_or_throw(runge_kutta_table<Real>(*track_, ode, segments, points_));
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
    buckets_.resize(2 * pieces);
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
