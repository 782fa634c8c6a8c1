// Random networks of moving points, against Coons' formula in long double, and against what it promises.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <numeric>
#include <ostream>
#include <vector>

#include "host_tools/plan/network.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "tests/support/oracle_network.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace network_property_test {

struct DrawnRow {
  std::size_t axis = 0;
  std::vector<std::int32_t> frames;
  std::vector<double> at;
};

struct RandomNetwork {
  std::vector<double> places;
  std::vector<std::int32_t> key_frames;
  std::vector<std::vector<double>> keys;  ///< of each axis
  std::vector<DrawnRow> drawn;
  bool rests_at_start = true;
  bool rests_at_end = true;

  [[nodiscard]] std::size_t axes() const { return places.size(); }
  [[nodiscard]] std::int32_t last() const { return key_frames.back(); }
  [[nodiscard]] const DrawnRow* drawn_of(std::size_t axis) const {
    const auto found = std::ranges::find(drawn, axis, &DrawnRow::axis);
    return found == drawn.end() ? nullptr : &*found;
  }
  /// Of all numbers: what is added to an axis may be large beside what it does itself.
  [[nodiscard]] double range() const {
    double low = keys[0][0];
    double high = low;
    const auto widen = [&](const std::vector<double>& values) {
      low = std::min(low, *std::ranges::min_element(values));
      high = std::max(high, *std::ranges::max_element(values));
    };
    for (const std::vector<double>& values : keys) widen(values);
    for (const DrawnRow& row : drawn) widen(row.at);
    return high - low;
  }

  [[nodiscard]] oracle::TimedKeys timed(const std::vector<double>& at,
                                        const std::vector<std::int32_t>& frames) const {
    oracle::TimedKeys timed;
    timed.at.assign(at.begin(), at.end());
    timed.frames.assign(frames.begin(), frames.end());
    timed.rests_at_start = rests_at_start;
    timed.rests_at_end = rests_at_end;
    return timed;
  }
  [[nodiscard]] oracle::NetworkOracle oracle() const {
    std::vector<oracle::NetworkAxis> row;
    for (std::size_t d = 0; d < axes(); ++d) {
      row.push_back({.place = places[d], .keys = timed(keys[d], key_frames), .drawn = {}});
      if (const DrawnRow* curve = drawn_of(d)) row.back().drawn = timed(curve->at, curve->frames);
    }
    return oracle::NetworkOracle(std::move(row));
  }
};

void showValue(const RandomNetwork& network, std::ostream& out) {
  const auto list = [&](const auto& values) {
    for (const auto value : values) out << " " << value;
  };
  out << "rest " << network.rests_at_start << network.rests_at_end << "; places";
  list(network.places);
  out << "; key frames";
  list(network.key_frames);
  for (const std::vector<double>& keys : network.keys) {
    out << "; keys";
    list(keys);
  }
  for (const DrawnRow& row : network.drawn) {
    out << "; axis " << row.axis << " drawn on";
    list(row.frames);
    out << " at";
    list(row.at);
  }
}

/// A network as a plan has it: solved by the product, and played by the core.
class PlayedNetwork {
 public:
  explicit PlayedNetwork(const RandomNetwork& from)
      : keys_(numbers_of(from)), curves_(curves_of(from)), network_(spec_of(from)), path_(network_.path()) {
    const std::vector<double> weights(from.axes(), 1);
    track_.emplace(
        TrackSpec{.path = {},
                  .cubics = CubicPathSpec{.spline = Spline::smooth,
                                          .closed = false,
                                          .axis_count = static_cast<std::int32_t>(from.axes()),
                                          .key_count = static_cast<std::int32_t>(from.key_frames.size()),
                                          .cubics = path_.cubics,
                                          .weights = weights,
                                          .knots = path_.knots,
                                          .over_frames = true},
                  .control_values = {},
                  .frames = from.last(),
                  .fps = {24, 1},
                  .arc_length = {},
                  .key_frames = from.key_frames,
                  .kinetic = Kinetic::curves},
        Solver::closed_form);
  }

  [[nodiscard]] const Network& network() const { return network_; }
  [[nodiscard]] const CubicsOverFrames& path() const { return path_; }
  [[nodiscard]] std::vector<double> at(std::int32_t frame, double fraction = 0) const {
    std::vector<double> positions(static_cast<std::size_t>(track_->track().path().axis_count()));
    track_->track().positions({frame, fraction}, positions);
    return positions;
  }

