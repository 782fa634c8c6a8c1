#include "host_tools/loop/loop_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

/// People see ten lines a second; the loop offers twice as many.
constexpr std::int64_t ns_between_lines = ns_per_s / 10;
constexpr std::int64_t snapshots_per_s = 20;
constexpr std::int64_t ns_between_looks = 5'000'000;
/// A machine without real-time rights may be late by many ticks; a program that was suspended, by a second.
constexpr std::int64_t stall_ns = ns_per_s;

/// Nothing is begun with a rig file that has changed.
TransportKey allowed(TransportKey key, const LoopAudience& audience) {
  const bool begins = key == TransportKey::acknowledge || key == TransportKey::start;
  return begins && audience.rig_has_changed && audience.rig_has_changed() ? TransportKey::refused : key;
}

}  // namespace

void LoopTrace::take(const RunLoop& loop, const LoopTask* act) {
  const bool commands = loop.sends_setpoints();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    AxisTrace& axis = axes_[i];
    axis.actual = loop.drive_states()[i].actual;
    axis.is_known = axis.is_known || loop.drive_states()[i].is_on;
    axis.is_commanded = axis.is_commanded || (commands && commanded_);
    // At the beginning of a tick a drive answers the setpoint before.
    axis.following_error = commands && commanded_ ? axis.commanded - axis.actual : 0;
    axis.following_error_peak = std::max(axis.following_error_peak, std::fabs(axis.following_error));
    if (commands) axis.commanded = loop.setpoints()[i].position;
  }
  commanded_ = commands;
  for (TickSink* sink : sinks_) {
    if (sink != nullptr) sink->take(loop, act);
  }
}

void LoopTrace::press(LoopTask& act, TransportKey key) {
  for (TickSink* sink : sinks_) {
    if (sink != nullptr) sink->press(key);
  }
  act.press(key);
}

RunSnapshot LoopTrace::shown(const LoopTask& act) const {
  RunSnapshot snapshot = act.snapshot();
  snapshot.axis_count = std::min(axes_.size(), snapshot.axes.size());
  std::copy_n(axes_.begin(), snapshot.axis_count, snapshot.axes.begin());
  for (std::size_t i = 0; commanded_ && i < snapshot.axis_count; ++i) {
    AxisPlace& axis = snapshot.axes[i];
    axis.commanded = axis.actual + axis.following_error;
  }
  return snapshot;
}

// --- as fast as it can be computed

ActEnd FastRunner::run(LoopTask& act, std::optional<std::int64_t> last) {
  ActEnd end;
  if (audience_.progress && last) audience_.progress(0, *last);
  end.begun = act.begin();
  if (!end.begun) return end;
  if (keys_.tells_releases()) trace_.press(act, TransportKey::tells_releases);
  while (!act.is_over()) {
    if (audience_.keys && !act.is_preparation()) keys_.feed(audience_.keys());
    while (const std::optional<TransportKey> key = keys_.next()) {
      trace_.press(act, allowed(*key, audience_));
    }
    if (audience_.device && !act.is_preparation()) {
      for (const TransportKey key : audience_.device()) trace_.press(act, key);
    }
    if (audience_.interrupted && audience_.interrupted()) trace_.press(act, TransportKey::quit);
    act.tick(1, time_of_tick(++tick_, rate_hz_));
    trace_.take(loop_, &act);
    ++end.ticks;
    if (end.ticks % 64 != 0 || wall_.now_ns() < next_show_ns_) continue;
    if (audience_.progress && last) audience_.progress(std::min(end.ticks, *last), *last);
    if (audience_.status) audience_.status(trace_.shown(act));
    next_show_ns_ = wall_.now_ns() + ns_between_lines;
  }
  return end;
}

// --- in real time

TimedRunner::TimedRunner(RunLoop& loop, std::int32_t rate_hz, const LoopAudience& audience, LoopTrace& trace,
                         Lateness lateness, const std::optional<RealTimeRequest>& request)
    : loop_(loop), rate_hz_(rate_hz), audience_(audience), trace_(trace), lateness_(lateness) {
  thread_ = std::thread([this, request] { live(request); });
  has_rights_.wait(false);
}

TimedRunner::~TimedRunner() {
  leaves_.store(true);
  thread_.join();
}

void TimedRunner::live(const std::optional<RealTimeRequest>& request) {
  std::optional<RealTimeThread> rights;
  if (request) {
    rights.emplace(*request);
    rights_ = rights->rights();
  }
  has_rights_.store(true);
  has_rights_.notify_one();
  loop();
}

