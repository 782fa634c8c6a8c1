#include "host_tools/table/trajectory_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/plan/plan_output.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "inbetween/limits/roll_trajectory.hpp"

namespace inbetween {
namespace {

/// The times of a stop are this much longer than its bounds ask for, so that no rounding is beyond them.
constexpr double stop_margin = 1e-9;

struct DriveScale {
  std::string_view unit;
  double scale = 1;
  double zero = 0;
};

DriveScale scale_of(const Drive& drive) {
  if (const std::optional<double> turns = turns_per_unit_of(drive)) return {"turns", *turns};
  if (const auto* steps = std::get_if<StepDirDrive>(&drive)) return {"steps", steps->steps_per_unit};
  if (const auto* pipe = std::get_if<PipeDrive>(&drive))
    return {"counts", pipe->counts_per_unit, pipe->count_at_zero};
  return {"counts", std::get<Cia402Drive>(drive).counts_per_unit};
}

/// Every position is that of an axis of the move, or of its motor where it has a calibration.
std::vector<TableMotor> motors_of_move(const Plan& plan) {
  const RigMotors motors = motors_of(*plan.rig());
  std::vector<TableMotor> result;
  for (std::size_t m = 0; m < motors.of.size(); ++m) {
    const PlanAxis& axis = plan.axes()[motors.of[m].axis];
    if (!axis.track) continue;
    const RigAxis& its = motors.rig.axes[m];
    const DriveScale scale = scale_of(its.drive);
    result.push_back({.name = its.name,
                      .unit = std::string(to_string(its.unit)),
                      .drive_unit = std::string(scale.unit),
                      .position = axis.move_axis,
                      .offset = motors.of[m].offset,
                      .scale = scale.scale,
                      .zero = scale.zero});
  }
  return result;
}

void refuse_take_up(const Plan& plan) {
  for (const PlanAxis& axis : plan.axes()) {
    if (!axis.track) continue;
    const auto a = static_cast<std::size_t>(&axis - plan.axes().data());
    const RigAxis& its = plan.rig()->axes[a];
    if (!its.backlash) continue;
    throw InputError(plan.place_of(a),
                     fmt::format("{} takes up its backlash, by where it came from, and a table cannot say "
                                 "that; play the move with inbetween run, or remove backlash from the rig",
                                 named(its)));
  }
}

/// Pieces of trajectories one after another, all of the same positions of their axes.
class GroupWriter {
 public:
  GroupWriter(std::vector<std::size_t> positions, std::vector<std::size_t> axes) : axes_(std::move(axes)) {
    group_.positions = std::move(positions);
  }

  /// Adds what a trajectory does from one time to another.
  void add(const Trajectory& trajectory, const FrameTime& begin, const FrameTime& end) {
    for (std::size_t i = trajectory.piece_at(begin); i < trajectory.pieces().size(); ++i) {
      const TrajectoryPiece& piece = trajectory.pieces()[i];
      if (end <= piece.begin) return;
      const auto u_of = [&](const FrameTime& time) {
        return frames_between(piece.begin, time) * piece.inverse_frames;
      };
      const FrameTime first = std::max(piece.begin, begin);
      const FrameTime last = std::min(trajectory.end_of(i), end);
      const double from = piece.begin < begin ? u_of(begin) : 0;
      const double to = end < trajectory.end_of(i) ? u_of(end) : 1;
      const bool is_whole = from == 0 && to == 1;
      const double per_frame = is_whole ? piece.inverse_frames : 1 / frames_between(first, last);
      add_piece(first, per_frame, [&](std::size_t axis) {
        const PiecePolynomial whole = distance_on_piece(trajectory, piece, axis);
        PiecePolynomial c = is_whole ? whole : part_of(whole, from, to);
        c[0] += trajectory.values()[piece.begin_row + axis];
        return c;
      });
    }
  }

  /// Adds the whole of a trajectory.
  void add(const Trajectory& trajectory) { add(trajectory, trajectory.begin(), trajectory.end()); }

  /// Ends the group with the positions at rest, which are those of what plays to the last bit.
  TableGroup finish(std::vector<double> end) {
    group_.end = std::move(end);
    return std::move(group_);
  }

 private:
  template <class CoefficientsOf>
  void add_piece(const FrameTime& begin, double per_frame, const CoefficientsOf& coefficients_of) {
    std::vector<PiecePolynomial> all;
    std::size_t degree = 0;
    for (const std::size_t axis : axes_) {
      all.push_back(coefficients_of(axis));
      for (std::size_t power = degree + 1; power < all.back().size(); ++power) {
        if (all.back()[power] != 0) degree = power;
      }
    }
    group_.pieces.push_back({.begin = begin,
                             .per_frame = per_frame,
                             .first = group_.coefficients.size(),
                             .degree = static_cast<int>(degree)});
    for (const PiecePolynomial& c : all) {
      group_.coefficients.insert(group_.coefficients.end(), c.begin(),
                                 c.begin() + static_cast<std::ptrdiff_t>(degree) + 1);
    }
  }

  std::vector<std::size_t> axes_;  // of the trajectories
  TableGroup group_;
};

/// The rolls of some axes as a trajectory that holds while this lives.
class RollPieces {
 public:
  explicit RollPieces(std::span<const RollAxis> rolls)
      : values_(6 * rolls.size()),
        trajectory_(value_or_throw(roll_trajectory(rolls, {.pieces = pieces_,
                                                           .values = values_,
                                                           .buckets = buckets_,
                                                           .breaks = {},
                                                           .unbounded = {},
                                                           .samples = {},
                                                           .numbers = {}}))) {}
  RollPieces(const RollPieces&) = delete;
  RollPieces& operator=(const RollPieces&) = delete;

