#include "inbetween/path/arc_length.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "firmware_core/src/path/piece_fit.hpp"
#include "firmware_core/src/path/segment_speed.hpp"

namespace inbetween {
namespace arc_length_test {

/// A path and its arc length with the memory they stand in.
class MeasuredPath {
 public:
  explicit MeasuredPath(const PathSpec& spec, const ArcLengthOptions& options = {})
      : memory_(std::make_unique<Memory>()),
        path_(Path::make(spec, memory_->path.memory())),
        arc_length_(ArcLength::make(*path_, options, memory_->arc_length.memory())) {}

  const Path& path() const { return *path_; }
  const ArcLength& operator*() const { return *arc_length_; }
  const ArcLength* operator->() const { return &*arc_length_; }

  /// From the start to a point, in one number.
  double distance(const PathPoint& point) const { return arc_length_->distance(*path_, point).high; }
  PathPoint locate(double distance) const { return arc_length_->locate({distance, 0}); }
  double coordinate_at(double distance, std::int32_t axis) const {
    return path_->position(locate(distance), axis);
  }

 private:
  struct Memory {
    PathStorage<16, 4> path;
    ArcLengthStorage<16, 4000> arc_length;
  };
  std::unique_ptr<Memory> memory_;
  Result<Path> path_;
  Result<ArcLength> arc_length_;
};

// --- closed forms

TEST(ArcLength, StraightLinesHaveTheLengthOfTheirChords) {
  const std::vector<double> keys{0, 0, 3, 4, 3, -8};
  const MeasuredPath line({.spline = Spline::linear, .axis_count = 2, .keys = keys});
  const double rounding = 64 * std::numeric_limits<double>::epsilon();
  EXPECT_NEAR(line->total(), 17, rounding);
  EXPECT_NEAR(line->segment_begin(1).high, 5, rounding);
  EXPECT_NEAR(line.distance({1, 0.25}), 8, rounding);
  EXPECT_NEAR(line.coordinate_at(2.5, 0), 1.5, rounding);
  EXPECT_NEAR(line.coordinate_at(11, 1), -2, rounding);
}

TEST(ArcLength, IsMeasuredThroughTheWeights) {
  const std::vector<double> keys{0, 0, 3, 4};
  const std::vector<double> weights{4, 0.5};
  const MeasuredPath line({.spline = Spline::linear, .axis_count = 2, .keys = keys, .weights = weights});
  EXPECT_DOUBLE_EQ(line->total(), std::sqrt(148.0));
}

/// Integral of sqrt(1 + 4 u^2) from 0 to u.
double parabola_length(double u) {
  return u / 2 * std::sqrt(1 + 4 * u * u) + std::asinh(2 * u) / 4;
}

TEST(ArcLength, AParabolaHasTheLengthOfItsFormula) {
  // The middle of these four Catmull-Rom segments' three is (u, u^2), u = 2 t - 1.
  const std::vector<double> keys{-3, 9, -1, 1, 1, 1, 3, 9};
  const MeasuredPath path({.spline = Spline::catmull_rom, .axis_count = 2, .keys = keys}, {.delta = 1e-9});
  const double before = path->segment_begin(1).high;
  EXPECT_NEAR(path->segment_begin(2).high - before, 2 * parabola_length(1), 1e-13);
  for (const double u : {-0.9, -0.5, 0.0, 0.3, 0.8}) {
    const double length = parabola_length(1) + parabola_length(u);
    EXPECT_NEAR(path.distance({1, (1 + u) / 2}) - before, length, 1e-13) << u;
    EXPECT_NEAR(path.coordinate_at(before + length, 0), u, 1e-9) << u;
    EXPECT_NEAR(path.coordinate_at(before + length, 1), u * u, 2e-9) << u;
  }
}

/// Keys whose middle Catmull-Rom segment is Neile's parabola (u^2, u^3) with a cusp at u = 0.
const std::vector<double> cusp_keys{9, -11, 1, -1, 1, 1, 9, 11};

double cusp_length(double u) {
  return (std::pow(4 + 9 * u * u, 1.5) - 8) / 27;
}

TEST(ArcLength, ACuspHasTheLengthOfItsFormulaAndIsPassedAtIt) {
  const MeasuredPath path({.spline = Spline::catmull_rom, .axis_count = 2, .keys = cusp_keys});
  const double cusp = path->segment_begin(1).high + cusp_length(1);
  EXPECT_NEAR(path->segment_begin(2).high - cusp, cusp_length(1), 1e-13);
  EXPECT_NEAR(path.coordinate_at(cusp, 0), 0, 1e-12);
  EXPECT_LE(path->piece_count(), 100) << "cut at the cusp, the two halves are smooth";
  for (const double u : {1e-4, 0.01, 0.1, 0.5, 0.9}) {
    EXPECT_NEAR(path.coordinate_at(cusp + cusp_length(u), 1), u * u * u, 2e-6 * cusp_length(u)) << u;
    EXPECT_NEAR(path.coordinate_at(cusp - cusp_length(u), 1), -u * u * u, 2e-6 * cusp_length(u)) << u;
  }
}

TEST(ArcLength, TensionOneIsSmoothInTheSquareRootOfTheDistance) {
  // One axis, P' = 0 at both keys: P = 3 t^2 - 2 t^3 is its own arc length.
  const std::vector<double> keys{0, 1};
  const std::vector<KeyShape> shapes(2, {.tension = 1, .continuity = 0, .bias = 0});
  const MeasuredPath path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
  const double delta = Precision::default_delta;
  EXPECT_NEAR(path->total(), 1, delta);
  EXPECT_LE(path->piece_count(), 40);
  for (const double distance : {1e-6, 1e-3, 0.2, 0.5, 0.9, 0.99999}) {
    EXPECT_NEAR(path.coordinate_at(distance, 0), distance, delta) << distance;
  }
}

TEST(ArcLength, APathThatTurnsBackOnALineIsMeasuredBothWays) {
  // u^2 for u = 2 t - 1 in the middle: from 1 down to 0 and up again.
  const std::vector<double> keys{9, 1, 1, 9};
  const MeasuredPath path({.spline = Spline::catmull_rom, .axis_count = 1, .keys = keys});
  const double before = path->segment_begin(1).high;
  EXPECT_NEAR(path->segment_begin(2).high - before, 2, 1e-13);
  for (const double to_turn : {0.9, 0.1, 1e-3, 1e-6}) {
    EXPECT_NEAR(path.coordinate_at(before + 1 - to_turn, 0), to_turn, 1e-6 * to_turn + 1e-14);
    EXPECT_NEAR(path.coordinate_at(before + 1 + to_turn, 0), to_turn, 1e-6 * to_turn + 1e-14);
  }
}

TEST(ArcLength, APathBeyondItsEndGoesOnGrowing) {
  const std::vector<double> keys{0, 0, 3, 4};
  const MeasuredPath line({.spline = Spline::linear, .axis_count = 2, .keys = keys});
  EXPECT_DOUBLE_EQ(line.distance({1, 0}), 5);
  EXPECT_DOUBLE_EQ(line.distance({1, 0.5}), 7.5);
}

// --- ends and standstill

const std::vector<double> bent{0, 0, 1, 3, 7, 2, 7.5, 2.5, -4, -20, 5, 5};

TEST(ArcLength, TheEndsOfThePathAreExact) {
  std::vector<double> keys;
  for (const double coordinate : bent) keys.push_back(static_cast<double>(coordinate));
  const MeasuredPath path({.axis_count = 2, .keys = keys});
  const TwoSum total = path->segment_begin(5);
  EXPECT_EQ(path->total(), total.high);
  EXPECT_EQ(path->locate({0, 0}), (PathPoint{0, 0}));
  EXPECT_EQ(path->locate(total), (PathPoint{5, 0}));
  EXPECT_EQ(path->locate({2 * path->total(), 0}), (PathPoint{5, 0}));
  EXPECT_EQ(path.distance({0, 0}), 0);
  EXPECT_EQ(path.distance({5, 0}), path->total());
}

// A track of parts adds large parts that cancel, so that `high` may be well behind the end and `low` bring it
// back.
TEST(ArcLength, ADistanceOfTwoPartsIsBeforeTheEndWhenItsSumIs) {
  const std::vector<double> keys{0, 0, 3, 4, 3, -8};
  const MeasuredPath line({.spline = Spline::linear, .axis_count = 2, .keys = keys});
  const double total = line->total();
  const PathPoint point = line->locate({2 * total, -total - 0.25});
  EXPECT_EQ(point.segment, 1);
  EXPECT_NEAR(line.path().position(point, 1), -7.75, 256 * std::numeric_limits<double>::epsilon());
}

TEST(ArcLength, APathThatStaysHasNoLengthAndOnePlace) {
  const std::vector<double> keys{4, 4, 4};
  for (const auto& count : {std::size_t{1}, std::size_t{3}}) {
    const MeasuredPath path({.axis_count = 1, .keys = std::span(keys).first(count)});
    EXPECT_EQ(path->total(), 0);
    EXPECT_EQ(path->piece_count(), 0);
    EXPECT_EQ(path->locate({0, 0}), (PathPoint{0, 0}));
    EXPECT_EQ(path.distance({static_cast<std::int32_t>(count) - 1, 0}), 0);
  }
}

TEST(ArcLength, ASegmentThatStaysIsPassedInNoDistance) {
  const std::vector<double> keys{0, 10, 10, 30};
  const MeasuredPath path({.spline = Spline::linear, .axis_count = 1, .keys = keys});
  EXPECT_DOUBLE_EQ(path->total(), 30);
  EXPECT_EQ(path->segment_begin(1).high, path->segment_begin(2).high);
  EXPECT_DOUBLE_EQ(path.distance({1, 0.5}), 10);
  EXPECT_EQ(path.locate(10 * (1 - 1e-14)).segment, 0);
  EXPECT_EQ(path.locate(10 * (1 + 1e-14)).segment, 2);
}

// --- the inverse

TEST(ArcLength, TheInverseComesBackToWhereItStarted) {
  for (const double delta : {1e-4, 1e-6, 1e-9}) {
    for (const Acceptance acceptance : {Acceptance::estimated, Acceptance::certified}) {
      const MeasuredPath path({.axis_count = 2, .keys = bent}, {.delta = delta, .acceptance = acceptance});
      for (int i = 0; i <= 1000; ++i) {
        const double distance = path->total() * i / 1000;
        EXPECT_NEAR(path.distance(path.locate(distance)), distance, delta * path->total() / 4) << delta;
      }
    }
  }
}

TEST(ArcLength, TheNumberOfBucketsChangesNoPoint) {
  const MeasuredPath path({.spline = Spline::catmull_rom, .axis_count = 2, .keys = cusp_keys});
  ArcLengthStorage<3, 4000> storage;
  ArcLengthMemory memory = storage.memory();
  for (const std::size_t buckets : {1U, 2U, 7U, 4000U}) {
    memory.buckets = std::span(storage.buckets).first(buckets);
    const auto arc_length = ArcLength::make(path.path(), {}, memory);
    ASSERT_TRUE(arc_length);
    for (int i = 0; i <= 3000; ++i) {
      const double distance = path->total() * i / 3000;
      EXPECT_EQ(arc_length->locate({distance, 0}), path.locate(distance));
    }
  }
}

/// With a cusp, where the pieces take roots and crowd, and with both ends.
TEST(ArcLength, ManyDistancesAtOnceLeadToTheSameBitsAsEachByItself) {
  const MeasuredPath path({.spline = Spline::catmull_rom, .axis_count = 2, .keys = cusp_keys});
  for (const double share : {-0.1, 0.0, 0.3, 0.999}) {
    const TwoSum begin{share * path->total(), 1e-17 * path->total()};
    std::vector<double> distances(1500);
    for (std::size_t i = 0; i < distances.size(); ++i) {
      distances[i] = path->total() * (1.2 * static_cast<double>(i) / static_cast<double>(distances.size()));
    }
    for (const bool rise : {true, false}) {
      if (!rise) std::swap(distances[700], distances[703]);  // they need not
      std::vector<PathPoint> points(distances.size());
      const bool in_order = path->locate(begin, distances, points);
      EXPECT_EQ(in_order, rise || points[700] == points[703]) << share;
      for (std::size_t i = 0; i < distances.size(); ++i) {
        EXPECT_EQ(points[i], path->locate(begin, distances[i])) << share << ", distance " << i;
        TwoSum distance = begin;
        distance.add(distances[i]);
        EXPECT_NEAR(path.distance(points[i]), path.distance(path->locate(distance)), 1e-14 * path->total());
      }
    }
  }
}

/// Distances a few roundings apart, of which some lead back by a rounding of t: alone in their four, as the
/// first and the last of them, and behind them.
TEST(ArcLength, PointsThatRoundingPutsOutOfOrderAreToldOf) {
  const MeasuredPath path({.spline = Spline::catmull_rom, .axis_count = 2, .keys = cusp_keys});
  std::vector<double> distances(7);
  std::vector<PathPoint> points(distances.size());
  std::array<int, 7> falls{};  // how often the point at this place was before the one in front of it
  for (int i = 1; i < 20'000; ++i) {
    double distance = 0.3 * path->total() * i / 20'000;
    for (double& next : distances) next = distance = std::nextafter(distance, path->total());
    const bool in_order = path->locate({0.1 * path->total(), 0}, distances, points);
    bool are_in_order = true;
    for (std::size_t k = 1; k < points.size(); ++k) {
      if (points[k - 1].at_or_before(points[k])) continue;
      are_in_order = false;
      ++falls[k];
    }
    ASSERT_TRUE(are_in_order || !in_order) << "from distance " << i;
  }
  for (std::size_t k = 1; k < falls.size(); ++k) EXPECT_GT(falls[k], 0) << "at place " << k;
}

TEST(ArcLength, ASmallerDeltaTakesMorePiecesAndLessError) {
  double error_before = std::numeric_limits<double>::infinity();
  std::int32_t pieces_before = 0;
  for (const double delta : {1e-2, 1e-4, 1e-6, 1e-9}) {
    const MeasuredPath path({.axis_count = 2, .keys = bent}, {.delta = delta});
    double error = 0;
    for (int i = 0; i <= 1000; ++i) {
      const double distance = path->total() * i / 1000;
      error = std::max(error, std::fabs(path.distance(path.locate(distance)) - distance));
    }
    EXPECT_GT(path->piece_count(), pieces_before);
    EXPECT_LT(error, error_before);
    EXPECT_EQ(path->delta(), delta);
    pieces_before = path->piece_count();
    error_before = error;
  }
}

/// The largest |q t'^2 - 1| that a thousand places of a piece show.
double sampled_residual(const AnchoredInterval& interval, const PieceBatch<>& batch, std::size_t index) {
  const auto c = batch.coefficients(index);
  const double step = batch.row.step[index];
  double worst = 0;
  for (int i = 1; i < 1000; ++i) {
    const double u = i / 1000.0;
    double t = 0;
    double slope = 0;
    for (std::size_t k = c.size(); k-- > 0;) {
      slope = t + u * slope;
      t = c[k] + u * t;
    }
    const double y = batch.near_end(index).y + step * (interval.forward ? u : 1 - u);
    const double rate = slope / step / (interval.stands_still ? 2 * y : 1);
    const double q = interval.speed_squared.value(std::fabs(t - interval.anchor));
    worst = std::max(worst, std::fabs(q * rate * rate - 1));
  }
  return worst;
}

TEST(ArcLength, TheCertificateBoundsTheErrorOfAPieceAndIsNotFarAboveIt) {
  // A bend, a cusp inside, tension 1 at both ends: plain pieces and square roots, forward and backward.
  const std::vector<double> line{0, 1};
  const std::vector<KeyShape> still(2, {.tension = 1, .continuity = 0, .bias = 0});
  const std::vector<double> parabola{-3, 9, -1, 1, 1, 1, 3, 9};
  const PathSpec bend{.spline = Spline::catmull_rom, .axis_count = 2, .keys = parabola};
  const PathSpec cusp{.spline = Spline::catmull_rom, .axis_count = 2, .keys = cusp_keys};
  const PathSpec rest{.spline = Spline::tcb, .axis_count = 1, .keys = line, .shapes = still};
  int checked = 0;
  for (const PathSpec& spec : {bend, cusp, rest}) {
    const MeasuredPath path(spec);
    const SegmentSpeed speed(path.path().segment(spec.keys.size() > 2 ? 1 : 0), path.path().weights());
    const AnchoredIntervals split = split_where_slow(speed);
    for (std::size_t i = 0; i < split.count; ++i) {
      const AnchoredInterval& interval = split.intervals[i];
      const PieceFitter fitter(interval);
      PieceBatch<> batch;
      batch.near = fitter.at_anchor();
      for (std::size_t end = 0; end < lane_count; ++end) {
        batch.row.tau.set(end, interval.extent * static_cast<double>(end + 1) / 4);
      }
      fitter.fit(0, batch);
      for (std::size_t index = 0; index < lane_count; ++index) {
        const double sampled = sampled_residual(interval, batch, index);
        const double certified = fitter.certified_residual(batch, index);
        EXPECT_GE(certified, sampled);
        EXPECT_LE(certified, 8 * sampled + 1e-11);
        EXPECT_LE(batch.largest_residual(index), sampled * (1 + 1e-9) + 1e-12);
        ++checked;
      }
    }
  }
  EXPECT_GE(checked, 20);
}

TEST(ArcLength, ALineThatStartsFromRestWithNextToNoCurvatureIsMeasured) {
  // P' = b t + c t^2 with b = 0.0077 c: the first stretch has a derivative that is no number, the next ones
  // fit.
  const std::vector<double> line{0, 1, 5.977};
  const std::vector<KeyShape> shapes{{.tension = 1, .continuity = 0, .bias = 0}, {}, {}};
  for (const double delta : {1e-4, 1e-6, 1e-9}) {
    const MeasuredPath path({.spline = Spline::tcb, .axis_count = 1, .keys = line, .shapes = shapes},
                            {.delta = delta});
    EXPECT_NEAR(path->total(), 5.977, 1e-12);
    EXPECT_LT(path->piece_count(), 1000);
  }
}

// --- scale and offset

TEST(ArcLength, NeitherScaleNorOffsetMatters) {
  const MeasuredPath plain({.axis_count = 2, .keys = bent});
  for (const double scale : {std::ldexp(1.0, 332), std::ldexp(1.0, -332)}) {  // about 1e+-100
    std::vector<double> keys = bent;
    for (double& coordinate : keys) coordinate *= scale;
    const MeasuredPath path({.axis_count = 2, .keys = keys});
    EXPECT_EQ(path->total(), plain->total() * scale);
    EXPECT_EQ(path->piece_count(), plain->piece_count());
    for (int i = 0; i <= 100; ++i) {
      const double distance = plain->total() * i / 100;
      EXPECT_EQ(path.locate(distance * scale), plain.locate(distance));
    }
  }
  std::vector<double> keys = bent;
  for (double& coordinate : keys) coordinate += 1e12;
  const MeasuredPath far({.axis_count = 2, .keys = keys});
  EXPECT_EQ(far->total(), plain->total());
}

// --- what is refused

TEST(ArcLength, ADeltaThatFloatingPointCannotReachIsAnError) {
  const std::vector<double> keys{0, 1, 3};
  ArcLengthStorage<2, 4000> storage;
  PathStorage<3, 1> path_storage;
  const auto path = Path::make({.axis_count = 1, .keys = keys}, path_storage.memory());
  const double least = Precision::smallest_delta;
  for (const double delta :
       {0.0, -least, std::nextafter(least, 0.0), 0.1, 1.0, std::numeric_limits<double>::quiet_NaN(),
        std::numeric_limits<double>::infinity()}) {
    const auto refused = ArcLength::make(*path, {.delta = delta}, storage.memory());
    ASSERT_FALSE(refused) << delta;
    EXPECT_EQ(refused.error().code, ErrorCode::accuracy);
  }
  for (const double delta : {least, std::nextafter(0.1, 0.0)}) {
    EXPECT_TRUE(ArcLength::make(*path, {.delta = delta}, storage.memory())) << delta;
  }
}

/// Memory whose parts can be given any size.
struct LooseMemory {
  std::vector<ArcPiece> pieces;
  std::vector<double> begins;
  std::vector<std::int32_t> buckets;
  std::vector<std::int32_t> first_pieces;
  std::vector<TwoSum> segment_begins;

