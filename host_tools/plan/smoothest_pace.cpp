#include "host_tools/plan/smoothest_pace.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "host_tools/numerics/band_matrix.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/timing/integral_row.hpp"
#include "inbetween/timing/speed_profile.hpp"

namespace inbetween {
namespace {

constexpr std::int32_t max_pace_spans = 2047;
/// Between two rests that lie off the knots, two spans are lost and four are the least that a speed takes.
constexpr std::int32_t spans_in_shortest = 6;
constexpr std::int32_t min_pace_spans = 8;
/// Twenty are usual. Where there is no curve the iteration makes no way.
constexpr int max_pace_iterations = 200;
/// The share of a step that is taken, so that no control value reaches 0.
constexpr double way_to_border = 0.995;
/// The tolerance of the complementarity and of the rows, with control values about 1.
constexpr double pace_tolerance = 1e-13;
/// A row may miss by this share of the length: more is no rounding.
constexpr double acceptable_pace_miss = 1e-11;

Error unmet(std::int32_t key, std::int32_t frame) {
  return {.code = ErrorCode::no_solution,
          .what = "no smooth speed curve of at most 2048 control values meets this key on its frame",
          .remedy = R"(move the frame, or time the keys as curves (kinetic = "curves"))",
          .key = key,
          .frame = frame};
}

/// How many spans the curve has.
std::int32_t span_count(const PaceSpec& spec) {
  const std::int32_t frames = spec.key_frames.back();
  std::int64_t unit = 1;  // every touch is on a knot of so many spans
  for (const std::int32_t key : spec.touches) {
    const std::int32_t frame = spec.key_frames[static_cast<std::size_t>(key)];
    unit = std::lcm<std::int64_t>(unit, frames / std::gcd(frames, frame));
    if (unit <= max_pace_spans) continue;
    throw SolverError({.code = ErrorCode::no_solution,
                       .what =
                           "no speed curve of at most 2048 control values has a knot on this frame, where "
                           "its speed is to touch 0",
                       .remedy = "move the frame, so that it divides the frames of the move more evenly",
                       .key = key,
                       .frame = frame});
  }
  std::int32_t shortest = frames;
  for (std::size_t i = 1; i < spec.key_frames.size(); ++i) {
    shortest = std::min(shortest, spec.key_frames[i] - spec.key_frames[i - 1]);
  }
  const std::int64_t wished = std::max<std::int64_t>(
      (static_cast<std::int64_t>(spans_in_shortest) * frames + shortest - 1) / shortest, min_pace_spans);
  const std::int64_t times = std::min((wished + unit - 1) / unit, max_pace_spans / unit);
  return static_cast<std::int32_t>(unit * std::max<std::int64_t>(times, 1));
}

/// A sum of a few unknowns.
struct Term {
  std::size_t unknown = 0;
  double weight = 0;
};

/// The quadratic program over the running sums x of W_i v_i, where W_i is the integral of the curve in which
/// v_i is 1 and the others are 0. Control values that are 0 add nothing and have no unknown.
class PaceProgram {
 public:
  PaceProgram(const PaceSpec& spec, std::int32_t f)
      : spec_(spec), f_(f), whole_(0.0, static_cast<double>(f_), f_) {
    fix_values();
    for (std::int32_t i = 0; i <= f_; ++i) {
      if (is_zero_[index(i)] == 0) free_.push_back(i);
    }
    before_.assign(is_zero_.size() + 1, 0);
    for (std::size_t i = 0; i < is_zero_.size(); ++i)
      before_[i + 1] = before_[i] + (is_zero_[i] != 0 ? 0U : 1U);
    list_rows();
    number_unknowns();
  }

