#include "motion_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

/// Of what is found in the cell, and of what is found of the axis in all of them: a rate change that is 2 %
/// lower makes a stop that much longer, and a quarter of that costs twice the time.
template <Precise Real>
inline constexpr Real own_closeness = Real(0.02);
template <Precise Real>
inline constexpr Real peak_closeness = Real(0.005);
/// A part of a cell halved so often is given as it is.
constexpr std::int32_t max_cell_halvings = 30;
/// So small that most of the width of a bound can be rounding.
constexpr std::int32_t cell_halvings_before_rounding = 5;

template <Precise Real>
void raise(MotionTriple<Real>& to, const MotionTriple<Real>& from) {
  for (std::size_t i = 0; i < motion_quantities; ++i) to[i] = std::max(to[i], from[i]);
}

template <Precise Real>
void raise_magnitude(MotionTriple<Real>& to, const MotionTriple<Real>& from) {
  for (std::size_t i = 0; i < motion_quantities; ++i) {
    // What is no number is not found; the enclosure of its surroundings is without bound.
    if (std::fabs(from[i]) <= std::numeric_limits<Real>::max()) to[i] = std::max(to[i], std::fabs(from[i]));
  }
}

/// One track of the move.
template <Precise Real>
class TrackCells {
 public:
  TrackCells(const Move<Real>& move, const Track<Real>& track, std::size_t first_axis,
             std::span<AxisTurn<Real>> turns, const MotionCells<Real>& out)
      : axes_(static_cast<std::size_t>(track.path().axis_count())),
        all_axes_(move.axis_count()),
        first_axis_(first_axis),
        first_frame_(static_cast<Real>(move.first_frame())),
        cell_frames_(static_cast<Real>(move.last_frame() - move.first_frame()) /
                     static_cast<Real>(out.cells)),
        out_(out),
        walk_(track),
        enclosure_(track, turns) {}

  void run() {
    walk_.run([this](const Stretch<Real>& stretch) { sample(stretch); });
    walk_.run([this](const Stretch<Real>& stretch) {
      enclosure_.show(stretch.path);
      take_reversal(stretch);
      each_part(stretch, [&](const MotionBox<Real>& part, std::size_t cell) { prove(stretch, part, cell); });
    });
  }

 private:
  struct Box {
    MotionBox<Real> box;
    std::uint64_t open = 0;  ///< axes that are not bounded closely enough yet
    std::int32_t halvings = 0;
  };

  [[nodiscard]] std::span<MotionTriple<Real>> of_cell(std::size_t cell) const {
    return out_.suprema.subspan(cell * all_axes_ + first_axis_, axes_);
  }
  [[nodiscard]] std::size_t cell_of(Real frame) const {
    const Real cell = (frame - first_frame_) / cell_frames_;
    return cell > 0 ? std::min(static_cast<std::size_t>(cell), out_.cells - 1) : 0;
  }

  /// The peaks of the axes, so far as three points of every stretch show them.
  void sample(const Stretch<Real>& stretch) {
    enclosure_.show(stretch.path);
    for (const Real x : {Real(0), stretch.end / 2, stretch.end}) {
      const MotionSurroundings<Real> point = enclosure_.at(stretch, x, walk_.tau_at(stretch, x));
      for (std::size_t d = 0; d < axes_; ++d) raise_magnitude(peaks_[d], enclosure_.here(d, point));
    }
  }

  void take_reversal(const Stretch<Real>& stretch) {
    if (!enclosure_.turns_back(stretch)) return;
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
    const std::size_t last = cell_of(time.frame(stretch.end));
    const bool forward = time.frames > 0;
    MotionBox<Real> part{.begin = 0, .end = 0, .tau_begin = stretch.tau_begin};
    for (std::size_t cell = cell_of(time.frame(0));; forward ? ++cell : --cell) {
      const auto border = static_cast<Real>(forward ? cell + 1 : cell);
      const Real x = (first_frame_ + border * cell_frames_ - time.first_frame) / time.frames;
      part.end = cell == last ? stretch.end : std::clamp(x, part.begin, stretch.end);
      part.tau_end = walk_.tau_at(stretch, part.end);
      if (part.end > part.begin || stretch.end == 0) visit(part, cell);
      if (cell == last) return;
      part.begin = part.end;
      part.tau_begin = part.tau_end;
    }
  }

