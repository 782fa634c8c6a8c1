#include "host_tools/numerics/band_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace inbetween {
namespace {

/// Ten to forty steps are usual, and max_idle_steps end a search that leads nowhere. The bound is for one
/// that gets better and better and never good.
constexpr int max_steps = 200;
/// The share of a step that is taken, so that no slack reaches 0: there the next step would have no length.
/// With less more steps are needed.
constexpr double step_share = 0.995;
/// The search ends with so little slope: what is left of the gradient, with unknowns and costs about 1.
constexpr double slope_tolerance = 1e-8;
/// And with so little between the cost and its bound from below: an unknown may be off by its root, which is
/// 1e-6 (BandProgramProperty.ItIsTheNearestOfAllThatKeepTheConditions).
constexpr double gap_tolerance = 1e-12;
/// Where rounding ends the search, this much of a condition may be missed: more is no rounding.
constexpr double acceptable_miss = 1e-9;
/// And so much slope may be left there.
constexpr double acceptable_slope = 1e-6;
/// And so much of a gap: an unknown is off by 3e-4 of its size at most, which nobody sees in a curve.
constexpr double acceptable_gap = 1e-7;
/// So many steps without a better one end the search: rounding prevents one, and further steps lead astray. A
/// fifth of the steps of a fit with about a hundred values went on to the 200th, and some were then refused;
/// with this bound a fit with a lock takes 0.30 s for 1.85 s.
constexpr int max_idle_steps = 10;
/// Of what is acceptable already, a better one has a tenth left: small gains would put off the end.
constexpr double better_share = 0.1;
/// A slack of a first point that is nearer to 0 is taken for this: beside a border the first steps would be
/// short.
constexpr double first_slack = 0.1;
/// A shorter step moves nothing but rounding.
constexpr double shortest_step = 1e-9;
/// Of what is missed of the conditions: slacks are kept at least so large until it is met, for slacks that
/// vanish before would leave no room to meet it.
constexpr double min_aim_share = 1e-3;
/// A corrected step that leaves more than this of the gap may lead astray, and is taken without its
/// correction.
constexpr double max_gap_share = 0.9;
/// A step without correction aims at this share of the gap: a smaller one would come near a border again.
constexpr double careful_share = 0.2;

}  // namespace

BandProgram::Row BandProgram::row_of(std::span<const Term> sum, double bound, double eased) {
  const std::size_t first = terms_.size();
  terms_.insert(terms_.end(), sum.begin(), sum.end());
  return {.first = first, .end = terms_.size(), .bound = bound, .eased = eased};
}

void BandProgram::add_cost(std::span<const Term> one, std::span<const Term> other, double factor) {
  for (const Term& x : one) {
    for (const Term& y : other) {
      costs_.push_back({x.unknown, y.unknown, factor * x.weight * y.weight});
      costs_.push_back({y.unknown, x.unknown, factor * x.weight * y.weight});
    }
  }
}

void BandProgram::add_gain(std::span<const Term> sum, double factor) {
  for (const Term& term : sum) gains_[term.unknown] += factor * term.weight;
}

void BandProgram::allow_ease(double price, double curvature) {
  price_ = price;
  curvature_ = curvature;
  demand_at_least({}, 0, true);
}

void BandProgram::demand(std::span<const Term> sum, double value) {
  equations_.push_back(row_of(sum, value, 0));
}

void BandProgram::demand_at_least(std::span<const Term> sum, double bound, bool is_eased) {
  inequalities_.push_back(row_of(sum, bound, is_eased ? 1 : 0));
}

/// Every equation stands behind the last unknown that it speaks of, so that the band is narrow and no pivot
/// is 0.
void BandProgram::number_places() {
  const auto reach = [&](const Row& row) {
    std::size_t last = 0;
    for (const Term& term : terms_of(row)) last = std::max(last, term.unknown);
    return last;
  };
  std::vector<std::size_t> order(equations_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return reach(equations_[i]); });
  place_of_unknown_.clear();
  place_of_equation_.assign(equations_.size(), 0);
  size_ = 0;
  auto next = order.begin();
  for (std::size_t i = 0; i < gains_.size(); ++i) {
    place_of_unknown_.push_back(size_++);
    for (; next != order.end() && reach(equations_[*next]) <= i; ++next) place_of_equation_[*next] = size_++;
  }
  band_ = 0;
  const auto widen = [&](std::size_t one, std::size_t other) {
    band_ = std::max(band_, one > other ? one - other : other - one);
  };
  for (const Product& cost : costs_) widen(place_of_unknown_[cost.one], place_of_unknown_[cost.other]);
  for (const Row& row : inequalities_) {
    for (const Term& x : terms_of(row)) {
      for (const Term& y : terms_of(row)) widen(place_of_unknown_[x.unknown], place_of_unknown_[y.unknown]);
    }
  }
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    for (const Term& x : terms_of(equations_[e])) widen(place_of_equation_[e], place_of_unknown_[x.unknown]);
  }
}

