#include "inbetween/limits/motor_trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "inbetween/base/zeroin.hpp"
#include "inbetween/limits/roll_trajectory.hpp"
#include "limits/motor_sampler.hpp"
#include "trajectory/bernstein.hpp"
#include "trajectory/trajectory_builder.hpp"

namespace inbetween {
namespace {

/// An axis that turns beside a mark passes it twice. So many halvings of a piece find both places; in less
/// time than that the third derivative of the curve makes no difference.
constexpr int max_halvings = 12;
constexpr int max_evaluations = 100;

Error no_joints(std::size_t needed) {
  return {.code = ErrorCode::capacity,
          .what = "a motor has more joints than its memory",
          .remedy = "give it a larger capacity",
          .needed = static_cast<std::int64_t>(needed)};
}

/// It evaluates by de Casteljau's scheme; u counts from the begin of the whole piece.
double value_at(const Bernstein& polynomial, double u) {
  std::array<double, 8> c = polynomial.c;
  const double t = (u - polynomial.begin) / (polynomial.end - polynomial.begin);
  for (std::size_t round = polynomial.degree; round > 0; --round) {
    for (std::size_t i = 0; i < round; ++i) c[i] = (1 - t) * c[i] + t * c[i + 1];
  }
  return c[0];
}

/// 1 where the coefficients do not fall, -1 where they do not rise, 0 where they do both.
int direction_of(const Bernstein& polynomial) {
  const auto end = polynomial.c.begin() + static_cast<std::ptrdiff_t>(polynomial.degree) + 1;
  if (std::is_sorted(polynomial.c.begin(), end)) return 1;
  return std::is_sorted(polynomial.c.begin(), end, [](double a, double b) { return a > b; }) ? -1 : 0;
}

/// Writes the joints of a motor to the caller's memory, in their order.
class JointWriter {
 public:
  JointWriter(const MotorSource& source, std::span<MotorJoint> out)
      : axes_(*source.trajectory), axis_(source.axis), calibration_(*source.calibration), out_(out) {}

  Result<std::span<const MotorJoint>> write() {
    const std::span<const TrajectoryPiece> pieces = axes_.pieces();
    for (std::uint32_t i = 0; i < pieces.size(); ++i) {
      add({.time = pieces[i].begin, .piece_before = i > 0 ? i - 1 : 0, .piece_after = i});
      find_passings(i);
    }
    const auto last = static_cast<std::uint32_t>(pieces.size() - 1);
    add({.time = axes_.end_of(last), .piece_before = last, .piece_after = last});
    if (count_ > out_.size()) return no_joints(count_);
    take_notes();
    choose_curves();
    return std::span<const MotorJoint>(out_.first(count_));
  }

 private:
  void add(const MotorJoint& joint) {
    if (count_ < out_.size()) out_[count_] = joint;
    ++count_;
  }

  /// The places inside a piece at which the axis passes a mark: it is halved until it goes in one direction.
  void find_passings(std::uint32_t index) {
    const TrajectoryPiece& piece = axes_.pieces()[index];
    std::array<Bernstein, max_halvings + 1> stack;
    std::size_t count = 0;
    stack[count++] = position_of(axes_, piece, axis_).shifted(axes_.values()[piece.begin_row + axis_]);
    while (count > 0) {
      Bernstein& top = stack[count - 1];
      const auto [first, last] = marks_between(-top.negated().highest(), top.highest());
      const int direction = direction_of(top);
      if (first < last && direction == 0 && count < stack.size()) {
        const Bernstein second = top.halve();
        // The first half lies on top.
        stack[count++] = top;
        stack[count - 2] = second;
        continue;
      }
      for (std::size_t k = first; k < last; ++k) {
        const std::size_t mark = direction < 0 ? first + last - 1 - k : k;
        pass(top, calibration_.pieces()[mark].from, index);
      }
      --count;
    }
  }
  /// The marks that lie inside; mark k begins piece k of the curve, from 1 on.
  [[nodiscard]] std::pair<std::size_t, std::size_t> marks_between(double low, double high) const {
    const auto from = [](const CalibrationPiece& piece) { return piece.from; };
    const auto marks = calibration_.pieces().subspan(1);
    const auto first = std::ranges::upper_bound(marks, low, {}, from);
    const auto last = std::ranges::lower_bound(marks, high, {}, from);
    const auto index = [&](auto at) { return static_cast<std::size_t>(at - marks.begin()) + 1; };
    return {index(first), std::max(index(first), index(last))};
  }
  void pass(const Bernstein& part, double mark, std::uint32_t index) {
    const double from = part.c[0] - mark;
    const double to = part.c[part.degree] - mark;
    if (!((from < 0 && to >= 0) || (from > 0 && to <= 0))) return;
    const auto off = [&](double u) { return value_at(part, u) - mark; };
    const double u = zeroin(off, {part.begin, from}, {part.end, to}, 0, max_evaluations).x;
    const TrajectoryPiece& piece = axes_.pieces()[index];
    const FrameTime time = moved_by(piece.begin, u / piece.inverse_frames);
    const FrameTime before = count_ <= out_.size() ? out_[count_ - 1].time : piece.begin;
    if (before < time && time < axes_.end_of(index))
      add({.time = time, .piece_before = index, .piece_after = index});
  }

