#include "host_tools/plan/smoothest_pace.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/numerics/band_program.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/timing/integral_row.hpp"
#include "inbetween/timing/speed_profile.hpp"

namespace inbetween {
namespace {

/// A speed curve has no more control values than a file may hold: one more than spans.
constexpr std::int32_t max_pace_spans = static_cast<std::int32_t>(max_control_values) - 1;
/// Between two rests that lie off the knots, two spans are lost and four are the least that a speed takes.
constexpr std::int32_t spans_in_shortest = 6;
/// A curve between two rests has four control values that are 0, and five others that shape it.
constexpr std::int32_t min_pace_spans = 8;
/// A key may be missed by this share of the length: more is no rounding, and no curve.
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
  const std::int64_t wanted = std::max<std::int64_t>(
      (static_cast<std::int64_t>(spans_in_shortest) * frames + shortest - 1) / shortest, min_pace_spans);
  const std::int64_t times = std::min((wanted + unit - 1) / unit, max_pace_spans / unit);
  return static_cast<std::int32_t>(unit * std::max<std::int64_t>(times, 1));
}

/// The quadratic program over the running sums of W_i v_i, where W_i is the integral of the curve in which
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
    program_ = BandProgram(free_.size());
    demand_keys();
    for (std::size_t p = 0; p < free_.size(); ++p) program_.demand_at_least(share_of(p), 0);
    add_costs();
  }

  /// Nothing rests, and only the length is demanded.
  [[nodiscard]] bool bends_nowhere() const { return free_.size() == is_zero_.size() && keys_.size() == 1; }
  /// False where there is no such curve.
  bool solve() {
    std::vector<double> even;
    double total = 0;
    for (std::size_t p = 0; p < free_.size(); ++p) even.push_back(total += weight(p));
    if (!program_.solve(even)) return false;
    double worst = 0;
    for (std::size_t r = 0; r < keys_.size(); ++r) worst = std::max(worst, program_.missed(r) / f_);
    return worst <= acceptable_pace_miss;
  }
  /// The key that is missed most.
  [[nodiscard]] Error blame() const {
    std::size_t worst = 0;
    for (std::size_t r = 0; r < keys_.size(); ++r) {
      if (program_.missed(r) > program_.missed(worst)) worst = r;
    }
    const std::size_t key = keys_.empty() ? 0 : keys_[worst];
    return unmet(static_cast<std::int32_t>(key), spec_.key_frames[key]);
  }
  [[nodiscard]] std::vector<double> control_values() const {
    std::vector<double> values(static_cast<std::size_t>(f_) + 1);
    for (std::size_t p = 0; p < free_.size(); ++p) values[index(free_[p])] = program_.slack(p) / weight(p);
    double largest = 0;
    for (const double value : values) largest = std::max(largest, value);
    for (double& value : values) value = value / largest * largest_control_value;
    return values;
  }

 private:
  using Sum = std::vector<Term>;

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

  /// Adds factor * v_p, in running sums.
  void add_value(std::size_t p, double factor, Sum& sum) const {
    sum.push_back({p, factor / weight(p)});
    if (p > 0) sum.push_back({p - 1, -factor / weight(p)});
  }
  /// W_p v_p: what it adds to the running sum before it.
  static Sum share_of(std::size_t p) {
    Sum sum{{p, 1}};
    if (p > 0) sum.push_back({p - 1, -1});
    return sum;
  }

  /// Phi up to each key that is passed at a speed, in the unknowns near it.
  void demand_keys() {
    const double length = spec_.key_distances.back();
    for (std::size_t k = 1; k < spec_.key_frames.size(); ++k) {
      if (!(spec_.key_distances[k] > spec_.key_distances[k - 1])) continue;
      keys_.push_back(k);
      const IntegralRow row(0, a_of_key(k), f_);
      // Of the values far to the left the whole integral counts: their running sum.
      std::int32_t first = std::max<std::int32_t>(static_cast<std::int32_t>(a_of_key(k)) - 1, 0);
      if (static_cast<std::int32_t>(a_of_key(k)) >= f_ - 2) first = std::max(f_ - 4, 0);
      Sum sum;
      const std::size_t left = before_[index(first)];
      if (left > 0) sum.push_back({left - 1, 1});
      for (std::int32_t i = first; i <= std::min(row.last(), f_); ++i) {
        if (is_zero_[index(i)] == 0) add_value(before_[index(i)], row.weight(i), sum);
      }
      program_.demand(sum, spec_.key_distances[k] / length * f_);
    }
  }

  /// phi'' at an inner knot; at the ends it is 0.
  [[nodiscard]] Sum second_derivative(std::int32_t knot) const {
    Sum sum;
    if (knot <= 0 || knot >= f_) return sum;
    for (const auto& [i, factor] :
         {std::pair{knot - 1, 1.0}, std::pair{knot, -2.0}, std::pair{knot + 1, 1.0}}) {
      if (is_zero_[index(i)] == 0) add_value(before_[index(i)], factor, sum);
    }
    return sum;
  }
  /// The integral of phi''^2 over a span is (s0^2 + s0 s1 + s1^2) / 3, with phi'' at its ends.
  void add_costs() {
    Sum here = second_derivative(0);
    for (std::int32_t knot = 0; knot < f_; ++knot) {
      const Sum next = second_derivative(knot + 1);
      program_.add_cost(here, here, 2.0 / 3);
      program_.add_cost(here, next, 2.0 / 3);
      program_.add_cost(next, next, 2.0 / 3);
      here = next;
    }
  }

  const PaceSpec& spec_;
  std::int32_t f_;
  IntegralRow whole_;
  std::vector<std::uint8_t> is_zero_;  ///< whether a control value is 0
  std::vector<std::int32_t> free_;     ///< the control values that may be above 0
  std::vector<std::size_t> before_;    ///< of each control value, how many of them stand before it
  std::vector<std::size_t> keys_;      ///< of each equation
  BandProgram program_{0};
};

}  // namespace

std::vector<double> smoothest_pace(const PaceSpec& spec) {
  for (std::int32_t f = span_count(spec);; f *= 2) {
    PaceProgram program(spec, f);
    // Every even change of speed is as smooth as none: the program has no single answer.
    if (program.bends_nowhere())
      return std::vector<double>(static_cast<std::size_t>(f) + 1, largest_control_value);
    if (program.solve()) return program.control_values();
    if (2 * f > max_pace_spans) throw SolverError(program.blame());
  }
}

}  // namespace inbetween
