#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "inbetween/base/bisection.hpp"
#include "inbetween/timing/track.hpp"
#include "timing/lock_share.hpp"

/// When a track at a drawn speed passes a place of its path.

namespace inbetween {

inline double frame_of(const Track& track, const CurvePlace& place) {
  return (static_cast<double>(place.span) + place.t) * static_cast<double>(track.frames()) /
         static_cast<double>(track.profile().span_count());
}

/// The first time behind frame 0, to the last bit, at which `target` plus `offset` is travelled; the end
/// where it is not.
inline FrameTime first_time(const Track& track, const TwoSum& target, double offset) {
  const auto distance_beyond = [&](const FrameTime& time) {
    return track.distance(time).minus(target) - offset;
  };
  std::int32_t before = 0;
  std::int32_t reached = track.frames();
  while (reached - before > 1) {
    const std::int32_t middle = before + (reached - before) / 2;
    (distance_beyond({middle, 0}) >= 0 ? reached : before) = middle;
  }
  if (!(distance_beyond({reached, 0}) >= 0)) return {reached, 0};
  constexpr int halvings = std::numeric_limits<double>::digits;
  const auto beyond = [&](double fraction) { return distance_beyond({before, fraction}); };
  const auto is_before = [](double distance) { return !(distance >= 0); };
  const SpeedProfile& profile = track.profile();
  const std::int32_t first = track.place({before, 0}).span;
  const std::int32_t last = track.place({reached, 0}).span;
  double high = 1;
  if (track.portions().empty() && last <= first + 1) {
    const auto slope = [&](double fraction) {
      const CurvePlace place = track.place({before, fraction});
      return track.constant() * profile.span(place.span).value(place.t) *
             static_cast<double>(profile.span_count()) / static_cast<double>(track.frames());
    };
    const double distance =
        track.constant() * (profile.span(first).integral() + profile.span(last).integral());
    high = bisected_near_zero({0, 1}, halvings, distance_rounding * distance, beyond, slope, is_before).high;
  } else {
    high = bisected({0, 1}, halvings, [&](double fraction) { return is_before(beyond(fraction)); }).high;
  }
  return high < 1 ? FrameTime{before, high} : FrameTime{reached, 0};
}

/// The place of the speed curve at which a distance is reached. The curve is 0 only where a span begins or
/// ends, or all along one: of the places that are as near as a lock is, the slowest beginning of a span.
inline CurvePlace place_of_distance(const Track& track, const TwoSum& target) {
  const double margin = lock_share * track.arc_length().total();
  const CurvePlace first = track.place(first_time(track, target, -margin));
  const CurvePlace last = track.place(first_time(track, target, margin));
  if (first.span == last.span) return {first.span, first.t + (last.t - first.t) / 2};
  CurvePlace slowest{last.span, 0};
  for (std::int32_t span = last.span - 1; span > first.span; --span) {
    const SpeedProfile& profile = track.profile();
    if (profile.span(span).b0 < profile.span(slowest.span).b0) slowest.span = span;
  }
  return slowest;
}

inline bool has_length(const Track& track, std::int32_t segment) {
  return track.arc_length().segment_begin(segment + 1).minus(track.arc_length().segment_begin(segment)) > 0;
}

/// The constants with which the curve arrives at a place and leaves it, and the place itself: where a portion
/// begins there, that is its frame.
struct MetPlace {
  CurvePlace place;
  double arriving = 0;
  double leaving = 0;
};

inline MetPlace find_distance(const Track& track, const TwoSum& target) {
  const std::span<const Portion> portions = track.portions();
  if (portions.empty()) return {place_of_distance(track, target), track.constant(), track.constant()};
  const double margin = lock_share * track.arc_length().total();
  for (std::size_t i = 1; i < portions.size(); ++i) {
    const FrameTime begin{portions[i].begin_frame, 0};
    if (std::fabs(track.distance(begin).minus(target)) <= margin) {
      return {track.place(begin), portions[i - 1].constant, portions[i].constant};
    }
  }
  const CurvePlace place = place_of_distance(track, target);
  const double frame = frame_of(track, place);
  double constant = portions.front().constant;
  for (const Portion& portion : portions) {
    if (static_cast<double>(portion.begin_frame) <= frame) constant = portion.constant;
  }
  return {place, constant, constant};
}

}  // namespace inbetween
