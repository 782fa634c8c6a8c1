#include "tests/support/solved_move.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

Spline spline_of(oracle::Kind kind) {
  switch (kind) {
    case oracle::Kind::smooth:
      return Spline::smooth;
    case oracle::Kind::catmull_rom:
      return Spline::catmull_rom;
    case oracle::Kind::tcb:
      return Spline::tcb;
    case oracle::Kind::linear:
      return Spline::linear;
  }
  return Spline::smooth;
}

}  // namespace

TrackInput::TrackInput(const RandomMove& move) {
  for (const auto& key : move.keys.at) {
    for (const long double value : key) keys.push_back(static_cast<double>(value));
  }
  for (const long double weight : move.keys.weights) weights.push_back(static_cast<double>(weight));
  for (const auto& shape : move.keys.tension_continuity_bias) {
    shapes.push_back(
        {static_cast<double>(shape[0]), static_cast<double>(shape[1]), static_cast<double>(shape[2])});
  }
  for (const double value : move.speed) control_values.push_back(static_cast<double>(value));
  spec.path = {.spline = spline_of(move.keys.kind),
               .closed = move.keys.closed,
               .axis_count = static_cast<std::int32_t>(move.keys.at.front().size()),
               .keys = keys,
               .weights = weights,
               .shapes = shapes};
  spec.control_values = control_values;
  spec.frames = move.frames;
  spec.fps = {24, 1};
}

SolvedTrack solve(const RandomMove& move, const ArcLengthOptions& arc_length) {
  TrackInput input(move);
  input.spec.arc_length = arc_length;
  return {input.spec, Solver::closed_form};
}

std::vector<std::pair<int, double>> oracle_places(const Track& track, const FrameTable& table) {
  const std::int32_t segments = track.path().segment_count();
  std::vector<std::pair<int, double>> places;
  for (const PathPoint& point : table.points()) {
    if (point.segment < segments) {
      places.emplace_back(point.segment, std::clamp(static_cast<double>(point.t), 0.0, 1.0));
    } else {
      places.emplace_back(std::max(segments - 1, 0), segments > 0 ? 1.0 : 0.0);
    }
  }
  return places;
}

std::optional<std::vector<oracle::MetKey>> met_keys(const RandomMove& move, const SolvedTrack& solved) {
  const std::vector<double>& values = solved.control_values();
  const auto f = static_cast<int>(values.size()) - 1;
  const oracle::Profile profile(values);
  const oracle::Path path(move.keys);
  std::vector<oracle::MetKey> met;
  long double before = 0;
  for (std::size_t i = 0; i < move.times.size(); ++i) {
    const auto key = static_cast<int>(i);
    if (i > 0) before += path.length(key - 1, 0, 1);
    if (move.times[i].break_frame >= 0) {
      met.push_back({key, static_cast<long double>(move.times[i].break_frame) * f / move.frames});
    }
    if (move.times[i].hold == 0) continue;
    std::optional<int> rest;
    for (int knot = 1; knot < f && !rest; ++knot) {
      const auto v = static_cast<std::size_t>(knot);
      const long double share = profile.integral(knot) / profile.integral(f);
      const bool is_here = std::fabs(share - before / path.total_length()) < 1e-9L;
      if (values[v - 1] == 0 && values[v] == 0 && values[v + 1] == 0 && is_here) rest = knot;
    }
    if (!rest) return std::nullopt;
    // Of keys in one place the first.
    if (met.empty() || path.travelled({met.back().key, 0}, {key, 0}) > 0) {
      met.push_back({key, static_cast<long double>(*rest)});
    }
  }
  return met;
}

}  // namespace inbetween
