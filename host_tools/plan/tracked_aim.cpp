#include "host_tools/plan/tracked_aim.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host_tools/joints/tip_deviation.hpp"
#include "host_tools/joints/vector_length.hpp"
#include "host_tools/numerics/hypotenuse.hpp"
#include "host_tools/plan/frame_of_distance.hpp"
#include "host_tools/plan/row_spline.hpp"

namespace inbetween {
namespace {

/// 128 times the steps that most begin with (min_steps_per_frame): motion that needs more has a jump, and is
/// refused with a remedy.
constexpr std::int32_t max_steps_per_frame = 256;
/// Each step is a solution of the joints and a cubic for every axis, so that the bound is one of memory and
/// time. The refusal names it.
constexpr std::size_t max_time_steps = 200'000;
/// As on a path over its length: a tenth of what a crane's aim may be off (0.01 deg).
constexpr double max_aim_rad = FollowTolerance{}.aim_rad;
/// Half of what a speed may be off (1e-4).
constexpr double max_speed_share = 5e-5;
/// Between two keys: as many as a FrameKnot counts.
constexpr std::int32_t max_aim_parts = std::numeric_limits<std::int16_t>::max();

/// The cubic on one step that has these places and velocities (per step) at its ends.
Cubic between(double from, double velocity, double to, double end_velocity) {
  return {from, velocity, 3 * (to - from) - 2 * velocity - end_velocity,
          2 * (from - to) + velocity + end_velocity};
}

/// Half the second derivative at both ends.
std::array<double, 2> end_curvatures(const std::vector<Cubic>& cubics) {
  return {cubics.front().c2, cubics.back().second(1) / 2};
}

/// The spline through the values, but beside an end that rests: there the acceleration is 0 instead.
std::vector<Cubic> spline_with_rests(SplineRun run, bool rests_first, bool rests_last) {
  const std::array places{std::size_t{1}, run.values.size() - 2};
  const std::array rests{rests_first, rests_last};
  const std::array<double, 2> wrong = end_curvatures(spline_through(run));
  std::array<std::array<double, 2>, 2> effects{{{1, 0}, {0, 1}}};  // of a value beside an end
  std::array<double, 2> right{};
  for (std::size_t i = 0; i < 2; ++i) {
    if (!rests.at(i)) continue;
    SplineRun unit{.steps = run.steps, .values = std::vector<double>(run.values.size())};
    unit.values[places.at(i)] = 1;
    effects.at(i) = end_curvatures(spline_through(unit));
    right.at(i) = -wrong.at(i);
  }
  // An end that does not rest is left as it is, whatever the other one does to it.
  if (!rests_first) effects[1][0] = 0;
  if (!rests_last) effects[0][1] = 0;
  const double determinant = effects[0][0] * effects[1][1] - effects[1][0] * effects[0][1];
  if (rests_first)
    run.values[places[0]] += (right[0] * effects[1][1] - right[1] * effects[1][0]) / determinant;
  if (rests_last)
    run.values[places[1]] += (right[1] * effects[0][0] - right[0] * effects[0][1]) / determinant;
  std::vector<Cubic> cubics = spline_through(run);
  // To the last bit, which rounding has left off.
  if (rests_first) cubics.front().c1 = cubics.front().c2 = 0;
  if (rests_last) {
    Cubic& last = cubics.back();
    last.c3 = run.values.back() - last.c0;
    last.c1 = 3 * last.c3;
    last.c2 = -last.c1;
  }
  return cubics;
}

class Tracking {
 public:
  Tracking(const MoveTrack& track, const Track& drawn, LinkInTime* aim, const Kinematics& kinematics,
           const RigFile& rig)
      : track_(track),
        drawn_(drawn),
        aim_(aim),
        kinematics_(kinematics),
        axes_(track, drawn, kinematics, rig, place_of(aim)),
        motion_(axes_.rows().count) {
    refuse_what_steps();
    const TrackBounds bounds = bounds_of(drawn);
    if (bounds.steps) refuse_steps();
    for (const std::size_t row : axes_.rows().at) {
      max_speed_ = hypotenuse(max_speed_, bounds.peaks[row].velocity.value);
      max_jerk_ = hypotenuse(max_jerk_, bounds.peaks[row].jerk.value);
    }
    off_m_ = std::max(off_share * drawn.arc_length().total(), off_share * min_length);
    find_key_frames();
  }

  TrackedPath solve(std::int32_t first_steps_per_frame) {
    for (per_frame_ = first_steps_per_frame; per_frame_ <= max_steps_per_frame; per_frame_ *= 2) {
      step_s_ = 1 / (per_frame_ * drawn_.frame_rate().frames_per_second());
      steps_ = static_cast<std::size_t>(drawn_.frames()) * static_cast<std::size_t>(per_frame_);
      if (steps_ < 8) continue;
      if (steps_ > max_time_steps || max_frames_between_keys() * per_frame_ > max_aim_parts) break;
      if (drawn_off() > off_m_) continue;
      sample();
      FollowedPath path = build();
      if (is_good(path.accuracy)) {
        axes_.refuse_beyond_ranges(path, [&](std::size_t step, double t) {
          return drawn_.locate(time_of(static_cast<double>(step) + t));
        });
        return {std::move(path), key_frames_, per_frame_};
      }
    }
    refuse_too_many_steps();
  }

