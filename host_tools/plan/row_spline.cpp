#include "host_tools/plan/row_spline.hpp"

#include <utility>

namespace inbetween {
namespace {

/// Row k: before[k] x[k-1] + diagonal[k] x[k] + behind[k] x[k+1] = right[k].
struct Tridiagonal {
  std::vector<double> before, diagonal, behind;

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
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    chords.push_back((run.values[k + 1] - run.values[k]) / run.steps[k]);
  }
  return chords;
}

/// Second derivatives at all places.
std::vector<double> clamped_moments(const SplineRun& run) {
  const std::vector<double>& h = run.steps;
  const std::vector<double> chords = chords_of(run);
  const std::size_t last = h.size();
  Tridiagonal system;
  std::vector<double> right;
  system.add(0, 2 * h.front(), h.front());
  right.push_back(6 * (chords.front() - run.first_slope));
  for (std::size_t k = 1; k < last; ++k) {
    system.add(h[k - 1], 2 * (h[k - 1] + h[k]), h[k]);
    right.push_back(6 * (chords[k] - chords[k - 1]));
  }
  system.add(h.back(), 2 * h.back(), 0);
  right.push_back(6 * (run.last_slope - chords.back()));
  return system.solve(std::move(right));
}

/// The rows between the ends are solved with the moment at the seam as a parameter; its own row then gives
/// it.
std::vector<double> periodic_moments(const SplineRun& run) {
  const std::vector<double>& h = run.steps;
  const std::vector<double> chords = chords_of(run);
  const std::size_t last = h.size();
  if (last < 2) return std::vector<double>(last + 1);
  Tridiagonal system;
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

}  // namespace

std::vector<Cubic> spline_through(const SplineRun& run) {
  const std::vector<double> moments = run.periodic ? periodic_moments(run) : clamped_moments(run);
  std::vector<Cubic> cubics;
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    const double square = run.steps[k] * run.steps[k];
    const double difference = run.values[k + 1] - run.values[k];
    cubics.push_back({run.values[k], difference - square * (2 * moments[k] + moments[k + 1]) / 6,
                      square * moments[k] / 2, square * (moments[k + 1] - moments[k]) / 6});
  }
  return cubics;
}

double first_slope_of(std::span<const double, 5> values, double step) {
  return (-25 * values[0] + 48 * values[1] - 36 * values[2] + 16 * values[3] - 3 * values[4]) / (12 * step);
}

}  // namespace inbetween
