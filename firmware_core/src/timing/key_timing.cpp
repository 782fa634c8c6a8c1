#include "inbetween/timing/key_timing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/timing/speed_profile.hpp"

namespace inbetween {
namespace {

/// Newton's method on a piecewise quadratic function ends in as many steps as pieces are met.
constexpr int max_iterations = 200;
/// Of a step, far enough for any multiplier that a curve from 0 to 100 can need.
constexpr int max_doublings = 40;
/// Of them every third halves the stretch that is searched.
constexpr int max_secants = 60;

Error wish_error(const char* what, const char* remedy, const KeyLock& lock) {
  return {
      .code = ErrorCode::out_of_range, .what = what, .remedy = remedy, .key = lock.key, .frame = lock.frame};
}

/// Integral of the cardinal cubic B-spline with support (-2, 2) from -2 to x.
template <Precise Real>
Real bspline_integral(Real x) {
  if (x <= -2) return 0;
  if (x >= 2) return 1;
  const Real y = x > 0 ? -x : x;  // the spline is even
  const Real u = y + 2;
  const Real below =
      y <= -1 ? u * u * u * u / 24 : Real(0.5) + y * (Real(2) / 3 - y * y * (Real(1) / 3 + y / 8));
  return x > 0 ? 1 - below : below;
}

/// How the integral of phi over [begin, end] depends on each control value, natural ends included.
template <Precise Real>
class IntegralRow {
 public:
  IntegralRow(Real begin, Real end, std::int32_t f) : begin_(begin), end_(end), f_(f) {}

  [[nodiscard]] std::int32_t first() const {
    return std::max<std::int32_t>(0, static_cast<std::int32_t>(begin_) - 2);
  }
  [[nodiscard]] std::int32_t last() const { return std::min(f_, static_cast<std::int32_t>(end_) + 3); }
  [[nodiscard]] Real weight(std::int32_t i) const {
    Real sum = spline(i);
    if (i == 0) sum += 2 * spline(-1);  // the phantom value is 2 v_0 - v_1
    if (i == 1) sum -= spline(-1);
    if (i == f_) sum += 2 * spline(f_ + 1);
    if (i == f_ - 1) sum -= spline(f_ + 1);
    return sum;
  }
  [[nodiscard]] Real integral(std::span<const Real> values) const {
    Real sum = 0;
    for (std::int32_t i = first(); i <= last(); ++i) sum += weight(i) * values[static_cast<std::size_t>(i)];
    return sum;
  }

 private:
  [[nodiscard]] Real spline(std::int32_t i) const {
    const auto centre = static_cast<Real>(i);
    return bspline_integral(end_ - centre) - bspline_integral(begin_ - centre);
  }
  Real begin_, end_;
  std::int32_t f_;
};

/// x nearest to v with rows * x = targets and 0 <= x <= ceiling.
template <Precise Real>
class NearestCurve {
 public:
  NearestCurve(const KeyTimingMemory<Real>& memory, std::int32_t f, std::span<const KeyLock> locks,
               std::int32_t frames)
      : memory_(memory),
        locks_(locks),
        frames_(frames),
        f_(f),
        rows_(locks.size() - 1),
        lambda_(memory.multipliers.first(rows_)),
        residual_(memory.multipliers.subspan(rows_, rows_)),
        direction_(memory.multipliers.subspan(2 * rows_, rows_)),
        trial_(memory.multipliers.subspan(3 * rows_, rows_)) {}

  [[nodiscard]] IntegralRow<Real> row(std::size_t r) const { return {a(locks_[r]), a(locks_[r + 1]), f_}; }
  /// Where a lock stands on the curve.
  [[nodiscard]] Real a(const KeyLock& lock) const {
    return static_cast<Real>(lock.frame) * static_cast<Real>(f_) / static_cast<Real>(frames_);
  }

