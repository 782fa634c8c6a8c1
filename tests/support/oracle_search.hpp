// The search of many functions of one variable at once for their largest values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "tests/support/oracle_limits.hpp"

namespace inbetween::oracle {

inline constexpr long double infinity = std::numeric_limits<long double>::infinity();

inline std::vector<long double> evenly(long double from, long double to, int parts) {
  std::vector<long double> places;
  places.reserve(static_cast<std::size_t>(parts) + 1);
  for (int i = 0; i < parts; ++i)
    places.push_back(from + (to - from) * static_cast<long double>(i) / static_cast<long double>(parts));
  places.push_back(to);
  return places;
}

/// One evaluation of all functions: the variable, the values, and the place that is reported.
struct Sample {
  long double x = 0;
  std::vector<long double> values;
  long double place = 0;
};

/// Where a function may have a maximum larger than any sample.
struct SearchBracket {
  std::size_t function = 0;
  long double from = 0, to = 0;
  long double potential = 0;
};

/// `evaluate` fills in the values and the place of a Sample whose x is set, or returns false where it cannot.
template <typename Evaluate>
class Search {
 public:
  Search(const Evaluate& evaluate, std::vector<Extreme>& best) : evaluate_(evaluate), best_(best) {
    for (Sample* sample : {&before_, &middle_, &after_}) sample->values.resize(best.size());
  }

  /// The given places, which ascend, and with Between::climbed all maxima between them.
  void run(const std::vector<long double>& places, Between between) {
    for (const long double x : places) feed(x);
    finish_row();
    if (between == Between::skipped) return;
    std::sort(brackets_.begin(), brackets_.end(),
              [](const SearchBracket& a, const SearchBracket& b) { return a.potential > b.potential; });
    for (const SearchBracket& bracket : brackets_)
      if (bracket.potential > best_[bracket.function].value) refine(bracket);
  }

 private:
  bool sample(long double x, Sample& at) {
    at.x = x;
    if (!evaluate_(at)) return false;
    for (std::size_t i = 0; i < best_.size(); ++i)
      if (at.values[i] > best_[i].value) best_[i] = {at.values[i], at.place};
    return true;
  }

  void feed(long double x) {
    if (!sample(x, after_)) {
      finish_row();
      return;
    }
    for (std::size_t i = 0; i < best_.size(); ++i) {
      const long double top = middle_.values[i];
      if (row_ == 1 && top >= after_.values[i]) remember(i, middle_, top, after_);
      if (row_ >= 2 && top >= before_.values[i] && top >= after_.values[i]) remember(i, before_, top, after_);
    }
    std::swap(before_, middle_);
    std::swap(middle_, after_);
    ++row_;
  }

  void finish_row() {
    if (row_ >= 2)
      for (std::size_t i = 0; i < best_.size(); ++i)
        if (middle_.values[i] >= before_.values[i]) remember(i, before_, middle_.values[i], middle_);
    row_ = 0;
  }

  /// A parabola through a maximum and its neighbours rises above it by at most an eighth of `rise`; four
  /// times as much as all of it is for what is no parabola.
  void remember(std::size_t i, const Sample& left, long double top, const Sample& right) {
    const long double rise = top - std::min(left.values[i], right.values[i]);
    const long double potential = top + 4 * rise;
    if (rise > 1e-12L * std::fabs(top) && potential > best_[i].value)
      brackets_.push_back({i, left.x, right.x, potential});
  }

  /// A bracket may hold several crests: it is divided once more before each of them is climbed.
  void refine(const SearchBracket& bracket) {
    constexpr int parts = 24;
    std::array<long double, parts + 1> value{};
    const auto x = [&](int k) {
      return bracket.from + (bracket.to - bracket.from) * static_cast<long double>(k) / parts;
    };
    for (int k = 0; k <= parts; ++k)
      value[static_cast<std::size_t>(k)] = sample(x(k), after_) ? after_.values[bracket.function] : -infinity;
    for (int k = 0; k <= parts; ++k) {
      const int left = std::max(k - 1, 0);
      const int right = std::min(k + 1, parts);
      const long double top = value[static_cast<std::size_t>(k)];
      const long double beside =
          std::min(value[static_cast<std::size_t>(left)], value[static_cast<std::size_t>(right)]);
      const bool crest = top >= value[static_cast<std::size_t>(left)] &&
                         top >= value[static_cast<std::size_t>(right)] && top > beside;
      if (crest && top + 4 * (top - beside) > best_[bracket.function].value)
        climb(bracket.function, x(left), x(right));
    }
  }

  /// Golden section search; thirty steps shrink the bracket to 5e-7 of itself, which for the value of a
  /// parabola is 3e-13 of its rise.
  void climb(std::size_t function, long double low, long double high) {
    const long double ratio = (std::sqrt(5.0L) - 1) / 2;
    const auto value_at = [&](long double x) {
      return sample(x, after_) ? after_.values[function] : -infinity;
    };
    long double left = high - ratio * (high - low);
    long double right = low + ratio * (high - low);
    long double value_left = value_at(left);
    long double value_right = value_at(right);
    for (int step = 0; step < 30; ++step) {
      if (value_left > value_right) {
        high = std::exchange(right, left);
        value_right = value_left;
        left = high - ratio * (high - low);
        value_left = value_at(left);
      } else {
        low = std::exchange(left, right);
        value_left = value_right;
        right = low + ratio * (high - low);
        value_right = value_at(right);
      }
    }
  }

  const Evaluate& evaluate_;
  std::vector<Extreme>& best_;
  Sample before_, middle_, after_;
  int row_ = 0;  ///< samples since the last that could not be evaluated
  std::vector<SearchBracket> brackets_;
};

}  // namespace inbetween::oracle