void BandProgram::assemble() {
  placed_ = terms_;
  for (Term& term : placed_) term.unknown = place_of_unknown_[term.unknown];
  constant_.emplace(size_, band_);
  right_.assign(size_, 0);
  for (std::size_t i = 0; i < gains_.size(); ++i) right_[place_of_unknown_[i]] = gains_[i];
  for (const Product& cost : costs_) {
    constant_->add(place_of_unknown_[cost.one], place_of_unknown_[cost.other], cost.factor / 2);
  }
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const std::size_t here = place_of_equation_[e];
    right_[here] = equations_[e].bound;
    for (const Term& term : placed(equations_[e])) {
      constant_->add(here, term.unknown, term.weight);
      constant_->add(term.unknown, here, -term.weight);
    }
  }
}

double BandProgram::sum_of(const Row& row, std::span<const double> x, double ease) const {
  double sum = row.eased * ease;
  for (const Term& term : placed(row)) sum += term.weight * x[term.unknown];
  return sum;
}

double BandProgram::value(std::span<const Term> sum) const {
  double value = 0;
  for (const Term& term : sum) value += term.weight * x_[place_of_unknown_[term.unknown]];
  return value;
}

double BandProgram::missed(std::size_t i) const {
  return std::fabs(sum_of(equations_[i], x_, 0) - equations_[i].bound);
}

double BandProgram::gap() const {
  return std::inner_product(slack_.begin(), slack_.end(), dual_.begin(), 0.0);
}

void BandProgram::begin(std::span<const double> start) {
  number_places();
  assemble();
  x_.assign(size_, 0);
  for (std::size_t i = 0; i < start.size(); ++i) x_[place_of_unknown_[i]] = start[i];
  ease_ = 0;
  double short_of = 0;
  for (const Row& row : inequalities_) {
    if (row.eased > 0) short_of = std::max(short_of, row.bound - sum_of(row, x_, 0));
  }
  ease_ = price_ > 0 ? short_of + first_slack : 0;
  slack_.clear();
  for (const Row& row : inequalities_) {
    slack_.push_back(std::max(sum_of(row, x_, ease_) - row.bound, first_slack));
  }
  // The duals of what is eased add up to the price of the ease in the end.
  const double eased = static_cast<double>(std::ranges::count(inequalities_, 1.0, &Row::eased));
  dual_.clear();
  for (const Row& row : inequalities_) dual_.push_back(row.eased > 0 ? std::min(price_ / eased, 1.0) : 0.1);
}

/// The linear equations of one step. The ease is a border around the band.
class BandProgram::Newton {
 public:
  explicit Newton(const BandProgram& program)
      : in_(program),
        matrix_(*in_.constant_),
        base_(in_.right_),
        border_(in_.size_),
        corner_(in_.curvature_),
        ease_base_(-in_.curvature_ * in_.ease_ - in_.price_) {
    in_.constant_->subtract_product(in_.x_, base_);
    for (std::size_t k = 0; k < in_.inequalities_.size(); ++k) {
      const Row& row = in_.inequalities_[k];
      const double stiffness = in_.dual_[k] / in_.slack_[k];
      for (const Term& x : in_.placed(row)) {
        for (const Term& y : in_.placed(row)) {
          matrix_.add(x.unknown, y.unknown, stiffness * x.weight * y.weight);
        }
        base_[x.unknown] += x.weight * in_.dual_[k];
        border_[x.unknown] += row.eased * stiffness * x.weight;
      }
      corner_ += row.eased * stiffness;
      ease_base_ += row.eased * in_.dual_[k];
      missed_.push_back(in_.sum_of(row, in_.x_, in_.ease_) - row.bound - in_.slack_[k]);
    }
    for (const double slope : base_) slope_ = std::max(slope_, std::fabs(slope));
    for (const std::size_t e : in_.place_of_equation_) miss_ = std::max(miss_, std::fabs(base_[e]));
    for (const double missed : missed_) miss_ = std::max(miss_, std::fabs(missed));
    matrix_.factor();
    inner_border_ = border_;
    matrix_.solve(inner_border_);
    corner_ -= std::inner_product(border_.begin(), border_.end(), inner_border_.begin(), 0.0);
  }

  /// By how much any condition is missed.
  [[nodiscard]] double miss() const { return miss_; }
  /// By how much any equation of the step is missed: a condition, or that nothing slopes any more.
  [[nodiscard]] double slope() const { return slope_; }

