#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "base/interval.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/timing/track.hpp"
#include "time_pieces.hpp"

/// Velocity, acceleration and jerk of every axis of a track over a short stretch of time, enclosed. The
/// method is that of bound_motion (motion_bounds.hpp); what is done with the enclosures is up to the caller.

namespace inbetween {

/// Rounding of a bound as a whole, and of the place in time at which the factors of a product are taken: a
/// bound that is made of enclosures is multiplied by 1 and this.
template <Precise Real>
inline constexpr Real bound_rounding = std::numeric_limits<Real>::digits > 30 ? Real(1e-6) : Real(1e-3);

/// One factor and its derivatives: T, T', T'' along the path, or w, w', w'' in time.
template <class Number>
struct MotionFactor {
  std::array<Centred<Number>, motion_quantities> part;
  Interval<Number> third_slope = {};  ///< T''' along the path
  Number rounding{};                  ///< of T'' in the middle
};

/// 1 / b of a number b above 0: in the middle of a box, and anywhere on it.
template <Precise Real>
struct Reciprocal {
  Real value = 0;
  Interval<Real> range = {};
};

/// A part of a stretch: `x` in its middle and tau there.
template <Precise Real>
struct MotionBox {
  Real begin = 0, end = 1;
  Real tau_begin = 0, tau_end = 0;
  Real x = 0;
  Real tau = 0;

  /// The box that has nothing but its middle.
  [[nodiscard]] MotionBox middle() const { return {x, x, tau, tau, x, tau}; }
};

/// The numbers that the axes have in common on a box.
template <Precise Real>
struct MotionSurroundings {
  Real tau = 0;
  Real tau_radius = 0;
  Real seconds = 0;             ///< from the middle to the further end
  Centred<Real> speed_squared;  ///< of the path: q, or q / tau^2 where it stands still at tau = 0
  /// What the numerators of an axis' derivatives by distance are multiplied with: q^(-1/2), q^-2, q^(-7/2).
  std::array<Reciprocal<Real>, motion_quantities> by_distance = {};
  MotionFactor<Real> speed;
  /// What T''', T'', T' and T are multiplied with in the derivative of the jerk by time.
  std::array<Interval<Real>, 4> jerk_change = {};
  Interval<Real> by_distance_slope = {};  ///< 7/2 q' / q
  Interval<Real> by_fourth = {};          ///< q^-4
  Real jerk_seconds =
      std::numeric_limits<Real>::infinity();  ///< as `seconds`, where the jerk may be taken from the middle
  Real pace = 0;                              ///< speed / tau, of a piece that stands still at tau = 0
  Interval<Real> pace_range = {};
};

template <Precise Real>
Interval<Real> not_negative(Interval<Real> range) {
  range.low = std::max(range.low, Real(0));
  return range;
}

/// What all axes that turn as one pace says have in common in their products on a box.
template <Precise Real>
struct SpeedRanges {
  Interval<Real> speed, change, second;
  Interval<Real> pace_speed, pace_change, cube;  ///< pace * speed, pace * change, pace^3

  SpeedRanges() = default;
  SpeedRanges(const MotionFactor<Real>& factor, const Interval<Real>& pace)
      : speed(factor.part[0].range()),
        change(factor.part[1].range()),
        second(factor.part[2].range()),
        pace_speed(pace * not_negative(speed)),
        pace_change(pace * change),
        cube{pace.low * pace.low * pace.low, pace.high * pace.high * pace.high} {}
  /// Where the pace is the speed.
  explicit SpeedRanges(const MotionFactor<Real>& factor)
      : SpeedRanges(factor, not_negative(factor.part[0].range())) {}