  /// The index of a row that stays unmet, or -1.
  std::int32_t solve() {
    std::ranges::fill(lambda_, Real(0));
    Real total = 0;
    for (std::size_t r = 0; r < rows_; ++r) total += memory_.targets[r];
    const Real tolerance = 64 * std::numeric_limits<Real>::epsilon() * total;
    const Real largest_cost = cost_bound();
    static_cast<void>(evaluate(lambda_));
    for (int i = 0; i < max_iterations && worst_residual() > tolerance; ++i) {
      newton_direction();
      if (!climb(largest_cost)) break;
    }
    return worst_residual() <= tolerance ? -1 : worst_row();
  }

 private:
  /// x(lambda) into `adjusted`, the residual, and the value of the dual function.
  Real evaluate(std::span<const Real> lambda) {
    const std::span<Real> x = memory_.adjusted.first(static_cast<std::size_t>(f_) + 1);
    std::ranges::copy(memory_.drawn.first(x.size()), x.begin());
    for (std::size_t r = 0; r < rows_; ++r) {
      const IntegralRow<Real> weights = row(r);
      for (std::int32_t i = weights.first(); i <= weights.last(); ++i) {
        const auto index = static_cast<std::size_t>(i);
        x[index] += lambda[r] * memory_.mobility[index] * weights.weight(i);
      }
    }
    Real dual = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::clamp(x[i], Real(0), memory_.ceiling[i]);
      const Real change = x[i] - memory_.drawn[i];
      if (memory_.mobility[i] > 0) dual += change * change / (2 * memory_.mobility[i]);
    }
    for (std::size_t r = 0; r < rows_; ++r) {
      residual_[r] = row(r).integral(x) - memory_.targets[r];
      dual -= lambda[r] * residual_[r];
    }
    return dual;
  }
  /// No curve changes the drawn one by more than this, which is why no dual value is larger if there is a
  /// curve (weak duality).
  [[nodiscard]] Real cost_bound() const {
    Real bound = 0;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(f_); ++i) {
      if (!(memory_.mobility[i] > 0)) continue;
      const Real change = std::max(memory_.drawn[i], memory_.ceiling[i] - memory_.drawn[i]);
      bound += change * change / (2 * memory_.mobility[i]);
    }
    return bound * (1 + 16 * std::numeric_limits<Real>::epsilon()) + std::numeric_limits<Real>::min();
  }

  /// How fast the dual rises along the direction, at the multipliers evaluated last.
  [[nodiscard]] Real slope() const {
    Real sum = 0;
    for (std::size_t r = 0; r < rows_; ++r) sum -= residual_[r] * direction_[r];
    return sum;
  }
  Real evaluate_at(Real step) {
    for (std::size_t r = 0; r < rows_; ++r) trial_[r] = lambda_[r] + step * direction_[r];
    return evaluate(trial_);
  }

  /// Goes on along the direction until the dual rises no more; its slope falls there, piece by piece linear.
  /// Where few values are free a Newton step is far from there, which is why the zero of the slope is
  /// searched for. False if there is no curve.
  bool climb(Real largest_cost) {
    const Real unmet = worst_residual();
    const Real first_slope = slope();
    if (!(first_slope > 0)) return false;  // rounding: nothing is gained any more
    Real low = 0;
    Real low_slope = first_slope;
    Real high = 1;
    if (evaluate_at(high) > largest_cost) return false;
    Real high_slope = slope();
    for (int i = 0; i < max_doublings && high_slope > first_slope / 2; ++i) {
      low = high;
      low_slope = high_slope;
      high *= 4;
      if (evaluate_at(high) > largest_cost) return false;
      high_slope = slope();
    }
    Real step = high;
    Real step_slope = high_slope;
    for (int i = 0; i < max_secants; ++i) {
      if (std::fabs(step_slope) <= first_slope / 16 || worst_residual() <= unmet / 16) break;
      const Real secant = low + (high - low) * (low_slope / (low_slope - high_slope));
      const Real middle = low + (high - low) / 2;
      step = i % 3 == 2 || !(secant > low && secant < high) ? middle : secant;
      static_cast<void>(evaluate_at(step));
      step_slope = slope();
      (step_slope > 0 ? low : high) = step;
      (step_slope > 0 ? low_slope : high_slope) = step_slope;
    }
    std::ranges::copy(trial_, lambda_.begin());
    return true;
  }

