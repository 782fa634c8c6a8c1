// A hand's motion of which the truth is known: sampled, with noise, it comes back as keys and a speed curve.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <vector>

#include "host_tools/fit/motion_fit.hpp"
#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace motion_fit_property_test {

constexpr double tolerance = 2;       // px
constexpr double noise = 0.5;         // px, of each axis
constexpr double speed_share = 0.02;  // of the peak speed

struct Drawn {
  oracle::Keys keys;
  std::vector<double> speed;
  int frames = 72;
  double rate = 100;  // of the pointer, Hz
  std::uint32_t seed = 0;
};

void showValue(const Drawn& drawn, std::ostream& out) {
  for (const auto& key : drawn.keys.at) out << "(" << double(key[0]) << ", " << double(key[1]) << ") ";
  out << "speed";
  for (const double value : drawn.speed) out << " " << value;
  out << ", " << drawn.frames << " frames, " << drawn.rate << " Hz, seed " << drawn.seed;
}

int number(int begin, int end) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(begin, end));
}

oracle::Keys keys_of(const std::vector<std::vector<double>>& at) {
  oracle::Keys keys;
  for (const std::vector<double>& key : at) keys.at.push_back({key.begin(), key.end()});
  return keys;
}

/// Keys 120 to 400 px on, at an angle of up to 90 degrees: at full speed no hand turns farther. The pace is
/// that of a few strokes and begins and ends at rest.
Drawn random_drawn() {
  std::vector<std::vector<double>> at = {{500, 300}};
  double heading = number(0, 360);
  for (int count = number(2, 7); count > 0; --count) {
    const double length = number(120, 401);
    const double angle = heading * std::numbers::pi / 180;
    at.push_back({at.back()[0] + length * std::cos(angle), at.back()[1] + length * std::sin(angle)});
    heading += number(-90, 91);
  }
  Drawn drawn{.keys = keys_of(at), .speed = {0, 0}};
  for (int i = number(3, 6); i > 0; --i) drawn.speed.push_back(number(20, 101) / 10.0);
  drawn.speed.insert(drawn.speed.end(), {0, 0});
  drawn.frames = number(48, 121);
  drawn.rate = number(60, 126);
  drawn.seed = static_cast<std::uint32_t>(number(0, 1'000'000));
  return drawn;
}

struct Truth {
  explicit Truth(const Drawn& drawn) : path(drawn.keys), profile(drawn.speed), frames(drawn.frames) {}
  Truth(const MotionFit& fit) : path(keys_of(fit.keys)), profile(fit.speed), frames(fit.frames) {}

  [[nodiscard]] oracle::Row at(double seconds) const {
    return oracle::row_at(path, profile, frames, std::min<long double>(seconds * 24, frames));
  }
  [[nodiscard]] std::vector<double> position(double seconds) const {
    const oracle::Row row = at(seconds);
    return {static_cast<double>(path.position(row.place.segment, row.place.t, 0)),
            static_cast<double>(path.position(row.place.segment, row.place.t, 1))};
  }
  oracle::Path path;
  oracle::Profile profile;
  int frames;
};

SampledMotion recorded(const Drawn& drawn, const Truth& truth) {
  SampledMotion sampled{
      .times = {}, .positions = {}, .tolerances = {tolerance, tolerance}, .weights = {1, 1}};
  std::mt19937 engine(drawn.seed);
  std::normal_distribution<double> shake(0, noise);
  for (int i = 0; i / drawn.rate <= drawn.frames / 24.0; ++i) {
    sampled.times.push_back(i / drawn.rate);
    for (const double x : truth.position(sampled.times.back()))
      sampled.positions.push_back(x + shake(engine));
  }
  return sampled;
}

/// The largest distance from the truth's path to the fit's and back, and the largest difference of speeds as
/// a share of the peak, from 5 % to 95 % of the time.
struct Miss {
  double space = 0, speed = 0;
};

Miss miss_of(const Truth& truth, const Truth& fit) {
  const double seconds = truth.frames / 24.0;
  std::vector<std::vector<double>> one;
  std::vector<std::vector<double>> other;
  double peak = 0;
  Miss miss;
  for (int i = 0; i <= 400; ++i) {
    const double time = seconds * i / 400;
    one.push_back(truth.position(time));
    other.push_back(fit.position(time));
    const double speed = static_cast<double>(truth.at(time).speed);
    peak = std::max(peak, speed);
    if (i >= 20 && i <= 380)
      miss.speed = std::max(miss.speed, std::fabs(static_cast<double>(fit.at(time).speed) - speed));
  }
  miss.speed /= peak;
  const auto distance = [](const std::vector<double>& p, const std::vector<double>& a,
                           const std::vector<double>& b) {
    const double x = b[0] - a[0];
    const double y = b[1] - a[1];
    const double square = x * x + y * y;
    const double t = square > 0 ? std::clamp(((p[0] - a[0]) * x + (p[1] - a[1]) * y) / square, 0.0, 1.0) : 0;
    return std::hypot(p[0] - a[0] - t * x, p[1] - a[1] - t * y);
  };
  const auto farthest = [&](const auto& points, const auto& line) {
    double most = 0;
    for (const auto& point : points) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t i = 1; i < line.size(); ++i)
        least = std::min(least, distance(point, line[i - 1], line[i]));
      most = std::max(most, least);
    }
    return most;
  };
  miss.space = std::max(farthest(one, other), farthest(other, one));
  return miss;
}

TEST(MotionFitProperty, AHandsMotionComesBackWithinItsToleranceAndTwoPercentOfItsPeakSpeed) {
  check_property(200, [] {
    const Drawn drawn = random_drawn();
    const Truth truth(drawn);
    const MotionFit fit = fit_motion(recorded(drawn, truth));
    const Miss miss = miss_of(truth, Truth(fit));
    std::ostringstream drawn_text;
    showValue(drawn, drawn_text);
    RC_LOG() << drawn_text.str() << "\nspace " << miss.space << " px, speed " << miss.speed
             << " of the peak, " << fit.keys.size() << " keys, " << fit.speed.size() << " control values\n";
    RC_ASSERT(fit.frames == drawn.frames);
    RC_ASSERT(miss.space <= tolerance);
    RC_ASSERT(miss.speed <= speed_share);
  });
}

}  // namespace motion_fit_property_test
}  // namespace inbetween
