#include "tests/support/oracle_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace inbetween {
namespace {

using Function = std::function<long double(long double)>;

/// Where `sign` * x is largest between two places.
long double extremum(const Function& x, long double low, long double high, long double sign) {
  constexpr long double golden = 0.618033988749894848204586834366L;
  long double a = high - golden * (high - low);
  long double b = low + golden * (high - low);
  long double at_a = sign * x(a);
  long double at_b = sign * x(b);
  for (int i = 0; i < 45; ++i) {
    if (at_a < at_b) {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = sign * x(b);
    } else {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = sign * x(a);
    }
  }
  return (low + high) / 2;
}

long double bisected(const Function& x, long double level, bool up, long double low, long double high) {
  for (int i = 0; i < 48; ++i) {
    const long double middle = (low + high) / 2;
    const bool is_past = up ? x(middle) >= level : x(middle) < level;
    (is_past ? high : low) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

std::vector<OracleCrossing> oracle_crossings(const Function& x, long double begin, long double end,
                                             int cells) {
  const long double width = (end - begin) / cells;
  std::vector<long double> places;
  std::vector<long double> values;
  for (int i = 0; i <= cells; ++i) {
    places.push_back(i == cells ? end : begin + width * i);
    values.push_back(x(places.back()));
  }
  if (std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end()) return {};
  std::vector<long double> looked_at = places;
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    const long double before = values[i] - values[i - 1];
    const long double behind = values[i + 1] - values[i];
    if (before > 0 && behind <= 0) looked_at.push_back(extremum(x, places[i - 1], places[i + 1], 1));
    if (before < 0 && behind >= 0) looked_at.push_back(extremum(x, places[i - 1], places[i + 1], -1));
  }
  // An extremum so near an end that the neighbour inside does not show it.
  looked_at.push_back(extremum(x, places[0], places[1], values[1] > values[0] ? -1 : 1));
  const std::size_t last = places.size() - 1;
  looked_at.push_back(extremum(x, places[last - 1], places[last], values[last] > values[last - 1] ? 1 : -1));
  std::sort(looked_at.begin(), looked_at.end());

  std::vector<OracleCrossing> crossings;
  for (std::size_t i = 1; i < looked_at.size(); ++i) {
    const long double low = looked_at[i - 1];
    const long double high = looked_at[i];
    long double count = std::floor(x(low) + 0.5L);
    const long double last_count = std::floor(x(high) + 0.5L);
    while (count != last_count) {
      const bool up = last_count > count;
      const long double at = bisected(x, up ? count + 0.5L : count - 0.5L, up, low, high);
      const long double nearby = width * 1e-6L;
      crossings.push_back({at, std::fabs(x(at + nearby) - x(at - nearby)) / (2 * nearby), up});
      count += up ? 1 : -1;
    }
  }
  return crossings;
}

long double oracle_quintic(const OracleMotion& start, const OracleMotion& end, long double u) {
  const long double w = 1 - u;
  // x^3 (10 - 15 x + 6 x^2) and its companions, written for either end by symmetry.
  const auto position = [](long double x) { return x * x * x * (10 + x * (-15 + 6 * x)); };
  const auto velocity = [](long double x, long double rest) { return rest * x * x * x * (1 + 3 * rest); };
  const auto acceleration = [](long double x, long double rest) { return x * x * x * rest * rest / 2; };
  return start.position * position(w) + end.position * position(u) + start.velocity * velocity(w, u) -
         end.velocity * velocity(u, w) + start.acceleration * acceleration(w, u) +
         end.acceleration * acceleration(u, w);
}

}  // namespace inbetween