  [[nodiscard]] Real worst_residual() const {
    Real worst = 0;
    for (const Real r : residual_) {
      if (!(std::fabs(r) <= worst)) worst = std::fabs(r);
    }
    return worst;
  }
  [[nodiscard]] std::int32_t worst_row() const {
    const auto worst =
        std::ranges::max_element(residual_, {}, [](Real residual) { return std::fabs(residual); });
    return static_cast<std::int32_t>(worst - residual_.begin());
  }

  /// Solves (A_free A_free^T) direction = -residual by Cholesky's method.
  void newton_direction() {
    const std::size_t n = rows_;
    const std::span<Real> m = memory_.matrix.first(n * n);
    std::ranges::fill(m, Real(0));
    for (std::size_t r = 0; r < n; ++r) {
      const IntegralRow<Real> here = row(r);
      for (std::size_t c = 0; c <= r; ++c) {
        const IntegralRow<Real> other = row(c);
        const std::int32_t last = std::min(here.last(), other.last());
        for (std::int32_t i = std::max(here.first(), other.first()); i <= last; ++i) {
          const auto index = static_cast<std::size_t>(i);
          const Real x = memory_.adjusted[index];
          const bool is_free = x > 0 && x < memory_.ceiling[index];
          if (is_free) m[r * n + c] += memory_.mobility[index] * here.weight(i) * other.weight(i);
        }
      }
    }
    for (std::size_t r = 0; r < n; ++r) {
      // Where too few values are free the matrix is singular; the shift keeps the direction an ascent.
      m[r * n + r] += Real(1e-12) + 16 * std::numeric_limits<Real>::epsilon() * m[r * n + r];
      for (std::size_t c = 0; c <= r; ++c) {
        Real sum = m[r * n + c];
        for (std::size_t k = 0; k < c; ++k) sum -= m[r * n + k] * m[c * n + k];
        m[r * n + c] = r == c ? std::sqrt(std::max(sum, Real(1e-14))) : sum / m[c * n + c];
      }
    }
    for (std::size_t r = 0; r < n; ++r) {
      Real sum = -residual_[r];
      for (std::size_t k = 0; k < r; ++k) sum -= m[r * n + k] * direction_[k];
      direction_[r] = sum / m[r * n + r];
    }
    for (std::size_t r = n; r-- > 0;) {
      Real sum = direction_[r];
      for (std::size_t k = r + 1; k < n; ++k) sum -= m[k * n + r] * direction_[k];
      direction_[r] = sum / m[r * n + r];
    }
  }

  KeyTimingMemory<Real> memory_;
  std::span<const KeyLock> locks_;
  std::int32_t frames_;
  std::int32_t f_;
  std::size_t rows_;
  std::span<Real> lambda_, residual_, direction_, trial_;
};

/// The exact curve on twice as many spans, natural ends kept (Lane and Riesenfeld 1980). In place.
template <Precise Real>
void refine(std::span<Real> values, std::int32_t f) {
  const auto v = [&](std::int32_t i) -> Real& { return values[static_cast<std::size_t>(i)]; };
  // From the right: 2 i and 2 i + 1 stand at or behind i, and the coarse values left of i are still there.
  Real right = v(f);  // coarse value i + 1
  Real here = v(f);   // coarse value i
  for (std::int32_t i = f; i >= 0; --i) {
    const Real left = i > 0 ? v(i - 1) : here;
    v(2 * i) = i == 0 || i == f ? here : (left + 6 * here + right) / 8;
    if (i < f) v(2 * i + 1) = (here + right) / 2;
    right = here;
    here = left;
  }
}

