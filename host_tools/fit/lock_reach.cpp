#include "host_tools/fit/lock_reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host_tools/fit/fewest_frames.hpp"

namespace inbetween {
namespace {

/// A limit counts as this share larger, for the rounding of what is held against it. Without it
/// LimitsOfLocks.AreNeverToldToExcludeAMotionThatKeepsThem may find a motion at a limit excluded; with more a
/// proof is missed.
constexpr double limit_rounding = 1e-6;
/// A position may be off by this share of it.
constexpr double place_rounding = 1e-9;
/// A place so near to a key, in t, is the key, where the direction of the path may change: the place of a
/// lock is found by its distance, with more error than its t is told apart by here.
constexpr double key_rounding = 1e-6;
/// An axis that makes up a smaller share of the direction of the path says nothing of the speed along it.
constexpr double min_share = 1e-9;

struct Range {
  double low = 0;
  double high = 0;
};

/// Halvings of an interval of velocities: 54 come to its last bit.
constexpr int halvings = 60;

/// How an axis may move between two places.
struct Stretch {
  Range distance;  ///< what it travels, as exactly as it is known
  double seconds = 0;
  Range velocity;  ///< on the whole stretch
  double acceleration = 0;

  [[nodiscard]] Stretch turned_round() const {
    return {{-distance.high, -distance.low}, seconds, {-velocity.high, -velocity.low}, acceleration};
  }
  /// The farthest distance with these velocities at its ends: full acceleration, the highest velocity if it
  /// is reached, full deceleration.
  [[nodiscard]] double farthest(double begin, double end) const {
    const double peak = std::min((begin + end + acceleration * seconds) / 2, velocity.high);
    const double ramps = (2 * peak - begin - end) / acceleration;
    return ((peak - begin) * (peak + begin) + (peak - end) * (peak + end)) / (2 * acceleration) +
           peak * std::max(seconds - ramps, 0.0);
  }
};

/// The lowest velocity at the end of a stretch, whose velocity at the beginning is in `before`: below it the
/// axis does not come far enough. Above the highest possible one where it never does.
double lowest_after(const Range& before, const Stretch& stretch) {
  const double change = stretch.acceleration * stretch.seconds;
  double low = std::max(before.low - change, stretch.velocity.low);
  double high = std::min(before.high + change, stretch.velocity.high);
  const auto comes_far_enough = [&](double end) {
    return stretch.farthest(std::min(before.high, end + change), end) >= stretch.distance.low;
  };
  if (!comes_far_enough(high)) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < halvings && !comes_far_enough(low); ++i) {
    const double middle = low + (high - low) / 2;
    (comes_far_enough(middle) ? high : low) = middle;
  }
  return low;
}

/// The velocities of an axis at the end of a stretch. None are left, low above high, where it cannot be there
/// in this time. That each is possible with some velocity at the beginning follows from both bounds rising
/// with it.
Range velocities_after(const Range& before, const Stretch& stretch) {
  const double low = std::clamp(before.low, stretch.velocity.low, stretch.velocity.high);
  const double high = std::clamp(before.high, stretch.velocity.low, stretch.velocity.high);
  return {lowest_after({low, high}, stretch), -lowest_after({-high, -low}, stretch.turned_round())};
}

/// A place that has to be met: where every axis is, and how it goes on.
struct Place {
  Meeting meeting;
  PathPoint point;
  std::vector<double> position;
  std::vector<double> direction;  ///< of length 1; empty where the path has none, or turns
};

class LockReach {
 public:
  LockReach(const Plan& plan, std::size_t index)
      : path_(plan.tracks()[index].track().path()),
        fps_(plan.move().fps.rate.frames_per_second()),
        axes_(static_cast<std::size_t>(path_.axis_count())) {
    for (std::size_t a = 0; a < plan.axes().size(); ++a) {
      if (plan.axes()[a].track != index) continue;
      const RigAxis& limits = plan.rig()->axes[a];
      axes_[plan.axes()[a].track_axis] = {a, limits.max_velocity * (1 + limit_rounding),
                                          limits.max_acceleration * (1 + limit_rounding)};
    }
    for (const Meeting& meeting : meetings_of(plan, index)) {
      places_.push_back(place_of(meeting, plan.tracks()[index].track().locate({meeting.frame, 0})));
    }
  }

  [[nodiscard]] std::optional<UnreachedLock> first_unreached() const {
    std::optional<Failure> failure = follow_from(0, places_.size());
    if (!failure) return std::nullopt;
    // The nearest lock from which it can be told.
    std::size_t begin = 0;
    for (std::size_t i = failure->place; i-- > 0;) {
      const std::optional<Failure> nearer = follow_from(i, failure->place + 1);
      if (!nearer) continue;
      failure = nearer;
      begin = i;
      break;
    }
    const Meeting& one = places_[begin].meeting;
    const Meeting& other = places_[failure->place].meeting;
    return UnreachedLock{one.key, one.frame + one.hold, other.key, other.frame, axes_[failure->axis].index};
  }

 private:
  struct Axis {
    std::size_t index = 0;
    double velocity = 0;
    double acceleration = 0;
  };
  struct Failure {
    std::size_t place = 0;
    std::size_t axis = 0;
  };

