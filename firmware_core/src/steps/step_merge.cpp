#include "inbetween/steps/step_merge.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace inbetween {
namespace {

constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();
/// Two steps and a turn between them: within these edges there is more room than a grain asks for.
constexpr std::size_t edges_ahead = 8;

bool is_rise(const StepEdge& edge) {
  return edge.line == StepLine::step && edge.level;
}
bool is_fall(const StepEdge& edge) {
  return edge.line == StepLine::step && !edge.level;
}

/// The time that the timing asks for between an edge and a later one.
std::int64_t min_gap_ns(const StepTiming& timing, const StepEdge& first, const StepEdge& second) {
  if (first.line == StepLine::dir) return timing.dir_setup_ns;
  if (is_rise(first)) return timing.pulse_ns;
  return second.line == StepLine::dir ? timing.dir_hold_ns : timing.pause_ns;
}

/// One axis on its way through its edges.
class EdgeCursor {
 public:
  EdgeCursor() = default;
  EdgeCursor(const StepLines& lines, std::span<const StepEdge> edges, std::int64_t grain_ns)
      : lines_(&lines), edges_(edges), grain_ns_(grain_ns) {
    look();
  }

  /// The earliest and the latest time of its next edge; never_ns: it has no next edge.
  [[nodiscard]] std::int64_t earliest_ns() const { return earliest_ns_; }
  [[nodiscard]] std::int64_t latest_ns() const { return latest_ns_; }

  /// Puts the next edge at `at_ns`.
  void take(std::int64_t at_ns, EdgeInstant& instant) {
    const StepEdge& edge = edges_[next_];
    const std::uint64_t bit = std::uint64_t{1} << (edge.line == StepLine::step ? lines_->step : lines_->dir);
    instant.mask |= bit;
    if (edge.level) instant.levels |= bit;
    if (is_fall(edge)) may_rise_ns_ = at_ns + lines_->timing.pause_ns;
    before_ns_ = at_ns;
    ++next_;
    look();
  }

 private:
  void look() {
    if (next_ == edges_.size()) {
      earliest_ns_ = latest_ns_ = never_ns;
      return;
    }
    const StepEdge& edge = edges_[next_];
    earliest_ns_ = edge.at_ns;
    if (grain_ns_ == 0) {
      latest_ns_ = edge.at_ns;
      return;
    }
    if (next_ > 0) {
      const std::int64_t gap_ns = min_gap_ns(lines_->timing, edges_[next_ - 1], edge);
      earliest_ns_ = std::max(earliest_ns_, before_ns_ + gap_ns);
      if (is_rise(edge)) earliest_ns_ = std::max(earliest_ns_, may_rise_ns_);
    }
    latest_ns_ = edge.at_ns + room_ns();
  }

  /// The longest delay of the next edge after which the edges behind it, delayed as little as possible, are
  /// at most a grain late, and the last edge and the last fall are not late. It is computed from the back;
  /// the edge `edges_ahead` away counts as immovable. A fall is followed by the next edge and also, behind a
  /// change of DIR, by the next rise.
  [[nodiscard]] std::int64_t room_ns() const {
    const std::size_t last = std::min(edges_.size() - 1, next_ + edges_ahead);
    std::int64_t room = 0;
    std::int64_t rise_latest_ns = is_rise(edges_[last]) ? edges_[last].at_ns : never_ns;
    for (std::size_t i = last; i-- > next_;) {
      const StepEdge& edge = edges_[i];
      const StepEdge& behind = edges_[i + 1];
      room += behind.at_ns - edge.at_ns - min_gap_ns(lines_->timing, edge, behind);
      if (is_fall(edge)) {
        const bool is_last = rise_latest_ns == never_ns;
        room = is_last ? 0 : std::min(room, rise_latest_ns - lines_->timing.pause_ns - edge.at_ns);
      }
      room = std::min(room, grain_ns_);
      if (is_rise(edge)) rise_latest_ns = edge.at_ns + room;
    }
    return room;
  }

