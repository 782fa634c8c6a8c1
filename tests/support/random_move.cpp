#include "tests/support/random_move.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <sstream>
#include <stdexcept>

namespace inbetween {
namespace {

using oracle::Kind;

// RapidCheck narrows ranges while its size is small; a move of the first test is as random as one of the
// last.
int number(int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, below));
}
bool happens(int percent) {
  return number(100) >= 100 - percent;
}

std::size_t count_between(int least, int most) {
  return static_cast<std::size_t>(least) + static_cast<std::size_t>(number(most - least + 1));
}

/// -range..range, and shrinking to zero.
int signed_number(int range) {
  const int n = number(2 * range + 1);
  return n % 2 == 1 ? (n + 1) / 2 : -n / 2;
}

double power_of_ten(int exponent) {
  return std::pow(10.0, exponent);
}

/// How one axis is drawn: coordinate = offset + scale * whole number.
struct AxisRange {
  double scale;
  double offset;
  bool constant;
};

AxisRange axis_range(double common_scale) {
  const double scale = common_scale * power_of_ten(signed_number(3));
  const double offset = happens(30) ? scale * signed_number(1000) * power_of_ten(number(7)) : 0.0;
  return {.scale = scale, .offset = offset, .constant = happens(8)};
}

std::vector<AxisRange> axis_ranges() {
  const double common_scale = happens(3) ? (happens(50) ? 1e100 : 1e-100) : power_of_ten(-number(4));
  const bool alike = happens(60);
  std::vector<AxisRange> ranges(count_between(1, 6));
  for (AxisRange& range : ranges) {
    range = axis_range(common_scale);
    if (alike) range.scale = ranges.front().scale;
  }
  return ranges;
}

/// Whole numbers per key and axis, from which the coordinates are made.
std::vector<std::vector<int>> key_numbers(std::size_t keys, std::size_t axes) {
  std::vector<std::vector<int>> result(keys, std::vector<int>(axes));
  const bool collinear = happens(8);
  for (std::vector<int>& key : result)
    for (int& value : key) value = signed_number(1000);
  for (std::size_t i = 1; collinear && i < keys; ++i) {
    const int along = signed_number(5);
    for (std::size_t axis = 0; axis < axes; ++axis) result[i][axis] = result[0][axis] * along;
  }
  if (happens(12))
    for (int repeats = 1 + number(3); repeats > 0; --repeats) {
      const auto i = count_between(0, static_cast<int>(keys) - 1);
      if (i > 0) result[i] = result[i - 1];
    }
  return result;
}

std::vector<std::vector<long double>> coordinates() {
  const std::vector<AxisRange> ranges = axis_ranges();
  const auto keys = count_between(2, 12);
  std::vector<std::vector<long double>> result;
  for (const std::vector<int>& numbers : key_numbers(keys, ranges.size())) {
    std::vector<long double>& key = result.emplace_back();
    for (std::size_t axis = 0; axis < ranges.size(); ++axis) {
      const AxisRange& range = ranges[axis];
      const double coordinate = range.constant ? range.offset : range.offset + range.scale * numbers[axis];
      key.push_back(static_cast<long double>(coordinate));
    }
  }
  return result;
}

double tension() {
  if (happens(2)) return 1.0;
  if (happens(2)) return 1.0 - power_of_ten(-1 - number(12));
  return signed_number(999) / 1000.0;
}

std::vector<std::array<long double, 3>> tension_continuity_bias(std::size_t keys) {
  std::vector<std::array<long double, 3>> result;
  for (std::size_t i = 0; i < keys; ++i) {
    const double t = tension();
    const double c = signed_number(1000) / 1000.0;
    const double b = signed_number(1000) / 1000.0;
    result.push_back({static_cast<long double>(t), static_cast<long double>(c), static_cast<long double>(b)});
  }
  return result;
}

std::vector<long double> weights(std::size_t axes) {
  std::vector<long double> result;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const double weight = happens(5) ? 0.0 : (1 + number(400)) / 100.0;
    result.push_back(static_cast<long double>(weight));
  }
  return result;
}

std::vector<double> control_values() {
  std::vector<double> values(count_between(1, 20));
  for (double& value : values) value = happens(20) ? 0.0 : (1 + number(400)) / 4.0;
  if (values.size() >= 3 && happens(40)) values[0] = values[1] = 0;
  if (values.size() >= 3 && happens(40)) values[values.size() - 1] = values[values.size() - 2] = 0;
  if (std::all_of(values.begin(), values.end(), [](double value) { return value == 0; }))
    values[values.size() / 2] = 1;
  return values;
}