  /// The slope of the path at t, of length 1, or empty.
  [[nodiscard]] std::vector<double> direction(std::int32_t segment, double t) const {
    std::vector<double> slope(axes_.size());
    double square = 0;
    double size = 0;
    for (std::size_t d = 0; d < slope.size(); ++d) {
      const Cubic& cubic = path_.segment(segment)[d];
      slope[d] = cubic.derivative(t);
      square += slope[d] * slope[d];
      size += std::fabs(cubic.c1) + std::fabs(cubic.c2) + std::fabs(cubic.c3);
    }
    const double length = std::sqrt(square);
    if (!(length > key_rounding * size)) return {};
    for (double& value : slope) value /= length;
    return slope;
  }
  [[nodiscard]] Place place_of(const Meeting& meeting, const PathPoint& point) const {
    const std::int32_t last = path_.segment_count() - 1;
    const std::int32_t segment = std::min(point.segment, last);
    const double t = point.segment > last ? 1 : point.t;
    Place place{.meeting = meeting, .point = point, .position = {}, .direction = direction(segment, t)};
    for (std::size_t d = 0; d < axes_.size(); ++d)
      place.position.push_back(path_.segment(segment)[d].value(t));
    const std::int32_t beside = t < 0.5 ? segment - 1 : segment + 1;
    if (std::min(t, 1 - t) > key_rounding || beside < 0 || beside > last) return place;
    const std::vector<double> other = direction(beside, t < 0.5 ? 1 : 0);
    const bool goes_on = other.size() == place.direction.size() &&
                         std::ranges::equal(other, place.direction, [](double a, double b) {
                           return std::fabs(a - b) <= 2 * key_rounding;
                         });
    if (!goes_on) place.direction.clear();
    return place;
  }

  /// The velocities that an axis may have on the way from one place to the next. Where it does not turn they
  /// have one sign.
  [[nodiscard]] Range velocity_between(const Place& from, const Place& to, std::size_t axis) const {
    bool rises = true;
    bool falls = true;
    for (std::int32_t i = from.point.segment; i <= to.point.segment && i < path_.segment_count(); ++i) {
      const Cubic& cubic = path_.segment(i)[axis];
      const double begin = i == from.point.segment ? from.point.t : 0;
      const double end = i == to.point.segment ? to.point.t : 1;
      const double flattest = cubic.c3 != 0 ? std::clamp(-cubic.c2 / (3 * cubic.c3), begin, end) : begin;
      for (const double t : {begin, flattest, end}) {
        const double slope = cubic.derivative(t);
        rises = rises && slope >= 0;
        falls = falls && slope <= 0;
      }
    }
    const double most = axes_[axis].velocity;
    return {rises ? 0 : -most, falls ? 0 : most};
  }

  /// The velocities that the limits of the axes allow.
  [[nodiscard]] std::vector<Range> allowed_velocities() const {
    std::vector<Range> allowed;
    for (const Axis& axis : axes_) allowed.push_back({-axis.velocity, axis.velocity});
    return allowed;
  }

  /// Passes one place at any speed and returns the first one behind it, before `end`, that cannot be met.
  [[nodiscard]] std::optional<Failure> follow_from(std::size_t begin, std::size_t end) const {
    std::vector<Range> velocities = allowed_velocities();
    if (keep_common(places_[begin], velocities)) return std::nullopt;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const Place& from = places_[i - 1];
      const Place& to = places_[i];
      const double seconds = (to.meeting.frame - from.meeting.frame - from.meeting.hold) / fps_;
      for (std::size_t d = 0; d < axes_.size(); ++d) {
        const double distance = to.position[d] - from.position[d];
        const double off = place_rounding * (std::fabs(to.position[d]) + std::fabs(from.position[d]));
        velocities[d] = velocities_after(velocities[d], {.distance = {distance - off, distance + off},
                                                         .seconds = seconds,
                                                         .velocity = velocity_between(from, to, d),
                                                         .acceleration = axes_[d].acceleration});
        if (velocities[d].low > velocities[d].high) return Failure{i, d};
      }
      if (const std::optional<std::size_t> axis = keep_common(to, velocities)) return Failure{i, *axis};
    }
    return std::nullopt;
  }

  /// Leaves of the velocities at a place those that belong to a speed along the path that every axis can
  /// have. Returns an axis that can have none of them.
  [[nodiscard]] std::optional<std::size_t> keep_common(const Place& place,
                                                       std::vector<Range>& velocities) const {
    Range speed{0, place.meeting.rests ? 0 : std::numeric_limits<double>::infinity()};
    std::size_t fastest = 0;  // the axis that needs the lowest speed
    for (std::size_t d = 0; d < axes_.size(); ++d) {
      Range& range = velocities[d];
      const double rounding = limit_rounding * axes_[d].velocity;
      range = {std::max(range.low - rounding, -axes_[d].velocity),
               std::min(range.high + rounding, axes_[d].velocity)};
      if (range.low > range.high || (place.meeting.rests && (range.low > 0 || range.high < 0))) return d;
      if (place.meeting.rests) range = {0, 0};
      const double share = place.direction.empty() ? 0 : place.direction[d];
      if (std::fabs(share) < min_share) continue;
      Range along{range.low / share, range.high / share};
      if (share < 0) std::swap(along.low, along.high);
      if (along.low > speed.low) {
        speed.low = along.low;
        fastest = d;
      }
      speed.high = std::min(speed.high, along.high);
      if (speed.low > speed.high) return along.high < 0 ? d : fastest;
    }
    for (std::size_t d = 0; d < axes_.size() && !place.direction.empty(); ++d) {
      const double share = place.direction[d];
      if (std::fabs(share) < min_share) continue;
      velocities[d] = {std::min(share * speed.low, share * speed.high),
                       std::max(share * speed.low, share * speed.high)};
    }
    return std::nullopt;
  }

  const Path& path_;
  double fps_;
  std::vector<Axis> axes_;
  std::vector<Place> places_;
};

}  // namespace

std::optional<UnreachedLock> unreached_lock(const Plan& plan, std::size_t track) {
  if (!plan.tracks()[track].key_timing()) return std::nullopt;
  return LockReach(plan, track).first_unreached();
}

}  // namespace inbetween
