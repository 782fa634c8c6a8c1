#include "host_tools/takes/tick_codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "host_tools/takes/byte_text.hpp"

namespace inbetween {
namespace {

constexpr std::uint8_t chunk_version = 1;
constexpr std::size_t sum_bytes = 8;

// What a tick has.
enum Flag : std::uint8_t {
  is_next = 1,  ///< it is the next, in the same state, on the frame that was expected
  has_time = 2,
  has_told = 4,
  tells_otherwise = 8,  ///< setpoints are not those that were expected
  has_other_rate = 16,
  has_other_turn = 32,
  is_rounded = 64,    ///< actual positions are some doubles off
  is_unsteady = 128,  ///< an axis goes not as fast as before
};

/// Beside the state.
constexpr unsigned shown_frame = 0x80;
/// An actual position that is so many doubles off is a whole number of counts that was computed otherwise.
constexpr std::int64_t max_rounding = 64;
/// Beyond this many counts a difference of two is no double any more.
constexpr double max_counts = 1e15;
/// No playhead goes so many frames in a tick.
constexpr double max_step_frames = 1e9;

std::int64_t places_between(double from, double to) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(place_of_bits(to)) -
                                   static_cast<std::uint64_t>(place_of_bits(from)));
}

bool are_same(double one, double other) {
  return std::bit_cast<std::uint64_t>(one) == std::bit_cast<std::uint64_t>(other);
}

/// Whole frames and a part, of which the whole ones may be beyond any move.
struct ExpectedTime {
  std::int64_t frame = 0;
  double fraction = 0;
};

/// The actual positions of an axis: counts from the first of the chunk, or from one that is no such number.
struct CountedAxis {
  double resolution = 0;
  double per_unit = 0;    ///< 1 / resolution
  double anchor = 0;      ///< the position that counts are from
  double first = 0;       ///< its own count, where it is one
  bool is_whole = false;  ///< the anchor is a whole number of counts to the last bit
  bool is_known = false;  ///< there is an anchor
  std::int64_t last = 0, before = 0;

  void restart(double actual) {
    anchor = actual;
    first = std::nearbyint(actual * per_unit);
    is_whole = std::fabs(first) < max_counts && are_same(first / per_unit, actual);
    is_known = std::isfinite(actual);
    last = before = 0;
  }
  [[nodiscard]] double position(std::int64_t counts) const {
    const auto whole = static_cast<double>(counts);
    return is_whole ? (first + whole) / per_unit : anchor + whole * resolution;
  }
  /// False where the position is too far for counts, or none.
  bool count(double actual, std::int64_t& counts) const {
    const double number = is_whole ? actual * per_unit - first : (actual - anchor) * per_unit;
    if (!is_known || !(std::fabs(number) < max_counts)) return false;
    counts = std::llrint(number);
    return true;
  }
  [[nodiscard]] std::int64_t expected() const {
    return static_cast<std::int64_t>(2 * static_cast<std::uint64_t>(last) -
                                     static_cast<std::uint64_t>(before));
  }
  void go_to(std::int64_t counts) {
    before = last;
    last = counts;
  }
};

}  // namespace

class KnownTicks {
 public:
  explicit KnownTicks(const TickShape& shape)
      : axes(shape.axes.size()),
        told(shape.axes.size()),
        told_before(shape.axes.size()),
        expected(shape.axes.size()),
        motions(shape.motion != nullptr ? shape.motion->axis_count() : 0),
        tick_s_(1.0 / shape.rate_hz),
        fps_(shape.frame_rate.frames_per_second()) {
    for (std::size_t a = 0; a < axes.size(); ++a) {
      axes[a].resolution = shape.axes[a].resolution;
      axes[a].per_unit = 1 / shape.axes[a].resolution;
    }
  }

