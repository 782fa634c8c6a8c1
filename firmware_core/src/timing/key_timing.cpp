#include "inbetween/timing/key_timing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/timing/speed_profile.hpp"
#include "timing/lock_frames.hpp"
#include "timing/nearest_curve.hpp"

namespace inbetween {
namespace {

/// A touch takes about two spans on either side of its knot: so many spans to one that was drawn leave the
/// curve as drawn from one drawn span away on.
constexpr std::int32_t spans_to_touch = 4;

class Adjustment {
 public:
  Adjustment(const KeyTimingSpec& spec, const KeyTimingMemory& memory, std::size_t lock_count)
      : spec_(spec),
        memory_(memory),
        locks_(memory.locks.first(lock_count)),
        drawn_f_(static_cast<std::int32_t>(spec.control_values.size()) - 1),
        is_periodic_(spec.ends == CurveEnds::periodic) {}

  Result<KeyTiming> run() {
    for (std::int32_t refinements = 0;; ++refinements) {
      const std::int32_t f = drawn_f_ << refinements;
      const std::int64_t needed = static_cast<std::int64_t>(f) + 1;
      const bool fits = needed <= static_cast<std::int64_t>(memory_.adjusted.size()) &&
                        needed * spec_.frames < std::numeric_limits<std::int32_t>::max();
      if (!fits) return unmet(needed);
      if (refinements == 0) {
        std::ranges::copy(spec_.control_values, memory_.drawn.begin());
      } else {
        refine_control_values(memory_.drawn, static_cast<std::size_t>(f) / 2, spec_.ends);
      }
      if (spec_.key_distances.back() <= 0) return as_drawn();
      if (!is_fine_enough(f) || !find_knots(f)) continue;
      const std::int32_t row = attempt(f);
      if (row < 0) return timing(f, refinements);
      blame(locks_[static_cast<std::size_t>(row) + 1]);
      // That the last key is met on the last frame is nobody's request; the key before it is in the way.
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

  /// The knots on which the eased keys are met. False where a finer curve is needed: a locked frame lies off
  /// the knots, there is no room for the touch, or it would be as wide as what was drawn.
  bool find_knots(std::int32_t f) {
    const bool may_refine = 2 * static_cast<std::size_t>(f) < memory_.adjusted.size();
    const bool is_coarse = f / drawn_f_ < spans_to_touch && may_refine;
    bool found = true;
    touch_is_off_knot_ = false;
    for (std::size_t i = 0; i < locks_.size(); ++i) {
      KeyLock& lock = memory_.locks[i];
      lock.knot = -1;
      if (!lock.ease) continue;
      const std::int64_t scaled = static_cast<std::int64_t>(lock.frame) * f;
      const bool off_knot = is_locked(lock) && scaled % spec_.frames != 0;
      const std::int32_t knot =
          touched_knot(static_cast<std::int32_t>((scaled + spec_.frames / 2) / spec_.frames), f);
      const bool is_seam = is_periodic_ && lock.key == 0;
      const bool is_inside = is_seam ? f >= 6 : knot >= 1 && knot < f;
      const bool has_room = is_inside && f <= std::numeric_limits<std::int16_t>::max();
      lock.knot = static_cast<std::int16_t>(has_room ? knot : -1);
      if (!off_knot && has_room && (!is_coarse || touches(knot, f))) continue;
      found = false;
      touch_is_off_knot_ = off_knot;
      blame(lock);
    }
    return found;
  }
  /// Whether the drawn curve touches 0 at a knot already.
  [[nodiscard]] bool touches(std::int32_t knot, std::int32_t f) const {
    const bool is_seam = is_periodic_ && knot == 0;
    if (!is_seam && (knot < 1 || knot >= f)) return false;
    const auto is_zero = [&](std::int32_t i) { return memory_.drawn[static_cast<std::size_t>(i)] == 0; };
    return is_zero(is_seam ? f - 1 : knot - 1) && is_zero(knot) && is_zero(knot + 1);
  }
  /// A neighbour at which the curve touches 0 already, as one does that was adjusted before; else the knot.
  [[nodiscard]] std::int32_t touched_knot(std::int32_t knot, std::int32_t f) const {
    const std::int32_t reach = f / spec_.frames + 1;  // the frame of the key is a whole one
    if (is_periodic_ && knot == 0) return knot;
    for (std::int32_t away = 0; away <= reach; ++away) {
      if (touches(knot - away, f)) return knot - away;
      if (touches(knot + away, f)) return knot + away;
    }
    return knot;
  }
  /// Whether the author gave the key its frame.
  [[nodiscard]] bool is_locked(const KeyLock& lock) const {
    const auto request = std::ranges::lower_bound(spec_.locks, lock.key, {}, &KeyLock::key);
    return request != spec_.locks.end() && request->key == lock.key && request->frame >= 0;
  }

  void blame(const KeyLock& lock) {
    unmet_key_ = lock.key;
    unmet_frame_ = lock.frame;
  }

  std::int32_t attempt(std::int32_t f) {
    const std::size_t count = static_cast<std::size_t>(f) + 1;
    const std::span<double> drawn = memory_.drawn.first(count);
    NearestCurve curve(memory_, f, spec_.ends, locks_, spec_.frames);
    set_targets(curve, f);
    for (std::size_t i = 0; i < count; ++i) {
      memory_.ceiling[i] = is_rest(drawn, i, spec_.ends) ? 0.0 : largest_control_value;
    }
    for (const KeyLock& lock : locks_) {
      if (lock.hold > 0 || lock.ease) rest_at(lock, curve, f);
    }
    set_mobility(f);
    stop_between_equal_keys(curve);
    return curve.solve();
  }

  /// Between two locks with no distance in between no value can be above 0. Left to the multipliers, this
  /// would take an infinite one.
  void stop_between_equal_keys(const NearestCurve& curve) {
    for (std::size_t r = 0; r + 1 < locks_.size(); ++r) {
      if (memory_.targets[r] > 0) continue;
      const IntegralRow row = curve.row(r);
      for (std::int32_t i = row.first(); i <= row.last(); ++i) {
        if (row.weight(i) > 0) memory_.ceiling[row.index(i)] = 0;
      }
    }
  }

  /// The distance to the nearest value that stands still, in drawn spans, through a smooth step.
  void set_mobility(std::int32_t f) {
    const std::span<double> mobility = memory_.mobility.first(static_cast<std::size_t>(f) + 1);
    const double per_value = static_cast<double>(drawn_f_) / static_cast<double>(f);
    const auto come_to = [&](std::size_t i, double away) {
      return memory_.ceiling[i] > 0 ? std::min(away + per_value, 1.0) : 0.0;
    };
    double after = 1;
    double before = 1;
    if (is_periodic_) {  // once round, to know how far the last rest is from either side of the seam
      for (std::size_t i = 0; i + 1 < mobility.size(); ++i) after = come_to(i, after);
      for (std::size_t i = mobility.size() - 1; i-- > 0;) before = come_to(i, before);
    }
    for (std::size_t i = 0; i < mobility.size(); ++i) mobility[i] = after = come_to(i, after);
    if (is_periodic_) mobility.back() = mobility.front();
    for (std::size_t i = mobility.size() - (is_periodic_ ? 1 : 0); i-- > 0;) {
      before = come_to(i, before);
      mobility[i] = smooth_step(std::min(mobility[i], before));
    }
  }

  /// Phi between two breaks as drawn, and in it each lock's share of the length.
  void set_targets(const NearestCurve& curve, std::int32_t f) {
    for (std::size_t begin = 0; begin + 1 < locks_.size();) {
      std::size_t end = begin + 1;
      while (end + 1 < locks_.size() && !locks_[end].breaks) ++end;
      const IntegralRow stretch(curve.a(locks_[begin]), curve.a(locks_[end]), f, spec_.ends);
      const double integral = stretch.integral(memory_.drawn);
      const double length = distance(locks_[end]) - distance(locks_[begin]);
      for (std::size_t r = begin; r < end; ++r) {
        const double part = distance(locks_[r + 1]) - distance(locks_[r]);
        memory_.targets[r] = length > 0 ? part / length * integral : 0.0;
      }
      begin = end;
    }
  }
  [[nodiscard]] double distance(const KeyLock& lock) const {
    return spec_.key_distances[static_cast<std::size_t>(lock.key)];
  }

  /// Without a hold the curve touches 0 at a knot: three values are 0.
  void rest_at(const KeyLock& lock, const NearestCurve& curve, std::int32_t f) {
    const double begin = curve.a(lock);
    const double end = lock.hold > 0 ? curve.a_of_frame(lock.frame + lock.hold) : begin;
    const double ramp = static_cast<double>(f) / static_cast<double>(drawn_f_);  // one drawn span
    const bool is_drawn = lock.ease && touches(lock.knot, f);
    // Further away than the ramp the curve is as drawn. Beside the seam of a periodic one, no place is far.
    const auto reach = static_cast<std::int32_t>(ramp) + 3;
    const auto first = static_cast<std::int32_t>(begin) - reach;
    const auto last = static_cast<std::int32_t>(end) + reach;
    const bool is_at_seam = is_periodic_ && (first <= 0 || last >= f);
    for (std::int32_t i = is_at_seam ? 0 : std::max<std::int32_t>(first, 0);
         i <= (is_at_seam ? f : std::min(last, f)); ++i) {
      const auto outside = [&](std::int32_t at) {
        const auto here = static_cast<double>(at);
        return std::max(begin - here, here - end) - 2;
      };
      double away = outside(i);
      if (is_periodic_) away = std::min({away, outside(i - f), outside(i + f)});
      const auto value = static_cast<std::size_t>(i);
      if (away < 0) {
        memory_.drawn[value] = 0;
        memory_.ceiling[value] = 0;
      } else if (!is_drawn) {
        memory_.drawn[value] *= smooth_step((away + 1) / (ramp + 1));
      }
    }
  }

  /// On a path without length every key is met on every frame.
  [[nodiscard]] KeyTiming as_drawn() {
    std::ranges::copy(spec_.control_values, memory_.adjusted.begin());
    return timing(drawn_f_, 0);
  }

  void restore_drawn(std::int32_t refinements) {
    std::ranges::copy(spec_.control_values, memory_.drawn.begin());
    for (std::int32_t i = 0; i < refinements; ++i)
      refine_control_values(memory_.drawn, static_cast<std::size_t>(drawn_f_) << i, spec_.ends);
  }

  [[nodiscard]] KeyTiming timing(std::int32_t f, std::int32_t refinements) {
    const std::size_t count = static_cast<std::size_t>(f) + 1;
    restore_drawn(refinements);
    KeyTiming result{
        .control_values = memory_.adjusted.first(count), .locks = locks_, .refinements = refinements};
    for (std::size_t i = 0; i < count; ++i) {
      const double change = std::fabs(memory_.adjusted[i] - memory_.drawn[i]);
      if (change > result.largest_change) {
        result.largest_change = change;
        result.largest_change_at = static_cast<std::int32_t>(i);
      }
    }
    return result;
  }

  [[nodiscard]] Error unmet(std::int64_t needed) const {
    if (touch_is_off_knot_) {
      return {.code = ErrorCode::no_solution,
              .what = "the speed can touch 0 only on a knot of the speed curve, and this frame is on none",
              .remedy = "lock it on a frame that is, or remove its frame",
              .key = unmet_key_,
              .frame = unmet_frame_,
              .needed = needed};
    }
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

  const KeyTimingSpec& spec_;
  const KeyTimingMemory& memory_;
  std::span<const KeyLock> locks_;
  std::int32_t drawn_f_;
  bool is_periodic_;
  bool hold_is_too_short_ = false;
  bool touch_is_off_knot_ = false;
  std::int32_t unmet_key_ = -1;
  std::int32_t unmet_frame_ = -1;
};

Status check_memory(const KeyTimingSpec& spec, const KeyTimingMemory& memory) {
  const std::size_t rows = spec.locks.size() + 1;
  const std::size_t values = memory.adjusted.size();
  const bool enough = values >= spec.control_values.size() && memory.drawn.size() >= values &&
                      memory.mobility.size() >= values && memory.ceiling.size() >= values &&
                      memory.locks.size() >= rows + 1 && memory.targets.size() >= rows &&
                      memory.multipliers.size() >= 4 * rows && memory.rows.size() >= rows &&
                      memory.weights.size() >= lock_weight_count(rows - 1, values) &&
                      memory.matrix.size() >= lock_entry_count(rows - 1);
  if (enough) return Done{};
  return Error{.code = ErrorCode::capacity,
               .what = "there are more locked keys or control values than the memory of the key timing",
               .remedy = "give it a larger capacity",
               .needed = static_cast<std::int64_t>(std::max(rows, spec.control_values.size()))};
}

}  // namespace

Result<KeyTiming> adjust_to_locks(const KeyTimingSpec& spec, const KeyTimingMemory& memory) {
  if (spec.control_values.size() < 2 || spec.key_distances.empty() || spec.frames < 1) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "locked keys need a speed curve of at least two control values",
                 .remedy = "draw a curve, for example speed = [10, 10]"};
  }
  if (const Status enough = check_memory(spec, memory); !enough) return enough.error();
  const Result<std::size_t> count = complete_locks(spec, memory.locks, memory.targets);
  if (!count) return count.error();
  return Adjustment(spec, memory, *count).run();
}

}  // namespace inbetween