  /// Each break and each unbounded side of the axis is one of the motor. All are in their order.
  void take_notes() {
    std::size_t j = 0;
    const auto go_to = [&](const FrameTime& time) {
      while (j < count_ && out_[j].time < time) ++j;
      return j < count_ && out_[j].time == time;
    };
    for (const TrajectoryBreak& one : axes_.breaks())
      if (go_to(one.time)) out_[j].key = one.key;
    j = 0;
    for (const UnboundedSide& side : axes_.unbounded()) {
      if (side.axis != static_cast<std::int32_t>(axis_) || !go_to(side.time)) continue;
      const std::uint8_t known = out_[j].unbounded;
      out_[j].unbounded = known == 0 ? side.order : std::min(known, side.order);
      if (side.key >= 0) out_[j].key = side.key;
    }
  }
  /// Between two joints the axis is on one piece of the curve: on that of its place in the middle.
  void choose_curves() {
    for (std::size_t j = 0; j + 1 < count_; ++j) {
      const double frames = frames_between(out_[j].time, out_[j + 1].time);
      const double place = axes_.motion_of(axis_, moved_by(out_[j].time, frames / 2)).position;
      out_[j].curve_after = out_[j + 1].curve_before =
          static_cast<std::uint8_t>(calibration_.piece_index(place));
    }
    out_[0].curve_before = out_[0].curve_after;
    out_[count_ - 1].curve_after = out_[count_ - 1].curve_before;
  }

  const Trajectory& axes_;
  std::size_t axis_;
  const Calibration& calibration_;
  std::span<MotorJoint> out_;
  std::size_t count_ = 0;
};

}  // namespace

Result<Trajectory> fit_motor(const MotorSource& source, std::span<MotorJoint> joints,
                             const TrajectoryMemory& memory) {
  if (source.axis >= source.trajectory->axis_count()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a motor follows an axis that the trajectory does not have",
                 .remedy = "count the axes from 0"};
  }
  const Result<std::span<const MotorJoint>> found = JointWriter(source, joints).write();
  if (!found) return found.error();
  const CalibrationPiece& first = source.calibration->pieces()[1];
  const CalibrationPiece& last = source.calibration->pieces().back();
  const double slope = (last.cubic.c0 - first.cubic.c0) / (last.from - first.from);
  const double travel = std::fabs(slope) * source.travel;
  return fit_sampled(MotorSampler(source, *found), {.travel = std::span(&travel, 1)}, memory);
}

Result<Trajectory> fit_motor(const RollAxis& roll, const Calibration& calibration,
                             std::span<MotorJoint> joints, const TrajectoryMemory& memory) {
  std::array<TrajectoryPiece, 1> piece;
  std::array<double, 6> values{};
  std::array<std::uint32_t, 1> bucket{};
  const TrajectoryMemory of_axis{piece, values, bucket, {}, {}, {}, {}};
  const Result<Trajectory> axis = roll_trajectory(std::span(&roll, 1), of_axis);
  if (!axis) return axis.error();
  const AxisPeaks peaks = roll.peaks();
  const double travel = peaks.highest.value - peaks.lowest.value;
  return fit_motor(MotorSource{&*axis, 0, &calibration, travel}, joints, memory);
}

}  // namespace inbetween
