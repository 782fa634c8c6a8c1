#include "inbetween/limits/stop_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stop_pairs.hpp"

namespace inbetween {
namespace {

/// A release is planned with a little less than could be followed exactly: a playhead that advances in ticks
/// is off by rounding, which grows while the rate falls, and needs room to come back. The set stays viable:
/// the smaller Q is, the steeper it may be. Held by playhead_test (AStopAtEveryTick...).
inline constexpr double release_share = 0.99;

/// What V permits, and so much more: the rounding of a playhead.
inline constexpr double state_rounding = 1e-6;

/// In seconds. Where a change of the rate would take longer it waits for a better place.
inline constexpr double max_patience = 60;

/// A cell's supremum this share of a limit above the truth costs a thousandth of a stop.
inline constexpr double slack_share = 0.001;

Status check(const StopRequest& request, std::size_t cell_entries, std::size_t peaks) {
  const MotionCells& motion = request.motion;
  const std::size_t axes = motion.stride();
  if (request.limits.size() != axes || (peaks != 0 && peaks != axes)) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are not as many limits as axes, or peaks of stops",
                 .remedy = "give one for every axis of all tracks, track after track, and every motor",
                 .needed = static_cast<std::int64_t>(axes)};
  }
  if (!(request.rate > 0) || !std::isfinite(request.rate) || !(request.tick_seconds > 0) ||
      !std::isfinite(request.tick_seconds)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the highest rate of a stop is not above 0",
                 .remedy = "use 1, or the highest rate that the move is played at"};
  }
  if (motion.line.cells == 0 || cell_entries != motion.line.cells + 1 ||
      motion.suprema.size() != motion.line.cells * axes) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the memory of the stop bounds has not as many cells as the motion",
                 .remedy =
                     "give it one entry more than the motion has cells, and the motion one supremum for "
                     "each cell and axis",
                 .needed = static_cast<std::int64_t>(motion.line.cells + 1)};
  }
  if (request.within != nullptr && !request.within->is_as_fine_as(cell_entries, request.rate)) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the bounds that others shall stay within have other cells, or a lower rate",
                 .remedy = "make them for the same move, with as many cells and for the highest rate"};
  }
  return Done{};
}

/// In a cell without a pair the rate stays what it is; whatever its release may be, there is none.
StopCell cell_of_pair(const StopRequest& request, const StopPair& pair) {
  const auto [change, jerk] = pair;
  const bool waits = request.may_wait && !(request.rate / change + change / jerk <= max_patience);
  if (waits) return {0, 0, request.max_rate_jerk()};
  return {change, jerk, jerk};
}

/// The pair of every cell, up to the first without one.
std::optional<StopObstacle> find_pairs(const StopRequest& request, std::span<StopCell> out) {
  const std::size_t cells = request.motion.line.cells;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const PairSearch search(request, cell);
    std::optional<StopObstacle> obstacle = search.obstacle();
    if (obstacle && !request.may_wait) {
      obstacle->frame = request.motion.middle_frame(cell);
      return obstacle;
    }
    out[cell] = cell_of_pair(request, obstacle ? StopPair{} : search.quickest());
  }
  out[cells] = out[cells - 1];
  return std::nullopt;
}

Error refusal(const StopObstacle& obstacle) {
  const bool is_jerk = obstacle.quantity == StopQuantity::jerk;
  return {.code = ErrorCode::no_solution,
          .what = is_jerk ? "the jerk of the motion leaves nothing of the stop_jerk to slow down with"
                          : "the acceleration of the motion leaves nothing of the stop_acceleration to slow "
                            "down with",
          .remedy = is_jerk ? "raise the stop_jerk of the axis, or make the move gentler there"
                            : "raise the stop_acceleration of the axis, or make the move gentler there",
          .axis = obstacle.axis,
          .frame = obstacle.frame >= 0 ? static_cast<std::int32_t>(obstacle.frame) : -1};
}

