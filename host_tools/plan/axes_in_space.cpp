#include "host_tools/plan/axes_in_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <numeric>

#include "host_tools/numerics/hypotenuse.hpp"
#include "host_tools/plan/frame_of_distance.hpp"

namespace inbetween {
namespace {

/// Below this share of the rig's best, a direction is lost: the axes would move ten thousand times as fast.
/// SpaceTrack.APathThatEndsBesideASingularPlaceIsRefused has a path that ends nearer to one than this.
constexpr double singular_share = 1e-4;
/// Places between two keys at which the worst of what is out of reach is sought, for the message alone.
constexpr int places_between_keys = 64;
/// What an axis may be beyond its range by rounding, as a share of the range. Below it an axis that is keyed
/// at its limit would be refused by rounding.
constexpr double range_rounding = 1e-9;

/// The length of some rows of a path, as a sum of chords.
double rough_length(const Path& path, const std::vector<std::size_t>& rows) {
  double sum = 0;
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    for (int k = 0; k < chords_between_keys; ++k) {
      double chord = 0;
      for (const std::size_t row : rows) {
        const Cubic& c = path.segment(i)[row];
        chord = hypotenuse(chord, c.value((k + 1.0) / chords_between_keys) -
                                      c.value(k / static_cast<double>(chords_between_keys)));
      }
      sum += chord;
    }
  }
  return sum;
}

}  // namespace

SpaceRows::SpaceRows(const MoveSpace& space) {
  const auto take = [&](bool is_there, std::size_t numbers) {
    std::vector<std::size_t> rows;
    if (is_there) rows = rows_from(count, numbers);
    count += rows.size();
    return rows;
  };
  at = take(space.has_at, 3);
  aim = take(space.has_aim, 3);
  roll = take(space.has_roll, 1);
  if (!space.fixed_aim.empty()) aim = take(true, 3);
}

const Tip& tip_named(const std::string& name, const Place& place, const Kinematics& kinematics) {
  const auto tip = std::ranges::find(kinematics.tips(), name, &Tip::name);
  if (tip != kinematics.tips().end()) return *tip;
  std::vector<std::string> known;
  for (const Tip& one : kinematics.tips()) known.push_back(one.name);
  throw InputError(place,
                   fmt::format("the rig has no tip {}; it has {}", in_quotes(name), comma_separated(known)));
}

std::vector<std::size_t> coordinates_for(const MoveTrack& track, const Tip& tip, const Place& place,
                                         const Kinematics& kinematics, const RigFile& rig) {
  std::vector<std::size_t> coordinates;
  for (const std::string& axis : track.axes) {
    coordinates.push_back(
        static_cast<std::size_t>(std::ranges::find(rig.axes, axis, &RigAxis::name) - rig.axes.begin()));
  }
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const bool moves = kinematics.tree().moves(static_cast<std::int32_t>(a), tip.link);
    const auto own = std::ranges::find(coordinates, a);
    if (moves && own == coordinates.end()) {
      throw InputError(place, fmt::format("axis {} moves {} and is not in this track; add it to axes",
                                          in_quotes(rig.axes[a].name), in_quotes(tip.name)));
    }
    if (moves || own == coordinates.end() || !track.space) continue;
    throw InputError(track.axis_places[static_cast<std::size_t>(own - coordinates.begin())],
                     fmt::format("axis {} does not move {}; give it a track of its own",
                                 in_quotes(rig.axes[a].name), in_quotes(tip.name)));
  }
  return coordinates;
}

std::vector<std::size_t> rows_from(std::size_t first, std::size_t count) {
  std::vector<std::size_t> rows(count);
  std::iota(rows.begin(), rows.end(), first);
  return rows;
}

bool is_c2(const MoveTrack& track) {
  return track.spline == Spline::smooth && track.overshoot;
}

AxesInSpace::AxesInSpace(const MoveTrack& track, const Track& drawn, const Kinematics& kinematics,
                         const RigFile& rig, const std::optional<Vector3>& aim)
    : track_(track),
      space_(*track.space),
      drawn_(drawn),
      rig_(rig),
      kinematics_(kinematics),
      tip_(tip_named(space_.tips.front(), space_.place, kinematics)),
      rows_(space_),
      coordinates_(coordinates_for(track, tip_, space_.place, kinematics, rig)),
      solver_(kinematics, tip_.link, axes_of_rig()),
      aim_(aim) {
  set_elbow();
  rank_ = solver_.usual_rank(target({0, 0}));
}