  /// Towards slack * dual = aim, with the product of the steps before as a correction.
  [[nodiscard]] Direction direction(double aim, const Direction* before) const {
    Direction step{.x = base_, .slack = missed_, .dual = in_.dual_};
    double ease = ease_base_;
    for (std::size_t k = 0; k < in_.inequalities_.size(); ++k) {
      const Row& row = in_.inequalities_[k];
      const double product = before != nullptr ? before->slack[k] * before->dual[k] : 0;
      step.dual[k] = (aim - product) / in_.slack_[k] - in_.dual_[k];
      const double push = step.dual[k] - in_.dual_[k] / in_.slack_[k] * missed_[k];
      for (const Term& term : in_.placed(row)) step.x[term.unknown] += push * term.weight;
      ease += row.eased * push;
    }
    matrix_.solve(step.x);
    if (in_.price_ > 0) {
      step.ease = (ease - std::inner_product(border_.begin(), border_.end(), step.x.begin(), 0.0)) / corner_;
      for (std::size_t i = 0; i < step.x.size(); ++i) step.x[i] -= step.ease * inner_border_[i];
    }
    for (std::size_t k = 0; k < in_.inequalities_.size(); ++k) {
      step.slack[k] += in_.sum_of(in_.inequalities_[k], step.x, step.ease);
      step.dual[k] -= in_.dual_[k] / in_.slack_[k] * step.slack[k];
    }
    return step;
  }

 private:
  const BandProgram& in_;
  BandMatrix matrix_;
  std::vector<double> base_;  ///< what is missing of every equation of the step
  std::vector<double> missed_, border_, inner_border_;
  double corner_ = 0, ease_base_ = 0, miss_ = 0, slope_ = 0;
};

void BandProgram::move(const Direction& by, double length) {
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += length * by.x[i];
  for (std::size_t k = 0; k < slack_.size(); ++k) {
    slack_[k] += length * by.slack[k];
    dual_[k] += length * by.dual[k];
  }
  ease_ += length * by.ease;
}

double BandProgram::gap_after(const Direction& by, double length) const {
  double gap = 0;
  for (std::size_t k = 0; k < slack_.size(); ++k) {
    gap += (slack_[k] + length * by.slack[k]) * (dual_[k] + length * by.dual[k]);
  }
  return gap;
}

bool BandProgram::solve(std::span<const double> start) {
  begin(start);
  // One length for both: the cost is quadratic, and so the two are not independent.
  const auto longest = [&](const Direction& by) {
    double length = 1;
    for (std::size_t k = 0; k < slack_.size(); ++k) {
      if (by.slack[k] < 0) length = std::min(length, -step_share * slack_[k] / by.slack[k]);
      if (by.dual[k] < 0) length = std::min(length, -step_share * dual_[k] / by.dual[k]);
    }
    return length;
  };
  const double count = std::max<double>(static_cast<double>(slack_.size()), 1);
  Direction best;
  double least = std::numeric_limits<double>::infinity();  // what the best leaves, over what is acceptable
  double missed_before = least;
  double to_be_better = least;
  int idle = 0;
  for (int i = 0; i < max_steps && idle < max_idle_steps; ++i) {
    const Newton newton(*this);
    if (!std::isfinite(newton.slope())) break;
    // An unknown may be off by the root of the gap, and so its root stands beside miss and slope.
    const double left = std::max({newton.miss() / acceptable_miss, newton.slope() / acceptable_slope,
                                  std::sqrt(gap() / acceptable_gap)});
    if (left < least) {
      least = left;
      best = {.x = x_, .slack = slack_, .dual = dual_, .ease = ease_};
    }
    idle = left < to_be_better ? 0 : idle + 1;
    if (idle == 0) to_be_better = left <= 1 ? better_share * left : left;
    // The steps meet the conditions more and more exactly until only rounding is missed.
    const bool is_met = newton.miss() <= acceptable_miss && newton.miss() > missed_before / 2;
    if (is_met && newton.slope() <= slope_tolerance && gap() <= gap_tolerance) break;
    missed_before = newton.miss();
    const Direction straight = newton.direction(0, nullptr);
    const double share = gap() > 0 ? gap_after(straight, longest(straight)) / gap() : 0;
    // Slacks that vanish long before the conditions are met would leave no room to meet them.
    const double to_meet = std::max(newton.miss(), newton.slope());
    const double min_aim = to_meet > acceptable_slope ? min_aim_share * to_meet : 0;
    const double aim = std::max(share * share * share * gap() / count, min_aim);
    Direction turned = newton.direction(aim, &straight);
    double length = longest(turned);
    // The correction may lead astray, and the gap rise and fall without end: then the step goes without it.
    if (gap_after(turned, length) > max_gap_share * gap()) {
      turned = newton.direction(std::max(careful_share * gap() / count, min_aim), nullptr);
      length = longest(turned);
    }
    if (!(length > shortest_step) || !std::isfinite(gap_after(turned, length))) break;
    move(turned, length);
  }
  if (!(least <= 1)) return false;
  x_ = std::move(best.x);
  slack_ = std::move(best.slack);
  dual_ = std::move(best.dual);
  ease_ = best.ease;
  return true;
}

}  // namespace inbetween
