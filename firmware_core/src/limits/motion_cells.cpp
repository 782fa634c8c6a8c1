#include "inbetween/limits/motion_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "branch_and_bound.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "motion_enclosure.hpp"

namespace inbetween {
namespace {

/// The closeness to the peak of the cell, and to the peak of the axis in all cells: a rate change that is 2 %
/// lower makes a stop that much longer, and a quarter of that costs twice the time.
template <Precise Real>
inline constexpr Real own_closeness = Real(0.02);
template <Precise Real>
inline constexpr Real peak_closeness = Real(0.005);
constexpr HalvingLimits cell_halvings{.max = 30, .before_rounding = 5};

template <Precise Real>
void raise_to(MotionTriple<Real>& to, const MotionTriple<Real>& from) {
  for (std::size_t i = 0; i < motion_quantities; ++i) to[i] = std::max(to[i], from[i]);
}

/// This refers to what is known of a group of axes in the part of a cell.
template <Precise Real>
struct KnownGroup {
  GroupTriple<Real>& found;   ///< the highest motion found
  GroupTriple<Real>& room;    ///< of a bound above it: the slack, or a share of the peak in all cells
  GroupTriple<Real>& proven;  ///< the bound
};

template <Precise Real>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void raise_found(const GroupTriple<Real>& here,
                                                             const KnownGroup<Real>& group) {
  using Number = Group<Real>;
  for (std::size_t i = 0; i < motion_quantities; ++i) {
    // NaN is not found; the enclosure of its surroundings is without bound.
    const Number value = absolute(here[i]);
    const Number unbounded(std::numeric_limits<Real>::infinity());
    group.found[i] = greatest(group.found[i], if_less(value, unbounded, value, Number(Real(0))));
    group.room[i] = greatest(group.room[i], peak_closeness<Real> * group.found[i]);
  }
}

template <Precise Real>
Group<Real> allowed_of(const KnownGroup<Real>& group, std::size_t i) {
  const Group<Real>& found = group.found[i];
  return greatest(found + greatest(own_closeness<Real> * found, group.room[i]), group.proven[i]);
}

/// Returns the bits of the axes that are not close enough, and proves the others.
template <Precise Real>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES std::uint64_t take_close(const MotionRange<Group<Real>>& range,
                                                                     const KnownGroup<Real>& group) {
  using Number = Group<Real>;
  raise_found<Real>(range.here, group);
  const Number none(Real(0));
  Number far = none;
  for (std::size_t i = 0; i < motion_quantities; ++i) {
    far = if_less(allowed_of<Real>(group, i), range.bound[i], Number(Real(1)), far);
  }
  for (std::size_t i = 0; i < motion_quantities; ++i) {
    group.proven[i] = greatest(group.proven[i], if_less(none, far, none, range.bound[i]));
  }
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < group_size; ++k) {
    bits |= static_cast<std::uint64_t>(lane_of(far, k) > 0) << k;
  }
  return bits;
}

/// One track of the move.
template <Precise Real>
class TrackCells {
 public:
  TrackCells(const Move<Real>& move, const Track<Real>& track, std::size_t first_axis,
             std::span<AxisTurn<Real>> turns, const MotionCells<Real>& out)
      : axes_(static_cast<std::size_t>(track.path().axis_count())),
        all_axes_(move.axis_count() + out.motors),
        first_axis_(first_axis),
        first_frame_(static_cast<Real>(move.first_frame())),
        cell_frames_(static_cast<Real>(move.last_frame() - move.first_frame()) /
                     static_cast<Real>(out.cells)),
        out_(out),
        walk_(track, move.part()),
        enclosure_(track, turns) {}