/// The path, or none where an axis of zero weight moves while the others stand still.
bool measurable(const oracle::Keys& keys) {
  try {
    oracle::segment_cubics(keys);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

RandomMove draw() {
  RandomMove move;
  oracle::Keys& keys = move.keys;
  keys.kind = std::array{Kind::smooth, Kind::catmull_rom, Kind::tcb,
                         Kind::linear}[static_cast<std::size_t>(number(4))];
  keys.closed = happens(25);
  keys.at = coordinates();
  if (keys.kind == Kind::tcb) keys.tension_continuity_bias = tension_continuity_bias(keys.at.size());
  if (happens(40)) keys.weights = weights(keys.at.front().size());
  if (!measurable(keys)) keys.weights.clear();
  move.speed = control_values();
  move.frames = 1 + number(400);
  move.singular = oracle::Path(keys).slowest() < 1e-6L;
  return move;
}

/// Some keys, and with an even chance the same way back.
std::vector<std::vector<long double>> there_and_back(std::size_t axes) {
  const auto keys = count_between(2, 5);
  std::vector<std::vector<long double>> result;
  for (std::size_t i = 0; i < keys; ++i) {
    std::vector<long double>& key = result.emplace_back();
    for (std::size_t d = 0; d < axes; ++d) key.push_back(static_cast<long double>(signed_number(1000)) / 4);
    if (i > 0 && happens(8)) key = result[i - 1];
  }
  if (happens(50))
    for (std::size_t i = keys - 1; i-- > 0;) result.push_back(result[i]);
  return result;
}

double turning_tension() {
  if (happens(40)) return 1.0;
  if (happens(25)) return 1.0 - power_of_ten(-1 - number(8));
  return signed_number(999) / 1000.0;
}

RandomMove draw_turning() {
  RandomMove move;
  oracle::Keys& keys = move.keys;
  keys.kind =
      std::array{Kind::smooth, Kind::catmull_rom, Kind::tcb, Kind::tcb}[static_cast<std::size_t>(number(4))];
  const auto axes = count_between(1, 4);
  keys.at = there_and_back(axes);
  const std::size_t count = keys.at.size();
  for (std::size_t i = 0; keys.kind == Kind::tcb && i < count; ++i)
    keys.tension_continuity_bias.push_back({turning_tension(), 0, 0});
  for (std::size_t d = 0; d < axes; ++d) keys.weights.push_back((1 + number(400)) / 100.0);
  move.frames = 40 * static_cast<int>(count) + number(300);
  move.speed = {0, happens(10) ? 3.0 : 0.0};
  for (std::size_t i = 0; i < count + 2; ++i) move.speed.push_back((4 + number(40)) / 4.0);
  move.speed.insert(move.speed.end(), {happens(10) ? 3.0 : 0.0, 0.0});
  move.times.resize(count);
  const bool breaks = happens(25);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const int frame = static_cast<int>(i) * move.frames / static_cast<int>(count - 1);
    if (breaks && happens(50)) move.times[i].break_frame = frame + signed_number(5);
    if (!breaks && happens(75)) move.times[i].hold = 1 + number(20);
  }
  return move;
}

/// Shortest decimals that read back as the same double, and a TOML float whatever the value.
std::string decimal(long double exact) {
  std::string text = fmt::format("{}", static_cast<double>(exact));
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

template <typename Numbers>
std::string list(const Numbers& numbers) {
  std::string text;
  for (const auto each : numbers)
    text += (text.empty() ? "" : ", ") + decimal(static_cast<long double>(each));
  return "[" + text + "]";
}

const char* name_of(Kind kind) {
  switch (kind) {
    case Kind::smooth:
      return "smooth";
    case Kind::catmull_rom:
      return "catmull-rom";
    case Kind::tcb:
      return "tcb";
    case Kind::linear:
      return "linear";
  }
  return "?";
}

}  // namespace

rc::Gen<RandomMove> random_move() {
  return rc::gen::exec([] { return draw(); });
}

rc::Gen<RandomMove> regular_move() {
  return rc::gen::suchThat(random_move(), [](const RandomMove& move) { return !move.singular; });
}

rc::Gen<RandomMove> turning_move() {
  return rc::gen::exec([] { return draw_turning(); });
}

std::string as_toml(const RandomMove& move) {
  const oracle::Keys& keys = move.keys;
  std::string axes;
  for (std::size_t axis = 0; axis < keys.at.front().size(); ++axis)
    axes += fmt::format("{}\"x{}\"", axis == 0 ? "" : ", ", axis);
  std::string text = fmt::format(
      "name = \"random move\"\nfps = 24\nframes = {}\n\n[[track]]\naxes = [{}]\nspline = \"{}\"\n",
      move.frames, axes, name_of(keys.kind));
  if (keys.closed) text += "closed = true\n";
  text += "keys = [\n";
  for (std::size_t i = 0; i < keys.at.size(); ++i) {
    text += "  { at = " + list(keys.at[i]);
    if (!keys.tension_continuity_bias.empty()) {
      const auto& [t, c, b] = keys.tension_continuity_bias[i];
      text += fmt::format(", tension = {}, continuity = {}, bias = {}", decimal(t), decimal(c), decimal(b));
    }
    if (!move.times.empty()) {
      const RandomKeyTime& time = move.times[i];
      if (time.hold > 0) text += fmt::format(", hold = {}", time.hold);
      if (time.break_frame >= 0) text += fmt::format(", frame = {}, break = true", time.break_frame);
    }
    text += " },\n";
  }
  text += "]\nspeed = " + list(move.speed) + "\n";
  if (!keys.weights.empty()) text += "weights = " + list(keys.weights) + "\n";
  return text;
}

void showValue(const RandomMove& move, std::ostream& out) {
  out << (move.singular ? "# singular path\n" : "") << as_toml(move);
}

void show(const RandomMove& move) {
  std::ostringstream text;
  showValue(move, text);
  RC_LOG() << text.str();
}

}  // namespace inbetween
