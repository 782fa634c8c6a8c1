#include "inbetween/steps/cue_timer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/quintic.hpp"
#include "inbetween/base/bisection.hpp"

namespace inbetween {
namespace {

/// 30 halvings cut a tick of a second to less than a nanosecond.
constexpr int halvings = 40;
/// A playhead reaches an end together with the tick if the rest is below this share, which is rounding.
constexpr double share_rounding = 1e-3;

Error wrong_pulse(std::size_t pulse, const char* what, const char* remedy) {
  return {.code = ErrorCode::out_of_range,
          .what = what,
          .remedy = remedy,
          .key = static_cast<std::int32_t>(pulse)};
}

std::uint64_t bit_of(std::int32_t line) {
  return std::uint64_t{1} << static_cast<unsigned>(line);
}

}  // namespace

/// The variable is the share 0..1 of the tick. Forward on the unfolded time line is positive.
struct CueTimer::TickMotion {
  double frames = 0;    ///< of the whole tick
  Quintic c{};          ///< frames(u) = c[1] u + c[2] u^2 + ...
  bool is_cut = false;  ///< the playhead comes to an end: only c[1] and c[2] count, until there
  std::int64_t start_ns = 0;
  std::int64_t tick_ns = 0;

  /// The share at which c[1] and c[2] alone have come so far, above 1 if they do not within the tick.
  [[nodiscard]] double cut_share(double distance) const {
    const double under_root = c[1] * c[1] + 4 * c[2] * distance;
    if (!(c[1] > 0) || under_root < 0) return 2;
    return 2 * distance / (c[1] + std::sqrt(under_root));
  }
  /// 0 <= distance <= frames.
  [[nodiscard]] std::int64_t time_ns(double distance) const {
    double share = cut_share(distance);
    if (!is_cut) {
      share = distance <= 0 ? 0.0 : 1.0;
      if (distance > 0 && distance < frames) {
        share = bisected({0, 1}, halvings, [&](double u) { return value_at(c, u) < distance; }).high;
      }
    }
    const auto length = static_cast<double>(tick_ns);
    return start_ns + static_cast<std::int64_t>(std::round(std::clamp(share, 0.0, 1.0) * length));
  }
};

/// The stretch between two turns, or within one tick.
struct CueTimer::Leg {
  FrameTime from, to;
  double distance = 0;  ///< frames into the tick at its beginning
  bool is_forward = true;
};

struct CueTimer::Output {
  CueRoom room;
  CueCount count;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  std::int64_t latest_ns = 0;  ///< time of the latest instant put out

  /// Changes at one time are one instant. A line that goes off and on in it stays on.
  void put(std::int64_t at_ns, std::uint64_t line, bool on) {
    if (count.instants == 0 || room.instants[count.instants - 1].at_ns != at_ns) {
      room.instants[count.instants++] = {.at_ns = at_ns};
    }
    EdgeInstant& instant = room.instants[count.instants - 1];
    instant.mask |= line;
    instant.levels = on ? instant.levels | line : instant.levels & ~line;
  }
  /// Whether a line goes off at the time of the last instant.
  [[nodiscard]] bool goes_off(std::int64_t at_ns, std::uint64_t line) const {
    if (count.instants == 0) return false;
    const EdgeInstant& instant = room.instants[count.instants - 1];
    return instant.at_ns == at_ns && (instant.mask & ~instant.levels & line) != 0;
  }
};

Result<CueTimer> CueTimer::make(std::span<const TimedPulse> pulses, std::int32_t first_frame,
                                std::int32_t last_frame, FrameRate fps) {
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    const TimedPulse& pulse = pulses[i];
    if (!(pulse.at.fraction >= 0 && pulse.at.fraction < 1)) {
      return wrong_pulse(i, "a pulse begins at no place of a frame", "use a fraction from 0 to below 1");
    }
    if (pulse.width_ns <= 0) return wrong_pulse(i, "a pulse takes no time", "use a width above 0");
    if (pulse.line < 0 || pulse.line >= static_cast<std::int32_t>(max_lines)) {
      return wrong_pulse(i, "a pulse is on no line", "use a line from 0 to 63");
    }
    if (i > 0 && pulse.at < pulses[i - 1].at) {
      return wrong_pulse(i, "a pulse is out of order", "sort the pulses by their places");
    }
  }
  if (first_frame > last_frame || fps.numerator <= 0 || fps.denominator <= 0) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "pulses are on no time line",
                 .remedy = "give its first and last frame, in order, and its frame rate"};
  }
  return CueTimer(pulses, first_frame, last_frame, fps.frames_per_second());
}

