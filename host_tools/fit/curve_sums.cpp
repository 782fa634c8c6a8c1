#include "host_tools/fit/curve_sums.hpp"

#include <algorithm>
#include <limits>

#include "inbetween/timing/integral_row.hpp"

namespace inbetween {
namespace {

/// So many uniform cubic B-splines are above 0 on a span.
constexpr std::size_t splines_on_span = 4;

/// The four B-splines of a span at t, each weighted: with its area from -infinity, its value and its first
/// two derivatives.
std::array<double, splines_on_span> splines_at(double t, const CurveWeights& weights) {
  const double r = 1 - t;
  const std::array<double, 4> value{r * r * r / 6, (4 + 3 * t * t * (t - 2)) / 6,
                                    (4 + 3 * r * r * (r - 2)) / 6, t * t * t / 6};
  const std::array<double, 4> first{-r * r / 2, t * (3 * t - 4) / 2, -r * (3 * r - 4) / 2, t * t / 2};
  const std::array<double, 4> second{r, 3 * t - 2, 3 * r - 2, t};
  std::array<double, splines_on_span> sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const double area = bspline_integral(t + 1 - static_cast<double>(i));
    sum[i] = weights.area * area + weights.value * value[i] + weights.first * first[i] +
             weights.second * second[i];
  }
  return sum;
}

/// Adds a term, or its weight where the unknown stands there already.
void add_term(std::size_t unknown, double weight, std::vector<Term>& terms) {
  const auto same = std::ranges::find(terms, unknown, &Term::unknown);
  if (same != terms.end()) {
    same->weight += weight;
  } else {
    terms.push_back({unknown, weight});
  }
}

}  // namespace

CurveSums::CurveSums(const std::vector<bool>& rests, CurveEnds ends)
    : f_(rests.size() - 1), ends_(ends), place_of_sum_(f_ + 4) {
  const bool is_periodic = ends == CurveEnds::periodic;
  // Whether value i - 1 stays 0.
  std::vector<bool> is_zero{is_periodic ? rests[f_ - 1] : rests[0] && rests[1]};
  is_zero.insert(is_zero.end(), rests.begin(), rests.end());
  is_zero.push_back(is_periodic ? rests[1] : rests[f_] && rests[f_ - 1]);
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> first_with_sum{0};
  for (std::size_t i = 0; i < is_zero.size(); ++i) {
    first_with_sum.push_back(is_zero[i] ? first_with_sum.back() : i + 1);
  }
  // A periodic curve is folded, so that its two ends lie side by side.
  std::vector<std::size_t> unknown_of(place_of_sum_.size(), none);
  for (std::size_t k = 0; k < place_of_sum_.size(); ++k) {
    const std::size_t i = !is_periodic ? k : k % 2 == 0 ? k / 2 : place_of_sum_.size() - 1 - k / 2;
    std::size_t& unknown = unknown_of[first_with_sum[i]];
    if (unknown == none) unknown = count_++;
    place_of_sum_[i] = unknown;
  }
}

CurveSums::Terms CurveSums::unrolled_value(std::size_t i) const {
  const std::size_t here = place_of_sum_[i + 1];
  const std::size_t before = place_of_sum_[i];
  if (here == before) return {};
  return {{here, 1}, {before, -1}};
}

CurveSums::Terms CurveSums::value(std::size_t i) const {
  return unrolled_value(i + 1);
}

CurveSums::Terms CurveSums::at(const CurvePlace& place, const CurveWeights& weights) const {
  const auto span = static_cast<std::size_t>(place.span);
  const auto splines = splines_at(place.t, weights);
  Terms terms;
  add_term(place_of_sum_[span], weights.area, terms);
  for (std::size_t i = 0; i < splines_on_span; ++i) {
    for (const Term& term : unrolled_value(span + i)) add_term(term.unknown, splines[i] * term.weight, terms);
  }
  std::erase_if(terms, [](const Term& term) { return term.weight == 0; });
  return terms;
}

std::vector<double> CurveSums::unrolled(std::span<const double> values) const {
  const bool is_periodic = ends_ == CurveEnds::periodic;
  std::vector<double> all{is_periodic ? values[f_ - 1] : 2 * values[0] - values[1]};
  all.insert(all.end(), values.begin(), values.end());
  all.push_back(is_periodic ? values[1] : 2 * values[f_] - values[f_ - 1]);
  return all;
}

std::vector<double> CurveSums::unknowns(std::span<const double> values) const {
  std::vector<double> result(count_);
  const std::vector<double> all = unrolled(values);
  double sum = 0;
  const auto at_start = splines_at(0, {.area = 1});
  for (std::size_t i = 0; i < splines_on_span; ++i) sum -= at_start[i] * all[i];
  result[place_of_sum_[0]] = sum;
  for (std::size_t i = 0; i < all.size(); ++i) {
    sum += all[i];
    result[place_of_sum_[i + 1]] = sum;
  }
  return result;
}

void CurveSums::demand_ends(BandProgram& program) const {
  const auto demand = [&](std::span<const std::pair<std::size_t, double>> values) {
    Terms terms;
    for (const auto& [i, weight] : values) {
      for (const Term& term : unrolled_value(i)) add_term(term.unknown, weight * term.weight, terms);
    }
    std::erase_if(terms, [](const Term& term) { return term.weight == 0; });
    if (!terms.empty()) program.demand(terms, 0);
  };
  using Values = std::array<std::pair<std::size_t, double>, 3>;
  if (ends_ == CurveEnds::periodic) {
    for (std::size_t i = 0; i < 3; ++i) demand(Values{{{i, 1}, {f_ + i, -1}, {i, 0}}});
  } else {
    demand(Values{{{0, 1}, {1, -2}, {2, 1}}});
    demand(Values{{{f_, 1}, {f_ + 1, -2}, {f_ + 2, 1}}});
  }
}

void CurveSums::demand_start(BandProgram& program) const {
  program.demand(at({}, {.area = 1}), 0);
}

void CurveSums::add_distance(std::span<const double> wanted, double factor, BandProgram& program) const {
  std::array<std::array<double, splines_on_span>, splines_on_span> gram{};
  for (const auto& [place, weight] : gauss_points) {
    const auto splines = splines_at(place, {.value = 1});
    for (std::size_t i = 0; i < splines_on_span; ++i) {
      for (std::size_t k = 0; k < splines_on_span; ++k) gram[i][k] += weight * splines[i] * splines[k];
    }
  }
  const std::vector<double> all = unrolled(wanted);
  for (std::size_t span = 0; span < f_; ++span) {
    for (std::size_t i = 0; i < splines_on_span; ++i) {
      double gain = 0;
      for (std::size_t k = 0; k < splines_on_span; ++k) {
        gain += gram[i][k] * all[span + k];
        program.add_cost(unrolled_value(span + i), unrolled_value(span + k), factor * gram[i][k]);
      }
      program.add_gain(unrolled_value(span + i), factor * gain);
    }
  }
}

}  // namespace inbetween