  void run() {
    for (std::size_t d = 0; lanes_are_quick && d < axes_; ++d) {
      set_lane<Real>(room_lanes_[d / group_size], d % group_size, out_.slack[first_axis_ + d]);
    }
    // One walk in the code, for one of them on the stack.
    for (const bool is_sampled : {false, true}) {
      walk_.run([this, is_sampled](const Stretch<Real>& stretch) {
        enclosure_.show(stretch.path);
        if (!is_sampled) return sample(stretch);
        take_reversal(stretch);
        each_part(stretch,
                  [&](const MotionBox<Real>& part, std::size_t cell) { prove(stretch, part, cell); });
      });
    }
  }

  // The rules of branch_and_bound.

  std::uint64_t take(std::size_t group, std::uint64_t open, const MotionRange<Group<Real>>& range,
                     Real /*frame*/) {
    return open & take_close<Real>(range, known(group));
  }
  [[nodiscard]] Real allowed(std::size_t d, std::size_t i) {
    return lane_of(allowed_of<Real>(known(d / group_size), i), d % group_size);
  }
  void accept(std::size_t d, const MotionTriple<Real>& bounds, Real /*frame*/) {
    GroupTriple<Real>& proven = known(d / group_size).proven;
    MotionTriple<Real> axis = lane_of<Real>(proven, d % group_size);
    raise_to(axis, bounds);
    set_lane<Real>(proven, d % group_size, axis);
  }

 private:
  /// Without lanes a group is an axis, and its numbers stand in the memory of the caller, not on a stack for
  /// as many axes as there can be.
  [[nodiscard]] KnownGroup<Real> known(std::size_t group) {
    if constexpr (lanes_are_quick) {
      return {found_[group], room_lanes_[group], proven_lanes_[group]};
    } else {
      return {found_[group], out_.slack[first_axis_ + group], proven_[group]};
    }
  }
  [[nodiscard]] std::span<MotionTriple<Real>> of_cell(std::size_t cell) const {
    return out_.suprema.subspan(cell * all_axes_ + first_axis_, axes_);
  }
  [[nodiscard]] std::size_t cell_of(Real frame) const {
    const Real cell = (frame - first_frame_) / cell_frames_;
    return cell > 0 ? std::min(static_cast<std::size_t>(cell), out_.cells - 1) : 0;
  }

  /// The peaks of the axes, so far as three points of every stretch show them.
  void sample(const Stretch<Real>& stretch) {
    for (const Real x : {stretch.from, stretch.from + (stretch.to - stretch.from) / 2, stretch.to}) {
      raise_at(stretch, x, walk_.tau_at(stretch, x));
    }
  }
  /// It is not inlined, so that what it needs is not on the stack while boxes are halved.
  [[gnu::noinline]] void raise_at(const Stretch<Real>& stretch, Real x, Real tau) {
    enclosure_.middles(
        enclosure_.at(stretch, x, tau),
        [this](std::size_t group, const GroupTriple<Real>& here) { raise_found<Real>(here, known(group)); });
  }

  void take_reversal(const Stretch<Real>& stretch) {
    if (stretch.from > 0 || !enclosure_.turns_back(stretch)) return;
    const std::size_t cell = cell_of(stretch.time.frame(0));
    for (std::size_t d = 0; d < axes_; ++d) {
      if (!enclosure_.steps_where_it_turns_back(d)) continue;
      of_cell(cell)[d][1] = of_cell(cell)[d][2] = std::numeric_limits<Real>::infinity();
    }
  }

  /// Calls visit(part, cell) for the parts of a stretch that lie in one cell each.
  template <class Visit>
  void each_part(const Stretch<Real>& stretch, const Visit& visit) {
    const TimePiece<Real>& time = stretch.time;
    const std::size_t last = cell_of(time.frame(stretch.to));
    const bool forward = time.frames > 0;
    MotionBox<Real> part{.begin = stretch.from, .end = stretch.from, .tau_begin = stretch.tau_from};
    for (std::size_t cell = cell_of(time.frame(stretch.from));; forward ? ++cell : --cell) {
      const auto border = static_cast<Real>(forward ? cell + 1 : cell);
      const Real x = (first_frame_ + border * cell_frames_ - time.first_frame) / time.frames;
      part.end = cell == last ? stretch.to : std::clamp(x, part.begin, stretch.to);
      part.tau_end = walk_.tau_at(stretch, part.end);
      if (part.end > part.begin || stretch.end == 0) visit(part, cell);
      if (cell == last) return;
      part.begin = part.end;
      part.tau_begin = part.tau_end;
    }
  }