  void restart() {
    number = -1;
    state = SupervisorState::disarmed;
    shows_frame = false;
    time = {};
    rate = change = change_before = 0;
    turn = 0;
    std::ranges::fill(told, 0);
    std::ranges::fill(told_before, 0);
    for (CountedAxis& axis : axes) axis.is_known = false;
  }
  /// In a tick the rate changes by the mean of its change before and after, as far as that goes on evenly.
  [[nodiscard]] double expected_rate(double now_change) const {
    return rate + (change + now_change) / 2 * tick_s_;
  }
  [[nodiscard]] double expected_change() const { return change + (change - change_before); }
  [[nodiscard]] ExpectedTime expected_time(double now_rate, double now_change) const {
    const double seconds = ((rate + now_rate) / 2 - (now_change - change) * tick_s_ / 12) * tick_s_;
    const double sum = time.fraction + seconds * fps_;
    if (!(std::fabs(sum) < max_step_frames)) return {time.frame, 0};
    const double whole = std::floor(sum);
    return {time.frame + static_cast<std::int64_t>(whole), sum - whole};
  }
  /// The setpoint that every axis has if nothing but the move moves it.
  void expect_told(const TickShape& shape, const TakeTick& tick) {
    std::ranges::copy(told, expected.begin());
    if (!tick.time || shape.motion == nullptr) return;
    shape.motion->motion(*tick.time, motions);
    for (std::size_t a = 0; a < expected.size(); ++a) {
      const auto& axis = shape.axes[a].move_axis;
      if (axis && *axis < motions.size()) expected[a] = motions[*axis].position;
    }
  }
  void take_place(const TakeTick& tick) {
    number = tick.number;
    state = tick.state;
    shows_frame = tick.shows_frame;
    turn = tick.turn;
    if (!tick.time) return;
    time = *tick.time;
    rate = tick.rate;
    change_before = change;
    change = tick.rate_change;
  }
  void take_told(std::span<const double> now) {
    std::swap(told, told_before);
    std::ranges::copy(now, told.begin());
  }

  std::int64_t number = -1;
  SupervisorState state = SupervisorState::disarmed;
  bool shows_frame = false;
  FrameTime time;
  double rate = 0, change = 0, change_before = 0;
  std::int64_t turn = 0;
  std::vector<CountedAxis> axes;
  std::vector<double> told, told_before, expected;
  std::vector<AxisMotion> motions;

 private:
  double tick_s_;
  double fps_;
};

namespace {

/// Writes a tick after those that are known.
class TickWriter {
 public:
  TickWriter(const TickShape& shape, KnownTicks& known, ByteWriter& out)
      : shape_(shape), known_(known), out_(out) {}

  void write(const TakeTick& tick) {
    write_place(tick);
    write_told(tick);
    known_.take_place(tick);
    write_actual(tick);
    out_.byte(flags_);
    out_.text() += body_.text();
  }

 private:
  void write_place(const TakeTick& tick) {
    const bool goes_on = tick.number == known_.number + 1 && tick.state == known_.state &&
                         tick.shows_frame == known_.shows_frame;
    ExpectedTime expected;
    if (tick.time) expected = known_.expected_time(tick.rate, tick.rate_change);
    if (goes_on && (!tick.time || tick.time->frame == expected.frame)) {
      flags_ |= is_next;
    } else {
      body_.whole_signed(tick.number - known_.number - 1);
      body_.byte(static_cast<std::uint8_t>(static_cast<unsigned>(tick.state) |
                                           (tick.shows_frame ? shown_frame : 0U)));
    }
    if (tick.turn != known_.turn) {
      flags_ |= has_other_turn;
      // Any two of them: what goes beyond the whole numbers comes back round (read_place).
      body_.whole_signed(static_cast<std::int64_t>(static_cast<std::uint64_t>(tick.turn) -
                                                   static_cast<std::uint64_t>(known_.turn)));
    }
    if (!tick.time) return;
    flags_ |= has_time;
    if (!are_same(tick.rate, known_.rate) || !are_same(tick.rate_change, known_.change)) {
      flags_ |= has_other_rate;
      body_.near(tick.rate_change, known_.expected_change());
      body_.near(tick.rate, known_.expected_rate(tick.rate_change));
    }
    if ((flags_ & is_next) == 0) body_.whole_signed(tick.time->frame - expected.frame);
    body_.near(tick.time->fraction, expected.fraction);
  }

