#pragma once

#include <fuzzer/FuzzedDataProvider.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>

#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"

/// A move made from any bytes: mostly one that an animator could draw, often one of the hard cases, and now
/// and then numbers that must be refused.

namespace inbetween {

struct AnyMove {
  Spline spline = Spline::smooth;
  bool closed = false;
  std::int32_t axis_count = 1;
  std::vector<double> keys;
  std::vector<double> weights;
  std::vector<KeyShape> shapes;
  std::vector<double> control_values;
  std::int32_t frames = 1;
  FrameRate fps;
  ArcLengthOptions options;
  std::int32_t substeps = 10;  ///< of the Runge-Kutta solver; 0 or less: not asked
  std::vector<KeyLock> locks;
  std::vector<std::int32_t> key_frames;  ///< not empty: timed by these, without a speed curve
  Kinetic kinetic = Kinetic::linear;
  bool overshoot = true;
  std::vector<double> lap;  ///< of a closed path
  bool rests_at_start = true;
  bool rests_at_end = true;
  CurveEnds ends = CurveEnds::natural;
  std::vector<std::int32_t> overlap_frames;  ///< of a linear path over frames
  std::vector<double> path_tolerances;       ///< of a linear path at a drawn speed

  [[nodiscard]] bool has_knots() const { return kinetic == Kinetic::curves || !path_tolerances.empty(); }
  [[nodiscard]] PathSpec path_spec() const {
    PathSpec spec{.spline = spline,
                  .closed = closed,
                  .axis_count = axis_count,
                  .keys = keys,
                  .lap = lap,
                  .weights = weights,
                  .shapes = shapes,
                  .overshoot = overshoot,
                  .rests_at_start = rests_at_start,
                  .rests_at_end = rests_at_end,
                  .overlap_frames = overlap_frames,
                  .path_tolerances = path_tolerances};
    if (kinetic == Kinetic::curves) spec.key_frames = key_frames;
    return spec;
  }
};

/// Draws the numbers of a move. Every byte string gives a move; a short one gives a small move.
class MoveFromBytes {
 public:
  explicit MoveFromBytes(FuzzedDataProvider& bytes) : bytes_(bytes) {}

  AnyMove draw() {
    AnyMove move;
    move.spline = bytes_.PickValueInArray({Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear});
    move.closed = bytes_.ConsumeBool();
    move.axis_count = bytes_.ConsumeIntegralInRange<std::int32_t>(1, 6);
    move.frames = frames();
    move.fps = fps();
    move.options = options();
    move.substeps = bytes_.ConsumeIntegralInRange<std::int32_t>(-12, 12);
    const auto key_count = bytes_.ConsumeIntegralInRange<std::size_t>(1, 16);
    const auto axes = static_cast<std::size_t>(move.axis_count);
    if (bytes_.ConsumeBool()) {
      for (std::size_t axis = 0; axis < axes; ++axis) move.weights.push_back(weight());
    }
    const auto value_count = bytes_.ConsumeIntegralInRange<std::size_t>(1, 24);
    for (std::size_t i = 0; i < value_count; ++i) move.control_values.push_back(control_value());
    if (move.spline == Spline::tcb) {
      for (std::size_t i = 0; i < key_count; ++i) move.shapes.push_back({shape(), shape(), shape()});
    }
    scale_ = bytes_.PickValueInArray({0, 0, 0, 0, 10, -10, 60, -60, 332, -332});
    offset_ = bytes_.PickValueInArray<double>({0, 0, 0, 0, 1e6, 1e12});
    for (std::size_t i = 0; i < key_count * axes; ++i) move.keys.push_back(coordinate(move.keys, axes));
    draw_timing(move, static_cast<std::int32_t>(key_count));
    draw_more(move, axes);
    return move;
  }