  void prove(const Stretch<Real>& stretch, const MotionBox<Real>& part, std::size_t cell) {
    proven_ = of_cell(cell);
    for (std::size_t group = 0; group * group_size < axes_; ++group) found_[group] = {};
    for (std::size_t d = 0; lanes_are_quick && d < axes_; ++d) {
      set_lane<Real>(known(d / group_size).proven, d % group_size, proven_[d]);
    }
    raise_at(stretch, part.end, part.tau_end);
    // A part begins where the one before it has ended. A microcontroller has no memory to keep what is there.
    const bool is_known = lanes_are_quick && part.begin > stretch.from;
    if constexpr (lanes_are_quick) {
      for (std::size_t group = 0; group * group_size < axes_; ++group) {
        const GroupTriple<Real> end = found_[group];
        if (is_known) raise_found<Real>(ends_[group], known(group));
        ends_[group] = end;
      }
    }
    if (!is_known) raise_at(stretch, part.begin, part.tau_begin);
    branch_and_bound<cell_halvings>(enclosure_, walk_, stretch, part, axes_, *this);
    for (std::size_t d = 0; lanes_are_quick && d < axes_; ++d) {
      proven_[d] = lane_of<Real>(known(d / group_size).proven, d % group_size);
    }
  }

  std::size_t axes_;
  std::size_t all_axes_;
  std::size_t first_axis_;
  Real first_frame_;
  Real cell_frames_;
  const MotionCells<Real>& out_;
  StretchWalk<Real> walk_;
  MotionEnclosure<Real> enclosure_;
  std::array<GroupTriple<Real>, max_axis_groups> found_{};
  std::span<MotionTriple<Real>> proven_;  ///< of the cell
  std::array<GroupTriple<Real>, lanes_are_quick ? max_axis_groups : 0> room_lanes_{};
  /// The suprema of the cell while it is worked on, and what is found at the end of a part. Filled for axes_.
  std::array<GroupTriple<Real>, lanes_are_quick ? max_axis_groups : 0> proven_lanes_, ends_;
};

/// |p1|, |p2|, |p3| of a roll between two times in seconds from the joint, both of one sign.
template <Precise Real>
MotionTriple<Real> roll_suprema(const RollAxis<Real>& roll, Real from, Real to) {
  std::array<Real, 5> c = roll.coefficients();
  if (from < 0) {  // mirrored in time: the magnitudes are the same
    c = {c[0], -c[1], c[2], -c[3], c[4]};
    from = -from;
    to = -to;
  }
  const Real middle = (from + to) / 2;
  const Real radius = std::fabs(to - from) / 2;
  const auto velocity = derivative(c);
  const auto acceleration = derivative(velocity);
  const AxisPeaks<Real> peaks = roll.peaks();
  return {std::min(centred(velocity, middle, radius).range().magnitude(), peaks.velocity.value),
          std::min(centred(acceleration, middle, radius).range().magnitude(), peaks.acceleration.value),
          std::min(centred(derivative(acceleration), middle, radius).range().magnitude(), peaks.jerk.value)};
}

/// Every cell that a roll has a part of. Its ends are moved outwards by the rounding of a time.
template <Precise Real>
void bound_roll(const Move<Real>& move, std::span<const RollAxis<Real>> rolls, const MotionCells<Real>& out) {
  if (rolls.empty()) return;
  const RollSpan& span = rolls.front().span();
  const Real seconds = rolls.front().seconds();
  const bool before = span.end == RollEnd::before;
  const Real begin = before ? -seconds : Real(0);
  const auto cells = static_cast<Real>(out.cells);
  const Real frame_seconds = seconds / static_cast<Real>(span.frames);
  const auto first = static_cast<Real>(move.first_frame() - span.joint_frame) * frame_seconds;
  const auto line = static_cast<Real>(move.last_frame() - move.first_frame()) * frame_seconds;
  for (std::size_t cell = 0; cell < out.cells; ++cell) {
    const Real from = std::max(first + line * (static_cast<Real>(cell) / cells), begin);
    const Real to = std::min(first + line * (static_cast<Real>(cell + 1) / cells), begin + seconds);
    if (!(from < to)) continue;
    for (std::size_t d = 0; d < rolls.size(); ++d) {
      raise_to(out.suprema[cell * (rolls.size() + out.motors) + d], roll_suprema(rolls[d], from, to));
    }
  }
}

}  // namespace