/// When the drawn curve arrives at a key, as a share of the time that it moves.
template <Precise Real>
Real arrival(const KeyTimingSpec<Real>& spec, std::int32_t key) {
  const auto f = static_cast<std::int32_t>(spec.control_values.size()) - 1;
  const auto spans = static_cast<Real>(f);
  const Real length = spec.key_distances.back();
  const Real share = length > 0 ? spec.key_distances[static_cast<std::size_t>(key)] / length
                                : static_cast<Real>(key) / static_cast<Real>(spec.key_distances.size());
  if (share <= 0) return 0;
  const Real target = share * IntegralRow<Real>(0, spans, f).integral(spec.control_values);
  Real low = 0;
  Real high = 1;
  for (int i = 0; i < std::numeric_limits<Real>::digits; ++i) {
    const Real middle = (low + high) / 2;
    (IntegralRow<Real>(0, middle * spans, f).integral(spec.control_values) < target ? low : high) = middle;
  }
  return high;
}

/// The frame of the hold at `index`, which has none: where the drawn curve arrives, played between the locks
/// with frames on either side in the frames that are no holds.
template <Precise Real>
std::int32_t arrival_frame(const KeyTimingSpec<Real>& spec, std::size_t index) {
  const std::span<const KeyLock> locks = spec.locks;
  std::int32_t begin_frame = 0;
  Real begin_share = 0;
  std::int32_t held_before = 0;
  for (std::size_t i = 0; i < index; ++i) {
    held_before += locks[i].hold;
    if (locks[i].frame < 0) continue;
    begin_frame = locks[i].frame + locks[i].hold;
    begin_share = arrival(spec, locks[i].key);
    held_before = 0;
  }
  std::int32_t moving = spec.frames - begin_frame - held_before;
  Real end_share = 1;
  for (std::size_t i = index; i < locks.size(); ++i) {
    if (locks[i].frame >= 0) {
      moving -= spec.frames - locks[i].frame;
      end_share = arrival(spec, locks[i].key);
      break;
    }
    moving -= locks[i].hold;
  }
  const Real share = arrival(spec, locks[index].key) - begin_share;
  const Real frames = share > 0 && end_share > begin_share
                          ? share / (end_share - begin_share) * static_cast<Real>(moving)
                          : Real(0);
  // The first frame at or behind it; a frame met but for rounding is that frame.
  const Real rounding = 64 * std::numeric_limits<Real>::epsilon() * static_cast<Real>(spec.frames);
  const auto whole = static_cast<std::int32_t>(frames);
  return begin_frame + held_before + (frames > static_cast<Real>(whole) + rounding ? whole + 1 : whole);
}

/// Every wish with its frame, between the two ends of the move. Returns how many.
template <Precise Real>
Result<std::size_t> complete_locks(const KeyTimingSpec<Real>& spec, std::span<KeyLock> out) {
  const auto last_key = static_cast<std::int32_t>(spec.key_distances.size()) - 1;
  std::int32_t holds = 0;
  for (const KeyLock& lock : spec.locks) holds += lock.hold;
  if (holds >= spec.frames) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the holds take all frames of the move",
                 .remedy = "shorten the holds or give the move more frames",
                 .key = spec.locks.front().key};
  }
  std::size_t count = 0;
  out[count++] = {.key = 0, .frame = 0};
  for (const KeyLock& wish : spec.locks) {
    if (wish.key < 0 || wish.key > last_key) {
      return wish_error("there is no such key", "count the keys from 0", wish);
    }
  }
  for (std::size_t i = 0; i < spec.locks.size(); ++i) {
    KeyLock lock = spec.locks[i];
    if (lock.frame < 0) lock.frame = arrival_frame(spec, i);
    const std::int32_t end = lock.frame + lock.hold;
    if (end > spec.frames) {
      return wish_error("this key would be left after the last frame",
                        "give it an earlier frame or a shorter hold", lock);
    }
    KeyLock& before = out[count - 1];
    if (lock.key == 0) {
      if (lock.frame != 0) return wish_error("the first key is met on frame 0", "remove its frame", lock);
      before = lock;
      continue;
    }
    if (lock.key == last_key && end != spec.frames) {
      return wish_error("the last key is met on the last frame", "remove its frame, or change frames", lock);
    }
    const std::int32_t left = before.frame + before.hold;
    if (lock.frame == left && lock.key != before.key) {
      return wish_error("this key is to be met on the frame of the locked key before it",
                        "give the two keys different frames", lock);
    }
    if (lock.frame < left) {
      return wish_error("this key is to be met before the locked key in front of it",
                        "give the keys frames in their own order", lock);
    }
    out[count++] = lock;
  }
  if (out[count - 1].key != last_key) {
    if (out[count - 1].frame + out[count - 1].hold >= spec.frames) {
      return wish_error("this key leaves no frame for the keys behind it", "give it an earlier frame",
                        out[count - 1]);
    }
    out[count++] = {.key = last_key, .frame = spec.frames};
  }
  return count;
}

