#include "sim/simulated_switch.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

constexpr double second_ns = 1e9;

/// Crossings are found between so many equal parts of a tick: an axis that goes to and fro within one of
/// them has not been there.
constexpr int parts = 16;

std::int64_t nanoseconds(double seconds) {
  return std::llround(seconds * second_ns);
}

/// Interpolates by Hermite's cubic at `share` of the time between both.
double position_between(const Setpoint& from, const Setpoint& to, double seconds, double share) {
  const double distance = to.position - from.position;
  const double left = 1 - share;
  return from.position + share * share * (3 - 2 * share) * distance +
         share * left * seconds * (left * from.velocity - share * to.velocity);
}

}  // namespace

SimulatedSwitch::SimulatedSwitch(const Settings& settings, double position, std::uint32_t seed)
    : settings_(settings),
      random_(seed),
      is_on_(settings.fault != Fault::open && past(position) >= 0),
      level_(is_on_ == settings.active_level) {}

bool SimulatedSwitch::is_on_at(double position) const {
  if (settings_.fault == Fault::open) return false;
  if (settings_.fault == Fault::stuck && is_on_) return true;
  return is_on_ ? past(position) > -settings_.hysteresis : past(position) >= 0;
}

double SimulatedSwitch::past(double position) const {
  return settings_.is_above ? position - settings_.closes : settings_.closes - position;
}

double SimulatedSwitch::random(double min, double max) {
  return min + (max - min) * (static_cast<double>(random_()) / 4294967296.0);
}

void SimulatedSwitch::move(std::int64_t from_ns, const Setpoint& from, std::int64_t to_ns, const Setpoint& to,
                           std::vector<LineEvent>& events) {
  const double seconds = static_cast<double>(to_ns - from_ns) / second_ns;
  for (int part = 1; part <= parts; ++part) {
    double low = static_cast<double>(part - 1) / parts;
    double high = static_cast<double>(part) / parts;
    if (is_on_at(position_between(from, to, seconds, high)) == is_on_) continue;
    for (int i = 0; i < 50; ++i) {
      const double middle = (low + high) / 2;
      (is_on_at(position_between(from, to, seconds, middle)) == is_on_ ? low : high) = middle;
    }
    is_on_ = !is_on_;
    add_change(from_ns + std::llround(high * static_cast<double>(to_ns - from_ns)));
  }
  if (settings_.noise_hz > 0) {
    if (next_noise_ns_ < 0) next_noise_ns_ = from_ns + nanoseconds(random(0, 2 / settings_.noise_hz));
    for (; next_noise_ns_ < to_ns; next_noise_ns_ += nanoseconds(random(0, 2 / settings_.noise_hz)) + 1) {
      add_pulse(next_noise_ns_, nanoseconds(random(1e-6, settings_.longest_noise_s)));
    }
  }
  if (settings_.fault == Fault::chatter && is_on_) {
    for (next_chatter_ns_ = std::max(next_chatter_ns_, from_ns); next_chatter_ns_ < to_ns;
         next_chatter_ns_ += nanoseconds(random(2e-4, 1.5e-3))) {
      add_pulse(next_chatter_ns_, nanoseconds(random(1e-4, 1e-3)));
    }
  }
  std::ranges::sort(toggles_ns_);
  std::size_t done = 0;
  for (; done < toggles_ns_.size() && toggles_ns_[done] < to_ns; ++done) {
    level_ = !level_;
    events.push_back({.at_ns = toggles_ns_[done], .line = settings_.line, .level = level_});
  }
  toggles_ns_.erase(toggles_ns_.begin(), toggles_ns_.begin() + static_cast<std::ptrdiff_t>(done));
}

/// The change itself, and an even number of toggles after it.
void SimulatedSwitch::add_change(std::int64_t at_ns) {
  toggles_ns_.push_back(at_ns);
  if (settings_.max_bounces == 0) return;
  for (auto i = random_() % (settings_.max_bounces + 1); i > 0; --i) {
    for (int edge = 0; edge < 2; ++edge)
      toggles_ns_.push_back(at_ns + 1 + nanoseconds(random(0, settings_.bounce_s)));
  }
}

void SimulatedSwitch::add_pulse(std::int64_t at_ns, std::int64_t length_ns) {
  toggles_ns_.push_back(at_ns);
  toggles_ns_.push_back(at_ns + length_ns);
}

}  // namespace inbetween