template <Precise Real>
void bound_cells(const Move<Real>& move, std::span<AxisTurn<Real>> turns, const MotionCells<Real>& out) {
  std::fill(out.suprema.begin(), out.suprema.end(), MotionTriple<Real>{});
  std::size_t first_axis = 0;
  for (const Track<Real>& track : move.tracks()) {
    TrackCells<Real>(move, track, first_axis, turns, out).run();
    first_axis += static_cast<std::size_t>(track.path().axis_count());
  }
  bound_roll(move, move.rolls().before, out);
  bound_roll(move, move.rolls().after, out);
  for (MotionTriple<Real>& axis : out.suprema) {
    for (Real& value : axis) value *= 1 + bound_rounding<Real>;
  }
}

template <Precise Real>
void bound_motors(const Move<Real>& move, std::span<const CalibratedMotor<Real>> motors,
                  const MotionCells<Real>& out) {
  const std::size_t axes = move.axis_count();
  const FrameRate fps = move.frame_rate();
  const Real cell_frames =
      static_cast<Real>(move.last_frame() - move.first_frame()) / static_cast<Real>(out.cells);
  // Beyond either end of a cell lies the rounding of a frame number.
  constexpr Real beyond = Real(1.001);
  const Real half_seconds =
      beyond * cell_frames / 2 * static_cast<Real>(fps.denominator) / static_cast<Real>(fps.numerator);
  for (std::size_t cell = 0; !motors.empty() && cell < out.cells; ++cell) {
    const Real middle = cell_frames * (static_cast<Real>(cell) + Real(0.5));
    const auto whole = static_cast<std::int32_t>(middle);
    const FrameTime<Real> time{move.first_frame() + whole, middle - static_cast<Real>(whole)};
    move.positions(time, out.places.first(axes));
    const std::span<MotionTriple<Real>> suprema = out.suprema.subspan(cell * (axes + motors.size()));
    for (std::size_t m = 0; m < motors.size(); ++m) {
      const MotionTriple<Real>& axis = suprema[motors[m].axis];
      const Real place = out.places[motors[m].axis];
      const Real reach = axis[0] * half_seconds;
      MotionTriple<Real>& motor = suprema[axes + m];
      motor = motor_motion(motors[m].calibration->bounds(place - reach, place + reach), axis);
      for (Real& value : motor) value *= 1 + bound_rounding<Real>;
    }
  }
}

template void bound_motors(const Move<double>&, std::span<const CalibratedMotor<double>>,
                           const MotionCells<double>&);
template void bound_motors(const Move<float>&, std::span<const CalibratedMotor<float>>,
                           const MotionCells<float>&);
template void bound_cells(const Move<double>&, std::span<AxisTurn<double>>, const MotionCells<double>&);
template void bound_cells(const Move<float>&, std::span<AxisTurn<float>>, const MotionCells<float>&);

}  // namespace inbetween