  void prove(const Stretch<Real>& stretch, const MotionBox<Real>& part, std::size_t cell) {
    const std::span<MotionTriple<Real>> proven = of_cell(cell);
    const MotionSurroundings<Real> begin = enclosure_.at(stretch, part.begin, part.tau_begin);
    const MotionSurroundings<Real> end = enclosure_.at(stretch, part.end, part.tau_end);
    for (std::size_t d = 0; d < axes_; ++d) {
      found_[d] = {};
      raise_magnitude(found_[d], enclosure_.here(d, begin));
      raise_magnitude(found_[d], enclosure_.here(d, end));
    }
    std::array<Box, max_cell_halvings + 2> stack;
    std::size_t count = 0;
    const std::uint64_t all = axes_ < max_bounded_axes ? (std::uint64_t{1} << axes_) - 1 : ~std::uint64_t{0};
    stack[count++] = {part, all, 0};
    while (count > 0) {
      Box next = stack[--count];
      MotionBox<Real>& box = next.box;
      box.x = stretch.divide(box.begin, box.end);
      box.tau = walk_.tau_at(stretch, box.x);
      const std::uint64_t open = prove_box(stretch, next, proven);
      if (open == 0) continue;
      stack[count++] = {{box.x, box.end, box.tau, box.tau_end}, open, next.halvings + 1};
      stack[count++] = {{box.begin, box.x, box.tau_begin, box.tau}, open, next.halvings + 1};
    }
  }

  /// Takes what is close enough and returns the axes for which the box has to be halved.
  std::uint64_t prove_box(const Stretch<Real>& stretch, const Box& whole,
                          std::span<MotionTriple<Real>> proven) {
    const MotionBox<Real>& box = whole.box;
    const MotionSurroundings<Real> surroundings = enclosure_.around(stretch, box);
    const bool is_last = whole.halvings >= max_cell_halvings || box.x <= box.begin || box.x >= box.end;
    std::uint64_t still_open = 0;
    for (std::size_t d = 0; d < axes_; ++d) {
      const std::uint64_t bit = std::uint64_t{1} << d;
      if ((whole.open & bit) == 0) continue;
      const auto [here, bound] = enclosure_.range(d, surroundings);
      raise_magnitude(found_[d], here);
      raise(peaks_[d], found_[d]);
      if (is_last || is_close(d, bound, proven[d]) ||
          (whole.halvings >= cell_halvings_before_rounding &&
           is_rounding(d, bound, proven[d], stretch, box))) {
        raise(proven[d], bound);
      } else {
        still_open |= bit;
      }
    }
    return still_open;
  }
  [[nodiscard]] Real allowed(std::size_t d, std::size_t i, const MotionTriple<Real>& proven) const {
    const Real more = std::max(found_[d][i] * own_closeness<Real>, peaks_[d][i] * peak_closeness<Real>);
    const PeakSlack<Real>& slack = out_.slack[first_axis_ + d];
    const MotionTriple<Real> slacks{slack.velocity, slack.acceleration, slack.jerk};
    return std::max(found_[d][i] + std::max(more, slacks[i]), proven[i]);
  }
  [[nodiscard]] bool is_close(std::size_t d, const MotionTriple<Real>& bound,
                              const MotionTriple<Real>& proven) const {
    for (std::size_t i = 0; i < motion_quantities; ++i) {
      if (!(bound[i] <= allowed(d, i, proven))) return false;
    }
    return true;
  }
  /// Halving does not help any more: at the very point rounding alone, that of the place at a time included,
  /// takes the bound half as far.
  [[nodiscard]] bool is_rounding(std::size_t d, const MotionTriple<Real>& bound,
                                 const MotionTriple<Real>& proven, const Stretch<Real>& stretch,
                                 const MotionBox<Real>& box) const {
    const MotionTriple<Real> floor = enclosure_.range(d, enclosure_.around(stretch, box.middle())).bound;
    for (std::size_t i = 0; i < motion_quantities; ++i) {
      const Real max_bound = allowed(d, i, proven);
      if (!(bound[i] <= max_bound) && !(bound[i] <= 2 * floor[i] && floor[i] > max_bound)) return false;
    }
    return true;
  }

  std::size_t axes_;
  std::size_t all_axes_;
  std::size_t first_axis_;
  Real first_frame_;
  Real cell_frames_;
  const MotionCells<Real>& out_;
  StretchWalk<Real> walk_;
  MotionEnclosure<Real> enclosure_;
  std::array<MotionTriple<Real>, max_bounded_axes> peaks_{};
  std::array<MotionTriple<Real>, max_bounded_axes> found_{};
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
      raise(out.suprema[cell * rolls.size() + d], roll_suprema(rolls[d], from, to));
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

template void bound_cells(const Move<double>&, std::span<AxisTurn<double>>, const MotionCells<double>&);
template void bound_cells(const Move<float>&, std::span<AxisTurn<float>>, const MotionCells<float>&);

}  // namespace inbetween
