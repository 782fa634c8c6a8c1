#include "inbetween/limits/calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

/// A curve is next to level where its slope is below this share of the chord between its two marks: the motor
/// would tell the place of the axis there no more.
inline constexpr double min_slope_share = 1e-3;

Error bad_mark(ErrorCode code, std::size_t mark, const char* what, const char* remedy) {
  return {.code = code, .what = what, .remedy = remedy, .key = static_cast<std::int32_t>(mark)};
}

Status check_marks(std::span<const CalibrationMark> marks, std::size_t pieces) {
  constexpr std::size_t max_marks = Calibration::max_marks;
  if (marks.size() < 2) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are fewer than two marks",
                 .remedy = "give one at each end of the range at least"};
  }
  if (marks.size() > max_marks || pieces < marks.size() + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "there are more marks than the curve has room for",
                 .remedy = "leave out some where the curve is nearly straight; 64 at most",
                 .needed = static_cast<std::int64_t>(marks.size() + 1)};
  }
  const bool rises = marks.back().motor > marks.front().motor;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!std::isfinite(marks[i].axis) || !std::isfinite(marks[i].motor)) {
      return bad_mark(ErrorCode::not_finite, i, "a mark is not a finite number", "write a number");
    }
    if (i == 0) continue;
    if (!(marks[i].axis > marks[i - 1].axis)) {
      return bad_mark(ErrorCode::out_of_range, i, "the axis does not rise from the mark before",
                      "write the marks in the order in which the axis passes them");
    }
    if (marks[i].motor == marks[i - 1].motor || (marks[i].motor > marks[i - 1].motor) != rises) {
      return bad_mark(ErrorCode::out_of_range, i, "the motor turns back or stays between two marks",
                      "correct the mark: the motor goes one way only");
    }
  }
  return Done{};
}

/// The second derivatives at the marks, 0 at both ends (Thomas' algorithm).
void find_bends(std::span<const CalibrationMark> marks, std::span<double> bends) {
  std::array<double, Calibration::max_marks> upper{};
  const auto chord = [&](std::size_t i) {
    return (marks[i + 1].motor - marks[i].motor) / (marks[i + 1].axis - marks[i].axis);
  };
  bends.front() = bends.back() = 0;
  for (std::size_t i = 1; i + 1 < marks.size(); ++i) {
    const double before = marks[i].axis - marks[i - 1].axis;
    const double after = marks[i + 1].axis - marks[i].axis;
    const double pivot = 2 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    bends[i] = (6 * (chord(i) - chord(i - 1)) - before * bends[i - 1]) / pivot;
  }
  for (std::size_t i = marks.size() - 1; i-- > 1;) bends[i] -= upper[i] * bends[i + 1];
}

Cubic cubic_between(const CalibrationMark& from, const CalibrationMark& to, double bend_from,
                    double bend_to) {
  const double distance = to.axis - from.axis;
  return {.c0 = from.motor,
          .c1 = (to.motor - from.motor) / distance - distance * (2 * bend_from + bend_to) / 6,
          .c2 = bend_from / 2,
          .c3 = (bend_to - bend_from) / (6 * distance)};
}

/// Where the slope of a cubic is extreme within 0..distance, the ends included.
std::array<double, 3> steepest_places(const Cubic& c, double from, double to) {
  const double inside = c.c3 != 0 ? -c.c2 / (3 * c.c3) : from;
  return {from, to, inside > from && inside < to ? inside : from};
}

}  // namespace