  [[nodiscard]] bool is_rest() const { return speed.low == 0 && speed.high == 0; }
};

/// One axis on a box, in axis units and seconds, or a lane of axes.
template <class Number>
struct MotionRange {
  std::array<Number, motion_quantities> here;   ///< in the middle
  std::array<Number, motion_quantities> bound;  ///< of the magnitude anywhere on the box; infinity: none
};

/// A number of each quantity of the motion, for a group of axes.
template <Precise Real>
using GroupTriple = std::array<Group<Real>, motion_quantities>;
inline constexpr std::size_t max_axis_groups = max_bounded_axes / group_size;

/// One axis of a group.
template <Precise Real>
MotionTriple<Real> lane_of(const GroupTriple<Real>& group, std::size_t i) {
  return {lane_of(group[0], i), lane_of(group[1], i), lane_of(group[2], i)};
}
template <Precise Real>
void set_lane(GroupTriple<Real>& group, std::size_t i, const MotionTriple<Real>& values) {
  for (std::size_t k = 0; k < motion_quantities; ++k) set_lane(group[k], i, values[k]);
}

/// The numerators of AxisTurn, of a lane of axes.
template <Precise Real>
struct TurnLanes {
  std::array<WideLanes<Real>, 3> first{};
  std::array<WideLanes<Real>, 5> second{};
  std::array<WideLanes<Real>, 8> third{};
  WideLanes<Real> steepest{};
  WideLanes<Real> size{};
  WideLanes<Real> bend{};  ///< above 0 where the axis is not straight
};

/// The derivative of a row on a piece, as a quadratic in tau, and the size of its terms.
template <Precise Real>
struct ScaledSlope {
  std::array<Real, 3> first{};
  Real size = 0;
};

/// Usage: show(path) for the piece of the path, around(...) for the box, range(d, ...) for each axis. Refers
/// to the track and to `turns`, an entry for each axis.
///
/// Where the path stands still, dP/dL turns without bound, as 1 / tau, and its derivative as 1 / tau^3; in
/// the motion they are multiplied with powers of the speed, which vanishes at a rest. There they are taken as
/// products with speed / tau, which is bounded: from speed ~ x^k follows distance ~ x^(k + 1) ~ tau^2.
template <Precise Real>
class MotionEnclosure {
 public:
  MotionEnclosure(const Track<Real>& track, std::span<AxisTurn<Real>> turns)
      : track_(track),
        axes_(static_cast<std::size_t>(track.path().axis_count())),
        turns_(turns.first(axes_)) {}

  /// All calls that follow are about this piece of the path. O(axes^2), nothing if it is the one of before.
  void show(const PathPiece<Real>& piece);

  /// The surroundings of a single moment.
  [[nodiscard]] MotionSurroundings<Real> at(const Stretch<Real>& stretch, Real x, Real tau) const;
  [[nodiscard]] MotionSurroundings<Real> around(const Stretch<Real>& stretch,
                                                const MotionBox<Real>& box) const;

  /// The motion of an axis in the middle of a box, and how far it can be from that on the box. O(1).
  [[nodiscard]] MotionRange<Real> range(std::size_t d, const MotionSurroundings<Real>& box) const;
  /// Calls visit(group, triple) for every group of axes: of each of them range(d, box).here.
  template <class Visit>
  void middles(const MotionSurroundings<Real>& box, const Visit& visit) const {
    const bool is_in_lanes = lanes_are_quick && !is_still_;
    for (std::size_t begin = 0; begin < axes_; begin += group_size) {
      GroupTriple<Real> group{};
      if (is_in_lanes) here_in_lanes(begin / group_size, box, group);
      for (std::size_t i = 0; i < group_size && begin + i < axes_; ++i) {
        if (!is_in_lanes || turns_[begin + i].straight) set_lane<Real>(group, i, here(begin + i, box));
      }
      visit(begin / group_size, group);
    }
  }
  /// Calls visit(group, open, range) for every group with axes whose bits are set, `open`: of these
  /// range(d, box), of the others 0.
  template <class Visit>
  void ranges(std::uint64_t axes, const MotionSurroundings<Real>& box, const Visit& visit) const {
    const bool is_in_lanes = lanes_are_quick && is_regular(box);
    const SpeedRanges<Real> of_speed = is_in_lanes ? SpeedRanges<Real>(box.speed) : SpeedRanges<Real>();
    for (std::size_t begin = 0; begin < axes_; begin += group_size) {
      const std::uint64_t open = axes >> begin & ((std::uint64_t{1} << group_size) - 1);
      if (open == 0) continue;
      MotionRange<Group<Real>> group{};
      if (is_in_lanes) range_in_lanes(begin / group_size, box, of_speed, group);
      for (std::size_t i = 0; i < group_size && begin + i < axes_; ++i) {
        const bool is_open = (open >> i & 1) != 0;
        if (is_in_lanes && is_open && !turns_[begin + i].straight) continue;
        const MotionRange<Real> axis = is_open ? range(begin + i, box) : MotionRange<Real>{};
        set_lane<Real>(group.here, i, axis.here);
        set_lane<Real>(group.bound, i, axis.bound);
      }
      visit(begin / group_size, open, group);
    }
  }