  void write_told(const TakeTick& tick) {
    if (tick.told.empty()) return;
    flags_ |= has_told;
    known_.expect_told(shape_, tick);
    if (!std::ranges::equal(tick.told, known_.expected, are_same)) {
      flags_ |= tells_otherwise;
      for (std::size_t a = 0; a < tick.told.size(); ++a) {
        body_.near(tick.told[a], 2 * known_.told[a] - known_.told_before[a]);
      }
    }
    known_.take_told(tick.told);
  }

  void write_actual(const TakeTick& tick) {
    roundings_.assign(tick.actual.size(), 0);
    ByteWriter counts;
    for (std::size_t a = 0; a < tick.actual.size(); ++a) {
      CountedAxis& axis = known_.axes[a];
      std::int64_t now = 0;
      if (!axis.count(tick.actual[a], now)) {
        flags_ |= is_unsteady;
        counts.whole(0);
        counts.number(tick.actual[a]);
        axis.restart(tick.actual[a]);
        continue;
      }
      const std::int64_t off = now - axis.expected();
      if (off != 0) flags_ |= is_unsteady;
      counts.whole(1 + ByteWriter::folded(off));
      axis.go_to(now);
      const std::int64_t rounding = places_between(axis.position(now), tick.actual[a]);
      if (std::llabs(rounding) <= max_rounding) roundings_[a] = rounding;
      if (roundings_[a] != 0) flags_ |= is_rounded;
    }
    if ((flags_ & is_unsteady) != 0) body_.text() += counts.text();
    if ((flags_ & is_rounded) == 0) return;
    for (const std::int64_t rounding : roundings_) body_.whole_signed(rounding);
  }

  const TickShape& shape_;
  KnownTicks& known_;
  ByteWriter& out_;
  ByteWriter body_;
  std::uint8_t flags_ = 0;
  std::vector<std::int64_t> roundings_;
};

class TickReader {
 public:
  TickReader(const TickShape& shape, KnownTicks& known, ByteReader& in)
      : shape_(shape), known_(known), in_(in) {}

  /// What is wrong; "" for nothing.
  const char* read(TakeTick& tick) {
    flags_ = in_.byte();
    if (const char* wrong = read_place(tick); *wrong != '\0') return wrong;
    read_told(tick);
    known_.take_place(tick);
    read_actual(tick);
    return in_.is_short() ? "it is cut off" : "";
  }

 private:
  [[nodiscard]] bool has(Flag flag) const { return (flags_ & flag) != 0; }

  const char* read_place(TakeTick& tick) {
    tick.number = known_.number + 1;
    tick.state = known_.state;
    tick.shows_frame = known_.shows_frame;
    if (!has(is_next)) {
      const std::int64_t gap = in_.whole_signed();
      const std::uint8_t told = in_.byte();
      const auto state = static_cast<std::uint8_t>(told & ~shown_frame);
      if (gap < 0 || gap > max_gap) return "its ticks do not follow each other";
      if (state >= supervisor_states) return "it has an unknown state";
      tick.number += gap;
      tick.state = static_cast<SupervisorState>(state);
      tick.shows_frame = (told & shown_frame) != 0;
    }
    tick.turn = known_.turn;
    if (has(has_other_turn)) {
      tick.turn = static_cast<std::int64_t>(static_cast<std::uint64_t>(tick.turn) +
                                            static_cast<std::uint64_t>(in_.whole_signed()));
    }
    tick.time.reset();
    tick.rate = tick.rate_change = 0;
    if (!has(has_time)) return "";
    tick.rate = known_.rate;
    tick.rate_change = known_.change;
    if (has(has_other_rate)) {
      tick.rate_change = in_.near(known_.expected_change());
      tick.rate = in_.near(known_.expected_rate(tick.rate_change));
    }
    const ExpectedTime expected = known_.expected_time(tick.rate, tick.rate_change);
    std::int64_t frame = expected.frame;
    if (!has(is_next)) {
      const std::int64_t off = in_.whole_signed();
      if (std::llabs(off / 2) > std::numeric_limits<std::int32_t>::max()) return no_frame;
      frame += off;
    }
    if (frame < std::numeric_limits<std::int32_t>::min() || frame > std::numeric_limits<std::int32_t>::max())
      return no_frame;
    const double fraction = in_.near(expected.fraction);
    if (!(fraction >= 0 && fraction < 1)) return no_frame;
    tick.time = FrameTime{static_cast<std::int32_t>(frame), fraction};
    return "";
  }