void find_peaks(const StopRequest& request, std::span<const StopCell> cells, std::span<AxisPeaks> out) {
  const double r = request.rate;
  const MotionCells& motion = request.motion;
  for (AxisPeaks& axis : out) axis.velocity = axis.acceleration = axis.jerk = {};
  for (std::size_t cell = 0; cell < motion.line.cells; ++cell) {
    const double frame = motion.middle_frame(cell);
    // A tick of the next cell may begin in this one.
    double change = 0;
    for (std::size_t i = cell > 0 ? cell - 1 : 0; i <= std::min(cell + 2, motion.line.cells); ++i) {
      change = std::max(change, cells[i].rate_change);
    }
    for (std::size_t d = 0; d < out.size(); ++d) {
      const auto& [p1, p2, p3] = motion.of_cell(cell)[d];
      out[d].velocity.raise(p1 * r, frame);
      out[d].acceleration.raise(p2 * r * r + p1 * change, frame);
      out[d].jerk.raise(p3 * r * r * r + 3 * p2 * r * change + p1 * cells[cell].rate_jerk, frame);
    }
  }
}

/// A stop under constant bounds, in seconds and in seconds of the time line: first a rate change above 0
/// falls to 0, then the stop from `rate`, on which the rate is as much above half of it as below.
struct ConstantStop {
  double seconds = 0;
  double distance = 0;

  ConstantStop(double rate, double rising, const StopPair& bound) {
    const auto [change, jerk] = bound;
    const double rise = std::min(rising / jerk, std::sqrt(2 * rate / jerk));
    const double fall =
        change * change <= jerk * rate ? rate / change + change / jerk : 2 * std::sqrt(rate / jerk);
    seconds = rise + fall;
    distance = rate * rise - jerk * rise * rise * rise / 6 + rate * fall / 2;
  }
};

}  // namespace

StopBounds::StopBounds(const StopRequest& request, std::span<StopCell> cells)
    : cells_(cells),
      rate_(request.rate),
      first_frame_(request.motion.line.first_frame),
      frames_(request.motion.line.last_frame - request.motion.line.first_frame) {
  const FrameRate fps = request.motion.fps;
  cell_frames_ = static_cast<double>(frames_) / static_cast<double>(cell_count());
  cell_seconds_ = cell_frames_ * static_cast<double>(fps.denominator) / static_cast<double>(fps.numerator);
}

/// Velocity matters where it takes a share of the acceleration at the largest rate change.
std::size_t stop_cells(const Move& move, std::int32_t rate_hz, double rate) {
  constexpr std::int64_t min_stop_cells = 64;
  const std::int32_t frames = move.last_frame() - move.first_frame();
  const std::int64_t ticks = last_tick(frames, move.frame_rate(), rate_hz);
  const auto longest = static_cast<std::int64_t>(static_cast<double>(ticks) / (2 * std::max(rate, 1.0)));
  const std::int64_t wanted = std::clamp<std::int64_t>(frames, min_stop_cells, max_stop_cells);
  return static_cast<std::size_t>(std::max<std::int64_t>(std::min(wanted, longest), 1));
}

void write_room(std::span<const AxisLimits> limits, double rate, double tick_seconds,
                std::span<MotionTriple> out) {
  const auto [max_rate_change, max_rate_jerk] = StopCaps(rate, tick_seconds);
  for (std::size_t d = 0; d < limits.size(); ++d) {
    const double acceleration = slack_share * limits[d].stop_acceleration();
    const double jerk =
        slack_share * limits[d].stop_jerk().value_or(max_rate_change * limits[d].stop_acceleration());
    out[d] = {std::min(acceleration / max_rate_change, jerk / max_rate_jerk),
              std::min(acceleration / rate / rate, jerk / (3 * rate * max_rate_change)),
              jerk / rate / rate / rate};
  }
}