FollowedPath AxesInSpace::follow() {
  const Path& path = drawn_.path();
  const Follower follower{
      .at = [this](const PathPoint& place) { return solve_at(place, place.segment == 0 && place.t == 0); },
      .slope = [this](const PathPoint& place) { return solver_.rates(target(place), rate(place), before_); },
      .has_slopes = is_determined()};
  if (!follower.has_slopes && !is_c2(track_)) {
    throw InputError(space_.place,
                     R"(the keys leave some of the axes free, which needs spline = "smooth" without )"
                     "overshoot = false; write that, or give the keys aim and roll");
  }
  const FollowLayout layout{.axes = rows_from(rows_.count, coordinates_.size()),
                            .guides = space_.has_at ? rows_.at : rows_.aim,
                            .position = rows_.at,
                            .aim = rows_.aim};
  const double length = std::max(rough_length(path, layout.guides), min_length);
  FollowedPath followed = followed_path(
      path, is_c2(track_), follower, layout, kinematics_, tip_.link, coordinates_,
      {.off_m = off_share * length}, [this](const FollowObstacle& obstacle) {
        refuse(obstacle.where,
               fmt::format("axis {} would have to move at once, because a singular place is near or the "
                           "solution goes no farther; lead the path round it",
                           name_of(obstacle.row)));
      });
  refuse_beyond_ranges(followed, [&](std::size_t step, double t) {
    const FrameKnot& knot = followed.knots[step];
    return PathPoint{knot.key, knot.parameter(t) - knot.key};
  });
  return followed;
}

std::vector<TipAxis> AxesInSpace::axes_of_rig() const {
  std::vector<TipAxis> axes;
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const RigAxis& axis = rig_.axes[coordinates_[i]];
    const std::optional<double> near = space_.near.empty() ? std::nullopt : space_.near[i];
    axes.push_back({coordinates_[i], axis.min, axis.max, near.value_or((axis.min + axis.max) / 2)});
  }
  return axes;
}

void AxesInSpace::set_elbow() {
  const bool is_arm = solver_.is_two_joint_arm() && rows_.aim.empty() && rows_.roll.empty() && !aim_;
  if (is_arm && !space_.elbow_up) {
    throw InputError(space_.place,
                     R"(an arm of two joints reaches every place with its elbow on either side; )"
                     R"(write elbow = "up" or elbow = "down")");
  }
  const bool is_said_of_others = track_.network.has_value();  // of the arms in its row
  if (!is_arm && space_.elbow_up && !is_said_of_others) {
    throw InputError(
        space_.elbow_place,
        fmt::format("elbow is for an arm of two parallel joints, the shoulder first, and {} hangs on "
                    "another; remove it, and say by near which solution is meant",
                    in_quotes(tip_.name)));
  }
  if (is_arm) solver_.set_elbow(*space_.elbow_up ? ElbowSide::left : ElbowSide::right);
}

std::string AxesInSpace::name_of(std::size_t axis) const {
  return in_quotes(track_.axes[axis]);
}

template <class Number>
TipTarget AxesInSpace::target_of(const Number& number, const std::optional<Vector3>& aim) const {
  const auto vector = [&](const std::vector<std::size_t>& rows) -> std::optional<Vector3> {
    if (rows.empty()) return std::nullopt;
    return Vector3{number(rows[0]), number(rows[1]), number(rows[2])};
  };
  TipTarget result{
      .position = vector(rows_.at), .aim = rows_.aim.empty() ? aim : vector(rows_.aim), .roll = {}};
  if (!rows_.roll.empty()) result.roll = number(rows_.roll[0]) * std::numbers::pi / 180;
  return result;
}

TipTarget AxesInSpace::target(const PathPoint& place) const {
  const std::span<const Cubic> cubics = drawn_.path().segment(place.segment);
  return target_of([&](std::size_t row) { return cubics[row].value(place.t); }, aim_);
}

TipTargetRate AxesInSpace::rate(const PathPoint& place) const {
  const std::span<const Cubic> cubics = drawn_.path().segment(place.segment);
  return target_of([&](std::size_t row) { return cubics[row].derivative(place.t); }, std::nullopt);
}

const std::vector<double>& AxesInSpace::at(const FrameTime& time, const std::optional<MovingPoint>& aim,
                                           bool is_first) {
  aim_.reset();
  if (aim) aim_ = aim->position;
  return solve_at(drawn_.locate(time), is_first);
}

std::vector<double> AxesInSpace::velocities(const FrameTime& time,
                                            const std::optional<MovingPoint>& aim) const {
  std::vector<AxisMotion> motion(rows_.count);
  std::optional<Vector3> aim_velocity;
  if (aim) aim_velocity = aim->velocity;
  static_cast<void>(drawn_.motion(time, motion));
  return solver_.rates(target(drawn_.locate(time)),
                       target_of([&](std::size_t row) { return motion[row].velocity; }, aim_velocity),
                       before_);
}

const std::vector<double>& AxesInSpace::solve_at(const PathPoint& place, bool is_first) {
  const TipTarget wanted = target(place);
  const TipSolution found = is_first ? solver_.solve_from_ranges(wanted) : solver_.solve(wanted, before_);
  if (!found.is_exact()) refuse_miss(place, found.positions);
  const TipSolver::Freedom freedom = solver_.freedom(wanted, found.positions, rank_);
  if (is_first) sign_ = freedom.sign;
  if (freedom.smallest < singular_share) refuse_singular(place, freedom.weak_axis);
  if (freedom.sign != sign_) refuse_singular(place, weak_axis_between(wanted, before_, found.positions));
  before_ = found.positions;
  return before_;
}