/// Rises from 0 to 1 with two derivatives 0 at both ends.
template <Precise Real>
Real smooth_step(Real x) {
  const Real u = std::clamp(x, Real(0), Real(1));
  return u * u * u * (10 - u * (15 - 6 * u));
}

/// Whether the curve stands still at a value: two zeros at an end of it, three elsewhere.
template <Precise Real>
bool is_rest(std::span<const Real> values, std::size_t index) {
  const auto zeros = [&](std::size_t first, std::size_t last) {
    const auto part = values.subspan(first, last - first + 1);
    return std::ranges::all_of(part, [](Real value) { return value == 0; });
  };
  const std::size_t f = values.size() - 1;
  if (index <= 1 && zeros(0, 1)) return true;
  if (index + 1 >= f && zeros(f - 1, f)) return true;
  for (std::size_t middle = std::max<std::size_t>(index, 2) - 1; middle <= index + 1; ++middle) {
    if (middle + 1 <= f && zeros(middle - 1, middle + 1)) return true;
  }
  return false;
}

template <Precise Real>
class Adjustment {
 public:
  Adjustment(const KeyTimingSpec<Real>& spec, const KeyTimingMemory<Real>& memory, std::size_t lock_count)
      : spec_(spec),
        memory_(memory),
        locks_(memory.locks.first(lock_count)),
        drawn_f_(static_cast<std::int32_t>(spec.control_values.size()) - 1) {}

  Result<KeyTiming<Real>> run() {
    for (std::int32_t refinements = 0;; ++refinements) {
      const std::int32_t f = drawn_f_ << refinements;
      const std::int64_t needed = static_cast<std::int64_t>(f) + 1;
      const bool fits = needed <= static_cast<std::int64_t>(memory_.adjusted.size()) &&
                        needed * spec_.frames < std::numeric_limits<std::int32_t>::max();
      if (!fits) return unmet(needed);
      if (refinements == 0) {
        std::ranges::copy(spec_.control_values, memory_.drawn.begin());
      } else {
        refine(memory_.drawn, f / 2);
      }
      if (spec_.key_distances.back() <= 0) return as_drawn();
      if (!is_fine_enough(f)) continue;
      const std::int32_t row = attempt(f);
      if (row < 0) return timing(f, refinements);
      blame(locks_[static_cast<std::size_t>(row) + 1]);
      // That the last key is met on the last frame is nobody's wish; the key before it is in the way.
      if (row > 0 && static_cast<std::size_t>(row) + 2 == locks_.size()) {
        blame(locks_[static_cast<std::size_t>(row)]);
      }
      // `adjusted` served as the scratch of the attempt; `drawn` must be the drawn curve again.
      restore_drawn(refinements);
    }
  }

 private:
  /// The rest of a hold covers whole spans: they must be short beside it.
  bool is_fine_enough(std::int32_t f) {
    const auto too_short = std::ranges::find_if(locks_, [&](const KeyLock& lock) {
      const std::int64_t frames_per_span_allowed = std::max<std::int32_t>(lock.hold / 4, 1);
      return lock.hold > 0 && static_cast<std::int64_t>(f) * frames_per_span_allowed < spec_.frames;
    });
    hold_is_too_short_ = too_short != locks_.end();
    if (hold_is_too_short_) blame(*too_short);
    return !hold_is_too_short_;
  }

