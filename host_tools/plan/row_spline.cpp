#include "host_tools/plan/row_spline.hpp"

#include <utility>

namespace inbetween {
namespace {

/// Row k: before[k] x[k-1] + diagonal[k] x[k] + behind[k] x[k+1] = right[k].
struct Tridiagonal {
  std::vector<double> before, diagonal, behind;

  explicit Tridiagonal(std::size_t rows) {
    for (std::vector<double>* side : {&before, &diagonal, &behind}) side->reserve(rows);
  }
  void add(double b, double d, double a) {
    before.push_back(b);
    diagonal.push_back(d);
    behind.push_back(a);
  }
  /// By elimination. The diagonal dominates.
  [[nodiscard]] std::vector<double> solve(std::vector<double> right) const {
    std::vector<double> pivots = diagonal;
    for (std::size_t k = 1; k < right.size(); ++k) {
      const double share = before[k] / pivots[k - 1];
      pivots[k] -= share * behind[k - 1];
      right[k] -= share * right[k - 1];
    }
    for (std::size_t k = right.size(); k-- > 0;) {
      if (k + 1 < right.size()) right[k] -= behind[k] * right[k + 1];
      right[k] /= pivots[k];
    }
    return right;
  }
};

std::vector<double> chords_of(const SplineRun& run) {
  std::vector<double> chords;
  chords.reserve(run.steps.size());
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    chords.push_back((run.values[k + 1] - run.values[k]) / run.steps[k]);
  }
  return chords;
}

/// A run with ends, and with the knot of each rest. Where that is, nothing says the value: beside a rest at x
/// an axis whose second derivative rises from 0 to M within a step h is at x + M h^2 / 6, and its derivative
/// at the rest is 0 for every M. So `values` has x there, and `per_moment` h^2 / 6.
struct OpenRun {
  SplineRun run;
  std::vector<double> per_moment;  ///< of each value; 0 where that is known

  explicit OpenRun(const SplineRun& of) : run(of) {
    const double first = run.steps.front();
    const double last = run.steps.back();
    if (run.first_end == SplineEnd::rest) {
      run.steps.front() -= first / 4;
      run.steps.insert(run.steps.begin(), first / 4);
      run.values.insert(run.values.begin(), run.values.front());
    }
    if (run.last_end == SplineEnd::rest) {
      run.steps.back() -= last / 4;
      run.steps.push_back(last / 4);
      run.values.push_back(run.values.back());
    }
    per_moment.assign(run.values.size(), 0);
    if (run.first_end == SplineEnd::rest) per_moment[1] = run.steps.front() * run.steps.front() / 6;
    if (run.last_end == SplineEnd::rest)
      per_moment[per_moment.size() - 2] = run.steps.back() * run.steps.back() / 6;
  }
};

/// Second derivatives at all places.
std::vector<double> open_moments(const OpenRun& open) {
  const SplineRun& run = open.run;
  const std::vector<double>& h = run.steps;
  const std::vector<double>& g = open.per_moment;
  const std::vector<double> chords = chords_of(run);
  const std::size_t last = h.size();
  Tridiagonal system(last + 1);
  std::vector<double> right;
  right.reserve(last + 1);
  if (run.first_end == SplineEnd::slope) {
    system.add(0, 2 * h.front(), h.front() - 6 * g[1] / h.front());
    right.push_back(6 * (chords.front() - run.first_slope));
  } else {
    system.add(0, 1, 0);
    right.push_back(0);
  }
  for (std::size_t k = 1; k < last; ++k) {
    system.add(h[k - 1] - 6 * g[k - 1] / h[k - 1],
               2 * (h[k - 1] + h[k]) + 6 * (g[k] / h[k - 1] + g[k] / h[k]), h[k] - 6 * g[k + 1] / h[k]);
    right.push_back(6 * (chords[k] - chords[k - 1]));
  }
  if (run.last_end == SplineEnd::slope) {
    system.add(h.back() - 6 * g[last - 1] / h.back(), 2 * h.back(), 0);
    right.push_back(6 * (run.last_slope - chords.back()));
  } else {
    system.add(0, 1, 0);
    right.push_back(0);
  }
  return system.solve(std::move(right));
}

/// The rows between the ends are solved with the moment at the seam as a parameter; its own row then gives
/// it.
std::vector<double> periodic_moments(const SplineRun& run) {
  const std::vector<double>& h = run.steps;
  const std::vector<double> chords = chords_of(run);
  const std::size_t last = h.size();
  if (last < 2) return std::vector<double>(last + 1);
  Tridiagonal system(last);
  std::vector<double> right;
  std::vector<double> of_seam;
  for (std::size_t k = 1; k < last; ++k) {
    system.add(h[k - 1], 2 * (h[k - 1] + h[k]), h[k]);
    right.push_back(6 * (chords[k] - chords[k - 1]));
    of_seam.push_back(0);
  }
  of_seam.front() -= h.front();
  of_seam.back() -= h.back();
  const std::vector<double> known = system.solve(std::move(right));
  const std::vector<double> share = system.solve(std::move(of_seam));
  const double missing =
      6 * (chords.front() - chords.back()) - h.back() * known.back() - h.front() * known.front();
  const double seam =
      missing / (2 * (h.back() + h.front()) + h.back() * share.back() + h.front() * share.front());
  std::vector<double> moments{seam};
  for (std::size_t k = 0; k < known.size(); ++k) moments.push_back(known[k] + seam * share[k]);
  moments.push_back(seam);
  return moments;
}

std::vector<Cubic> cubics_with(const SplineRun& run, const std::vector<double>& moments) {
  std::vector<Cubic> cubics;
  cubics.reserve(run.steps.size());
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    const double square = run.steps[k] * run.steps[k];
    const double difference = run.values[k + 1] - run.values[k];
    cubics.push_back({run.values[k], difference - square * (2 * moments[k] + moments[k + 1]) / 6,
                      square * moments[k] / 2, square * (moments[k + 1] - moments[k]) / 6});
  }
  return cubics;
}

}  // namespace

std::vector<Cubic> spline_through(const SplineRun& run) {
  if (run.periodic) return cubics_with(run, periodic_moments(run));
  OpenRun open(run);
  const std::vector<double> moments = open_moments(open);
  std::vector<double>& values = open.run.values;
  for (std::size_t k = 0; k < values.size(); ++k) values[k] += open.per_moment[k] * moments[k];
  std::vector<Cubic> cubics = cubics_with(open.run, moments);
  // Beside a rest nothing is left of the derivatives, not even a rounding, which would ask for a roll.
  if (run.first_end == SplineEnd::rest) cubics.front() = {values[0], 0, 0, open.per_moment[1] * moments[1]};
  if (run.last_end == SplineEnd::rest) {
    const std::size_t knot = values.size() - 2;
    const double p = -open.per_moment[knot] * moments[knot];
    cubics.back() = {values.back() - p, 3 * p, -3 * p, p};
  }
  return cubics;
}

double first_slope_of(std::span<const double, 5> values, double step) {
  return (-25 * values[0] + 48 * values[1] - 36 * values[2] + 16 * values[3] - 3 * values[4]) / (12 * step);
}

}  // namespace inbetween
