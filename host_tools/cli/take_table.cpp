#include "host_tools/cli/take_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/cli/take_export.hpp"

namespace inbetween {
namespace {

MoveUnit unit_of_take(const TakeAxis& axis) {
  const auto* const word = std::ranges::find(move_unit_words, axis.unit);
  return word == move_unit_words.end() ? MoveUnit::of_rig
                                       : static_cast<MoveUnit>(word - move_unit_words.begin() + 1);
}

std::string name_of_take(const TakeStore& store, std::int64_t take) {
  return fmt::format("{}, take {}", store.file(), take);
}

/// Samples along the time line of a move, of which whole frames are made.
class FramesPassed {
 public:
  FramesPassed(WholeFrames part, BakedTable& table) : next_(part.first), last_(part.last), table_(table) {}

  /// Where the axes are at a place of the time line, in frames.
  void pass(double frame, std::vector<double> positions) {
    while (next_ <= last_ && next_ <= frame) {
      const bool is_between = frame_ && *frame_ < next_ && frame > next_;
      if (!frame_ && frame > next_) begin_later(frame);
      if (next_ > frame) break;
      const double share = is_between ? (next_ - *frame_) / (frame - *frame_) : 1;
      for (std::size_t i = 0; i < positions.size(); ++i) {
        const double from = is_between ? positions_[i] : positions[i];
        table_.columns[i].values.push_back((1 - share) * from + share * positions[i]);
      }
      if (!table_.first_frame) table_.first_frame = next_;
      ++next_;
    }
    frame_ = frame;
    positions_ = std::move(positions);
  }
  [[nodiscard]] std::int32_t next() const { return next_; }

 private:
  /// The frames before the first sample were not seen.
  void begin_later(double frame) { next_ = static_cast<std::int32_t>(std::ceil(frame)); }

  std::int32_t next_, last_;
  BakedTable& table_;
  std::optional<double> frame_ = {};
  std::vector<double> positions_ = {};
};

/// Calls `pass` with each place of the time line, in frames, at which the axes were, and where they were,
/// while it asks for more.
void pass_frames(TakeStore& store, const Take& take, RecordedPositions positions,
                 const std::vector<std::size_t>& axes,
                 const std::function<bool(double, const std::vector<double>&)>& pass) {
  std::optional<double> told_frame;  // of the tick before
  bool was_held = false;             // the tick before told the axes to stay where the move begins
  bool has_begun = false;
  const auto chosen = [&](const std::vector<double>& all) {
    std::vector<double> values;
    values.reserve(axes.size());
    for (const std::size_t a : axes) values.push_back(all[a]);
    return values;
  };
  std::vector<double> last_told;
  store.read_ticks(take, [&](const TakeTick& tick) {
    bool goes_on = true;
    const auto give = [&](double frame, const std::vector<double>& all) {
      has_begun = has_begun || frame >= take.part.first;
      goes_on = pass(frame, chosen(all));
    };
    std::optional<double> frame;
    if (tick.time && !tick.told.empty()) frame = tick.time->frame + tick.time->fraction;
    // A move without a pre-roll leaves its first frame between two ticks.
    const bool begins = frame && !has_begun && was_held && *frame > take.part.first;
    if (begins) give(take.part.first, positions == RecordedPositions::told ? last_told : tick.actual);
    if (positions == RecordedPositions::told) {
      if (frame) give(*frame, tick.told);
    } else if (told_frame && !tick.actual.empty()) {
      give(*told_frame, tick.actual);
    }
    told_frame = frame;
    was_held = !tick.told.empty() && !frame;
    last_told = tick.told;
    return goes_on;
  });
}

/// Those that were in a track.
std::vector<std::size_t> moved_axes(const Take& take) {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < take.axes.size(); ++a)
    if (take.axes[a].move_axis) axes.push_back(a);
  return axes;
}

/// Raises what a place between two rows says of AxisRow::off.
void raise_off(AxisRows& rows, double frame, const std::vector<double>& values) {
  const double place = frame - static_cast<double>(rows.first_frame);
  const auto row = static_cast<std::size_t>(std::floor(place));
  const double share = place - std::floor(place);
  for (std::size_t a = 0; a < values.size(); ++a) {
    AxisRow& axis = rows.axes[a];
    if (row >= axis.off.size()) continue;
    const double line = (1 - share) * axis.positions[row] + share * axis.positions[row + 1];
    axis.off[row] = std::max(axis.off[row], std::fabs(values[a] - line));
  }
}

}  // namespace

BakedTable ticks_of_take(TakeStore& store, std::int64_t number, RecordedPositions positions) {
  const Take take = store.read_head(number);
  BakedTable table = read_record_table(record_of_take(store, number), name_of_take(store, number), positions);
  for (BakedColumn& column : table.columns) {
    const auto axis = std::ranges::find(take.axes, column.name, &TakeAxis::name);
    if (axis != take.axes.end()) column.unit = unit_of_take(*axis);
  }
  table.fps = FrameRate{take.rate_hz, 1};
  table.lines.clear();  // of a text that nobody has
  return table;
}

BakedTable frames_of_take(TakeStore& store, std::int64_t number, RecordedPositions positions) {
  const Take take = store.read_head(number);
  BakedTable table{.file = name_of_take(store, number)};
  const std::vector<std::size_t> axes = moved_axes(take);
  for (const std::size_t a : axes) {
    table.columns.push_back({.name = take.axes[a].name, .unit = unit_of_take(take.axes[a])});
  }
  table.fps = take.frame_rate;
  table.phase = ShutterPhase::frame_boundary;
  FramesPassed frames(take.part, table);
  pass_frames(store, take, positions, axes, [&](double frame, const std::vector<double>& values) {
    frames.pass(frame, values);
    return frames.next() <= take.part.last;
  });
  if (frames.next() <= take.part.last) {
    table.warnings.push_back({{table.file},
                              fmt::format("the take has frames {} to {} of {} to {}, and so has the file",
                                          table.first_frame.value_or(take.part.first), frames.next() - 1,
                                          take.part.first, take.part.last)});
  }
  check_table(table);
  return table;
}

AxisRows rows_of_take(TakeStore& store, std::int64_t number, RecordedPositions positions) {
  const Take take = store.read_head(number);
  BakedTable table = frames_of_take(store, number, positions);
  AxisRows rows{.name = table.file,
                .fps = *table.fps,
                .first_frame = table.first_frame.value_or(0),
                .rows = table.rows(),
                .axes = {}};
  for (BakedColumn& column : table.columns) {
    rows.axes.push_back({.name = std::move(column.name),
                         .positions = std::move(column.values),
                         .off = std::vector<double>(rows.rows - 1, 0)});
  }
  // Of a frame that was passed several times the first pass is in the rows.
  double farthest = static_cast<double>(rows.first_frame);
  const double last = farthest + static_cast<double>(rows.rows - 1);
  pass_frames(store, take, positions, moved_axes(take), [&](double frame, const std::vector<double>& values) {
    if (frame >= farthest && frame <= last) raise_off(rows, frame, values);
    farthest = std::max(farthest, frame);
    return frame < last;
  });
  return rows;
}

}  // namespace inbetween