 private:
  static std::vector<double> numbers_of(const RandomNetwork& from) {
    std::vector<double> numbers;
    for (std::size_t k = 0; k < from.key_frames.size(); ++k) {
      for (const std::vector<double>& keys : from.keys) numbers.push_back(keys[k]);
    }
    return numbers;
  }
  static std::vector<NetworkCurve> curves_of(const RandomNetwork& from) {
    std::vector<NetworkCurve> curves;
    for (const DrawnRow& row : from.drawn) curves.push_back({row.axis, row.frames, row.at});
    return curves;
  }
  [[nodiscard]] NetworkSpec spec_of(const RandomNetwork& from) const {
    return {.keys = keys_,
            .key_frames = from.key_frames,
            .places = from.places,
            .curves = curves_,
            .rests_at_start = from.rests_at_start,
            .rests_at_end = from.rests_at_end};
  }

  std::vector<double> keys_;
  std::vector<NetworkCurve> curves_;
  Network network_;
  CubicsOverFrames path_;
  std::optional<SolvedTrack> track_;
};

std::vector<std::int32_t> random_frames(std::int32_t last, int most) {
  std::vector<std::int32_t> frames{0};
  for (int i = *rc::gen::inRange(0, most); i > 0; --i) {
    frames.push_back(frames.back() + *rc::gen::inRange(1, std::max(2 * last / most, 2)));
    if (frames.back() >= last) frames.pop_back();
  }
  frames.push_back(last);
  return frames;
}

/// Few values, so that neighbouring ones are often the same and the axis rests, beside others.
double random_value() {
  const bool is_plain = *rc::gen::inRange(0, 3) == 0;
  return is_plain ? *rc::gen::inRange(-1, 2) * 10.0 : *rc::gen::inRange(-100'000, 100'001) / 1000.0;
}

/// A drawn curve meets the keys of its axis, which need not be on frames of its points.
RandomNetwork random_network() {
  RandomNetwork network;
  const int axes = *rc::gen::inRange(1, 9);
  double place = *rc::gen::inRange(-3, 4);
  for (int d = 0; d < axes; ++d) {
    network.places.push_back(place);
    place += std::max(*rc::gen::inRange(-1, 4), 0) / 3.0;
  }
  network.rests_at_start = *rc::gen::arbitrary<bool>();
  network.rests_at_end = *rc::gen::arbitrary<bool>();
  const std::int32_t last = *rc::gen::inRange(2, 97);
  network.key_frames = random_frames(last, 6);
  for (int d = 0; d < axes; ++d) {
    std::vector<double>& keys = network.keys.emplace_back();
    for (std::size_t k = 0; k < network.key_frames.size(); ++k) keys.push_back(random_value());
    if (*rc::gen::inRange(0, 2) == 0) continue;
    DrawnRow row{.axis = static_cast<std::size_t>(d), .frames = random_frames(last, 9), .at = {}};
    for (std::size_t i = 0; i < row.frames.size(); ++i) row.at.push_back(random_value());
    const std::vector<oracle::TimedPiece> curve = smooth_curve(network.timed(row.at, row.frames));
    for (std::size_t k = 0; k < keys.size(); ++k) {
      keys[k] = static_cast<double>(oracle::curve_at(curve, network.key_frames[k], 0));
    }
    network.drawn.push_back(std::move(row));
  }
  return network;
}

TEST(NetworkProperty, EveryAxisIsWhereCoonsFormulaSays) {
  double worst = 0;
  check_property(2000, [&] {
    const RandomNetwork network = random_network();
    RC_LOG() << rc::toString(network);
    const PlayedNetwork played(network);
    RC_ASSERT(!played.network().gap().has_value());
    const oracle::NetworkOracle oracle = network.oracle();
    const double range = network.range();
    for (std::int32_t eighth = 0; eighth <= 8 * network.last(); ++eighth) {
      const std::vector<double> at = played.at(eighth / 8, eighth % 8 / 8.0);
      for (std::size_t d = 0; d < network.axes(); ++d) {
        const auto wanted = static_cast<double>(oracle.at(d, eighth / 8.0L, 0));
        RC_ASSERT(std::fabs(at[d] - wanted) <= 1e-9 * range);
        if (range > 0) worst = std::max(worst, std::fabs(at[d] - wanted) / range);
      }
    }
  });
  std::cout << "largest difference: " << worst << " of the range\n";
}

