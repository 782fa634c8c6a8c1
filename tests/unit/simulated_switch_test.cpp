// The simulated switch against the place and the times that its settings say.
#include "sim/simulated_switch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace inbetween {
namespace simulated_switch_test {

constexpr std::int64_t tick_ns = 4'000'000;
constexpr double speed = 10;  // mm/s, 0.04 mm a tick

/// An axis that moves evenly, and what a switch tells meanwhile.
struct Ride {
  explicit Ride(const SimulatedSwitch::Settings& settings, double position = 0, std::uint32_t seed = 1)
      : there(settings, position, seed), at{.position = position} {}

  void go(double velocity, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const Setpoint next{at.position + velocity * 0.004, velocity, 0};
      there.move(now_ns, {at.position, velocity, 0}, now_ns + tick_ns, next, events);
      at = next;
      now_ns += tick_ns;
    }
  }

  SimulatedSwitch there;
  Setpoint at;
  std::int64_t now_ns = 1'000'000'000;
  std::vector<LineEvent> events;
};

/// 1 mm at 10 mm/s; and 0.3 mm back beyond the place it takes 0.03 s longer than to the place.
TEST(SimulatedSwitch, ClosesAtItsPlaceAndOpensItsHysteresisBeforeIt) {
  Ride ride({.closes = 1.0, .hysteresis = 0.3});
  EXPECT_FALSE(ride.there.level());
  ride.go(speed, 50);
  ASSERT_EQ(ride.events.size(), 1U);
  EXPECT_NEAR(static_cast<double>(ride.events[0].at_ns), 1.1e9, 2);
  EXPECT_TRUE(ride.events[0].level);
  EXPECT_TRUE(ride.there.level());
  ride.go(-speed, 50);  // from 2 mm
  ASSERT_EQ(ride.events.size(), 2U);
  EXPECT_NEAR(static_cast<double>(ride.events[1].at_ns), 1.2e9 + 0.13e9, 2);
  EXPECT_FALSE(ride.there.level());
}

TEST(SimulatedSwitch, FacesTheOtherWayAndWithTheOtherLevel) {
  Ride ride({.line = 3, .active_level = false, .is_above = false, .closes = -1.0});
  EXPECT_TRUE(ride.there.level());
  ride.go(-speed, 50);
  ASSERT_EQ(ride.events.size(), 1U);
  EXPECT_EQ(ride.events[0].line, 3);
  EXPECT_FALSE(ride.events[0].level);
  EXPECT_NEAR(static_cast<double>(ride.events[0].at_ns), 1.1e9, 2);
}

/// The cubic through both ends, which is exact for an even jerk: 1 mm is passed where 400/3 t^3 = 1.
TEST(SimulatedSwitch, TheTimeOfAnEdgeIsThatOfTheCurvedMotion) {
  SimulatedSwitch there({.closes = 1.0}, 0, 1);
  std::vector<LineEvent> events;
  const auto at = [](double t) { return Setpoint{400 * t * t * t / 3, 400 * t * t, 800 * t}; };
  for (int i = 0; i < 60; ++i) {
    there.move(i * tick_ns, at(i * 0.004), (i + 1) * tick_ns, at((i + 1) * 0.004), events);
  }
  ASSERT_EQ(events.size(), 1U);
  EXPECT_NEAR(static_cast<double>(events[0].at_ns), std::cbrt(3.0 / 400) * 1e9, 2);
}

TEST(SimulatedSwitch, BouncesForNoLongerThanItSaysAndEndsActuated) {
  int bounced = 0;
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    Ride ride({.closes = 1.0, .bounce_s = 0.003, .max_bounces = 5}, 0, seed);
    ride.go(speed, 50);
    ASSERT_EQ(ride.events.size() % 2, 1U);
    EXPECT_LE(ride.events.size(), 11U);
    EXPECT_NEAR(static_cast<double>(ride.events.front().at_ns), 1.1e9, 2);
    EXPECT_LE(ride.events.back().at_ns - ride.events.front().at_ns, 3'000'001);
    EXPECT_TRUE(ride.there.level());
    for (std::size_t i = 1; i < ride.events.size(); ++i) {
      EXPECT_GE(ride.events[i].at_ns, ride.events[i - 1].at_ns);
      EXPECT_NE(ride.events[i].level, ride.events[i - 1].level);
    }
    if (ride.events.size() > 1) ++bounced;
  }
  EXPECT_GT(bounced, 25);
}

TEST(SimulatedSwitch, NoiseComesAsShortPulsesAndTheSameSeedRepeatsThem) {
  const SimulatedSwitch::Settings settings{.closes = 1.0, .noise_hz = 20, .longest_noise_s = 2e-4};
  Ride ride(settings);
  Ride again(settings);
  Ride other(settings, 0, 2);
  for (Ride* each : {&ride, &again, &other}) each->go(0, 2500);  // 10 s
  EXPECT_NEAR(static_cast<double>(ride.events.size()) / 2, 200, 60);
  EXPECT_FALSE(ride.there.level());
  for (std::size_t i = 0; i + 1 < ride.events.size(); i += 2) {
    EXPECT_LE(ride.events[i + 1].at_ns - ride.events[i].at_ns, 200'000);
  }
  const auto times = [](const Ride& each) {
    std::vector<std::int64_t> result;
    for (const LineEvent& event : each.events) result.push_back(event.at_ns);
    return result;
  };
  EXPECT_EQ(times(ride), times(again));
  EXPECT_NE(times(ride), times(other));
}

TEST(SimulatedSwitch, StuckItStaysActuatedAndOpenItNeverIs) {
  Ride stuck({.closes = 1.0, .fault = SimulatedSwitch::Fault::stuck});
  stuck.go(speed, 50);
  stuck.go(-speed, 100);
  EXPECT_EQ(stuck.events.size(), 1U);
  EXPECT_TRUE(stuck.there.level());
  Ride open({.closes = 1.0, .fault = SimulatedSwitch::Fault::open});
  open.go(speed, 50);
  EXPECT_TRUE(open.events.empty());
}

TEST(SimulatedSwitch, ChatteringItOpensAgainAndAgainWhileItIsActuated) {
  Ride ride({.closes = 1.0, .fault = SimulatedSwitch::Fault::chatter});
  ride.go(speed, 20);
  EXPECT_TRUE(ride.events.empty());
  ride.go(speed, 30);
  EXPECT_GT(ride.events.size(), 60U);
  ride.go(-speed, 30);
  const std::size_t until_open = ride.events.size();
  ride.go(-speed, 30);
  EXPECT_EQ(ride.events.size(), until_open);
  EXPECT_FALSE(ride.there.level());
}

}  // namespace simulated_switch_test
}  // namespace inbetween