  [[nodiscard]] const Trajectory& operator*() const { return trajectory_; }

 private:
  std::vector<TrajectoryPiece> pieces_{1};
  std::vector<double> values_;
  std::vector<std::uint32_t> buckets_{0};
  Trajectory trajectory_;
};

/// The axes of one track that have no motor of their own.
TableGroup group_of_track(const PlayedMotion& motion, const Trajectory& trajectory, std::size_t first_axis,
                          const std::vector<std::size_t>& axes) {
  const Move& move = motion.move();
  std::vector<std::size_t> positions(axes);
  for (std::size_t& position : positions) position += first_axis;
  GroupWriter writer(positions, axes);
  const auto add_rolls = [&](std::span<const RollAxis> rolls) {
    if (!rolls.empty()) writer.add(*RollPieces(rolls.subspan(first_axis, trajectory.axis_count())));
  };
  add_rolls(move.rolls().before);
  writer.add(trajectory, {move.part().first, 0}, {move.part().last, 0});
  add_rolls(move.rolls().after);
  std::vector<double> all(motion.axis_count());
  motion.positions({move.last_frame(), 0}, all);
  std::vector<double> end(positions.size());
  std::ranges::transform(positions, end.begin(), [&](std::size_t position) { return all[position]; });
  return writer.finish(std::move(end));
}

TableGroup group_of_motor(const PlayedMotion& motion, const PlayedMotor& motor) {
  const Move& move = motion.move();
  GroupWriter writer({motor.axis}, {0});
  if (motor.pre_roll != nullptr) writer.add(*motor.pre_roll);
  writer.add(*motor.whole, {move.part().first, 0}, {move.part().last, 0});
  if (motor.post_roll != nullptr) writer.add(*motor.post_roll);
  return writer.finish({motion.motion_of(motor, {move.last_frame(), 0}).position});
}

std::vector<TableGroup> groups_of(const PlayedMotion& motion) {
  std::vector<TableGroup> groups;
  std::size_t first_axis = 0;
  for (const Trajectory& trajectory : motion.trajectories()) {
    std::vector<std::size_t> axes;
    for (std::size_t axis = 0; axis < trajectory.axis_count(); ++axis) {
      if (std::ranges::find(motion.motors(), first_axis + axis, &PlayedMotor::axis) == motion.motors().end())
        axes.push_back(axis);
    }
    if (!axes.empty()) groups.push_back(group_of_track(motion, trajectory, first_axis, axes));
    first_axis += trajectory.axis_count();
  }
  for (const PlayedMotor& motor : motion.motors()) groups.push_back(group_of_motor(motion, motor));
  return groups;
}

/// This is the quickest stop under constant bounds of the rate's change and of its jerk: the change grows as
/// quickly as the jerk allows, stays at its bound if it gets there, and falls again.
TableStop stop_within(const StopBound& bound) {
  const double longest_jerk_s = bound.rate_change / bound.rate_jerk;
  TableStop stop{.jerk_s = longest_jerk_s, .steady_s = 1 / bound.rate_change - longest_jerk_s};
  if (stop.steady_s < 0) stop = {.jerk_s = 1 / std::sqrt(bound.rate_jerk), .steady_s = 0};
  stop.jerk_s *= 1 + stop_margin;
  stop.steady_s *= 1 + stop_margin;
  return stop;
}

/// A stop that begins anywhere between two places, within the bounds of all that it passes.
TableStop stop_from(const StopBounds& bounds, const Move& move, const FrameTime& begin, double frames) {
  const double per_s = move.frame_rate().frames_per_second();
  const FrameTime last{move.last_frame(), 0};
  TableStop stop;
  double passed = -1;
  for (double more = frames; more > passed;) {
    passed = more;
    const FrameTime end = moved_by(begin, passed);
    stop = stop_within(bounds.min_between(begin, end < last ? end : last));
    more = frames + stop.seconds() / 2 * per_s;
  }
  return stop;
}

std::vector<TableStop> stops_of(const Plan& plan, const StopBounds& bounds) {
  const Move& move = plan.played();
  const std::size_t count = stop_cells(move, plan.rig()->rate_hz, 1);
  const double frames =
      static_cast<double>(move.last_frame() - move.first_frame()) / static_cast<double>(count);
  std::vector<TableStop> stops;
  for (std::size_t cell = 0; cell < count; ++cell) {
    const FrameTime begin = moved_by({move.first_frame(), 0}, static_cast<double>(cell) * frames);
    stops.push_back(stop_from(bounds, move, begin, frames));
  }
  return stops;
}

}  // namespace

TrajectoryTable trajectory_table(const Plan& plan, const CheckReport& report) {
  refuse_take_up(plan);
  TrajectoryTable table;
  table.name = plan.move().name;
  table.rig = plan.rig()->name;
  table.hash = hash_in_words(plan.move());
  table.fps = plan.move().fps.rate;
  table.rate_hz = plan.rig()->rate_hz;
  table.first_frame = plan.played().first_frame();
  table.last_frame = plan.played().last_frame();
  table.position_count = plan.played().axis_count();
  table.motors = motors_of_move(plan);
  table.groups = groups_of(plan.motion());
  table.stops = stops_of(plan, *report.planned_stops->bounds());
  return table;
}

double longest_stop_s(const TrajectoryTable& table) {
  double longest = 0;
  for (const TableStop& stop : table.stops) longest = std::max(longest, stop.seconds());
  return longest;
}

std::size_t piece_count(const TrajectoryTable& table) {
  std::size_t count = 0;
  for (const TableGroup& group : table.groups) count += group.pieces.size();
  return count;
}

}  // namespace inbetween
