#include "host_tools/cli/take_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < take.axes.size(); ++a) {
    if (!take.axes[a].move_axis) continue;
    axes.push_back(a);
    table.columns.push_back({.name = take.axes[a].name, .unit = unit_of_take(take.axes[a])});
  }
  table.fps = take.frame_rate;
  table.phase = ShutterPhase::frame_boundary;
  FramesPassed frames(take.part, table);
  std::optional<double> told_frame;  // of the tick before
  bool was_held = false;             // the tick before told the axes to stay where the move begins
  const auto chosen = [&](const std::vector<double>& all) {
    std::vector<double> values;
    for (const std::size_t a : axes) values.push_back(all[a]);
    return values;
  };
  std::vector<double> last_told;
  store.read_ticks(take, [&](const TakeTick& tick) {
    std::optional<double> frame;
    if (tick.time && !tick.told.empty()) frame = tick.time->frame + tick.time->fraction;
    // A move without a pre-roll leaves its first frame between two ticks.
    const bool begins = frame && !table.first_frame && was_held && *frame > take.part.first;
    if (begins) {
      frames.pass(take.part.first, chosen(positions == RecordedPositions::told ? last_told : tick.actual));
    }
    if (positions == RecordedPositions::told) {
      if (frame) frames.pass(*frame, chosen(tick.told));
    } else if (told_frame && !tick.actual.empty()) {
      frames.pass(*told_frame, chosen(tick.actual));
    }
    told_frame = frame;
    was_held = !tick.told.empty() && !frame;
    last_told = tick.told;
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

}  // namespace inbetween
