#include "host_tools/fit/curve_sums.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace inbetween {
namespace curve_sums_test {

double value_of(const CurveSums::Terms& terms, const std::vector<double>& unknowns) {
  double value = 0;
  for (const Term& term : terms) value += term.weight * unknowns[term.unknown];
  return value;
}

struct Curve {
  std::vector<double> values;
  CurveEnds ends = CurveEnds::natural;
};
const std::vector<Curve> curves = {{{2, 7, 1, 0, 5, 9}},
                                   {{0, 0, 4, 9, 0, 0, 0, 5, 3, 0, 0}},
                                   {{3, 8, 0, 11, 6, 3}, CurveEnds::periodic},
                                   {{0, 8, 2, 4, 6, 9, 1, 0}, CurveEnds::periodic},
                                   {{4, 9}},
                                   {{4, 9, 4}}};

CurveSums sums_of(const Curve& curve) {
  return {rests_of(curve.values, curve.ends), curve.ends};
}

TEST(CurveSums, TellHowTheCurveAndItsAreaFollowFromNeighbours) {
  const CurveWeights weights{.area = 1.25, .value = -2, .first = 3, .second = 0.5};
  for (const Curve& curve : curves) {
    const CurveSums sums = sums_of(curve);
    const std::vector<double> unknowns = sums.unknowns(curve.values);
    const ControlCurve same(curve.values, curve.ends);
    const std::size_t f = curve.values.size() - 1;
    for (int i = 0; i <= 100; ++i) {
      const CurvePlace place = place_at(static_cast<double>(f) * i / 100, f);
      const CurveValues at = same.at(place);
      const CurveSums::Terms terms = sums.at(place, weights);
      EXPECT_LE(terms.size(), 5U);
      EXPECT_NEAR(value_of(terms, unknowns), 1.25 * at.area - 2 * at.value + 3 * at.first + 0.5 * at.second,
                  1e-11);
    }
    for (std::size_t i = 0; i <= f; ++i) {
      EXPECT_NEAR(value_of(sums.value(i), unknowns), curve.values[i], 1e-12);
    }
  }
}

TEST(CurveSums, OfACurveThatRestsAreFewerThanItsValues) {
  EXPECT_EQ(CurveSums(std::vector<bool>(11), CurveEnds::natural).unknown_count(), 14U);
  // The ends rest with the values beside them, and three rest within.
  EXPECT_EQ(sums_of(curves[1]).unknown_count(), 14U - 3 - 3 - 3);
}

TEST(CurveSums, TheNearestCurveIsTheOneThatIsWanted) {
  for (const Curve& curve : curves) {
    const CurveSums sums = sums_of(curve);
    BandProgram program(sums.unknown_count());
    sums.add_distance(curve.values, 1, program);
    sums.demand_ends(program);
    sums.demand_start(program);
    ASSERT_TRUE(program.solve(std::vector<double>(sums.unknown_count())));
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      EXPECT_NEAR(program.value(sums.value(i)), curve.values[i], 1e-10);
    }
  }
}

TEST(CurveSums, WhereOneValueIsGivenTheOthersMakeTheDistanceLeast) {
  for (const Curve& curve : curves) {
    const std::size_t count = curve.values.size();
    const bool is_periodic = curve.ends == CurveEnds::periodic;
    const CurveSums sums(std::vector<bool>(count), curve.ends);
    BandProgram program(sums.unknown_count());
    sums.add_distance(curve.values, 1, program);
    sums.demand_ends(program);
    sums.demand_start(program);
    program.demand(sums.value(1), curve.values[1] + 2);
    ASSERT_TRUE(program.solve(std::vector<double>(sums.unknown_count())));
    std::vector<double> change;
    for (std::size_t i = 0; i < count; ++i) change.push_back(program.value(sums.value(i)) - curve.values[i]);
    const double least = mean_square(change, curve.ends);
    for (std::size_t i = 0; i + (is_periodic ? 1 : 0) < count; ++i) {
      if (i == 1) continue;
      for (const double more : {-0.01, 0.01}) {
        std::vector<double> other = change;
        other[i] += more;
        if (is_periodic) other.back() = other.front();
        EXPECT_GT(mean_square(other, curve.ends), least);
      }
    }
  }
}

}  // namespace curve_sums_test
}  // namespace inbetween