Result<Calibration> Calibration::make(std::span<const CalibrationMark> marks,
                                      std::span<CalibrationPiece> pieces) {
  if (const Status checked = check_marks(marks, pieces.size()); !checked) return checked.error();
  std::array<double, max_marks> bends{};
  find_bends(marks, std::span(bends).first(marks.size()));
  for (std::size_t i = 0; i + 1 < marks.size(); ++i) {
    const double distance = marks[i + 1].axis - marks[i].axis;
    const double chord = (marks[i + 1].motor - marks[i].motor) / distance;
    const Cubic cubic = cubic_between(marks[i], marks[i + 1], bends[i], bends[i + 1]);
    for (const double t : steepest_places(cubic, 0.0, distance)) {
      if (cubic.derivative(t) / chord >= min_slope_share) continue;
      return bad_mark(ErrorCode::no_solution, i, "the curve from this mark to the next turns back",
                      "measure one more mark between the two, or beside them");
    }
    pieces[i + 1] = {marks[i].axis, cubic};
  }
  const std::size_t last = marks.size() - 1;
  const double end_distance = marks[last].axis - marks[last - 1].axis;
  pieces[0] = {marks[0].axis, {.c0 = marks[0].motor, .c1 = pieces[1].cubic.c1}};
  pieces[last + 1] = {marks[last].axis,
                      {.c0 = marks[last].motor, .c1 = pieces[last].cubic.derivative(end_distance)}};
  return Calibration(pieces.first(marks.size() + 1));
}

std::size_t Calibration::piece_index(double axis) const {
  const auto behind =
      std::upper_bound(pieces_.begin() + 1, pieces_.end(), axis,
                       [](double place, const CalibrationPiece& piece) { return place < piece.from; });
  return static_cast<std::size_t>(behind - pieces_.begin()) - 1;
}

CalibrationSlope Calibration::slope_at(double axis) const {
  const CalibrationPiece& piece = piece_at(axis);
  const double t = axis - piece.from;
  return {piece.cubic.derivative(t), piece.cubic.second(t), piece.cubic.third()};
}

double Calibration::axis_at(double motor) const {
  const bool up = rises();
  const auto behind = std::upper_bound(pieces_.begin() + 1, pieces_.end(), motor,
                                       [up](double place, const CalibrationPiece& piece) {
                                         return up ? place < piece.cubic.c0 : place > piece.cubic.c0;
                                       });
  const CalibrationPiece& piece = *(behind - 1);
  const Cubic& c = piece.cubic;
  if (behind == pieces_.begin() + 1 || behind == pieces_.end()) return piece.from + (motor - c.c0) / c.c1;
  // Newton's method, and the middle of the bracket where it would leave that.
  constexpr int max_steps = 64;
  double low = 0;
  double high = behind->from - piece.from;
  double t = high * ((motor - c.c0) / (behind->cubic.c0 - c.c0));
  for (int i = 0; i < max_steps; ++i) {
    const double off = c.value(t) - motor;
    ((off > 0) == up ? high : low) = t;
    double next = t - off / c.derivative(t);
    if (!(next >= low && next <= high)) next = low + (high - low) / 2;
    if (std::fabs(next - t) <= std::numeric_limits<double>::epsilon() * high) break;
    t = next;
  }
  return piece.from + t;
}

Setpoint Calibration::motor_of(const Setpoint& axis) const {
  const CalibrationSlope slope = slope_at(axis.position);
  return {.position = motor_at(axis.position),
          .velocity = slope.first * axis.velocity,
          .acceleration = slope.second * axis.velocity * axis.velocity + slope.first * axis.acceleration};
}

CalibrationSlope Calibration::bounds(double low, double high) const {
  CalibrationSlope most;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Cubic& c = pieces_[i].cubic;
    const bool is_last = i + 1 == pieces_.size();
    const double begin = i == 0 ? low : std::max(low, pieces_[i].from);
    const double end = is_last ? high : std::min(high, pieces_[i + 1].from);
    if (!(begin <= end)) continue;
    const double from = begin - pieces_[i].from;
    const double to = end - pieces_[i].from;
    for (const double t : steepest_places(c, from, to))
      most.first = std::max(most.first, std::fabs(c.derivative(t)));
    for (const double t : {from, to}) most.second = std::max(most.second, std::fabs(c.second(t)));
    most.third = std::max(most.third, std::fabs(c.third()));
  }
  constexpr double rounding = 1 + 16 * std::numeric_limits<double>::epsilon();
  return {most.first * rounding, most.second * rounding, most.third * rounding};
}

}  // namespace inbetween