  void blame(const KeyLock& lock) {
    unmet_key_ = lock.key;
    unmet_frame_ = lock.frame;
  }

  std::int32_t attempt(std::int32_t f) {
    const std::size_t count = static_cast<std::size_t>(f) + 1;
    const std::span<Real> drawn = memory_.drawn.first(count);
    NearestCurve<Real> curve(memory_, f, locks_, spec_.frames);
    set_targets(curve, f);
    for (std::size_t i = 0; i < count; ++i) {
      memory_.ceiling[i] = is_rest<Real>(drawn, i) ? Real(0) : Real(largest_control_value);
    }
    for (const KeyLock& lock : locks_) {
      if (lock.hold > 0) rest_at(lock, curve, f);
    }
    set_mobility(f);
    stop_between_equal_keys(curve);
    return curve.solve();
  }

  /// Between two locks with no distance in between no value can be above 0. Left to the multipliers, this
  /// would take an infinite one.
  void stop_between_equal_keys(const NearestCurve<Real>& curve) {
    for (std::size_t r = 0; r + 1 < locks_.size(); ++r) {
      if (memory_.targets[r] > 0) continue;
      const IntegralRow<Real> row = curve.row(r);
      for (std::int32_t i = row.first(); i <= row.last(); ++i) {
        if (row.weight(i) > 0) memory_.ceiling[static_cast<std::size_t>(i)] = 0;
      }
    }
  }

  /// The distance to the nearest value that stands still, in drawn spans, through a smooth step.
  void set_mobility(std::int32_t f) {
    const std::span<Real> mobility = memory_.mobility.first(static_cast<std::size_t>(f) + 1);
    const Real per_value = static_cast<Real>(drawn_f_) / static_cast<Real>(f);
    Real away = 1;
    for (std::size_t i = 0; i < mobility.size(); ++i) {
      away = memory_.ceiling[i] > 0 ? std::min(away + per_value, Real(1)) : Real(0);
      mobility[i] = away;
    }
    away = 1;
    for (std::size_t i = mobility.size(); i-- > 0;) {
      away = memory_.ceiling[i] > 0 ? std::min(away + per_value, Real(1)) : Real(0);
      mobility[i] = smooth_step(std::min(mobility[i], away));
    }
  }

  /// Phi between two breaks as drawn, and in it each lock's share of the length.
  void set_targets(const NearestCurve<Real>& curve, std::int32_t f) {
    for (std::size_t begin = 0; begin + 1 < locks_.size();) {
      std::size_t end = begin + 1;
      while (end + 1 < locks_.size() && !locks_[end].breaks) ++end;
      const Real integral =
          IntegralRow<Real>(curve.a(locks_[begin]), curve.a(locks_[end]), f).integral(memory_.drawn);
      const Real length = distance(locks_[end]) - distance(locks_[begin]);
      for (std::size_t r = begin; r < end; ++r) {
        const Real part = distance(locks_[r + 1]) - distance(locks_[r]);
        memory_.targets[r] = length > 0 ? part / length * integral : Real(0);
      }
      begin = end;
    }
  }
  [[nodiscard]] Real distance(const KeyLock& lock) const {
    return spec_.key_distances[static_cast<std::size_t>(lock.key)];
  }

  void rest_at(const KeyLock& lock, const NearestCurve<Real>& curve, std::int32_t f) {
    const Real begin = curve.a(lock);
    const Real end = curve.a({.key = lock.key, .frame = lock.frame + lock.hold});
    const Real ramp = static_cast<Real>(f) / static_cast<Real>(drawn_f_);  // one drawn span
    for (std::int32_t i = 0; i <= f; ++i) {
      const auto here = static_cast<Real>(i);
      const Real away = here < begin ? begin - 2 - here : here - end - 2;
      const auto index = static_cast<std::size_t>(i);
      if (away < 0) {
        memory_.drawn[index] = 0;
        memory_.ceiling[index] = 0;
      } else {
        memory_.drawn[index] *= smooth_step((away + 1) / (ramp + 1));
      }
    }
  }