  /// False where there is no such curve.
  bool solve() {
    start();
    for (int i = 0; i < max_pace_iterations && !is_solved(); ++i) step();
    return missed() <= acceptable_pace_miss;
  }
  /// The key that is missed most.
  [[nodiscard]] Error blame() const {
    std::size_t worst = 0;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (std::abs(residual(r)) > std::abs(residual(worst))) worst = r;
    }
    const std::size_t key = keys_.empty() ? 0 : keys_[worst];
    return unmet(static_cast<std::int32_t>(key), spec_.key_frames[key]);
  }
  [[nodiscard]] std::vector<double> control_values() const {
    std::vector<double> values(static_cast<std::size_t>(f_) + 1);
    for (std::size_t p = 0; p < free_.size(); ++p) values[index(free_[p])] = slack_[p] / weight(p);
    double largest = 0;
    for (const double value : values) largest = std::max(largest, value);
    for (double& value : values) value = value / largest * largest_control_value;
    return values;
  }

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] double weight(std::size_t p) const { return whole_.weight(free_[p]); }
  [[nodiscard]] double a_of_key(std::size_t k) const {
    return static_cast<double>(spec_.key_frames[k]) * f_ / spec_.key_frames.back();
  }

  void fix_values() {
    is_zero_.assign(static_cast<std::size_t>(f_) + 1, 0);
    if (spec_.rests_at_start) is_zero_[0] = is_zero_[1] = 1;
    if (spec_.rests_at_end) is_zero_[index(f_)] = is_zero_[index(f_ - 1)] = 1;
    for (const std::int32_t key : spec_.touches) {
      const auto knot = static_cast<std::int32_t>(std::lround(a_of_key(index(key))));
      for (std::int32_t i = std::max(knot - 1, 0); i <= std::min(knot + 1, f_); ++i) is_zero_[index(i)] = 1;
    }
    for (std::size_t k = 1; k < spec_.key_frames.size(); ++k) {
      if (spec_.key_distances[k] > spec_.key_distances[k - 1]) continue;
      const IntegralRow row(a_of_key(k - 1), a_of_key(k), f_);
      for (std::int32_t i = row.first(); i <= row.last(); ++i) {
        if (row.weight(i) > 0) is_zero_[index(i)] = 1;
      }
    }
  }

  /// Phi up to each key that is passed at a speed, in the unknowns near it.
  void list_rows() {
    const double length = spec_.key_distances.back();
    for (std::size_t k = 1; k < spec_.key_frames.size(); ++k) {
      if (!(spec_.key_distances[k] > spec_.key_distances[k - 1])) continue;
      keys_.push_back(k);
      targets_.push_back(spec_.key_distances[k] / length * f_);
      const IntegralRow row(0, a_of_key(k), f_);
      // Of the values far to the left the whole integral counts: their running sum.
      std::int32_t first = std::max<std::int32_t>(static_cast<std::int32_t>(a_of_key(k)) - 1, 0);
      if (static_cast<std::int32_t>(a_of_key(k)) >= f_ - 2) first = std::max(f_ - 4, 0);
      std::vector<Term> terms;
      const std::size_t left = before_[index(first)];
      if (left > 0) terms.push_back({left - 1, 1});
      for (std::int32_t i = first; i <= std::min(row.last(), f_); ++i) {
        if (is_zero_[index(i)] != 0) continue;
        const std::size_t p = before_[index(i)];
        add_value(p, row.weight(i), terms);
      }
      rows_.push_back(terms);
    }
  }
  /// Adds w v_p as a term of running sums.
  void add_value(std::size_t p, double w, std::vector<Term>& terms) const {
    terms.push_back({p, w / weight(p)});
    if (p > 0) terms.push_back({p - 1, -w / weight(p)});
  }

  /// Sums and the multipliers of rows in the order in which they come, so that the band is narrow.
  void number_unknowns() {
    std::size_t next = 0;
    std::size_t row = 0;
    place_of_multiplier_.assign(rows_.size(), 0);
    for (std::size_t p = 0; p < free_.size(); ++p) {
      place_of_sum_.push_back(next++);
      while (row < rows_.size() && last_unknown(rows_[row]) <= p) place_of_multiplier_[row++] = next++;
    }
    while (row < rows_.size()) place_of_multiplier_[row++] = next++;
    size_ = next;
    band_ = 0;
    for_each_entry(
        [&](std::size_t i, std::size_t j, double) { band_ = std::max(band_, i > j ? i - j : j - i); });
  }
  static std::size_t last_unknown(const std::vector<Term>& terms) {
    std::size_t last = 0;
    for (const Term& term : terms) last = std::max(last, term.unknown);
    return last;
  }

