// A convex quadratic program whose conditions speak of neighbouring unknowns.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/numerics/band_matrix.hpp"

namespace inbetween {

/// A part of a sum: an unknown and its factor.
struct Term {
  std::size_t unknown = 0;
  double weight = 0;
};

/// Finds the x with the smallest x^T H x / 2 - g^T x that keeps equations and inequalities. One more unknown,
/// the ease, may be added to some inequalities: by so much each of them may be missed, at a price.
///
/// The unknowns are numbered so that every sum, and every product in H, speaks of neighbours. A step costs
/// the number of unknowns and inequalities times the square of how far apart neighbours are.
///
/// Method: primal and dual interior points with a predictor and a corrector (Mehrotra 1992, On the
/// implementation of a primal-dual interior point method). Ten to forty steps are usual.
class BandProgram {
 public:
  explicit BandProgram(std::size_t unknowns) : gains_(unknowns) {}

  /// Adds factor * one * other / 2 to x^T H x / 2.
  void add_cost(std::span<const Term> one, std::span<const Term> other, double factor);
  /// Adds factor * sum to g^T x.
  void add_gain(std::span<const Term> sum, double factor);
  /// The ease s >= 0 costs price * s + curvature * s^2 / 2, both above 0.
  void allow_ease(double price, double curvature);
  /// Demands sum = value. Equations must not follow from each other.
  void demand(std::span<const Term> sum, double value);
  /// Demands sum >= bound or, if it is eased, sum + ease >= bound.
  void demand_at_least(std::span<const Term> sum, double bound, bool is_eased = false);

  /// Begins at `start`, one number per unknown. False where no x keeps all conditions, or rounding hides it.
  [[nodiscard]] bool solve(std::span<const double> start);
  /// The answer of the last solve().
  [[nodiscard]] double value(std::span<const Term> sum) const;
  [[nodiscard]] double ease() const { return ease_; }
  /// By how much the sum of inequality i, in the order in which they were added, is above its bound: what
  /// value() less the bound is up to rounding, and never below 0.
  [[nodiscard]] double slack(std::size_t i) const { return slack_[i]; }
  /// By how much equation i, in the order in which they were added, is missed.
  [[nodiscard]] double missed(std::size_t i) const;

 private:
  struct Row {
    std::size_t first = 0, end = 0;  ///< of terms_
    double bound = 0;
    double eased = 0;  ///< the factor of the ease, 1 or 0
  };
  /// Newton's step from one point to the next.
  struct Direction {
    std::vector<double> x, slack, dual;
    double ease = 0;
  };
  class Newton;

  [[nodiscard]] Row row_of(std::span<const Term> sum, double bound, double eased);
  [[nodiscard]] std::span<const Term> terms_of(const Row& row) const {
    return std::span(terms_).subspan(row.first, row.end - row.first);
  }
  /// The same, with the places of the unknowns.
  [[nodiscard]] std::span<const Term> placed(const Row& row) const {
    return std::span(placed_).subspan(row.first, row.end - row.first);
  }
  [[nodiscard]] double sum_of(const Row& row, std::span<const double> x, double ease) const;
  void number_places();
  void assemble();
  void begin(std::span<const double> start);
  void move(const Direction& by, double length);
  /// The sum of slack * dual: so far may the cost be from the least.
  [[nodiscard]] double gap() const;
  [[nodiscard]] double gap_after(const Direction& by, double length) const;

  struct Product {
    std::size_t one = 0, other = 0;
    double factor = 0;
  };
  std::vector<Product> costs_;
  std::vector<double> gains_;
  std::vector<Term> terms_;  ///< of all rows
  std::vector<Row> equations_, inequalities_;
  double price_ = 0, curvature_ = 0;  ///< 0 where there is no ease

  std::vector<std::size_t> place_of_unknown_, place_of_equation_;
  std::vector<Term> placed_;  ///< of all rows
  std::size_t size_ = 0, band_ = 0;
  std::optional<BandMatrix> constant_;  ///< the part of the matrix of a step that stays
  std::vector<double> right_;           ///< of the equations of a step at x = 0
  std::vector<double> x_;               ///< unknowns and the multipliers of equations, each at its place
  std::vector<double> slack_, dual_;    ///< of every inequality
  double ease_ = 0;
};

}  // namespace inbetween