  const StepLines* lines_ = nullptr;
  std::span<const StepEdge> edges_;
  std::int64_t grain_ns_ = 0;
  std::size_t next_ = 0;
  std::int64_t before_ns_ = 0;                                           ///< when the edge before was put
  std::int64_t may_rise_ns_ = std::numeric_limits<std::int64_t>::min();  ///< for the pause of STEP
  std::int64_t earliest_ns_ = never_ns;
  std::int64_t latest_ns_ = never_ns;
};

/// Whether edges are in the order of time, keep the timing, and every rise is followed by a fall.
bool keeps_timing(std::span<const StepEdge> edges, const StepTiming& timing) {
  std::int64_t may_rise_ns = std::numeric_limits<std::int64_t>::min();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const StepEdge& edge = edges[i];
    if (i > 0) {
      const StepEdge& before = edges[i - 1];
      if (is_rise(before) != is_fall(edge)) return false;
      if (edge.at_ns - before.at_ns < min_gap_ns(timing, before, edge)) return false;
    }
    if (is_rise(edge) && edge.at_ns < may_rise_ns) return false;
    if (is_fall(edge)) may_rise_ns = edge.at_ns + timing.pause_ns;
  }
  return true;
}

}  // namespace

Result<StepMerge> StepMerge::make(std::span<const StepLines> axes, std::int64_t grain_ns) {
  if (axes.empty()) {
    return Error{
        .code = ErrorCode::wrong_count, .what = "there is no axis", .remedy = "give the lines of one"};
  }
  if (grain_ns < 0) {
    return Error{
        .code = ErrorCode::out_of_range, .what = "the grain is negative", .remedy = "use 0 to move no edge"};
  }
  StepMerge merge;
  merge.grain_ns_ = grain_ns;
  std::uint64_t used = 0;
  for (const StepLines& lines : axes) {
    const auto axis = static_cast<std::int32_t>(merge.axes_.size());
    for (const std::int32_t line : {lines.step, lines.dir}) {
      const std::uint64_t bit = line < 0 || line > 63 ? 0 : std::uint64_t{1} << line;
      if (bit == 0 || (used & bit) != 0) {
        return Error{.code = ErrorCode::out_of_range,
                     .what = "a line is not from 0 to 63, or is used twice",
                     .remedy = "give every STEP and DIR a line of its own",
                     .axis = axis};
      }
      used |= bit;
    }
    if (const Status pushed = merge.axes_.push_back(lines); !pushed) return pushed.error();
  }
  return merge;
}

Result<std::size_t> StepMerge::merge(std::int64_t start_ns, std::span<const std::span<const StepEdge>> edges,
                                     std::span<EdgeInstant> out) const {
  if (edges.size() != axes_.size()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are not as many lists of edges as axes",
                 .remedy = "give one for every axis, empty if it has no edges",
                 .needed = static_cast<std::int64_t>(axes_.size())};
  }
  std::array<EdgeCursor, max_axes> memory;
  const std::span<EdgeCursor> cursors(memory.data(), axes_.size());
  std::size_t edge_count = 0;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!keeps_timing(edges[i], axes_[i].timing)) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "edges are out of order, or nearer to each other than the timing of the axis",
                   .remedy = "give what the step generator of this axis wrote",
                   .axis = static_cast<std::int32_t>(i)};
    }
    cursors[i] = EdgeCursor(axes_[i], edges[i], grain_ns_);
    edge_count += edges[i].size();
  }

  const auto is_earlier = [](const EdgeCursor& a, const EdgeCursor& b) {
    return a.earliest_ns() < b.earliest_ns();
  };
  std::size_t size = 0;
  for (;;) {
    std::int64_t at_ns = std::ranges::min_element(cursors, is_earlier)->earliest_ns();
    if (at_ns == never_ns) return size;
    // An edge that can wait for others waits. All edges that may come before the first of them must go are
    // taken together.
    std::int64_t latest_ns = never_ns;
    std::int64_t first_ns = at_ns;
    for (;;) {
      for (const EdgeCursor& cursor : cursors) {
        if (cursor.earliest_ns() == first_ns) latest_ns = std::min(latest_ns, cursor.latest_ns());
      }
      at_ns = first_ns;
      std::int64_t next_ns = never_ns;
      for (const EdgeCursor& cursor : cursors) {
        if (cursor.earliest_ns() > at_ns) next_ns = std::min(next_ns, cursor.earliest_ns());
      }
      if (next_ns == never_ns || next_ns > latest_ns) break;
      first_ns = next_ns;
    }
    if (size == out.size()) {
      return Error{.code = ErrorCode::capacity,
                   .what = "the memory for the instants of a tick is too small",
                   .remedy = "give one for every edge",
                   .needed = static_cast<std::int64_t>(edge_count)};
    }
    EdgeInstant instant{.at_ns = start_ns + at_ns};
    for (EdgeCursor& cursor : cursors) {
      if (cursor.earliest_ns() <= at_ns) cursor.take(at_ns, instant);
    }
    out[size++] = instant;
  }
}

}  // namespace inbetween