  /// visit(terms, factor) for phi''_k = sum of terms at every inner knot k, and for the products of
  /// neighbours: the integral of phi''^2 over a span is (s0^2 + s0 s1 + s1^2) / 3.
  [[nodiscard]] std::vector<Term> second_derivative(std::int32_t knot) const {
    std::vector<Term> terms;
    if (knot <= 0 || knot >= f_) return terms;
    for (const auto& [i, w] : {std::pair{knot - 1, 1.0}, std::pair{knot, -2.0}, std::pair{knot + 1, 1.0}}) {
      if (is_zero_[index(i)] == 0) add_value(before_[index(i)], w, terms);
    }
    return terms;
  }
  /// Entries of Q and of the rows, by place: the part of the matrix that stays.
  template <class Visit>
  void for_each_entry(const Visit& visit) const {
    std::vector<Term> here = second_derivative(0);
    for (std::int32_t knot = 0; knot < f_; ++knot) {
      const std::vector<Term> next = second_derivative(knot + 1);
      const auto add = [&](const std::vector<Term>& row, const std::vector<Term>& column, double factor) {
        for (const Term& x : row) {
          for (const Term& y : column) {
            visit(place_of_sum_[x.unknown], place_of_sum_[y.unknown], factor * x.weight * y.weight);
          }
        }
      };
      add(here, here, 2.0 / 3);
      add(next, next, 2.0 / 3);
      add(here, next, 1.0 / 3);
      add(next, here, 1.0 / 3);
      here = next;
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      for (const Term& term : rows_[r]) {
        visit(place_of_multiplier_[r], place_of_sum_[term.unknown], term.weight);
        visit(place_of_sum_[term.unknown], place_of_multiplier_[r], -term.weight);
      }
    }
    for (std::size_t p = 0; p + 1 < free_.size(); ++p) visit(place_of_sum_[p], place_of_sum_[p + 1], 0);
  }