 private:
  /// Drawn from what is left of the bytes, so that a short string is timed by its speed curve.
  void draw_timing(AnyMove& move, std::int32_t key_count) {
    const int timing = bytes_.ConsumeIntegralInRange(0, 7);
    if (timing == 1 || timing == 2) {
      std::int32_t frame = 0;
      const std::int32_t count = bytes_.ConsumeBool() ? key_count : key_count + 1;  // closed: and back
      for (std::int32_t i = 0; i < count; ++i) {
        move.key_frames.push_back(frame);
        frame += bytes_.ConsumeIntegralInRange(0, 30);
      }
      if (bytes_.ConsumeIntegralInRange(0, 7) != 0) move.frames = move.key_frames.back();
      move.kinetic = timing == 1 ? Kinetic::linear : Kinetic::monotone;
    } else if (timing >= 3) {
      const std::int32_t last_key = move.closed && key_count > 1 ? key_count : key_count - 1;
      std::int32_t frame = 0;
      for (std::int32_t key = 0; key <= last_key; ++key) {
        if (bytes_.ConsumeIntegralInRange(0, 2) != 0) continue;
        frame += bytes_.ConsumeIntegralInRange(-1, 20);
        const bool is_held = bytes_.ConsumeIntegralInRange(0, 3) == 0;
        const std::int32_t hold = is_held ? bytes_.ConsumeIntegralInRange(0, 12) : 0;
        move.locks.push_back({key, frame, hold, bytes_.ConsumeIntegralInRange(0, 3) == 0});
      }
    }
  }
  /// From what is left behind all that, so that a string means what it did before there was more.
  void draw_more(AnyMove& move, std::size_t axes) {
    move.overshoot = bytes_.ConsumeIntegralInRange(0, 3) != 1;
    if (!move.key_frames.empty() && bytes_.ConsumeIntegralInRange(0, 1) == 1) move.kinetic = Kinetic::curves;
    move.rests_at_start = bytes_.ConsumeIntegralInRange(0, 1) == 0;
    move.rests_at_end = bytes_.ConsumeIntegralInRange(0, 1) == 0;
    if (bytes_.ConsumeIntegralInRange(0, 3) == 1) {
      for (std::size_t axis = 0; axis < axes; ++axis) {
        move.lap.push_back(std::ldexp(static_cast<double>(bytes_.ConsumeIntegral<std::int8_t>()), scale_));
      }
    }
    for (KeyLock& lock : move.locks) {
      lock.ease = lock.hold == 0 && !lock.breaks && bytes_.ConsumeIntegralInRange(0, 3) == 1;
    }
    if (move.key_frames.empty() && move.locks.empty() && bytes_.ConsumeIntegralInRange(0, 3) == 1) {
      move.ends = CurveEnds::periodic;
      if (bytes_.ConsumeIntegralInRange(0, 7) != 7) move.control_values.back() = move.control_values.front();
    }
    draw_corners(move, move.keys.size() / axes);
  }
  void draw_corners(AnyMove& move, std::size_t keys) {
    if (move.spline != Spline::linear || !move.locks.empty() || bytes_.ConsumeIntegralInRange(0, 1) == 0)
      return;
    if (move.kinetic == Kinetic::curves) {
      for (std::size_t k = 0; k < keys; ++k)
        move.overlap_frames.push_back(bytes_.ConsumeIntegralInRange(-1, 40));
    } else if (move.key_frames.empty()) {
      for (std::size_t k = 0; k < keys; ++k)
        move.path_tolerances.push_back(
            std::ldexp(bytes_.ConsumeFloatingPointInRange(-0.01, 1.0), scale_ + 4));
    }
  }
  std::int32_t frames() {
    switch (bytes_.ConsumeIntegralInRange(0, 15)) {
      case 0:
        return bytes_.ConsumeIntegral<std::int32_t>();
      case 1:
      case 2:
        return bytes_.ConsumeIntegralInRange(1, 2000);
      default:
        return bytes_.ConsumeIntegralInRange(1, 60);
    }
  }
  FrameRate fps() {
    if (bytes_.ConsumeIntegralInRange(0, 15) == 0) {
      return {bytes_.ConsumeIntegralInRange(-1, 1000), bytes_.ConsumeIntegralInRange(-1, 1001)};
    }
    return bytes_.PickValueInArray<FrameRate>({{24, 1}, {24000, 1001}, {1000, 1}, {1, 1000}});
  }
  ArcLengthOptions options() {
    const double raw_delta = raw();
    const double delta = bytes_.PickValueInArray<double>(
        {Precision::default_delta, 1e-2, 1e-4, Precision::smallest_delta, raw_delta});
    return {.delta = delta,
            .acceptance = bytes_.ConsumeBool() ? Acceptance::certified : Acceptance::estimated};
  }
  double weight() {
    const double raw_weight = raw();
    return bytes_.PickValueInArray<double>({1, 1, 0, 0.01, 100, 1e-30, raw_weight});
  }
  double control_value() {
    switch (bytes_.ConsumeIntegralInRange(0, 7)) {
      case 0:
        return raw();
      case 1:
      case 2:
        return 0;
      case 3:
        return std::ldexp(1.0, -bytes_.ConsumeIntegralInRange(0, 200));
      default:
        return static_cast<double>(bytes_.ConsumeIntegralInRange(0, 100));
    }
  }
  /// A tension, continuity or bias: often at an end of its range, or nearly.
  double shape() {
    const double nearly = 1 - std::ldexp(1.0, -bytes_.ConsumeIntegralInRange(1, 52));
    const double raw_shape = raw();
    const auto part = static_cast<double>(bytes_.ConsumeIntegral<std::int8_t>()) / 100;
    return bytes_.PickValueInArray<double>({0, 1, -1, nearly, -nearly, part, part, raw_shape});
  }
  double coordinate(const std::vector<double>& before, std::size_t axes) {
    const double earlier = before.size() >= axes ? before[before.size() - axes] : 0.0;
    const auto number = static_cast<double>(bytes_.ConsumeIntegral<std::int8_t>());
    switch (bytes_.ConsumeIntegralInRange(0, 15)) {
      case 0:
        return raw();
      case 1:
      case 2:
      case 3:
        return earlier;
      case 4:
        return earlier + number * std::numeric_limits<double>::epsilon() * earlier;
      case 5:
        return earlier + std::ldexp(number, scale_ - bytes_.ConsumeIntegralInRange(0, 60));
      case 6:
        return std::ldexp(number, bytes_.ConsumeIntegralInRange(-340, 340));
      default:
        return offset_ + std::ldexp(number, scale_);
    }
  }
  /// Any bits: a NaN, an infinity, a subnormal number.
  double raw() {
    if (bytes_.ConsumeIntegralInRange(0, 3) != 0) return bytes_.ConsumeIntegral<std::int8_t>();
    std::array<std::uint8_t, sizeof(double)> bits{};
    for (std::uint8_t& byte : bits) byte = bytes_.ConsumeIntegral<std::uint8_t>();
    double value = 0;
    std::memcpy(&value, bits.data(), sizeof(double));
    return value;
  }

