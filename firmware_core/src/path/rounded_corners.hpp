#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/scaled_norm.hpp"
#include "inbetween/path/path.hpp"

/// The cubics of a linear path whose corners are rounded.

namespace inbetween {

/// On either side of a corner the straight line is convolved with a triangle: over h before it and h behind
/// it the velocity goes from that of one leg to that of the other with the acceleration of a triangle, so
/// that with D their difference
///   before: P = corner + v_before u + D (h + u)^3 / (6 h^2),  behind: P = corner + v_behind u + D (h - u)^3
///   / (6 h^2)
/// and the corner is missed by D h / 6. What u counts is the time of a path over frames, and otherwise the
/// weighted distance along the legs.
class RoundedCorners {
 public:
  RoundedCorners(const PathSpec& spec, const PathMemory& memory)
      : spec_(spec),
        memory_(memory),
        axes_(static_cast<std::size_t>(spec.axis_count)),
        keys_(spec.keys.size() / axes_),
        legs_(spec.closed && keys_ > 1 ? keys_ : keys_ - 1) {}

  static bool are_asked(const PathSpec& spec) {
    return !spec.overlap_frames.empty() || !spec.path_tolerances.empty();
  }

  /// The first action that is shorter than what overlaps in it.
  [[nodiscard]] Status check_actions() const {
    if (!by_frames()) return Done{};
    for (std::size_t k = 0; k < legs_; ++k) {
      const Leg leg = leg_of(k);
      if (leg.line() >= 0) continue;
      // So many frames of overlap at both its keys would just go in.
      const int halves = (leg.begins_at_rest ? 2 : 1) + (leg.ends_at_rest ? 2 : 1);
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the action behind this key is shorter than what overlaps in it",
                   .remedy = "lower the overlap of its keys, or give it more frames",
                   .key = static_cast<std::int32_t>(k),
                   .needed = static_cast<std::int64_t>(2 * leg.extent) / halves};
    }
    return Done{};
  }

  [[nodiscard]] std::size_t segments() const {
    std::size_t count = 0;
    for (std::size_t k = 0; k < legs_; ++k) count += leg_of(k).segments();
    return count;
  }

  /// Writes all cubics and knots.
  void write() {
    std::size_t first = 0;
    for (std::size_t k = 0; k < legs_; ++k) {
      const Leg leg = leg_of(k);
      write_knots(k, leg, first);
      const std::size_t before = k > 0 ? k - 1 : legs_ - 1;
      const std::size_t behind = k + 1 < legs_ ? k + 1 : 0;
      const Actions actions{leg_of(before).action(), leg.action(), leg_of(behind).action()};
      for (std::size_t d = 0; d < axes_; ++d) {
        const auto velocity = [&](std::size_t of, double action) {
          return action > 0 ? chord(of, d) / action : 0.0;
        };
        write_cubics(k, d, leg,
                     {leg.begins_at_rest ? 0.0 : velocity(before, actions.before), velocity(k, actions.own),
                      leg.ends_at_rest ? 0.0 : velocity(behind, actions.behind)},
                     first);
      }
      first += leg.segments();
    }
  }

 private:
  /// A leg is so long as u counts it, and half of what is rounded at either end lies on it.
  struct Leg {
    double extent = 0, begin = 0, end = 0;
    bool begins_at_rest = false, ends_at_rest = false;

    [[nodiscard]] double at_begin() const { return begins_at_rest ? 2 * begin : begin; }
    [[nodiscard]] double at_end() const { return ends_at_rest ? 2 * end : end; }
    /// The straight line between.
    [[nodiscard]] double line() const { return extent - at_begin() - at_end(); }
    /// A straight line from corner to corner: a corner of a rest is inside.
    [[nodiscard]] double action() const {
      return extent - (begins_at_rest ? begin : 0) - (ends_at_rest ? end : 0);
    }
    [[nodiscard]] std::size_t segments() const {
      return halves(begin, begins_at_rest) + halves(end, ends_at_rest) + (has_line() ? 1 : 0);
    }
    [[nodiscard]] bool has_line() const { return line() > 0 || !(begin > 0 || end > 0); }
    static std::size_t halves(double width, bool rests) { return width > 0 ? (rests ? 2 : 1) : 0; }
  };

  /// Knots divide a leg in space into so many parts.
  static constexpr std::int32_t leg_parts = 1 << 20;
  /// Between unit directions: a corner that turns less is none, and one that lacks less to turn back stays.
  static constexpr double min_turn = 1e-12;
  static constexpr double min_distance_through = 1e-6;

