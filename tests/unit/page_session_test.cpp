#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>

#include "editor/solver/session.hpp"

/// What the editor's page asks of its solver.

namespace inbetween {
namespace page_session_test {

using editor::Exchange;
using editor::Session;
using editor::TrackRequest;

/// A track of one axis with two keys, over one second at an even speed.
std::unique_ptr<Exchange> straight_track() {
  auto arguments = std::make_unique<Exchange>();
  TrackRequest& request = arguments->records.track_request;
  request = {};
  request.spline = static_cast<std::int32_t>(Spline::linear);
  request.kinetic = static_cast<std::int32_t>(Kinetic::curves);
  request.frames = 24;
  request.fps_numerator = 24;
  request.fps_denominator = 1;
  request.axis_count = 1;
  request.key_count = 2;
  request.weight_count = 1;
  request.control_value_count = 1;
  constexpr std::array<double, 4> keys_weight_and_speed{0, 100, 1, 1};
  std::ranges::copy(keys_weight_and_speed, arguments->numbers.begin());
  return arguments;
}

TEST(PageSession, RefusesASplineOrAKineticThatItDoesNotKnow) {
  const auto session = std::make_unique<Session>();
  const auto arguments = straight_track();
  TrackRequest& request = arguments->records.track_request;
  EXPECT_TRUE(session->solve_track(0, *arguments).has_value());
  for (std::int32_t* const word : {&request.spline, &request.kinetic}) {
    const std::int32_t known = *word;
    for (const std::int32_t unknown : {-1, 4}) {
      *word = unknown;
      const Status solved = session->solve_track(0, *arguments);
      ASSERT_FALSE(solved.has_value()) << unknown;
      EXPECT_EQ(solved.error().code, ErrorCode::out_of_range);
    }
    *word = known;
  }
  EXPECT_TRUE(session->solve_track(0, *arguments).has_value());
}

}  // namespace page_session_test
}  // namespace inbetween
