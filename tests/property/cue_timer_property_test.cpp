#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "inbetween/steps/cue_timer.hpp"
#include "tests/support/property.hpp"

/// Pulses against an oracle that knows only the position of the playhead as a function of time, samples it,
/// and keeps for each pulse whether it is armed.

namespace inbetween {
namespace cue_timer_property_test {

constexpr int many_plays = 2000;
constexpr int ticks_of_play = 120;
constexpr std::int32_t last_frame = 12;
constexpr std::size_t room = 64;
constexpr double microsecond_ns = 1000;

/// A tick with one r'', which does not turn, in frames and seconds, unfolded at the ends of the time line.
struct Motion {
  long double from = 0, rate = 0, change = 0, jerk = 0;
  [[nodiscard]] long double at(long double t) const {
    return from + t * (rate + t * (change / 2 + t * jerk / 6));
  }
  [[nodiscard]] Motion after(long double t) const {
    return {at(t), rate + t * (change + t * jerk / 2), change + t * jerk, 0};
  }
  /// When it comes to a place that lies between its ends: of 64 samples the first behind it, then halved.
  [[nodiscard]] long double time_of(long double place, long double tick_s) const {
    const bool forward = at(tick_s) > from;
    const auto is_behind = [&](long double t) { return forward ? at(t) >= place : at(t) <= place; };
    long double before = 0;
    long double behind = tick_s;
    for (int i = 1; i <= 64; ++i) {
      const long double t = tick_s * i / 64;
      if (is_behind(t)) {
        behind = t;
        break;
      }
      before = t;
    }
    for (int i = 0; i < 60; ++i) {
      const long double middle = (before + behind) / 2;
      (is_behind(middle) ? behind : before) = middle;
    }
    return behind;
  }
};

struct ExpectedPulse {
  std::size_t pulse;
  long double at_ns;
};

/// Which pulses begin when.
class Oracle {
 public:
  Oracle(const std::vector<TimedPulse>& pulses) : pulses_(pulses), is_armed_(pulses.size(), 1) {}

  void arm_all() { std::fill(is_armed_.begin(), is_armed_.end(), char{1}); }
  [[nodiscard]] static long double place_of(const TimedPulse& pulse) {
    return static_cast<long double>(pulse.at.frame) + static_cast<long double>(pulse.at.fraction);
  }
  /// From one place to another, `unfold` of which is the motion's.
  template <class Unfold>
  void go(long double from, long double to, const Motion& motion, long double tick_s, long double start_ns,
          Unfold unfold, bool forward) {
    for (std::size_t i = 0; i < pulses_.size(); ++i) {
      const long double place = place_of(pulses_[i]);
      if (!forward) {
        if (place >= to && place <= from) is_armed_[i] = 1;
        continue;
      }
      if (is_armed_[i] == 0 || place < from || place > to) continue;
      is_armed_[i] = 0;
      expected.push_back({i, start_ns + motion.time_of(unfold(place), tick_s) * 1e9L});
    }
  }
  std::vector<ExpectedPulse> expected;