std::size_t AxesInSpace::weak_axis_between(const TipTarget& wanted, const std::vector<double>& before,
                                           const std::vector<double>& behind) const {
  std::vector<double> middle;
  for (std::size_t i = 0; i < before.size(); ++i) middle.push_back((before[i] + behind[i]) / 2);
  return solver_.freedom(wanted, middle, rank_).weak_axis;
}

void AxesInSpace::refuse(const PathPoint& place, const std::string& problem) const {
  const auto passed = static_cast<std::size_t>(drawn_.path().parameter(place));
  const std::size_t key = std::min(passed, track_.keys.size() - 1);
  const double distance = drawn_.arc_length().distance(drawn_.path(), place).high;
  throw InputError(track_.keys[key].place, fmt::format("frame {:.2f}, {:.4g} m along the path: {}",
                                                       frame_of_place(drawn_, place), distance, problem));
}

void AxesInSpace::refuse_singular(const PathPoint& place, std::size_t axis) const {
  refuse(place,
         fmt::format("{} is in a singular place, where it cannot follow every direction and axis {} may be "
                     "anything; lead the path round it",
                     in_quotes(tip_.name), name_of(axis)));
}

void AxesInSpace::refuse_miss(const PathPoint& place, const std::vector<double>& nearest) const {
  PathPoint worst = place;
  TipSolution miss{.positions = nearest};
  for (int i = 0; i <= places_between_keys && place.segment < drawn_.path().segment_count(); ++i) {
    const PathPoint other{place.segment, static_cast<double>(i) / places_between_keys};
    const TipSolution found = solver_.solve(target(other), miss.positions);
    if (found.is_exact() || found.miss_m + found.miss_rad <= miss.miss_m + miss.miss_rad) continue;
    miss = found;
    worst = other;
  }
  if (miss.miss_m == 0 && miss.miss_rad == 0) miss = solver_.solve(target(place), nearest);
  const TipSolver::Freedom freedom = solver_.freedom(target(worst), miss.positions, coordinates_.size());
  const std::size_t axis = solver_.is_two_joint_arm() ? 1 : freedom.weak_axis;
  if (miss.miss_m > TipSolution::max_miss) {
    refuse(worst,
           fmt::format("{} cannot get there: the place is {:.4g} mm beyond what axis {} lets it reach; bring "
                       "it nearer",
                       in_quotes(tip_.name), miss.miss_m * 1000, name_of(axis)));
  }
  if (solver_.is_two_joint_arm()) refuse_singular(worst, 0);
  refuse(worst,
         fmt::format("{} cannot look there: it is {:.4g} deg off, and axis {} is what stops it; change aim "
                     "or roll",
                     in_quotes(tip_.name), miss.miss_rad * 180 / std::numbers::pi, name_of(axis)));
}

void AxesInSpace::refuse_beyond_ranges(
    const FollowedPath& path, const std::function<PathPoint(std::size_t step, double t)>& place_of) const {
  constexpr int samples = 8;  // of a cubic that is one of many parts between two keys
  const std::size_t rows = path.weights.size();
  double worst = range_rounding;
  std::size_t axis_of_worst = 0;
  double position_of_worst = 0;
  PathPoint place;
  for (std::size_t i = 0; i < path.cubics.size(); ++i) {
    const std::size_t d = i % rows;
    if (d >= coordinates_.size()) continue;
    const RigAxis& axis = rig_.axes[coordinates_[d]];
    for (int k = 0; k <= samples; ++k) {
      const double t = static_cast<double>(k) / samples;
      const double position = path.cubics[i].value(t);
      const double beyond = std::max(position - axis.max, axis.min - position) / (axis.max - axis.min);
      if (!(beyond > worst)) continue;
      worst = beyond;
      axis_of_worst = d;
      position_of_worst = position;
      place = place_of(i / rows, t);
    }
  }
  if (worst <= range_rounding) return;
  const RigAxis& axis = rig_.axes[coordinates_[axis_of_worst]];
  const bool is_above = position_of_worst > axis.max;
  const std::string_view unit = to_string(axis.unit);
  refuse(
      place,
      fmt::format("axis {} would have to go to {:.6g} {}, {:.4g} {} beyond its {} = {}; change the keys, or "
                  "say by near or elbow that another solution is meant",
                  name_of(axis_of_worst), position_of_worst, unit,
                  is_above ? position_of_worst - axis.max : axis.min - position_of_worst, unit,
                  is_above ? "max" : "min", is_above ? axis.max : axis.min));
}

}  // namespace inbetween