  [[nodiscard]] bool by_frames() const { return !spec_.key_frames.empty(); }
  [[nodiscard]] bool is_ring() const {
    return spec_.closed && legs_ > 1 && !(by_frames() && (spec_.rests_at_start || spec_.rests_at_end));
  }
  [[nodiscard]] double chord(std::size_t k, std::size_t d) const {
    return spec_.key(k + 1, d) - spec_.key(k, d);
  }
  [[nodiscard]] double weight(std::size_t d) const { return spec_.weights.empty() ? 1.0 : spec_.weights[d]; }
  [[nodiscard, gnu::noinline]] double extent(std::size_t k) const {
    if (by_frames()) return static_cast<double>(spec_.key_frames[k + 1] - spec_.key_frames[k]);
    return scaled_norm(axes_, [&](std::size_t d) { return weight(d) * chord(k, d); });
  }
  /// Half of what is rounded at a key: 0 where it stays a corner.
  [[nodiscard]] double width(std::size_t k) const {
    const bool is_end = k == 0 || k == legs_;
    if (by_frames()) {
      const bool rests = (k == 0 && spec_.rests_at_start) || (k == legs_ && spec_.rests_at_end);
      if (is_end && !rests && !is_ring()) return 0;
      return static_cast<double>(spec_.overlap_frames[k % keys_]) / 2;
    }
    if (is_end && !is_ring()) return 0;
    return width_in_space(k > 0 ? k - 1 : legs_ - 1, k % legs_, spec_.path_tolerances[k % keys_]);
  }
  [[nodiscard, gnu::noinline]] double width_in_space(std::size_t before, std::size_t behind,
                                                     double tolerance) const {
    const double one = extent(before);
    const double other = extent(behind);
    if (!(tolerance > 0) || !(one > 0) || !(other > 0)) return 0;
    // The legs have unit directions, and this is how long their sum is, or with -1 their difference.
    const auto joined = [&](double sign) {
      return scaled_norm(axes_, [&](std::size_t d) {
        return weight(d) * (chord(behind, d) / other + sign * (chord(before, d) / one));
      });
    };
    const double turn = joined(-1);
    const double through = joined(1);
    if (turn < min_turn || through < min_distance_through) return 0;
    const double half = std::min(one, other) / 2;
    const double wanted = 6 * tolerance / turn;
    // A line that is left is no shorter than rounding can tell.
    return wanted >= half ? half : std::min(wanted, half * (1 - 2.0 / leg_parts));
  }
  /// Not inline, as those below: a path is made once, and each copy takes a kilobyte and more on a
  /// microcontroller.
  [[nodiscard, gnu::noinline]] Leg leg_of(std::size_t k) const {
    return {.extent = extent(k),
            .begin = width(k),
            .end = width(k + 1),
            .begins_at_rest = by_frames() && k == 0 && spec_.rests_at_start,
            .ends_at_rest = by_frames() && k + 1 == legs_ && spec_.rests_at_end};
  }

  /// A leg and its neighbours have these lengths as u counts them, and an axis has such velocities there: at
  /// a rest it has 0.
  struct Actions {
    double before = 0, own = 0, behind = 0;
  };

  [[gnu::noinline]] void write_knots(std::size_t k, const Leg& leg, std::size_t first) {
    const std::int32_t parts = by_frames() ? static_cast<std::int32_t>(2 * leg.extent) : leg_parts;
    const auto part_of = [&](double share) {
      if (by_frames()) return static_cast<std::int32_t>(2 * share);
      return std::max<std::int32_t>(static_cast<std::int32_t>(share / leg.extent * parts), 1);
    };
    FrameKnot knot{.key = static_cast<std::int32_t>(k), .parts = parts};
    std::size_t next = first;
    const auto add = [&](std::int32_t length) {
      knot.length = length;
      memory_.knots[next++] = knot;
      knot.part += length;
    };
    for (std::size_t i = 0; i < Leg::halves(leg.begin, leg.begins_at_rest); ++i) add(part_of(leg.begin));
    const std::size_t halves_at_end = Leg::halves(leg.end, leg.ends_at_rest);
    const std::int32_t at_end =
        halves_at_end > 0 ? static_cast<std::int32_t>(halves_at_end) * part_of(leg.end) : 0;
    if (leg.has_line()) add(parts - knot.part - at_end);
    for (std::size_t i = 0; i < halves_at_end; ++i) {
      add((parts - knot.part) / static_cast<std::int32_t>(halves_at_end - i));
    }
  }

  [[gnu::noinline]] void write_cubics(std::size_t k, std::size_t d, const Leg& leg, const Actions& velocity,
                                      std::size_t first) {
    const double own = velocity.own;
    const double begin = spec_.key(k, d);
    const double end = spec_.key(k + 1, d);
    std::size_t next = first;
    const auto add = [&](const Cubic& cubic) { memory_.cubics[next++ * axes_ + d] = cubic; };
    if (leg.begin > 0) {
      if (leg.begins_at_rest) add(before_corner(begin, 0, own, leg.begin));
      add(behind_corner(begin, velocity.before, own, leg.begin));
    }
    if (leg.has_line()) {
      const bool is_whole = !(leg.begin > 0 || leg.end > 0);
      const double from = leg.at_begin() - (leg.begins_at_rest ? leg.begin : 0);
      add(is_whole ? Cubic{begin, chord(k, d), 0, 0} : Cubic{begin + own * from, own * leg.line(), 0, 0});
    }
    if (leg.end > 0) {
      add(before_corner(end, own, velocity.behind, leg.end));
      if (leg.ends_at_rest) add(behind_corner(end, own, 0, leg.end));
    }
  }

  /// Over t from 0 to 1, h long, about the corner `at` from one velocity to another.
  static Cubic before_corner(double at, double arriving, double leaving, double h) {
    return {at - arriving * h, arriving * h, 0, (leaving - arriving) * h / 6};
  }
  static Cubic behind_corner(double at, double arriving, double leaving, double h) {
    const double change = (leaving - arriving) * h;
    return {at + change / 6, leaving * h - change / 2, change / 2, -change / 6};
  }

  const PathSpec& spec_;
  const PathMemory& memory_;
  std::size_t axes_;
  std::size_t keys_;
  std::size_t legs_;
};

}  // namespace inbetween
