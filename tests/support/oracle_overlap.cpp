#include "tests/support/oracle_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace inbetween::oracle {
namespace {

/// The integral of triangle(x) * ramp(u - x) over x, where the triangle is `width` wide and the ramp is 0
/// below 0. Simpson's rule is exact between the places where one of them bends.
long double smoothed_ramp(long double u, long double width) {
  if (!(width > 0)) return std::max(u, 0.0L);
  const long double half = width / 2;
  const auto product = [&](long double x) {
    return (half - std::fabs(x)) / (half * half) * std::max(u - x, 0.0L);
  };
  std::vector<long double> bends = {-half, 0, std::clamp(u, -half, half), half};
  std::ranges::sort(bends);
  long double sum = 0;
  for (std::size_t i = 0; i + 1 < bends.size(); ++i) {
    const long double from = bends[i];
    const long double to = bends[i + 1];
    sum += (to - from) / 6 * (product(from) + 4 * product((from + to) / 2) + product(to));
  }
  return sum;
}

}  // namespace

long double overlapped_position(const OverlappingKeys& keys, long double frame) {
  const std::size_t last = keys.at.size() - 1;
  const auto later = [&](std::size_t k) {  // where the action before it ends and the one behind it begins
    if (k == 0 && keys.rests_at_start) return keys.frames[0] + keys.overlaps[0] / 2;
    if (k == last && keys.rests_at_end) return keys.frames[last] - keys.overlaps[last] / 2;
    return keys.frames[k];
  };
  const auto velocity = [&](std::size_t k) {
    return (keys.at[k + 1] - keys.at[k]) / (later(k + 1) - later(k));
  };
  long double before = velocity(0);  // straight on
  if (keys.is_ring) before = velocity(last - 1);
  if (keys.rests_at_start) before = 0;
  long double position = keys.at[0] + before * (frame - later(0));
  for (std::size_t k = 0; k <= last; ++k) {
    long double behind = k < last ? velocity(k) : before;
    if (k == last && keys.is_ring) behind = velocity(0);
    if (k == last && keys.rests_at_end) behind = 0;
    position += (behind - before) * smoothed_ramp(frame - later(k), keys.overlaps[k]);
    before = behind;
  }
  return position;
}

}  // namespace inbetween::oracle