 private:
  static std::optional<Vector3> place_of(LinkInTime* aim) {
    if (aim == nullptr) return std::nullopt;
    return aim->at({0, 0}).position;
  }
  [[noreturn]] void refuse_too_many_steps() const {
    const MoveSpace& space = *track_.space;
    if (aim_ == nullptr) {
      throw InputError(space.place,
                       fmt::format("no {} steps of time are enough for the axes to follow {}; draw it more "
                                   "smoothly, and away from where an axis has to turn at once",
                                   max_time_steps, in_quotes(space.tips.front())));
    }
    throw InputError(
        space.aim_place,
        fmt::format("no {} steps of time are enough for the axes to follow {}; move it and the track more "
                    "smoothly, lead it farther from the lens, or put more keys on the path",
                    max_time_steps, in_quotes(*space.aim_node)));
  }

  static double cube(double x) { return x * x * x; }
  [[nodiscard]] double drawn_off() const { return max_jerk_ * cube(step_s_) / 4; }

  [[nodiscard]] std::int32_t max_frames_between_keys() const {
    std::int32_t longest = 0;
    for (std::size_t k = 1; k < key_frames_.size(); ++k) {
      longest = std::max(longest, key_frames_[k] - key_frames_[k - 1]);
    }
    return longest;
  }

  void refuse_what_steps() const {
    if (aim_ != nullptr && aim_->steps()) {
      throw InputError(
          track_.space->aim_place,
          fmt::format("the motion of {} steps in velocity or acceleration, which an aim cannot follow; "
                      R"(move it with spline = "smooth" and without break)",
                      in_quotes(*track_.space->aim_node)));
    }
    if (!axes_.is_determined()) refuse_free_axes();
  }
  [[noreturn]] void refuse_free_axes() const {
    if (aim_ == nullptr) {
      throw InputError(
          track_.space->place,
          fmt::format("the place of {} leaves some of its axes free; give a point of a row as many "
                      "axes as its place needs, three in space",
                      in_quotes(track_.space->tips.front())));
    }
    throw InputError(
        track_.space->place,
        "the keys leave some of the axes free, and where the link looks moves; give the keys at and "
        "roll, or take the axes that are too many for them out of the rig's branch");
  }
  [[noreturn]] void refuse_steps() const {
    throw InputError(
        track_.space->place,
        R"(an aim that moves needs a path and a speed without steps; write spline = "smooth", and )"
        "no break");
  }

  void find_key_frames() {
    const std::size_t keys = track_.keys.size();
    for (std::size_t k = 0; k < keys; ++k) {
      if (track_.keys[k].frame && aim_ == nullptr) {  // it is drawn over frames
        key_frames_.push_back(*track_.keys[k].frame);
        continue;
      }
      const double frame = frame_of_place(drawn_, {static_cast<std::int32_t>(k), 0});
      key_frames_.push_back(k + 1 == keys ? drawn_.frames() : static_cast<std::int32_t>(std::lround(frame)));
      if (k == 0) key_frames_.back() = 0;
      if (k == 0 || key_frames_[k] > key_frames_[k - 1]) continue;
      throw InputError(
          track_.keys[k].place,
          fmt::format("keys {} and {} are met on about the same frame, {}, while where the link looks "
                      "moves; put them farther apart",
                      k - 1, k, key_frames_[k]));
    }
  }

  /// Of a place in steps since frame 0.
  [[nodiscard]] FrameTime time_of(double step) const {
    const double frame = std::floor(step / per_frame_);
    return {static_cast<std::int32_t>(frame), (step - frame * per_frame_) / per_frame_};
  }

  /// Everything at every step.
  void sample() {
    values_.clear();
    places_.clear();
    aims_.clear();
    nearest_ = std::numeric_limits<double>::infinity();
    for (std::size_t step = 0; step <= steps_; ++step) {
      const FrameTime time = time_of(static_cast<double>(step));
      std::optional<MovingPoint> point;
      if (aim_ != nullptr) point = aim_->at(time);
      values_.push_back(axes_.at(time, point, step == 0));
      if (step == 0) first_slope_ = axes_.velocities(time, point);
      if (step == steps_) last_slope_ = axes_.velocities(time, point);
      drawn_.motion(time, motion_);
      places_.push_back(drawn_place());
      if (!point) continue;
      aims_.push_back(*point);
      nearest_ = std::min(nearest_, length(point->position - places_.back().position));
    }
    // Between two steps both go half a step's distance at most.
    if (aim_ != nullptr) nearest_ -= (max_speed_ + aim_->max_speed()) * step_s_ / 2;
  }
  [[nodiscard]] MovingPoint drawn_place() const {
    const std::vector<std::size_t>& at = axes_.rows().at;
    return {{motion_[at[0]].position, motion_[at[1]].position, motion_[at[2]].position},
            {motion_[at[0]].velocity, motion_[at[1]].velocity, motion_[at[2]].velocity}};
  }