  /// On a path without length every key is met on every frame.
  [[nodiscard]] KeyTiming<Real> as_drawn() {
    std::ranges::copy(spec_.control_values, memory_.adjusted.begin());
    return timing(drawn_f_, 0);
  }

  void restore_drawn(std::int32_t refinements) {
    std::ranges::copy(spec_.control_values, memory_.drawn.begin());
    for (std::int32_t i = 0; i < refinements; ++i) refine(memory_.drawn, drawn_f_ << i);
  }

  [[nodiscard]] KeyTiming<Real> timing(std::int32_t f, std::int32_t refinements) {
    const std::size_t count = static_cast<std::size_t>(f) + 1;
    restore_drawn(refinements);
    KeyTiming<Real> result{
        .control_values = memory_.adjusted.first(count), .locks = locks_, .refinements = refinements};
    for (std::size_t i = 0; i < count; ++i) {
      const Real change = std::fabs(memory_.adjusted[i] - memory_.drawn[i]);
      if (change > result.largest_change) {
        result.largest_change = change;
        result.largest_change_at = static_cast<std::int32_t>(i);
      }
    }
    return result;
  }

  [[nodiscard]] Error unmet(std::int64_t needed) const {
    return {.code = ErrorCode::no_solution,
            .what = hold_is_too_short_ ? "the speed curve has too few control values for a hold this short"
                                       : "no speed curve from 0 to 100 meets this key on its frame",
            .remedy = hold_is_too_short_
                          ? "make the hold longer, or draw fewer control values"
                          : "move the frame, or draw the curve lower elsewhere so that there is room",
            .key = unmet_key_,
            .frame = unmet_frame_,
            .needed = needed};
  }

  const KeyTimingSpec<Real>& spec_;
  KeyTimingMemory<Real> memory_;
  std::span<const KeyLock> locks_;
  std::int32_t drawn_f_;
  bool hold_is_too_short_ = false;
  std::int32_t unmet_key_ = -1;
  std::int32_t unmet_frame_ = -1;
};

template <Precise Real>
Status check_memory(const KeyTimingSpec<Real>& spec, const KeyTimingMemory<Real>& memory) {
  const std::size_t rows = spec.locks.size() + 1;
  const std::size_t values = memory.adjusted.size();
  const bool enough = values >= spec.control_values.size() && memory.drawn.size() >= values &&
                      memory.mobility.size() >= values && memory.ceiling.size() >= values &&
                      memory.locks.size() >= rows + 1 && memory.targets.size() >= rows &&
                      memory.multipliers.size() >= 4 * rows && memory.matrix.size() >= rows * rows;
  if (enough) return Done{};
  return Error{.code = ErrorCode::capacity,
               .what = "there are more locked keys or control values than the memory of the key timing",
               .remedy = "give it a larger capacity",
               .needed = static_cast<std::int64_t>(std::max(rows, spec.control_values.size()))};
}

}  // namespace

template <Precise Real>
Result<KeyTiming<Real>> adjust_to_locks(const KeyTimingSpec<Real>& spec,
                                        const KeyTimingMemory<Real>& memory) {
  if (spec.control_values.size() < 2 || spec.key_distances.empty() || spec.frames < 1) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "locked keys need a speed curve of at least two control values",
                 .remedy = "draw a curve, for example speed = [10, 10]"};
  }
  if (const Status enough = check_memory(spec, memory); !enough) return enough.error();
  const Result<std::size_t> count = complete_locks(spec, memory.locks);
  if (!count) return count.error();
  return Adjustment<Real>(spec, memory, *count).run();
}

template Result<KeyTiming<double>> adjust_to_locks(const KeyTimingSpec<double>&,
                                                   const KeyTimingMemory<double>&);
template Result<KeyTiming<float>> adjust_to_locks(const KeyTimingSpec<float>&, const KeyTimingMemory<float>&);

}  // namespace inbetween