  LooseMemory(std::size_t segments, std::size_t piece_capacity)
      : pieces(piece_capacity),
        begins(piece_capacity),
        buckets(piece_capacity),
        first_pieces(segments + 1),
        segment_begins(segments + 1) {}
  ArcLengthMemory memory() { return {pieces, begins, buckets, first_pieces, segment_begins}; }
};

std::int64_t capacity_needed(const Result<ArcLength>& refused) {
  EXPECT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  return refused.error().needed;
}

TEST(ArcLength, StatesThePiecesNeededWhichJustSuffice) {
  for (const Spline spline : {Spline::smooth, Spline::catmull_rom}) {
    const std::vector<double>& keys = spline == Spline::smooth ? bent : cusp_keys;
    const MeasuredPath path({.spline = spline, .axis_count = 2, .keys = keys});
    const auto segments = static_cast<std::size_t>(path.path().segment_count());
    for (const std::size_t capacity : {1U, 2U, 20U}) {
      LooseMemory small(segments, capacity);
      const auto needed = capacity_needed(ArcLength::make(path.path(), {}, small.memory()));
      ASSERT_EQ(needed, path->piece_count());
      LooseMemory enough(segments, static_cast<std::size_t>(needed));
      EXPECT_TRUE(ArcLength::make(path.path(), {}, enough.memory()));
      LooseMemory one_less(segments, static_cast<std::size_t>(needed) - 1);
      EXPECT_FALSE(ArcLength::make(path.path(), {}, one_less.memory()));
    }
  }
}

TEST(ArcLength, StatesTheSegmentsNeededWhichJustSuffice) {
  const MeasuredPath path({.axis_count = 2, .keys = bent});
  LooseMemory small(3, 400);
  const auto needed = capacity_needed(ArcLength::make(path.path(), {}, small.memory()));
  ASSERT_EQ(needed, 5);
  LooseMemory enough(static_cast<std::size_t>(needed), 400);
  EXPECT_TRUE(ArcLength::make(path.path(), {}, enough.memory()));
}

TEST(ArcLength, EvenAPathThatStaysNeedsABucket) {
  const std::vector<double> keys{4, 4};
  const MeasuredPath path({.axis_count = 1, .keys = keys});
  LooseMemory none(1, 0);
  const auto needed = capacity_needed(ArcLength::make(path.path(), {}, none.memory()));
  ASSERT_EQ(needed, 1);
  LooseMemory enough(1, static_cast<std::size_t>(needed));
  EXPECT_TRUE(ArcLength::make(path.path(), {}, enough.memory()));
}

}  // namespace arc_length_test
}  // namespace inbetween