  /// Nothing moves or is accelerated at that end of the move.
  [[nodiscard]] bool rests_at(std::int32_t frame) {
    drawn_.motion({frame, 0}, motion_);
    const Vector3 none{};
    if (!std::ranges::all_of(motion_,
                             [](const auto& row) { return row.velocity == 0 && row.acceleration == 0; })) {
      return false;
    }
    if (aim_ == nullptr) return true;
    const LinkMotion& link = aim_->motion({frame, 0});
    return link.velocity == none && link.acceleration == none;
  }

  FollowedPath build() {
    const std::size_t axes = axes_.coordinates().size();
    const bool rests_first = rests_at(0);
    const bool rests_last = rests_at(drawn_.frames());
    std::vector<std::vector<Cubic>> rows;
    for (std::size_t d = 0; d < axes; ++d) {
      SplineRun run{.steps = std::vector<double>(steps_, 1), .values = {}};
      for (const std::vector<double>& value : values_) run.values.push_back(value[d]);
      run.first_slope = first_slope_[d] * step_s_;
      run.last_slope = last_slope_[d] * step_s_;
      rows.push_back(spline_with_rests(std::move(run), rests_first, rests_last));
    }
    FollowedPath path;
    path.weights.assign(axes, 1);
    std::size_t key = 0;
    for (std::size_t step = 0; step < steps_; ++step) {
      for (std::size_t d = 0; d < axes; ++d) path.cubics.push_back(rows[d][step]);
      const auto frame = static_cast<std::int32_t>(step) / per_frame_;
      if (frame >= key_frames_[key + 1]) ++key;
      const std::int32_t part = static_cast<std::int32_t>(step) - key_frames_[key] * per_frame_;
      const std::int32_t parts = (key_frames_[key + 1] - key_frames_[key]) * per_frame_;
      path.knots.push_back({.key = static_cast<std::int32_t>(key), .part = part, .parts = parts});
    }
    bound(rows, path.accuracy);
    return path;
  }

  [[nodiscard]] std::vector<Cubic> cubics_of(const std::vector<MovingPoint>& points, std::size_t step) const {
    const MovingPoint& from = points[step];
    const MovingPoint& to = points[step + 1];
    const Vector3 v = from.velocity * step_s_;
    const Vector3 w = to.velocity * step_s_;
    return {between(from.position.x, v.x, to.position.x, w.x),
            between(from.position.y, v.y, to.position.y, w.y),
            between(from.position.z, v.z, to.position.z, w.z)};
  }

  void bound(const std::vector<std::vector<Cubic>>& rows, FollowAccuracy& accuracy) const {
    double speed = 0;
    for (std::size_t step = 0; step < steps_; ++step) {
      std::vector<Cubic> axes;
      axes.reserve(rows.size());
      for (const std::vector<Cubic>& row : rows) axes.push_back(row[step]);
      const std::vector<Cubic> place = cubics_of(places_, step);
      std::vector<Cubic> aim;
      if (aim_ != nullptr) aim = cubics_of(aims_, step);
      const TipDeviation found =
          tip_deviation(kinematics_, axes_.tip().link, {axes, axes_.coordinates(), place, aim});
      accuracy.off_m = std::max(accuracy.off_m, found.off);
      accuracy.aim_rad = std::max(accuracy.aim_rad, found.aim);
      speed = std::max(speed, found.speed / step_s_);
    }
    accuracy.off_m += drawn_off();
    speed += max_jerk_ * step_s_ * step_s_ / 4;
    accuracy.speed_share = max_speed_ > 0 ? speed / max_speed_ : 0;
    accuracy.is_share_of_fastest = true;
    if (aim_ == nullptr) return;
    const double missed = aim_->max_jerk() * cube(step_s_) / 4;
    accuracy.aim_rad +=
        nearest_ > missed ? std::asin(missed / nearest_) : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] bool is_good(const FollowAccuracy& found) const {
    return found.off_m <= off_m_ && found.aim_rad <= max_aim_rad && found.speed_share <= max_speed_share;
  }

  const MoveTrack& track_;
  const Track& drawn_;
  LinkInTime* aim_;
  const Kinematics& kinematics_;
  AxesInSpace axes_;
  std::vector<AxisMotion> motion_;  // of the drawn rows, at a moment
  std::vector<std::int32_t> key_frames_;
  double max_speed_ = 0;  // of the drawn place
  double max_jerk_ = 0;
  double off_m_ = 0;  // the tolerance
  std::int32_t per_frame_ = 0;
  double step_s_ = 0;
  std::size_t steps_ = 0;
  std::vector<std::vector<double>> values_;
  std::vector<MovingPoint> places_, aims_;
  std::vector<double> first_slope_, last_slope_;
  double nearest_ = 0;  // the least distance from the lens to the point
};

}  // namespace

TrackedPath tracked_path(const MoveTrack& track, const Track& drawn, LinkInTime* aim,
                         const Kinematics& kinematics, const RigFile& rig,
                         std::int32_t first_steps_per_frame) {
  return Tracking(track, drawn, aim, kinematics, rig).solve(first_steps_per_frame);
}

}  // namespace inbetween
