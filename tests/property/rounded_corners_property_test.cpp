#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <ostream>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/support/oracle_overlap.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/oracle_quadrature.hpp"
#include "tests/support/property.hpp"
#include "tests/support/sided_derivatives.hpp"

/// Straight paths whose corners are rounded: in time by overlapping actions, in space by a tolerance.

namespace inbetween {
namespace rounded_corners_property_test {

struct CorneredMove {
  bool closed = false;
  bool rests_at_start = true;
  bool rests_at_end = true;
  std::int32_t axes = 1;
  std::vector<double> keys;
  std::vector<double> weights;
  std::vector<std::int32_t> frames;    ///< by frames
  std::vector<std::int32_t> overlaps;  ///< by frames
  std::vector<double> tolerances;      ///< at a drawn speed
  std::vector<double> speed;

  [[nodiscard]] std::size_t key_count() const { return keys.size() / static_cast<std::size_t>(axes); }
  [[nodiscard]] std::size_t legs() const { return closed ? key_count() : key_count() - 1; }
  [[nodiscard]] double at(std::size_t key, std::int32_t axis) const {
    return keys[key % key_count() * static_cast<std::size_t>(axes) + static_cast<std::size_t>(axis)];
  }
  [[nodiscard]] double size(std::int32_t axis) const {
    double most = 0;
    for (std::size_t k = 0; k < key_count(); ++k) most = std::max(most, std::fabs(at(k, axis)));
    return most + 1e-3;
  }
  [[nodiscard]] bool is_ring() const { return closed && !rests_at_start && !rests_at_end; }
  [[nodiscard]] TrackSpec spec() const {
    TrackSpec spec{.path = {.spline = Spline::linear,
                            .closed = closed,
                            .axis_count = axes,
                            .keys = keys,
                            .weights = weights},
                   .control_values = speed,
                   .frames = frames.empty() ? 120 : frames.back(),
                   .fps = {24, 1},
                   .arc_length = {},
                   .key_frames = frames,
                   .kinetic = Kinetic::curves,
                   .rests_at_start = rests_at_start,
                   .rests_at_end = rests_at_end};
    if (!frames.empty()) spec.path.overlap_frames = overlaps;
    if (frames.empty()) spec.path.path_tolerances = tolerances;
    if (frames.empty() && is_ring()) spec.ends = CurveEnds::periodic;
    return spec;
  }
};

void showValue(const CorneredMove& move, std::ostream& out) {
  out << (move.closed ? "closed, " : "") << "rest " << move.rests_at_start << move.rests_at_end << "; frames";
  for (const std::int32_t frame : move.frames) out << " " << frame;
  out << "; overlaps";
  for (const std::int32_t overlap : move.overlaps) out << " " << overlap;
  out << "; tolerances";
  for (const double tolerance : move.tolerances) out << " " << tolerance;
  out << "; weights";
  for (const double weight : move.weights) out << " " << weight;
  out << "; speed";
  for (const double value : move.speed) out << " " << value;
  out << "; keys of " << move.axes << " axes";
  for (const double key : move.keys) out << " " << key;
}

int number(int from, int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
}

CorneredMove random_keys(int max_axes) {
  CorneredMove move;
  move.axes = number(1, max_axes + 1);
  const int count = number(2, 9);
  move.closed = count > 2 && number(0, 3) == 0;
  for (int k = 0; k < count; ++k) {
    for (std::int32_t d = 0; d < move.axes; ++d) {
      const bool keeps = k > 0 && number(0, 6) == 0;
      const double value = number(-1000, 1001) / 8.0;
      move.keys.push_back(keeps ? move.keys[move.keys.size() - static_cast<std::size_t>(move.axes)] : value);
    }
  }
  return move;
}

/// Actions of 1 to 48 frames, and overlaps up to the shorter of the two beside a key; a rest takes one half
/// of its only action.
CorneredMove overlapping_move() {
  CorneredMove move = random_keys(3);
  move.rests_at_start = number(0, 2) == 0;
  move.rests_at_end = number(0, 2) == 0;
  move.frames = {0};
  for (std::size_t k = 0; k < move.legs(); ++k) move.frames.push_back(move.frames.back() + number(1, 49));
  const auto action = [&](std::size_t k) { return move.frames[k + 1] - move.frames[k]; };
  const std::size_t last = move.legs();
  for (std::size_t k = 0; k < move.key_count(); ++k) {
    const bool is_start = k == 0;
    const bool is_end = k == last;
    const std::int32_t before = is_start ? action(last - 1) : action(k - 1);
    const std::int32_t behind = is_end ? action(0) : action(k);
    std::int32_t most = std::min(before, behind);
    if (is_start && !move.is_ring()) most = behind / 2;
    if (is_end) most = before / 2;
    // The action to the rest of a closed path that ends at its first key.
    if (is_start && move.closed && !move.is_ring()) most = std::min(most, before / 2);
    const bool is_longest = number(0, 4) == 0;
    move.overlaps.push_back(is_longest ? most : number(0, most + 1));
  }
  return move;
}

oracle::OverlappingKeys oracle_keys(const CorneredMove& move, std::int32_t axis) {
  oracle::OverlappingKeys keys{.at = {},
                               .frames = {},
                               .overlaps = {},
                               .rests_at_start = move.rests_at_start,
                               .rests_at_end = move.rests_at_end,
                               .is_ring = move.is_ring()};
  for (std::size_t k = 0; k < move.frames.size(); ++k) {
    keys.at.push_back(move.at(k, axis));
    keys.frames.push_back(move.frames[k]);
    keys.overlaps.push_back(move.overlaps[k % move.key_count()]);
  }
  return keys;
}

TEST(RoundedCornersProperty, OverlappingActionsAreTheStraightLinesConvolvedWithATriangleAndC2) {
  double worst = 0;
  check_property(500, [&] {
    const CorneredMove move = overlapping_move();
    const SolvedTrack track(move.spec(), Solver::closed_form);
    std::vector<double> position(static_cast<std::size_t>(move.axes));
    for (std::int32_t d = 0; d < move.axes; ++d) {
      const oracle::OverlappingKeys keys = oracle_keys(move, d);
      for (std::int32_t frame = 0; frame <= move.frames.back(); ++frame) {
        for (const double fraction : {0.0, 0.3125}) {
          if (frame == move.frames.back() && fraction > 0) continue;
          track.track().positions({frame, fraction}, position);
          const long double asked =
              oracle::overlapped_position(keys, frame + static_cast<long double>(fraction));
          const double off =
              std::fabs(static_cast<double>(position[static_cast<std::size_t>(d)] - asked)) / move.size(d);
          worst = std::max(worst, off);
          RC_ASSERT(off <= 1e-9);
        }
      }
      const bool has_corner =
          std::ranges::any_of(move.overlaps, [](std::int32_t frames) { return frames == 0; });
      if (!has_corner) expect_no_steps(track, d, move.size(d), true);
    }
  });
  std::cout << "farthest from the convolution: " << worst << " of the size of an axis\n";
}

TEST(RoundedCornersProperty, AMoveWithNoOverlapIsThePlainStraightOneToTheLastBit) {
  check_property(200, [] {
    CorneredMove move = overlapping_move();
    std::ranges::fill(move.overlaps, 0);
    const SolvedTrack track(move.spec(), Solver::closed_form);
    TrackSpec plain = move.spec();
    plain.path.overlap_frames = {};
    plain.kinetic = Kinetic::linear;
    const SolvedTrack straight(plain, Solver::closed_form);
    std::vector<double> position(static_cast<std::size_t>(move.axes));
    std::vector<double> asked(position.size());
    for (std::int32_t frame = 0; frame <= move.frames.back(); ++frame) {
      for (const double fraction : {0.0, 0.25, 0.7}) {
        track.track().positions({frame, fraction}, position);
        straight.track().positions({frame, fraction}, asked);
        RC_ASSERT(position == asked);
      }
    }
  });
}

/// Corners of any angle, legs of any length, tolerances from far too small to far too large.
CorneredMove rounded_move() {
  CorneredMove move = random_keys(4);
  for (std::int32_t d = 0; d < move.axes; ++d) move.weights.push_back(number(1, 400) / 100.0);
  const bool is_ring = move.closed && number(0, 2) == 0;
  move.rests_at_start = move.rests_at_end = !is_ring;
  for (std::size_t k = 0; k < move.key_count(); ++k) {
    move.tolerances.push_back(number(0, 8) == 0 ? 0 : std::pow(10.0, number(-300, 250) / 100.0));
  }
  if (!is_ring) move.tolerances.front() = 0;
  for (int i = number(2, 9); i > 0; --i) move.speed.push_back(number(1, 400) / 4.0);
  if (is_ring) move.speed.push_back(move.speed.front());
  return move;
}

using Place = std::vector<long double>;

/// In weighted axes.
Place key_of(const CorneredMove& move, std::size_t key) {
  Place place;
  for (std::int32_t d = 0; d < move.axes; ++d)
    place.push_back(static_cast<long double>(move.weights[static_cast<std::size_t>(d)]) * move.at(key, d));
  return place;
}
Place place_of(const CorneredMove& move, const Path& path, const PathPoint& point) {
  Place place;
  for (std::int32_t d = 0; d < move.axes; ++d) {
    const Cubic& c = path.segment(point.segment)[static_cast<std::size_t>(d)];
    const auto t = static_cast<long double>(point.t);
    place.push_back(move.weights[static_cast<std::size_t>(d)] * (c.c0 + t * (c.c1 + t * (c.c2 + t * c.c3))));
  }
  return place;
}
long double between(const Place& one, const Place& other) {
  long double squares = 0;
  for (std::size_t d = 0; d < one.size(); ++d) squares += (one[d] - other[d]) * (one[d] - other[d]);
  return std::sqrt(squares);
}
/// The nearest that the two halves of a blend come to a key.
long double nearest_on(const CorneredMove& move, const Path& path, std::int32_t segment, const Place& key) {
  long double nearest = between(place_of(move, path, {segment, 0}), key);
  for (int i = 0; i <= 2000; ++i)
    nearest = std::min(nearest, between(place_of(move, path, {segment, i / 2000.0}), key));
  return nearest;
}

struct Corner {
  std::size_t key = 0;
  long double before = 0, behind = 0;  ///< legs, weighted
  long double turn = 0, through = 0;   ///< between unit directions, and their sum
};

/// The corners that may be rounded: those with two legs.
std::vector<Corner> corners_of(const CorneredMove& move) {
  std::vector<Corner> corners;
  const std::size_t count = move.key_count();
  for (std::size_t k = 0; k < count; ++k) {
    const bool has_both = move.is_ring() || (k > 0 && (k + 1 < count || move.closed));
    if (!has_both) continue;
    const Place here = key_of(move, k);
    const Place last = key_of(move, k + count - 1);
    const Place next = key_of(move, k + 1);
    Corner corner{.key = k, .before = between(last, here), .behind = between(here, next)};
    if (!(corner.before > 0) || !(corner.behind > 0)) continue;
    Place turn;
    Place through;
    for (std::size_t d = 0; d < here.size(); ++d) {
      const long double arriving = (here[d] - last[d]) / corner.before;
      const long double leaving = (next[d] - here[d]) / corner.behind;
      turn.push_back(leaving - arriving);
      through.push_back(leaving + arriving);
    }
    const Place nothing(here.size(), 0);
    corner.turn = between(turn, nothing);
    corner.through = between(through, nothing);
    corners.push_back(corner);
  }
  return corners;
}

TEST(RoundedCornersProperty, APathPassesEveryCornerWithinItsToleranceAndUsesItWhereTheLegsAllow) {
  int rounded = 0;
  int short_of_legs = 0;
  check_property(500, [&] {
    const CorneredMove move = rounded_move();
    const SolvedTrack track(move.spec(), Solver::closed_form);
    const Path& path = track.track().path();
    for (const Corner& corner : corners_of(move)) {
      std::int32_t segment = 0;
      while (path.key_at(segment) != static_cast<std::int32_t>(corner.key)) ++segment;
      const std::int32_t before = segment > 0 ? segment - 1 : path.segment_count() - 1;
      const Place key = key_of(move, corner.key);
      const long double miss =
          std::min(nearest_on(move, path, before, key), nearest_on(move, path, segment, key));
      const long double tolerance = move.tolerances[corner.key];
      const long double rounding =
          1e-13L * (corner.before + corner.behind + between(key, Place(key.size(), 0)));
      RC_ASSERT(miss <= tolerance + rounding);
      if (tolerance == 0 || corner.turn < 1e-9L || corner.through < 1e-5L) continue;
      ++rounded;
      const long double half = std::min(corner.before, corner.behind) / 2;
      // What a blend of this kind over half of the shorter leg could do.
      const long double possible = std::min(tolerance, corner.turn * half / 6);
      RC_ASSERT(miss >= 0.9L * possible - rounding);
      if (possible < tolerance) ++short_of_legs;
      // It begins and ends no further from the key than half of that leg.
      RC_ASSERT(between(place_of(move, path, {before, 0}), key) <= half * (1 + 1e-12L) + rounding ||
                path.knots()[static_cast<std::size_t>(before)].parts == 1);
      RC_ASSERT(between(place_of(move, path, {segment, 1}), key) <= half * (1 + 1e-12L) + rounding);
    }
  });
  std::cout << rounded << " corners rounded, " << short_of_legs << " of them with short legs\n";
  EXPECT_GT(rounded, 50);
  EXPECT_GT(short_of_legs, rounded / 10);
}

/// The weighted derivative, in t.
long double pace_at(const CorneredMove& move, const Path& path, std::int32_t segment, long double t) {
  long double squares = 0;
  for (std::int32_t d = 0; d < move.axes; ++d) {
    const Cubic& c = path.segment(segment)[static_cast<std::size_t>(d)];
    const long double rate = move.weights[static_cast<std::size_t>(d)] *
                             (c.c1 + t * (2 * c.c2 + t * (3 * static_cast<long double>(c.c3))));
    squares += rate * rate;
  }
  return std::sqrt(squares);
}

TEST(RoundedCornersProperty, ARoundedPathIsPassedAtTheDrawnSpeed) {
  double worst = 0;
  check_property(200, [&] {
    const CorneredMove move = rounded_move();
    RC_PRE(!move.is_ring());  // a periodic curve is another one
    const SolvedTrack track(move.spec(), Solver::closed_form);
    const Path& path = track.track().path();
    RC_PRE(track.track().arc_length().total() > 0);
    // Both sides by quadrature of their own: the length up to a point, and the integral of the drawn curve.
    const oracle::Profile profile(move.speed);
    std::vector<long double> begins = {0};
    const auto length = [&](std::int32_t segment, long double to) {
      const auto pace = [&](long double t) { return pace_at(move, path, segment, t); };
      return oracle::integral(pace, 0, to, 1e-14L * track.track().arc_length().total());
    };
    for (std::int32_t i = 0; i < path.segment_count(); ++i) begins.push_back(begins.back() + length(i, 1));
    for (std::int32_t frame = 0; frame <= 120; frame += 5) {
      const PathPoint point = track.track().locate({frame, 0});
      const long double passed =
          point.segment < path.segment_count()
              ? begins[static_cast<std::size_t>(point.segment)] + length(point.segment, point.t)
              : begins.back();
      const long double share = profile.integral(profile.spans() * static_cast<long double>(frame) / 120) /
                                profile.integral(profile.spans());
      const double off = static_cast<double>(std::fabs(passed / begins.back() - share));
      worst = std::max(worst, off);
      RC_ASSERT(off <= 1e-9);
    }
  });
  std::cout << "farthest from the drawn distance: " << worst << " of the length\n";
}

}  // namespace rounded_corners_property_test
}  // namespace inbetween