  void start() {
    sum_.assign(size_, 0);
    slack_.assign(free_.size(), 0);
    dual_.assign(free_.size(), 1);
    double total = 0;
    for (std::size_t p = 0; p < free_.size(); ++p) {
      slack_[p] = weight(p);
      total += slack_[p];
      sum_[place_of_sum_[p]] = total;
    }
  }
  [[nodiscard]] double complementarity() const {
    if (free_.empty()) return 0;
    return std::inner_product(slack_.begin(), slack_.end(), dual_.begin(), 0.0) /
           static_cast<double>(free_.size());
  }
  [[nodiscard]] double residual(std::size_t r) const {
    double sum = -targets_[r];
    for (const Term& term : rows_[r]) sum += term.weight * sum_[place_of_sum_[term.unknown]];
    return sum;
  }
  /// How far the worst row is from being met, as a share of the length.
  [[nodiscard]] double missed() const {
    double worst = 0;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const double share = std::abs(residual(r)) / f_;
      if (!(share <= worst)) worst = share;
    }
    return worst;
  }
  [[nodiscard]] bool is_solved() const {
    return missed() <= pace_tolerance && complementarity() <= pace_tolerance;
  }
  /// The Newton step towards complementarity `aim`, with the product of a step before as a correction.
  struct Direction {
    std::vector<double> sum, slack, dual;
  };
  [[nodiscard]] Direction direction(const BandMatrix& matrix, const std::vector<double>& base, double aim,
                                    const Direction* predicted) const {
    std::vector<double> right = base;
    std::vector<double> wanted(free_.size());
    for (std::size_t p = 0; p < free_.size(); ++p) {
      const double product = predicted != nullptr ? predicted->slack[p] * predicted->dual[p] : 0;
      wanted[p] = (aim - slack_[p] * dual_[p] - product) / slack_[p];
      right[place_of_sum_[p]] += wanted[p] + dual_[p];
      if (p > 0) right[place_of_sum_[p - 1]] -= wanted[p] + dual_[p];
    }
    matrix.solve(right);
    Direction found{right, std::vector<double>(free_.size()), std::vector<double>(free_.size())};
    for (std::size_t p = 0; p < free_.size(); ++p) {
      found.slack[p] = right[place_of_sum_[p]] - (p > 0 ? right[place_of_sum_[p - 1]] : 0);
      found.dual[p] = wanted[p] - dual_[p] / slack_[p] * found.slack[p];
    }
    return found;
  }
  static double longest(const std::vector<double>& from, const std::vector<double>& by) {
    double step = 1;
    for (std::size_t p = 0; p < from.size(); ++p) {
      if (by[p] < 0) step = std::min(step, -way_to_border * from[p] / by[p]);
    }
    return step;
  }

  void step() {
    BandMatrix matrix(size_, band_);
    std::vector<double> base(
        size_);  // minus the gradient by the sums and multipliers, and minus the residuals
    for_each_entry([&](std::size_t i, std::size_t j, double entry) {
      matrix.add(i, j, entry);
      base[i] -= entry * sum_[j];
    });
    for (std::size_t r = 0; r < rows_.size(); ++r) base[place_of_multiplier_[r]] += targets_[r];
    for (std::size_t p = 0; p < free_.size(); ++p) {
      const double stiffness = dual_[p] / slack_[p];
      const std::size_t here = place_of_sum_[p];
      matrix.add(here, here, stiffness);
      if (p == 0) continue;
      const std::size_t left = place_of_sum_[p - 1];
      matrix.add(left, left, stiffness);
      matrix.add(here, left, -stiffness);
      matrix.add(left, here, -stiffness);
    }
    matrix.factor();
    const Direction straight = direction(matrix, base, 0, nullptr);
    const double primal = longest(slack_, straight.slack);
    const double dual = longest(dual_, straight.dual);
    double reached = 0;
    for (std::size_t p = 0; p < free_.size(); ++p) {
      reached += (slack_[p] + primal * straight.slack[p]) * (dual_[p] + dual * straight.dual[p]);
    }
    const double now = complementarity();
    const double share = now > 0 ? reached / static_cast<double>(free_.size()) / now : 0;
    const Direction turned = direction(matrix, base, share * share * share * now, &straight);
    // One length for both: the objective is quadratic, and so the two are not independent.
    const double length = std::min(longest(slack_, turned.slack), longest(dual_, turned.dual));
    for (std::size_t i = 0; i < size_; ++i) sum_[i] += length * turned.sum[i];
    for (std::size_t p = 0; p < free_.size(); ++p) {
      slack_[p] += length * turned.slack[p];
      dual_[p] += length * turned.dual[p];
    }
  }

  const PaceSpec& spec_;
  std::int32_t f_;
  IntegralRow whole_;
  std::vector<std::uint8_t> is_zero_;  ///< whether a control value is 0
  std::vector<std::int32_t> free_;     ///< the control values that may be above 0
  std::vector<std::size_t> before_;    ///< of each control value, how many of them stand before it
  std::vector<std::size_t> keys_;
  std::vector<double> targets_;
  std::vector<std::vector<Term>> rows_;
  std::vector<std::size_t> place_of_sum_, place_of_multiplier_;
  std::size_t size_ = 0, band_ = 0;
  std::vector<double> sum_;  ///< sums and multipliers, each at its place
  std::vector<double> slack_, dual_;
};

}  // namespace

std::vector<double> smoothest_pace(const PaceSpec& spec) {
  for (std::int32_t f = span_count(spec);; f *= 2) {
    PaceProgram program(spec, f);
    if (program.solve()) return program.control_values();
    if (2 * f > max_pace_spans) throw SolverError(program.blame());
  }
}

}  // namespace inbetween