Status CueTimer::check_room(const CueRoom& room) {
  if (room.instants.size() >= instants_for(room.begun.size())) return Done{};
  return Error{.code = ErrorCode::capacity,
               .what = "too little room for the instants of the pulses",
               .remedy = "give as much as instants_for says",
               .needed = static_cast<std::int64_t>(instants_for(room.begun.size()))};
}

std::size_t CueTimer::first_at(const FrameTime& time) const {
  const auto found = std::partition_point(pulses_.begin(), pulses_.end(),
                                          [&](const TimedPulse& pulse) { return pulse.at < time; });
  return static_cast<std::size_t>(found - pulses_.begin());
}
std::size_t CueTimer::first_behind(const FrameTime& time) const {
  const auto found = std::partition_point(pulses_.begin(), pulses_.end(),
                                          [&](const TimedPulse& pulse) { return pulse.at <= time; });
  return static_cast<std::size_t>(found - pulses_.begin());
}

Result<CueCount> CueTimer::advance(const CueTick& tick, CueRoom room) {
  if (const Status enough = check_room(room); !enough) return enough.error();
  if (tick.end_ns <= tick.start_ns || (has_place_ && tick.start_ns < ended_ns_)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a tick takes no time, or begins before the last one ended",
                 .remedy = "give the ticks in their order"};
  }
  Output out{.room = room,
             .count = {},
             .start_ns = tick.start_ns,
             .end_ns = tick.end_ns,
             .latest_ns = tick.start_ns};
  begin_due(out);
  if (!has_place_ || tick.from.time != here_) next_ = first_at(tick.from.time);
  go_through(tick, out);
  end_before(tick.end_ns, out);
  has_place_ = true;
  here_ = tick.to.time;
  ended_ns_ = tick.end_ns;
  return out.count;
}

void CueTimer::go_through(const CueTick& tick, Output& out) {
  const FrameTime from = tick.from.time;
  const FrameTime to = tick.to.time;
  const bool turns = tick.repeated == Repeat::ping_pong;
  // The direction at the start of the tick; after a turn it is the other one.
  bool is_forward = from < to;
  if (tick.repeated != Repeat::none) is_forward = (tick.to.rate > 0) != turns;
  const FrameTime end = is_forward ? last_ : first_;
  const FrameTime other_end = is_forward ? first_ : last_;
  const FrameTime again = turns ? end : other_end;
  const double to_end = std::fabs(frames_between(from, end));
  TickMotion motion{.frames = tick.repeated == Repeat::none ? std::fabs(frames_between(from, to))
                                                            : to_end + std::fabs(frames_between(again, to)),
                    .start_ns = tick.start_ns,
                    .tick_ns = tick.end_ns - tick.start_ns};
  if (!(motion.frames > 0)) return;
  const double tick_s = static_cast<double>(motion.tick_ns) * 1e-9;
  const double sign = is_forward ? 1.0 : double{-1};
  const double sign_after = turns ? -sign : sign;
  const double begin_rate = sign * tick.from.rate * fps_ * tick_s;
  const double end_rate = sign_after * tick.to.rate * fps_ * tick_s;
  const double begin_change = sign * tick.from.rate_change * fps_ * tick_s * tick_s;
  const double end_change = sign_after * tick.to.rate_change * fps_ * tick_s * tick_s;
  motion.c = joining({0, begin_rate, begin_change}, {motion.frames, end_rate, end_change});
  const bool rests_at_end = tick.repeated == Repeat::none && to == end && end_rate == 0 && end_change == 0;
  motion.is_cut = rests_at_end && motion.cut_share(motion.frames) <= 1 + share_rounding;
  if (tick.repeated == Repeat::none) {
    go({from, to, 0, is_forward}, motion, out);
    return;
  }
  go({from, end, 0, is_forward}, motion, out);
  next_ = first_at(again);
  go({again, to, to_end, is_forward != turns}, motion, out);
}