 private:
  const std::vector<TimedPulse>& pulses_;
  std::vector<char> is_armed_;
};

double share() {
  return *rc::gen::inRange(0, 10'001) / 10'000.0;
}

FrameTime frame_time(long double place) {
  const long double whole = std::floor(place);
  const auto fraction = static_cast<double>(place - whole);
  if (fraction >= 1) return {static_cast<std::int32_t>(whole) + 1, 0};  // it is rounded up
  return {static_cast<std::int32_t>(whole), fraction};
}

std::vector<TimedPulse> random_pulses() {
  std::vector<TimedPulse> pulses;
  const int count = *rc::gen::inRange(1, 30);
  for (int i = 0; i < count; ++i) {
    const std::int32_t frame = *rc::gen::inRange(0, last_frame + 1);
    const double phase = frame == last_frame || *rc::gen::arbitrary<bool>() ? 0 : share() * 0.999;
    pulses.push_back({{frame, phase}, *rc::gen::inRange(1, 60'000) * 1000LL, *rc::gen::inRange(0, 4)});
  }
  std::ranges::stable_sort(pulses, [](const auto& a, const auto& b) { return a.at < b.at; });
  return pulses;
}

/// What the lines were, as the timer says.
struct Lines {
  std::array<std::vector<std::int64_t>, 4> edges;  ///< on, off, on, ...

  void take(const EdgeInstant& instant) {
    for (std::size_t line = 0; line < edges.size(); ++line) {
      if ((instant.mask >> line & 1) == 0) continue;
      const bool on = (instant.levels >> line & 1) != 0;
      RC_ASSERT(on == (edges[line].size() % 2 == 0));
      edges[line].push_back(instant.at_ns);
    }
  }
};

/// A play of ticks that pause, speed up, turn, repeat and jump.
class Play {
 public:
  Play() : pulses_(random_pulses()), oracle_(pulses_) {
    tick_ns_ = *rc::gen::element<std::int64_t>(250'000, 1'000'000, 4'000'000, 4'166'666, 10'000'000);
    const auto timer = CueTimer::make(pulses_, 0, last_frame, fps_);
    RC_ASSERT(timer);
    timer_.push_back(*timer);
    place_ = *rc::gen::inRange(0, last_frame + 1);
  }

  void tick() {
    std::int64_t length_ns = tick_ns_;
    if (*rc::gen::inRange(0, 20) == 0) length_ns *= *rc::gen::inRange(2, 12);
    if (*rc::gen::inRange(0, 50) == 0) jump();
    if (*rc::gen::inRange(0, 12) == 0) choose();
    move(length_ns);
  }

  void compare() {
    RC_ASSERT(begun_.size() == oracle_.expected.size());
    std::array<std::vector<std::pair<std::int64_t, std::int64_t>>, 4> spans;
    for (std::size_t i = 0; i < begun_.size(); ++i) {
      const ExpectedPulse& expected = oracle_.expected[i];
      const auto off_ns = std::fabs(static_cast<double>(expected.at_ns - begun_[i].at_ns));
      RC_ASSERT(off_ns < microsecond_ns);
      RC_ASSERT(pulses_[begun_[i].pulse].at == pulses_[expected.pulse].at);
      const TimedPulse& pulse = pulses_[begun_[i].pulse];
      spans[static_cast<std::size_t>(pulse.line)].emplace_back(begun_[i].at_ns,
                                                               begun_[i].at_ns + pulse.width_ns);
    }
    for (std::size_t line = 0; line < spans.size(); ++line) {
      std::ranges::sort(spans[line]);
      std::vector<std::int64_t> edges;
      for (const auto& [on, off] : spans[line]) {
        if (!edges.empty() && on <= edges.back()) {
          edges.back() = std::max(edges.back(), off);
        } else {
          edges.insert(edges.end(), {on, off});
        }
      }
      RC_ASSERT(edges == lines_.edges[line]);
    }
  }

  void finish() {
    // What was passed at the end of the last tick begins, and everything ends.
    mode_ = 0;
    move(tick_ns_);
    keep(timer_[0].end_all({begun_room_, instants_}));
  }

 private:
  void choose() {
    mode_ = *rc::gen::element(-1, 0, 1, 1, 1);
    speed_ = *rc::gen::element(0.1L, 0.5L, 1.0L, 1.0L, 2.0L, 10.0L);
    is_bent_ = *rc::gen::inRange(0, 3) == 0;
    repeat_ = *rc::gen::element(Repeat::none, Repeat::loop, Repeat::ping_pong);
  }
  void jump() {
    const long double to = *rc::gen::inRange(0, last_frame + 1);
    if (to == place_) return;
    place_ = to;
    oracle_.arm_all();
  }

  void move(std::int64_t length_ns) {
    // From an end there is nothing to play beyond it; and no tick is as long as half of the time line.
    if (place_ == (mode_ > 0 ? last_frame : 0)) {
      const long double pulse_frames = static_cast<long double>(length_ns) * 1e-9L * speed_ * fps_.numerator;
      if (repeat_ == Repeat::none || pulse_frames > last_frame / 4) mode_ = 0;
    }
    const long double tick_s = static_cast<long double>(length_ns) * 1e-9L;
    const long double frames_per_s = static_cast<long double>(fps_.frames_per_second()) * speed_;
    Motion motion{place_, mode_ * frames_per_s, 0, 0};
    if (is_bent_ && mode_ != 0) {
      // To twice the rate, or to half of it, within bounds that keep it from turning.
      motion.change = mode_ * frames_per_s / tick_s * (share() - 0.5) * 0.5;
      motion.jerk = mode_ * frames_per_s / tick_s / tick_s * (share() - 0.5) * 0.5;
    }
    const long double start_ns = static_cast<long double>(now_ns_);
    long double to = motion.at(tick_s);
    const bool forward = mode_ > 0;
    const long double end = forward ? last_frame : 0;
    const bool passes = mode_ != 0 && (forward ? to >= end : to <= end);
    Repeat repeated = Repeat::none;
    Motion after = motion.after(tick_s);
    const auto as_it_is = [](long double place) { return place; };
    if (mode_ == 0) {
      to = place_;
      after = {};
    } else if (!passes) {
      go(place_, to, motion, tick_s, start_ns, as_it_is, forward);
    } else if (repeat_ == Repeat::none || std::fabs(to - end) > last_frame / 2) {
      motion.change = motion.jerk = 0;
      if (forward ? motion.at(tick_s) < end : motion.at(tick_s) > end) motion.rate = (end - place_) / tick_s;
      to = end;
      go(place_, to, motion, tick_s, start_ns, as_it_is, forward);
      after = {};
      mode_ = 0;
    } else {
      repeated = repeat_;
      const long double beyond = to - end;
      go(place_, end, motion, tick_s, start_ns, as_it_is, forward);
      if (repeated == Repeat::loop) {
        const long double other = forward ? 0 : last_frame;
        to = other + beyond;
        oracle_.arm_all();
        if (forward) {
          go(
              other, to, motion, tick_s, start_ns, [&](long double p) { return end + p; }, true);
        }
      } else {
        to = end - beyond;
        go(
            end, to, motion, tick_s, start_ns, [&](long double p) { return end - (p - end); }, !forward);
        after.rate = -after.rate;
        after.change = -after.change;
        mode_ = -mode_;
      }
    }
    const long double fps = static_cast<long double>(fps_.frames_per_second());
    const CueTick tick{.from = {frame_time(place_), static_cast<double>(motion.rate / fps),
                                static_cast<double>(motion.change / fps)},
                       .to = {frame_time(to), static_cast<double>(after.rate / fps),
                              static_cast<double>(after.change / fps)},
                       .repeated = repeated,
                       .start_ns = now_ns_,
                       .end_ns = now_ns_ + length_ns};
    keep(timer_[0].advance(tick, {begun_room_, instants_}), tick.start_ns, tick.end_ns);
    now_ns_ += length_ns;
    // Both go on from the place that the timer was told.
    place_ = static_cast<long double>(tick.to.time.frame) + static_cast<long double>(tick.to.time.fraction);
  }
  template <class Unfold>
  void go(long double from, long double to, const Motion& motion, long double tick_s, long double start_ns,
          Unfold unfold, bool forward) {
    // The place is told to the timer as a double.
    const FrameTime told = frame_time(to);
    oracle_.go(from, static_cast<long double>(told.frame) + static_cast<long double>(told.fraction), motion,
               tick_s, start_ns, unfold, forward);
  }

  void keep(const Result<CueCount>& count, std::int64_t start_ns = 0, std::int64_t end_ns = INT64_MAX) {
    RC_ASSERT(count);
    std::int64_t before_ns = start_ns - 1;
    for (std::size_t i = 0; i < count->instants; ++i) {
      RC_ASSERT(instants_[i].at_ns > before_ns);
      RC_ASSERT(instants_[i].at_ns < end_ns);
      RC_ASSERT(instants_[i].mask != 0U);
      RC_ASSERT((instants_[i].levels & ~instants_[i].mask) == 0U);
      before_ns = instants_[i].at_ns;
      lines_.take(instants_[i]);
    }
    for (std::size_t i = 0; i < count->begun; ++i) begun_.push_back(begun_room_[i]);
  }

  FrameRate fps_{24, 1};
  std::vector<TimedPulse> pulses_;
  Oracle oracle_;
  std::vector<CueTimer> timer_;
  std::vector<BegunPulse> begun_room_ = std::vector<BegunPulse>(room);
  std::vector<EdgeInstant> instants_ = std::vector<EdgeInstant>(instants_for(room));
  std::int64_t tick_ns_ = 0;
  std::int64_t now_ns_ = 0;
  long double place_ = 0;
  int mode_ = 1;
  long double speed_ = 1;
  bool is_bent_ = false;
  Repeat repeat_ = Repeat::none;
  std::vector<BegunPulse> begun_;
  Lines lines_;
};

TEST(CueTimerProperty, PulsesBeginWhereTheOracleSaysToAMicrosecondAndLastTheirWidth) {
  check_property(many_plays, [] {
    Play play;
    for (int i = 0; i < ticks_of_play; ++i) play.tick();
    play.finish();
    play.compare();
  });
}

}  // namespace cue_timer_property_test
}  // namespace inbetween