TEST(NetworkProperty, EveryKeyAndEveryDrawnPointIsMet) {
  check_property(2000, [] {
    const RandomNetwork network = random_network();
    RC_LOG() << rc::toString(network);
    const PlayedNetwork played(network);
    const double rounding = 1e-9 * network.range();
    for (std::size_t k = 0; k < network.key_frames.size(); ++k) {
      const std::vector<double> at = played.at(network.key_frames[k]);
      for (std::size_t d = 0; d < network.axes(); ++d) {
        RC_ASSERT(std::fabs(at[d] - network.keys[d][k]) <= rounding);
      }
    }
    for (const DrawnRow& row : network.drawn) {
      for (std::size_t i = 0; i < row.frames.size(); ++i) {
        RC_ASSERT(std::fabs(played.at(row.frames[i])[row.axis] - row.at[i]) <= rounding);
      }
    }
  });
}

TEST(NetworkProperty, NeitherPositionNorVelocityNorAccelerationSteps) {
  check_property(2000, [] {
    const RandomNetwork network = random_network();
    RC_LOG() << rc::toString(network);
    const PlayedNetwork played(network);
    const std::vector<Cubic>& cubics = played.path().cubics;
    const std::vector<FrameKnot>& knots = played.path().knots;
    const std::size_t axes = network.axes();
    for (std::size_t d = 0; d < axes; ++d) {
      double largest[3] = {network.range(), 0, 0};
      const auto derivatives = [&](std::size_t k, double t) {
        const Cubic& cubic = cubics[k * axes + d];
        const double rate = 4.0 / knots[k].length;  // per frame
        return std::array{cubic.value(t), rate * cubic.derivative(t), rate * rate * cubic.second(t)};
      };
      for (std::size_t k = 0; k < knots.size(); ++k) {
        for (const double t : {0.0, 1.0}) {
          for (std::size_t n = 1; n < 3; ++n)
            largest[n] = std::max(largest[n], std::fabs(derivatives(k, t)[n]));
        }
      }
      for (std::size_t k = 1; k < knots.size(); ++k) {
        for (std::size_t n = 0; n < 3; ++n) {
          const double step = std::fabs(derivatives(k, 0)[n] - derivatives(k - 1, 1)[n]);
          RC_ASSERT(step <= 1e-9 * (largest[n] + network.range()));
        }
      }
    }
  });
}

TEST(NetworkProperty, AxesOfOnePlaceMayChangeTheirOrder) {
  check_property(2000, [] {
    const RandomNetwork network = random_network();
    RC_LOG() << rc::toString(network);
    std::vector<std::size_t> order(network.axes());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t d = 0; d + 1 < order.size(); ++d) {
      const auto other = static_cast<std::size_t>(
          *rc::gen::inRange<int>(static_cast<int>(d), static_cast<int>(order.size())));
      if (network.places[order[d]] == network.places[order[other]]) std::swap(order[d], order[other]);
    }
    RandomNetwork permuted = network;
    permuted.drawn.clear();
    for (std::size_t d = 0; d < order.size(); ++d) {
      permuted.keys[d] = network.keys[order[d]];
      if (const DrawnRow* row = network.drawn_of(order[d]))
        permuted.drawn.push_back({d, row->frames, row->at});
    }
    const PlayedNetwork one(network);
    const PlayedNetwork other(permuted);
    for (std::int32_t half = 0; half <= 2 * network.last(); ++half) {
      const std::vector<double> here = one.at(half / 2, half % 2 / 2.0);
      const std::vector<double> there = other.at(half / 2, half % 2 / 2.0);
      for (std::size_t d = 0; d < order.size(); ++d) {
        RC_ASSERT(std::fabs(there[d] - here[order[d]]) <= 1e-12 * network.range());
      }
    }
  });
}

/// A drawn curve that misses a key by more than rounding is told, with the key and the curve.
TEST(NetworkProperty, ACurveThatMissesAKeyIsTold) {
  check_property(2000, [] {
    RandomNetwork network = random_network();
    if (network.drawn.empty() || network.range() == 0) return;
    RC_LOG() << rc::toString(network);
    const auto curve = *rc::gen::inRange<std::size_t>(0, network.drawn.size());
    const auto key = *rc::gen::inRange<std::size_t>(0, network.key_frames.size());
    network.keys[network.drawn[curve].axis][key] += 1e-8 * network.range();
    const std::optional<NetworkGap> gap = PlayedNetwork(network).network().gap();
    RC_ASSERT(gap.has_value());
    RC_ASSERT(gap->curve == curve);
    RC_ASSERT(gap->key == key);
  });
}

}  // namespace network_property_test
}  // namespace inbetween
