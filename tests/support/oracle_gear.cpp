#include "tests/support/oracle_gear.hpp"

#include <cmath>
#include <utility>

namespace inbetween::oracle {
namespace {

using SplineRow = std::vector<long double>;

/// Rows of coefficients with the right-hand side behind them.
SplineRow solved(std::vector<SplineRow> rows) {
  const std::size_t n = rows.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t best = i;
    for (std::size_t k = i + 1; k < n; ++k) {
      if (std::fabs(rows[k][i]) > std::fabs(rows[best][i])) best = k;
    }
    std::swap(rows[i], rows[best]);
    for (std::size_t k = i + 1; k < n; ++k) {
      const long double share = rows[k][i] / rows[i][i];
      for (std::size_t j = i; j <= n; ++j) rows[k][j] -= share * rows[i][j];
    }
  }
  SplineRow x(n);
  for (std::size_t i = n; i-- > 0;) {
    long double left = rows[i][n];
    for (std::size_t j = i + 1; j < n; ++j) left -= rows[i][j] * x[j];
    x[i] = left / rows[i][i];
  }
  return x;
}

}  // namespace

MarkCurve::MarkCurve(std::vector<long double> x, const std::vector<long double>& y) : x_(std::move(x)) {
  const std::size_t stretches = x_.size() - 1;
  const std::size_t n = 4 * stretches;
  std::vector<SplineRow> rows;
  const auto add = [&](std::size_t stretch, const std::array<long double, 4>& here,
                       long double right) -> SplineRow& {
    SplineRow& row = rows.emplace_back(n + 1, 0.0L);
    for (std::size_t j = 0; j < 4; ++j) row[4 * stretch + j] = here[j];
    row[n] = right;
    return row;
  };
  for (std::size_t i = 0; i < stretches; ++i) {
    const long double h = x_[i + 1] - x_[i];
    add(i, {1, 0, 0, 0}, y[i]);
    add(i, {1, h, h * h, h * h * h}, y[i + 1]);
    if (i + 1 == stretches) continue;
    SplineRow& slope = add(i, {0, 1, 2 * h, 3 * h * h}, 0);
    slope[4 * (i + 1) + 1] = -1;
    SplineRow& bend = add(i, {0, 0, 2, 6 * h}, 0);
    bend[4 * (i + 1) + 2] = -2;
  }
  const long double last = x_[stretches] - x_[stretches - 1];
  add(0, {0, 0, 2, 0}, 0);
  add(stretches - 1, {0, 0, 2, 6 * last}, 0);
  const SplineRow c = solved(std::move(rows));
  for (std::size_t i = 0; i < stretches; ++i)
    cubics_.push_back({c[4 * i], c[4 * i + 1], c[4 * i + 2], c[4 * i + 3]});
}

std::array<long double, 4> MarkCurve::at(long double x) const {
  std::size_t i = 0;
  while (i + 1 < cubics_.size() && x >= x_[i + 1]) ++i;
  const long double inside = std::clamp(x, x_.front(), x_.back());
  const long double t = inside - x_[i];
  const auto& [a, b, c, d] = cubics_[i];
  const long double slope = b + t * (2 * c + t * 3 * d);
  const long double value = a + t * (b + t * (c + t * d));
  if (inside != x) return {value + slope * (x - inside), slope, 0, 0};
  return {value, slope, 2 * c + 6 * t * d, 6 * d};
}

}  // namespace inbetween::oracle