Result<StopBounds> StopBounds::make(const StopRequest& request, std::span<StopCell> cells,
                                    std::span<AxisPeaks> peaks, std::optional<StopObstacle>* obstacle) {
  if (const Status checked = check(request, cells.size(), peaks.size()); !checked) return checked.error();
  widen(request.motion);
  if (const auto found = find_pairs(request, cells)) {
    if (obstacle != nullptr) *obstacle = found;
    return refusal(*found);
  }
  StopBounds result(request, cells);
  if (request.within != nullptr) result.stay_within(*request.within);
  result.make_continuous();
  if (!request.may_wait) result.find_longest();
  if (!peaks.empty()) find_peaks(request, cells, peaks);
  return result;
}

/// Cell by cell, before the sweeps: they keep what they are made from.
void StopBounds::stay_within(const StopBounds& stops) {
  for (std::size_t i = 0; i < cell_count(); ++i) {
    const StopCell& here = stops.cells_[i];
    const StopCell& next = stops.cells_[i + 1];
    StopCell& own = cells_[i];
    own.rate_change = std::min(own.rate_change, std::min(here.rate_change, next.rate_change));
    own.rate_jerk = std::min(own.rate_jerk, here.rate_jerk);
    own.release_jerk = std::min(own.release_jerk, std::min(here.release_jerk, next.release_jerk));
  }
  cells_[cell_count()] = cells_[cell_count() - 1];
}

/// At a border the lower of both sides, so that linear interpolation stays below both cells; then the two
/// sweeps. R1 is below the pairs of two cells on each side: the R2 of a cell holds in its neighbours too, and
/// only beside the R1 of its own pair.
void StopBounds::make_continuous() {
  const std::size_t count = cell_count();
  for (std::size_t i = count - 1; i > 0; --i) {
    cells_[i].rate_change = std::min(cells_[i].rate_change, cells_[i - 1].rate_change);
    cells_[i].release_jerk = std::min(cells_[i].release_jerk, cells_[i - 1].release_jerk);
  }
  double before = cells_[0].rate_change;
  for (std::size_t i = 0; i <= count; ++i) {
    const double own = cells_[i].rate_change;
    const double after = cells_[std::min(i + 1, count)].rate_change;
    cells_[i].rate_change = std::min(own, std::min(before, after));
    before = own;
  }
  for (std::size_t i = 0; i < count; ++i) limit_rate_change(i, i + 1, i);
  for (std::size_t i = count; i > 0; --i) limit_rate_change(i, i - 1, i - 1);
  for (std::size_t i = 0; i < count; ++i) limit_release_jerk(i, i + 1, i);
  for (std::size_t i = count; i > 0; --i) limit_release_jerk(i, i - 1, i - 1);
  for (StopCell& cell : cells_) cell.release_jerk *= release_share;
}

void StopBounds::limit_rate_change(std::size_t from, std::size_t to, std::size_t cell) {
  const double max_rate_change = cells_[from].rate_change + cells_[cell].rate_jerk * (cell_seconds_ / rate_);
  cells_[to].rate_change = std::min(cells_[to].rate_change, max_rate_change);
}

/// From Q to Q' in one cell: Q' - Q <= c Q (R2 - Q') keeps (S) at every Q between them.
void StopBounds::limit_release_jerk(std::size_t from, std::size_t to, std::size_t cell) {
  const double jerk = cells_[cell].rate_jerk;
  if (jerk == 0) return;  // no rate changes there, so that none has to be released
  const double change =
      std::min(std::max(cells_[cell].rate_change, cells_[cell + 1].rate_change), std::sqrt(2 * rate_ * jerk));
  const double c = 2 * cell_seconds_ / (rate_ * change);
  const double low = cells_[from].release_jerk;
  cells_[to].release_jerk = std::min(cells_[to].release_jerk, low * ((1 + c * jerk) / (1 + c * low)));
}