void TimedRunner::loop() {
  const MonotonicClock clock;
  const std::int64_t period_ns = ns_per_s / rate_hz_;
  std::int64_t start_ns = clock.now_ns();
  for (std::int64_t number = 1; !leaves_.load(std::memory_order_relaxed); ++number) {
    clock.sleep_until_ns(start_ns + time_of_tick(number, rate_hz_));
    const std::int64_t now_ns = clock.now_ns();
    const std::int64_t latency_ns = now_ns - (start_ns + time_of_tick(number, rate_hz_));
    std::int32_t ticks = 1;
    if (latency_ns >= period_ns) {
      if (act_ != nullptr) ++late_ticks_;
      if (lateness_ == Lateness::catches_up || latency_ns >= stall_ns) {
        ticks += static_cast<std::int32_t>(std::min<std::int64_t>(latency_ns / period_ns, rate_hz_));
        number += latency_ns / period_ns;
      } else {
        start_ns += latency_ns;
      }
    }
    if (act_ != nullptr) latencies_.add(latency_ns, now_ns);
    // Time that stands still stands still for the simulated drives as well.
    tick(ticks, lateness_ == Lateness::time_stands_still ? time_of_tick(number, rate_hz_) : now_ns);
  }
}

void TimedRunner::tick(std::int32_t ticks, std::int64_t now_ns) {
  if (act_ == nullptr) {
    act_ = next_.exchange(nullptr, std::memory_order_acquire);
    if (act_ != nullptr) {
      end_ = {};
      end_.begun = act_->begin();
      if (!end_.begun) act_ = nullptr;
      if (act_ == nullptr) is_over_.store(true, std::memory_order_release);
    }
  }
  if (act_ == nullptr) {
    loop_.tick(ticks, now_ns);
    trace_.take(loop_);
    return;
  }
  while (const std::optional<TransportKey> key = typed_.pop()) trace_.press(*act_, *key);
  act_->tick(ticks, now_ns);
  trace_.take(loop_, act_);
  ++end_.ticks;
  if (--until_shown_ <= 0) {
    shown_.push(trace_.shown(*act_));
    until_shown_ = rate_hz_ / snapshots_per_s;
  }
  if (!act_->is_over()) return;
  act_ = nullptr;
  is_over_.store(true, std::memory_order_release);
}

void TimedRunner::attend(std::optional<std::int64_t> last) {
  if (audience_.keys) keys_.feed(audience_.keys());
  while (const std::optional<TransportKey> key = keys_.next()) typed_.push(allowed(*key, audience_));
  if (audience_.device)
    std::ranges::for_each(audience_.device(), [&](TransportKey key) { typed_.push(key); });
  if (audience_.interrupted && audience_.interrupted()) typed_.push(TransportKey::quit);
  std::optional<RunSnapshot> newest;
  while (const std::optional<RunSnapshot> one = shown_.pop()) newest = one;
  const std::int64_t now_ns = MonotonicClock().now_ns();
  if (!newest || now_ns < next_line_ns_) return;
  if (audience_.status) audience_.status(*newest);
  if (audience_.progress && last) {
    audience_.progress(static_cast<std::int64_t>(newest->share * static_cast<double>(*last)), *last);
  }
  next_line_ns_ = now_ns + ns_between_lines;
}

ActEnd TimedRunner::run(LoopTask& act, std::optional<std::int64_t> last) {
  if (audience_.progress && last) audience_.progress(0, *last);
  const MonotonicClock clock;
  next_line_ns_ = 0;
  if (keys_.tells_releases()) typed_.push(TransportKey::tells_releases);
  is_over_.store(false, std::memory_order_relaxed);
  next_.store(&act, std::memory_order_release);
  std::exception_ptr thrown;
  while (!is_over_.load(std::memory_order_acquire)) {
    if (thrown) {
      typed_.push(TransportKey::quit);
    } else {
      try {
        attend(last);
      } catch (...) {
        thrown = std::current_exception();
      }
    }
    clock.sleep_until_ns(clock.now_ns() + ns_between_looks);
  }
  if (thrown) std::rethrow_exception(thrown);
  return end_;
}

void refuse_unfit_machine(const std::string& rig_path, const std::vector<RealTimeRight>& rights) {
  for (const RealTimeRight& right : rights) {
    if (!right.refusal || !right.is_needed) continue;
    throw InputError({rig_path, 0, 0}, fmt::format("{}; {}, or move slowly with --allow-jitter",
                                                   right.refusal->what, right.refusal->remedy));
  }
}

}  // namespace inbetween