  /// Inside a segment the path stands still and is passed at a speed, at x = 0 of this stretch: the direction
  /// turns to its opposite.
  [[nodiscard]] bool turns_back(const Stretch<Real>& stretch) const;
  /// ... which is a step of this axis.
  [[nodiscard]] bool steps_where_it_turns_back(std::size_t d) const { return turns_[d].first[1] != 0; }

 private:
  using Triple = MotionTriple<Real>;
  using Factor = MotionFactor<Real>;
  static constexpr std::size_t lanes = lane_count;

  [[nodiscard]] ScaledSlope<Real> slope_of(const Cubic<Real>& c, const PathPiece<Real>& piece) const;
  /// Returns the slope of an axis. The rows behind the axes are guides.
  [[nodiscard]] ScaledSlope<Real> slope(std::size_t row) const {
    if (row < axes_) return {turns_[row].first, turns_[row].size};
    return guides_[row - axes_];
  }
  void show_parameter(std::span<const Cubic<Real>> cubics);
  void turn(std::size_t d);
  void turn_in_lanes(std::size_t group);
  void turn_where_still(std::size_t d);
  void find_direction(std::size_t d);
  void fill_lanes();
  /// Whether no axis is a special case on a box, but for those that go straight.
  [[nodiscard]] bool is_regular(const MotionSurroundings<Real>& box) const {
    return !is_still_ && box.by_distance[0].range.high <= std::numeric_limits<Real>::max() &&
           box.by_distance[1].range.high <= std::numeric_limits<Real>::max() &&
           box.by_distance[2].range.high <= std::numeric_limits<Real>::max();
  }
  [[nodiscard]] Triple here(std::size_t d, const MotionSurroundings<Real>& box) const;
  void here_in_lanes(std::size_t group, const MotionSurroundings<Real>& box, GroupTriple<Real>& out) const;
  void range_in_lanes(std::size_t group, const MotionSurroundings<Real>& box, const SpeedRanges<Real>& ranges,
                      MotionRange<Group<Real>>& out) const;
  void find_jerk_change(const Stretch<Real>& stretch, MotionSurroundings<Real>& box) const;
  void divide_by_distance(MotionSurroundings<Real>& box) const;
  /// The numerator of dP/dL, or that of it over tau.
  [[nodiscard]] std::array<Real, 3> first_of(std::size_t d) const {
    const std::array<Real, 3>& first = turns_[d].first;
    return turns_by_pace(d) ? std::array<Real, 3>{first[1], first[2], 0} : first;
  }
  /// The sign of d tau / d distance.
  [[nodiscard]] Real side() const { return shown_.interval.forward ? Real(1) : Real(-1); }
  [[nodiscard]] Factor time_factor(const TimePiece<Real>& time, Real x, Real radius) const;
  [[nodiscard]] Centred<Real> path_speed_squared(Real tau, Real radius) const;
  [[nodiscard]] Interval<Real> pace_range(const Stretch<Real>& stretch, const MotionBox<Real>& box,
                                          const MotionSurroundings<Real>& surroundings) const;
  [[nodiscard]] Interval<Real> pace_from_rest(const TimePiece<Real>& time, Real end,
                                              const Interval<Real>& speed_squared) const;
  [[nodiscard]] Real tau_rounding(const Stretch<Real>& stretch, Real tau) const;
  [[nodiscard]] Real steepest(std::size_t d) const;
  /// Whether the axis turns as `pace` says, and not as a power of the speed alone.
  [[nodiscard]] bool turns_by_pace(std::size_t d) const {
    return is_still_ && turns_[d].first[0] == 0 && !turns_[d].straight;
  }
  const Track<Real>& track_;
  std::size_t axes_;
  std::span<AxisTurn<Real>> turns_;
  std::array<ScaledSlope<Real>, max_guides> guides_{};
  std::array<TurnLanes<Real>, lanes_are_quick ? max_bounded_axes / lanes : 0> lanes_;  // filled for axes_
  PathPiece<Real> shown_{.segment = -1, .index = -1, .scale = 1, .interval = {}};
  Real scale_ = 1;
  Real inverse_scale_ = 1;
  bool is_still_ = false;  ///< at tau = 0
};

extern template class MotionEnclosure<double>;
extern template class MotionEnclosure<float>;

}  // namespace inbetween
