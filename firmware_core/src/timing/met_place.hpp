#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "inbetween/base/bisection.hpp"
#include "inbetween/timing/track.hpp"
#include "timing/lock_share.hpp"

/// When a track at a drawn speed passes a place of its path.

namespace inbetween {

template <Precise Real>
Real frame_of(const Track<Real>& track, const CurvePlace<Real>& place) {
  return (static_cast<Real>(place.span) + place.t) * static_cast<Real>(track.frames()) /
         static_cast<Real>(track.profile().span_count());
}

/// The first time behind frame 0, to the last bit, at which `target` plus `offset` is travelled; the end
/// where it is not.
template <Precise Real>
FrameTime<Real> first_time(const Track<Real>& track, const TwoSum<Real>& target, Real offset) {
  const auto way_beyond = [&](const FrameTime<Real>& time) {
    return track.distance(time).minus(target) - offset;
  };
  std::int32_t before = 0;
  std::int32_t reached = track.frames();
  while (reached - before > 1) {
    const std::int32_t middle = before + (reached - before) / 2;
    (way_beyond({middle, 0}) >= 0 ? reached : before) = middle;
  }
  if (!(way_beyond({reached, 0}) >= 0)) return {reached, 0};
  constexpr int halvings = std::numeric_limits<Real>::digits;
  const auto beyond = [&](Real fraction) { return way_beyond({before, fraction}); };
  const auto is_before = [](Real way) { return !(way >= 0); };
  const SpeedProfile<Real>& profile = track.profile();
  const std::int32_t first = track.place({before, 0}).span;
  const std::int32_t last = track.place({reached, 0}).span;
  Real high = 1;
  if (track.portions().empty() && last <= first + 1) {
    const auto slope = [&](Real fraction) {
      const CurvePlace<Real> place = track.place({before, fraction});
      return track.constant() * profile.span(place.span).value(place.t) *
             static_cast<Real>(profile.span_count()) / static_cast<Real>(track.frames());
    };
    const Real way = track.constant() * (profile.span(first).integral() + profile.span(last).integral());
    high = bisected_near_zero<Real>({0, 1}, halvings, distance_rounding<Real> * way, beyond, slope, is_before)
               .high;
  } else {
    high = bisected<Real>({0, 1}, halvings, [&](Real fraction) { return is_before(beyond(fraction)); }).high;
  }
  return high < 1 ? FrameTime<Real>{before, high} : FrameTime<Real>{reached, 0};
}

/// The place of the speed curve at which a distance is reached. The curve is 0 only where a span begins or
/// ends, or all along one: of the places that are as near as a lock is, the slowest beginning of a span.
template <Precise Real>
CurvePlace<Real> place_of_distance(const Track<Real>& track, const TwoSum<Real>& target) {
  const Real margin = lock_share<Real> * track.arc_length().total();
  const CurvePlace<Real> first = track.place(first_time(track, target, -margin));
  const CurvePlace<Real> last = track.place(first_time(track, target, margin));
  if (first.span == last.span) return {first.span, first.t + (last.t - first.t) / 2};
  CurvePlace<Real> slowest{last.span, 0};
  for (std::int32_t span = last.span - 1; span > first.span; --span) {
    const SpeedProfile<Real>& profile = track.profile();
    if (profile.span(span).b0 < profile.span(slowest.span).b0) slowest.span = span;
  }
  return slowest;
}

template <Precise Real>
bool has_length(const Track<Real>& track, std::int32_t segment) {
  return track.arc_length().segment_begin(segment + 1).minus(track.arc_length().segment_begin(segment)) > 0;
}

/// The constants with which the curve arrives at a place and leaves it, and the place itself: where a portion
/// begins there, that is its frame.
template <Precise Real>
struct MetPlace {
  CurvePlace<Real> place;
  Real arriving = 0;
  Real leaving = 0;
};

template <Precise Real>
MetPlace<Real> find_distance(const Track<Real>& track, const TwoSum<Real>& target) {
  const std::span<const Portion<Real>> portions = track.portions();
  if (portions.empty()) return {place_of_distance(track, target), track.constant(), track.constant()};
  const Real margin = lock_share<Real> * track.arc_length().total();
  for (std::size_t i = 1; i < portions.size(); ++i) {
    const FrameTime<Real> begin{portions[i].begin_frame, 0};
    if (std::fabs(track.distance(begin).minus(target)) <= margin) {
      return {track.place(begin), portions[i - 1].constant, portions[i].constant};
    }
  }
  const CurvePlace<Real> place = place_of_distance(track, target);
  const Real frame = frame_of(track, place);
  Real constant = portions.front().constant;
  for (const Portion<Real>& portion : portions) {
    if (static_cast<Real>(portion.begin_frame) <= frame) constant = portion.constant;
  }
  return {place, constant, constant};
}

}  // namespace inbetween