void CueTimer::go(const Leg& leg, const TickMotion& motion, Output& out) {
  if (!leg.is_forward) {
    next_ = first_at(leg.to);
    return;
  }
  Range due{next_, first_behind(leg.to)};
  for (; due.first < due.last; ++due.first) {
    const std::int64_t at_ns = motion.time_ns(leg.distance + frames_between(leg.from, pulses_[due.first].at));
    if (at_ns >= out.end_ns) break;
    begin(due.first, std::max(at_ns, out.latest_ns), out);
  }
  next_ = std::max(next_, due.last);
  // Each side of an end of the time line has at most one range.
  if (due.first < due.last) static_cast<void>(due_.push_back(due));
}

/// Begins the pulses that were passed exactly at the end of the tick before.
void CueTimer::begin_due(Output& out) {
  for (const Range& range : due_) {
    for (std::size_t i = range.first; i < range.last; ++i) begin(i, out.start_ns, out);
  }
  due_.clear();
}

void CueTimer::begin(std::size_t pulse, std::int64_t at_ns, Output& out) {
  if (out.count.begun == out.room.begun.size()) {
    ++counters_.lost;
    return;
  }
  end_before(at_ns, out);
  out.latest_ns = at_ns;
  const TimedPulse& timed = pulses_[pulse];
  const std::uint64_t line = bit_of(timed.line);
  std::int64_t& off_at_ns = off_at_ns_[static_cast<std::size_t>(timed.line)];
  const bool is_on = (lines_on_ & line) != 0;
  const bool is_merged = is_on || out.goes_off(at_ns, line);
  off_at_ns = is_on ? std::max(off_at_ns, at_ns + timed.width_ns) : at_ns + timed.width_ns;
  if (!is_on) out.put(at_ns, line, true);
  lines_on_ |= line;
  if (is_merged) ++counters_.merged;
  out.room.begun[out.count.begun++] = {.pulse = pulse, .at_ns = at_ns, .is_merged = is_merged};
}

void CueTimer::end_before(std::int64_t at_ns, Output& out) {
  for (;;) {
    std::size_t first = max_lines;
    for (std::uint64_t on = lines_on_; on != 0; on &= on - 1) {
      const auto line = static_cast<std::size_t>(std::countr_zero(on));
      if (off_at_ns_[line] >= at_ns) continue;
      if (first == max_lines || off_at_ns_[line] < off_at_ns_[first]) first = line;
    }
    if (first == max_lines) return;
    if (off_at_ns_[first] < out.start_ns) ++counters_.late_ends;
    const std::uint64_t line = bit_of(static_cast<std::int32_t>(first));
    out.latest_ns = std::max(off_at_ns_[first], out.latest_ns);
    out.put(out.latest_ns, line, false);
    lines_on_ &= ~line;
  }
}

Result<CueCount> CueTimer::end_all(CueRoom room) {
  if (const Status enough = check_room(room); !enough) return enough.error();
  Output out{.room = room, .count = {}, .start_ns = ended_ns_, .end_ns = ended_ns_, .latest_ns = ended_ns_};
  begin_due(out);
  end_before(std::numeric_limits<std::int64_t>::max(), out);
  return out.count;
}

}  // namespace inbetween
