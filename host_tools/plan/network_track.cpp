#include "host_tools/plan/network_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

[[noreturn]] void refuse_curve(const MoveTrack& track, const DrawnAxis& drawn, const Error& error) {
  const auto point = static_cast<std::size_t>(std::max(error.key, 0));
  const std::string frame =
      error.key < 0 ? "" : fmt::format(", frame {}", drawn.frames[std::min(point, drawn.frames.size() - 1)]);
  throw InputError(drawn.places[std::min(point, drawn.places.size() - 1)],
                   fmt::format("the curve of axis {}{}: {}; {}", in_quotes(coordinates_of(track)[drawn.axis]),
                               frame, error.what, error.remedy));
}

[[noreturn]] void refuse_gap(const MoveTrack& track, const NetworkGap& gap) {
  const DrawnAxis& drawn = track.network->drawn[gap.curve];
  const MoveKey& key = track.keys[gap.key];
  const auto [at_key, at_curve] = told_apart(gap.at_key, gap.drawn, Digits::significant, 6);
  throw InputError(
      drawn.axis < key.at_places.size() ? key.at_places[drawn.axis] : key.place,
      fmt::format("frame {}: key {} has axis {} at {}, and its drawn curve is at {}, {:.3g} away; leave the "
                  "axis out of the key, or draw the curve through it",
                  *key.frame, gap.key, in_quotes(coordinates_of(track)[drawn.axis]), at_key, at_curve,
                  std::fabs(gap.at_key - gap.drawn)));
}

}  // namespace

void settle_left_out(MoveTrack& track) {
  const RestingEnds rest = track.rest.value_or(RestingEnds{});
  for (const DrawnAxis& drawn : track.network->drawn) {
    const auto is_left_out = [&](const MoveKey& key) {
      return !key.is_left_out.empty() && key.is_left_out[drawn.axis];
    };
    if (std::ranges::none_of(track.keys, is_left_out)) continue;
    try {
      const FrameSpline curve(drawn.frames, drawn.at, 1, rest.start, rest.end);
      for (MoveKey& key : track.keys) {
        if (is_left_out(key)) key.at[drawn.axis] = curve.value(key.frame.value());
      }
    } catch (const SolverError& refused) {
      refuse_curve(track, drawn, refused.error());
    }
  }
}

CubicsOverFrames network_of(const MoveTrack& track, const TrackSpec& spec) {
  const MoveNetwork& network = *track.network;
  std::vector<NetworkCurve> curves;
  for (const DrawnAxis& drawn : network.drawn) curves.push_back({drawn.axis, drawn.frames, drawn.at});
  const std::size_t rows = is_row_of_points(track) ? world_coordinates : 1;
  std::vector<double> places;  // of each coordinate
  for (const double place : network.places) places.insert(places.end(), rows, place);
  try {
    const Network solved({.keys = spec.path.keys,
                          .key_frames = spec.key_frames,
                          .places = places,
                          .curves = curves,
                          .rests_at_start = spec.rests_at_start,
                          .rests_at_end = spec.rests_at_end,
                          .rows = rows});
    if (const auto gap = solved.gap()) refuse_gap(track, *gap);
    if (solved.segments() > max_network_segments) {
      throw InputError(network.place,
                       fmt::format("the frames of keys and curves cut the network into {} pieces, and {} are "
                                   "allowed; draw fewer points, or the curves on the same frames",
                                   solved.segments(), max_network_segments));
    }
    return solved.path();
  } catch (const CurveError& refused) {
    refuse_curve(track, network.drawn[refused.curve()], refused.error());
  }
}

}  // namespace inbetween
