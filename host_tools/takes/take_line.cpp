#include "host_tools/takes/take_line.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {

TakeLine::TakeLine(const TakeSamples& samples)
    : samples_(samples),
      // A little longer than two ticks: fractions of frames are rounded.
      longest_frames_(2.000001 * samples.frame_rate().frames_per_second() / samples.rate_hz()) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Place place{samples[i].turn, samples[i].time};
    if (ahead_.empty() || is_before(samples[ahead_.back()], place)) {
      ahead_.push_back(i);
    } else if (samples[ahead_.back()].turn == place.turn && samples[ahead_.back()].time == place.time) {
      ahead_.back() = i;
    }
  }
}

bool TakeLine::is_before(const TakeSample& sample, const Place& place) {
  return sample.turn != place.turn ? sample.turn < place.turn : sample.time < place.time;
}

double TakeLine::frames_from_to(std::size_t from, std::size_t to) const {
  return frames_between(samples_[ahead_[from]].time, samples_[ahead_[to]].time);
}

/// Whether there is no gap between a sample that leads on and the next of them.
bool TakeLine::is_near(std::size_t index) const {
  return index + 1 < ahead_.size() && samples_[ahead_[index]].turn == samples_[ahead_[index + 1]].turn &&
         frames_from_to(index, index + 1) <= longest_frames_;
}

/// The magnitude of the second derivative by frames at a sample between two near ones; 0 at any other.
double TakeLine::bend(std::size_t index, std::size_t axis) const {
  if (index == 0 || !is_near(index - 1) || !is_near(index)) return 0;
  const double here = samples_.actual(ahead_[index])[axis];
  const double left = frames_from_to(index - 1, index), right = frames_from_to(index, index + 1);
  const double slope_left = (here - samples_.actual(ahead_[index - 1])[axis]) / left;
  const double slope_right = (samples_.actual(ahead_[index + 1])[axis] - here) / right;
  return std::fabs(2 * (slope_right - slope_left) / (left + right));
}

/// The first of the samples that lead on that is not before a place. It is one of the next few where two
/// takes are gone through side by side: searching for each of them took most of the time of a path report.
std::size_t TakeLine::first_behind(const Place& place, std::size_t from) const {
  const auto is_sample_before = [&](std::size_t sample) { return is_before(samples_[sample], place); };
  constexpr std::size_t few = 3;
  if (from == 0 || is_sample_before(ahead_[from - 1])) {
    for (const std::size_t end = std::min(from + few, ahead_.size()); from < end; ++from) {
      if (!is_sample_before(ahead_[from])) return from;
    }
  }
  const auto found = std::partition_point(ahead_.begin(), ahead_.end(), is_sample_before);
  return static_cast<std::size_t>(found - ahead_.begin());
}

bool TakeLine::actual_at(const Place& place, std::span<double> out, std::span<double> missed,
                         std::size_t& from_sample) const {
  const std::size_t low = from_sample = first_behind(place, from_sample);
  if (low == ahead_.size()) return false;
  const TakeSample& behind = samples_[ahead_[low]];
  if (behind.turn == place.turn && behind.time == place.time) {
    std::ranges::copy(samples_.actual(ahead_[low]), out.begin());
    return true;
  }
  if (low == 0 || !is_near(low - 1)) return false;
  const double span = frames_from_to(low - 1, low);
  const double share = frames_between(samples_[ahead_[low - 1]].time, place.time) / span;
  const std::span<const double> from = samples_.actual(ahead_[low - 1]), to = samples_.actual(ahead_[low]);
  for (std::size_t axis = 0; axis < out.size(); ++axis) {
    out[axis] = from[axis] + share * (to[axis] - from[axis]);
    missed[axis] = std::max(missed[axis], span * span / 8 * std::max(bend(low - 1, axis), bend(low, axis)));
  }
  return true;
}

}  // namespace inbetween
