#include "host_tools/fit/curve_samples.hpp"

#include <algorithm>
#include <cmath>

#include "host_tools/fit/normal_equations.hpp"
#include "host_tools/fit/quadratic_program.hpp"

namespace inbetween {
namespace {

/// What differences of neighbouring control values cost, as a share of a sample's own weight. Only curves
/// with more control values than the samples can tell apart feel it.
constexpr double smoothing = 1e-9;

}  // namespace

CurveSamples::CurveSamples(std::span<const double> moments, std::size_t spans) : spans_(spans) {
  const std::size_t n = spans + 2;
  rows_.resize(moments.size() * n);
  gram_.resize(n * n);
  // In equal units: one control value of 1 moves the end by about 1.
  const double unit = 1 / static_cast<double>(spans);
  for (std::size_t m = 0; m < moments.size(); ++m) {
    const std::span<double> row(&rows_[m * n], n);
    places_.push_back(place_at(moments[m] * static_cast<double>(spans), spans));
    row[0] = 1;
    add_row(places_.back(), {.area = unit}, row.subspan(1));
    for (std::size_t i = 0; i < n; ++i) {
      if (row[i] == 0) continue;
      for (std::size_t j = 0; j < n; ++j) gram_[i * n + j] += row[i] * row[j];
    }
  }
  const double cost = smoothing * static_cast<double>(moments.size());
  for (std::size_t i = 1; i < n; ++i) gram_[i * n + i] += cost * unit;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    gram_[i * n + i] += cost;
    gram_[(i + 1) * n + i + 1] += cost;
    gram_[i * n + i + 1] -= cost;
    gram_[(i + 1) * n + i] -= cost;
  }
}

std::vector<double> CurveSamples::products(std::span<const double> samples) const {
  const std::size_t n = spans_ + 2;
  std::vector<double> products(n);
  for (std::size_t m = 0; m < samples.size(); ++m) {
    for (std::size_t i = 0; i < n; ++i) products[i] += rows_[m * n + i] * samples[m];
  }
  return products;
}

CurveSamples::Free CurveSamples::fit(std::span<const double> samples) const {
  std::vector<double> x = solved(gram_, products(samples));
  Free found{.offset = x[0], .values = {x.begin() + 1, x.end()}};
  for (double& value : found.values) value /= static_cast<double>(spans_);
  return found;
}

std::optional<std::vector<double>> CurveSamples::fit(std::span<const double> samples,
                                                     const CurveBounds& bounds) const {
  const std::size_t n = spans_ + 1;
  std::vector<double> gram;
  for (std::size_t i = 1; i <= n; ++i)
    gram.insert(gram.end(), &gram_[i * (n + 1) + 1], &gram_[i * (n + 1) + 1] + n);
  std::vector<double> right = products(samples);
  right.erase(right.begin());
  QuadraticProgram programme(gram, solved(gram, std::move(right)));
  std::vector<double> row(n);
  const double unit = 1 / static_cast<double>(spans_);
  add_row(place_at(static_cast<double>(spans_), spans_), {.area = unit}, row);
  if (!programme.add_equality(row, bounds.total)) return std::nullopt;
  const auto is_at_rest = [&](std::size_t i) {
    return (bounds.rests_at_start && i < 2) || (bounds.rests_at_end && i + 2 >= n);
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_at_rest(i)) continue;
    std::ranges::fill(row, 0.0);
    row[i] = 1;
    if (!programme.add_equality(row, 0)) return std::nullopt;
  }
  // The program forgets conditions that no longer hold x back: each turn adds the one that is broken most.
  for (std::size_t turns = 0; turns < 20 * n; ++turns) {
    std::size_t least = n;
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_at_rest(i) && (least == n || programme.x()[i] < programme.x()[least])) least = i;
    }
    if (least == n || programme.x()[least] >= -1e-9 * std::fabs(bounds.total)) break;
    std::ranges::fill(row, 0.0);
    row[least] = 1;
    if (!programme.add(row, 0)) return std::nullopt;
  }
  std::vector<double> values(programme.x().begin(), programme.x().end());
  for (std::size_t i = 0; i < n; ++i)
    values[i] = is_at_rest(i) ? 0 : std::max(values[i], 0.0) / static_cast<double>(spans_);
  return values;
}

double information(double square, std::size_t samples, std::size_t parameters) {
  const auto n = static_cast<double>(samples);
  return n * std::log(square) + static_cast<double>(parameters) * std::log(n);
}

}  // namespace inbetween
