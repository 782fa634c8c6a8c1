#include "inbetween/trajectory/bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

constexpr double close_share = 1e-3;
constexpr double close_position = 1e-9;
/// A hull shrinks to a quarter of what it is too wide with every halving.
constexpr int max_depth = 30;

/// Bernstein coefficients over a stretch of u.
struct Bernstein {
  std::array<double, 8> c{};
  std::size_t degree = 0;
  double begin = 0, end = 1;

  [[nodiscard]] double highest() const {
    double most = c[0];
    for (std::size_t i = 1; i <= degree; ++i) most = std::max(most, c[i]);
    return most;
  }
  [[nodiscard]] Bernstein derivative(double seconds) const {
    Bernstein result;
    result.degree = degree == 0 ? 0 : degree - 1;
    const double factor = static_cast<double>(degree) / seconds;
    for (std::size_t i = 0; i < degree; ++i) result.c[i] = factor * (c[i + 1] - c[i]);
    return result;
  }
  [[nodiscard]] Bernstein negated() const {
    Bernstein result = *this;
    for (double& one : result.c) one = -one;
    return result;
  }
  /// This becomes the first half, and the second is returned.
  Bernstein halve() {
    Bernstein second = *this;
    for (std::size_t round = 1; round <= degree; ++round) {
      for (std::size_t i = degree; i >= round; --i) c[i] = (c[i - 1] + c[i]) / 2;
      second.c[degree - round] = c[degree];
    }
    // What is left in c[i] is the i-th coefficient of the first half.
    second.begin = end = begin + (end - begin) / 2;
    return second;
  }
};

/// The position of an axis on a piece less the one at its begin.
Bernstein position_of(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis) {
  const std::size_t axes = trajectory.axis_count();
  const double* first = &trajectory.values()[piece.begin_row];
  const double* last = &trajectory.values()[piece.end_row];
  const std::size_t known = (piece.degree + std::size_t{1}) / 2;
  Bernstein result;
  result.degree = piece.degree;
  const double way = last[axis] - first[axis];
  for (std::size_t i = 0; i < known; ++i) {
    // b_i = sum over j of binomial(i, j) (n - j)! / n! h^j f^(j), from either end.
    double left = 0;
    double right = way;
    double factor = 1;  // binomial(i, j) (n - j)! / n! h^j
    for (std::size_t j = 1; j <= i; ++j) {
      factor *= static_cast<double>(i - j + 1) / static_cast<double>(j) * piece.seconds /
                static_cast<double>(piece.degree + 1 - j);
      left += factor * first[j * axes + axis];
      right += (j % 2 == 1 ? -factor : factor) * last[j * axes + axis];
    }
    result.c[i] = left;
    result.c[piece.degree - i] = right;
  }
  return result;
}

/// Raises `bound` to what a polynomial reaches, proven: not below it, and above by `share` of it or `slack`.
class Search {
 public:
  Search(double share, double slack) : share_(share), slack_(slack) {}

  [[nodiscard]] double bound() const { return bound_; }
  [[nodiscard]] double frame() const { return frame_; }

  void take(const Bernstein& whole, const TrajectoryPiece& piece) {
    if (whole.highest() <= bound_) return;
    std::array<Bernstein, max_depth + 1> stack;
    std::size_t count = 0;
    stack[count++] = whole;
    while (count > 0) {
      Bernstein& top = stack[count - 1];
      const double highest = top.highest();
      reach(top.c[0], top.begin, piece);
      reach(top.c[top.degree], top.end, piece);
      const double enough = reached_ + std::max(share_ * std::fabs(reached_), slack_);
      if (highest <= std::max(enough, bound_) || count == stack.size()) {
        bound_ = std::max(bound_, highest);
        --count;
        continue;
      }
      const Bernstein second = top.halve();
      // The half that promises more comes first, so that the other is left out more often.
      stack[count++] = second;
    }
  }

 private:
  void reach(double value, double u, const TrajectoryPiece& piece) {
    if (value <= reached_) return;
    reached_ = value;
    frame_ = static_cast<double>(piece.begin.frame) + piece.begin.fraction + u / piece.inverse_frames;
  }

  double share_;
  double slack_;
  double reached_ = -std::numeric_limits<double>::infinity();
  double bound_ = -std::numeric_limits<double>::infinity();
  double frame_ = 0;
};

Bernstein shifted(Bernstein polynomial, double by) {
  for (std::size_t i = 0; i <= polynomial.degree; ++i) polynomial.c[i] += by;
  return polynomial;
}

void bound_axis(const Trajectory& trajectory, std::size_t axis, AxisPeaks<double>& out) {
  double low = trajectory.values()[trajectory.pieces().front().begin_row + axis];
  double high = low;
  for (const TrajectoryPiece& piece : trajectory.pieces()) {
    low = std::min(low, trajectory.values()[piece.end_row + axis]);
    high = std::max(high, trajectory.values()[piece.end_row + axis]);
  }
  const double slack = close_position * (high - low);
  Search highest(0, slack), lowest(0, slack);
  std::array<Search, 3> peaks{Search(close_share, 0), Search(close_share, 0), Search(close_share, 0)};
  for (const TrajectoryPiece& piece : trajectory.pieces()) {
    const double begin = trajectory.values()[piece.begin_row + axis];
    Bernstein polynomial = position_of(trajectory, piece, axis);
    highest.take(shifted(polynomial, begin), piece);
    lowest.take(shifted(polynomial, begin).negated(), piece);
    for (Search& peak : peaks) {
      polynomial = polynomial.derivative(piece.seconds);
      peak.take(polynomial, piece);
      peak.take(polynomial.negated(), piece);
    }
  }
  out.highest = {highest.bound(), highest.frame()};
  out.lowest = {-lowest.bound(), lowest.frame()};
  out.velocity = {peaks[0].bound(), peaks[0].frame()};
  out.acceleration = {peaks[1].bound(), peaks[1].frame()};
  out.jerk = {peaks[2].bound(), peaks[2].frame()};
}

}  // namespace

void bound_trajectory(const Trajectory& trajectory, std::span<AxisPeaks<double>> out) {
  for (std::size_t d = 0; d < trajectory.axis_count(); ++d) bound_axis(trajectory, d, out[d]);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const UnboundedSide& side : trajectory.unbounded()) {
    AxisPeaks<double>& peaks = out[static_cast<std::size_t>(side.axis)];
    const double frame = static_cast<double>(side.time.frame) + side.time.fraction;
    if (side.order <= 1) peaks.velocity.raise(infinity, frame);
    if (side.order <= 2) peaks.acceleration.raise(infinity, frame);
    peaks.jerk.raise(infinity, frame);
  }
}

void steps_at(const Trajectory& trajectory, const TrajectoryBreak& at, std::span<TrajectoryStep> out) {
  const std::size_t axes = trajectory.axis_count();
  const TrajectoryPiece& before = trajectory.pieces()[at.piece - 1];
  const TrajectoryPiece& behind = trajectory.pieces()[at.piece];
  const double* arriving = &trajectory.values()[before.end_row];
  const double* leaving = &trajectory.values()[behind.begin_row];
  const std::size_t known = (std::min(before.degree, behind.degree) + std::size_t{1}) / 2;
  for (std::size_t d = 0; d < axes; ++d) {
    out[d] = {};
    if (known > 1) out[d].velocity = leaving[axes + d] - arriving[axes + d];
    if (known > 2) out[d].acceleration = leaving[2 * axes + d] - arriving[2 * axes + d];
  }
}

}  // namespace inbetween