  void read_told(TakeTick& tick) {
    tick.told.clear();
    if (!has(has_told)) return;
    tick.told.resize(known_.axes.size());
    if (has(tells_otherwise)) {
      for (std::size_t a = 0; a < tick.told.size(); ++a) {
        tick.told[a] = in_.near(2 * known_.told[a] - known_.told_before[a]);
      }
    } else {
      known_.expect_told(shape_, tick);
      std::ranges::copy(known_.expected, tick.told.begin());
    }
    known_.take_told(tick.told);
  }

  void read_actual(TakeTick& tick) {
    tick.actual.resize(known_.axes.size());
    for (std::size_t a = 0; a < tick.actual.size(); ++a) {
      CountedAxis& axis = known_.axes[a];
      const std::uint64_t code = has(is_unsteady) ? in_.whole() : 1;
      if (code == 0) {
        tick.actual[a] = in_.number();
        axis.restart(tick.actual[a]);
        continue;
      }
      axis.go_to(static_cast<std::int64_t>(static_cast<std::uint64_t>(axis.expected()) +
                                           static_cast<std::uint64_t>(ByteReader::unfolded(code - 1))));
      tick.actual[a] = axis.position(axis.last);
    }
    if (!has(is_rounded)) return;
    for (double& actual : tick.actual) {
      const std::int64_t rounding = in_.whole_signed();
      actual = at_place_of_bits(static_cast<std::int64_t>(static_cast<std::uint64_t>(place_of_bits(actual)) +
                                                          static_cast<std::uint64_t>(rounding)));
    }
  }

  static constexpr std::int64_t max_gap = std::int64_t{1} << 40U;
  static constexpr const char* no_frame = "it has a place that is on no time line";
  const TickShape& shape_;
  KnownTicks& known_;
  ByteReader& in_;
  std::uint8_t flags_ = 0;
};

}  // namespace

TickEncoder::TickEncoder(TickShape shape)
    : shape_(std::move(shape)), known_(std::make_unique<KnownTicks>(shape_)) {}
TickEncoder::~TickEncoder() = default;

void TickEncoder::add(const TakeTick& tick) {
  if (ticks_ == 0) {
    known_->restart();
    known_->number = tick.number - 1;
    first_ = tick.number;
  }
  ByteWriter out;
  TickWriter(shape_, *known_, out).write(tick);
  text_ += out.text();
  ++ticks_;
}

std::string TickEncoder::take_chunk() {
  ByteWriter out;
  out.byte(chunk_version);
  out.whole(static_cast<std::uint64_t>(ticks_));
  out.whole_signed(first_);
  out.text() += text_;
  out.fixed(sum_of(out.text()));
  text_.clear();
  ticks_ = 0;
  return std::move(out.text());
}

std::string decode_ticks(std::string_view chunk, const TickShape& shape,
                         const std::function<bool(const TakeTick&)>& take) {
  if (chunk.size() < sum_bytes) return "it is cut off";
  const std::string_view body = chunk.substr(0, chunk.size() - sum_bytes);
  if (ByteReader(chunk.substr(body.size())).fixed() != sum_of(body)) return "its check sum is wrong";
  ByteReader in(body);
  if (in.byte() != chunk_version) return "a newer program has written it";
  const std::uint64_t ticks = in.whole();
  const std::int64_t first = in.whole_signed();
  KnownTicks known(shape);
  known.restart();
  if (first < 0 || first > std::numeric_limits<std::int64_t>::max() / 2) return "it begins nowhere";
  known.number = first - 1;
  TickReader reader(shape, known, in);
  TakeTick tick;
  for (std::uint64_t i = 0; i < ticks; ++i) {
    if (const char* wrong = reader.read(tick); *wrong != '\0') return wrong;
    if (!take(tick)) return "";
  }
  return in.left() == 0 ? "" : "it has more bytes than ticks";
}

}  // namespace inbetween