  FuzzedDataProvider& bytes_;
  int scale_ = 0;
  double offset_ = 0;
};

/// The move in numbers that can be pasted into a test, to the last bit.
inline void print(const AnyMove& move) {
  const auto list = [](const char* name, const std::vector<double>& numbers) {
    std::fprintf(stderr, "  .%s = {", name);
    for (const double number : numbers) std::fprintf(stderr, "%a, ", static_cast<double>(number));
    std::fprintf(stderr, "}\n");
  };
  std::fprintf(stderr,
               "fuzz: spline %d, closed %d, axes %d, frames %d, fps %d/%d, delta %a, certified %d, k %d\n",
               static_cast<int>(move.spline), static_cast<int>(move.closed), move.axis_count, move.frames,
               move.fps.numerator, move.fps.denominator, static_cast<double>(move.options.delta),
               static_cast<int>(move.options.acceptance == Acceptance::certified), move.substeps);
  for (const KeyLock& lock : move.locks) {
    std::fprintf(stderr, "  lock {%d, %d, %d, %d, %d}\n", lock.key, lock.frame, lock.hold,
                 static_cast<int>(lock.breaks), static_cast<int>(lock.ease));
  }
  if (!move.key_frames.empty()) {
    std::fprintf(stderr, "  key frames of kinetic %d", static_cast<int>(move.kinetic));
    for (const std::int32_t frame : move.key_frames) std::fprintf(stderr, " %d", frame);
    std::fprintf(stderr, "\n");
  }
  std::fprintf(stderr, "  overshoot %d, rests %d %d, periodic %d\n", static_cast<int>(move.overshoot),
               static_cast<int>(move.rests_at_start), static_cast<int>(move.rests_at_end),
               static_cast<int>(move.ends == CurveEnds::periodic));
  for (const std::int32_t overlap : move.overlap_frames) std::fprintf(stderr, "  overlap %d\n", overlap);
  list("tolerances", move.path_tolerances);
  list("keys", move.keys);
  list("lap", move.lap);
  list("weights", move.weights);
  list("speed", move.control_values);
  std::fprintf(stderr, "  .shapes = {");
  for (const KeyShape& shape : move.shapes) {
    std::fprintf(stderr, "{%a, %a, %a}, ", static_cast<double>(shape.tension),
                 static_cast<double>(shape.continuity), static_cast<double>(shape.bias));
  }
  std::fprintf(stderr, "}\n");
}

}  // namespace inbetween