typename StopBounds::Place StopBounds::place(const FrameTime& time) const {
  const std::int64_t frame = static_cast<std::int64_t>(time.frame) - first_frame_;
  const auto count = static_cast<std::int64_t>(cell_count());
  if (frame < 0) return {0, 0};
  if (frame >= frames_) return {cell_count() - 1, 1};
  const std::int64_t scaled = frame * count;
  // In 32 bits, which a Cortex-M converts without its library.
  const double share = (static_cast<double>(static_cast<std::int32_t>(scaled % frames_)) +
                        time.fraction * static_cast<double>(static_cast<std::int32_t>(count))) /
                       static_cast<double>(frames_);
  // One frame may be several cells.
  const auto whole = static_cast<std::int32_t>(share);
  const std::int64_t cell = scaled / frames_ + whole;
  if (cell >= count) return {cell_count() - 1, 1};
  return {static_cast<std::size_t>(cell), share - static_cast<double>(whole)};
}

StopBound StopBounds::at(const FrameTime& time) const {
  const auto [cell, share] = place(time);
  const StopCell& here = cells_[cell];
  const StopCell& next = cells_[cell + 1];
  return {here.rate_change + share * (next.rate_change - here.rate_change), here.rate_jerk,
          here.release_jerk + share * (next.release_jerk - here.release_jerk)};
}

bool StopBounds::permits(const FrameTime& time, double rate, double change) const {
  constexpr double more = 1 + state_rounding;
  const StopBound bound = at(time);
  const double room = change < 0 ? rate : rate_ * more - rate;
  return room >= 0 && std::fabs(change) <= bound.rate_change * more &&
         change * change <= 2 * room * bound.release_jerk / release_share * more;
}

StopBound StopBounds::min_between(const FrameTime& from, const FrameTime& to) const {
  StopBound lowest = at(from);
  for (std::size_t i = place(from).cell + 1; i <= place(to).cell; ++i) {
    lowest = lowest.lower({cells_[i].rate_change, cells_[i].rate_jerk, cells_[i].release_jerk});
  }
  return lowest.lower(at(to));
}

StopLength StopBounds::stop_from_cell(std::size_t cell, bool forward) const {
  StopPair lowest{cells_[cell].rate_change, cells_[cell].release_jerk};
  const auto lowers = [&lowest](const StopCell& border) {
    const bool is_lower = border.rate_change < lowest.rate_change || border.release_jerk < lowest.rate_jerk;
    lowest = {std::min(lowest.rate_change, border.rate_change),
              std::min(lowest.rate_jerk, border.release_jerk)};
    return is_lower;
  };
  lowers(cells_[cell + 1]);
  const double rising = rising_in(cell);
  ConstantStop stop(rate_, rising, lowest);
  std::size_t border = forward ? cell + 1 : cell;
  double passed = 0;
  while (stop.distance > passed && border != (forward ? cell_count() : 0)) {
    border = forward ? border + 1 : border - 1;
    passed += cell_seconds_;
    if (lowers(cells_[border])) stop = ConstantStop(rate_, rising, lowest);
  }
  return {stop.seconds, frames_in(stop.distance)};
}

StopLength StopBounds::stop_from(const FrameTime& time, bool forward) const {
  return stop_from_cell(place(time).cell, forward);
}

/// A cell is passed over where even a stop under the least bounds of all cells would not be the longest.
void StopBounds::find_longest() {
  StopPair least{cells_[0].rate_change, cells_[0].release_jerk};
  for (const StopCell& cell : cells_) {
    least = {std::min(least.rate_change, cell.rate_change), std::min(least.rate_jerk, cell.release_jerk)};
  }
  for (std::size_t cell = 0; cell < cell_count(); ++cell) {
    const ConstantStop most(rate_, rising_in(cell), least);
    if (most.seconds <= longest_in_time_.length.seconds) continue;
    const double frame = static_cast<double>(first_frame_) + (static_cast<double>(cell) + 0.5) * cell_frames_;
    for (const bool forward : {true, false}) {
      const StopLength length = stop_from_cell(cell, forward);
      if (length.seconds > longest_in_time_.length.seconds) longest_in_time_ = {length, frame, forward};
    }
  }
}

}  // namespace inbetween
