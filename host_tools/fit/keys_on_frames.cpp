#include "host_tools/fit/keys_on_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "host_tools/numerics/band_matrix.hpp"

namespace inbetween {
namespace {

/// An ease with an even acceleration has 1/3, one at an even velocity 1; smoother ones have less than 1/3.
constexpr double max_ease_share = 0.5;
/// Weights grow so often before a largest miss is called the least:
/// KeysOnFrames.OnlyTheKeysOfACurveAreNeeded.
constexpr int max_reweighings = 8;
/// A miss above so many tolerances does not get below one by other weights.
constexpr double hopeless_miss = 2.5;
/// The acceleration 0 at an end that does not rest is one more row with this weight. More hides the others
/// behind its rounding.
constexpr double end_weight = 1e5;
/// With more keys the search does not look for the best of all keys to leave out, but takes them in turn.
constexpr std::size_t max_searched_keys = 64;
/// Up to so many keys are also looked for from other starts: of more the search among those
/// that are there finds as few.
constexpr std::size_t max_started_keys = 10;
/// Where rows bend by less than this share of the most, that is their rounding.
constexpr double min_bend_share = 1e-4;
/// B-splines of degree 3: so many are above 0 between two knots.
constexpr std::size_t spline_order = 4;
/// Where a key goes, its neighbours' curves change: so many coefficients on either side.
constexpr std::size_t coefficients_around = 7;

/// The cubic splines of all axes over a part of the frames, and what they miss.
class KeyedCurves {
 public:
  /// Frames first..last of the rows.
  KeyedCurves(const RowsOnFrames& rows, std::int32_t first, std::int32_t last, bool rests_at_start,
              bool rests_at_end)
      : rows_(&rows),
        first_(first),
        last_(last),
        rests_{rests_at_start, rests_at_end},
        keys_{first, last},
        coefficients_(rows.rows.size()) {
    find_knots();
    for (std::vector<double>& axis : coefficients_) axis.resize(count());
  }

  [[nodiscard]] const std::vector<std::int32_t>& keys() const { return keys_; }
  [[nodiscard]] double position(std::size_t axis, std::int32_t frame) const {
    const Basis basis = basis_at(frame);
    double sum = 0;
    for (std::size_t i = 0; i < spline_order; ++i)
      sum += basis.values[i] * coefficients_[axis][basis.first + i];
    return sum;
  }
  /// In tolerances, the largest of all axes.
  [[nodiscard]] double miss(std::int32_t frame) const {
    const Basis basis = basis_at(frame);
    double largest = 0;
    for (std::size_t a = 0; a < coefficients_.size(); ++a) {
      double sum = 0;
      for (std::size_t i = 0; i < spline_order; ++i)
        sum += basis.values[i] * coefficients_[a][basis.first + i];
      largest = std::max(largest, std::fabs(sum - row(a, frame)) / rows_->tolerances[a]);
    }
    return largest;
  }
  [[nodiscard]] double worst() const {
    double largest = 0;
    for (std::int32_t frame = first_; frame <= last_; ++frame) largest = std::max(largest, miss(frame));
    return largest;
  }

  /// With keys on these frames more; all coefficients anew. Returns the largest miss.
  double insert(std::span<const std::int32_t> frames) {
    keys_.insert(keys_.end(), frames.begin(), frames.end());
    std::ranges::sort(keys_);
    find_knots();
    for (std::vector<double>& axis : coefficients_) axis.assign(count(), 0);
    return fit(0, count());
  }
  /// Without an inner key; the coefficients around it anew. Returns the largest miss around it.
  double remove(std::size_t key) {
    keys_.erase(keys_.begin() + static_cast<std::ptrdiff_t>(key));
    find_knots();
    for (std::vector<double>& axis : coefficients_)
      axis.erase(axis.begin() + static_cast<std::ptrdiff_t>(key) + 1);
    return fit_around(key);
  }
  /// An inner key on another frame, between its neighbours.
  double move(std::size_t key, std::int32_t frame) {
    keys_[key] = frame;
    find_knots();
    return fit_around(key);
  }
  /// The coefficients around a key anew.
  double fit_around(std::size_t key) {
    return fit(key > coefficients_around ? key - coefficients_around : 0,
               std::min(count(), key + coefficients_around + spline_order));
  }

 private:
  struct Basis {
    std::size_t first = 0;  ///< coefficient
    std::array<double, spline_order> values{};
  };

  [[nodiscard]] double row(std::size_t axis, std::int32_t frame) const {
    return rows_->rows[axis][static_cast<std::size_t>(frame)];
  }
  [[nodiscard]] std::size_t count() const { return knots_.size() - spline_order; }

  void find_knots() {
    knots_.clear();
    const auto add_ends = [&](double frame) { knots_.insert(knots_.end(), spline_order - 1, frame); };
    add_ends(first_);
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      knots_.push_back(keys_[k]);
      if (k + 1 == keys_.size()) break;
      const double length = keys_[k + 1] - keys_[k];
      if (k == 0 && rests_.first) knots_.push_back(keys_[k] + length / 4);
      if (k + 2 == keys_.size() && rests_.second) knots_.push_back(keys_[k + 1] - length / 4);
    }
    add_ends(last_);
  }

  /// Cox and de Boor's recurrence.
  [[nodiscard]] Basis basis_at(double frame) const {
    const auto behind = std::upper_bound(knots_.begin() + spline_order, knots_.end() - spline_order, frame);
    const auto span = static_cast<std::size_t>(behind - knots_.begin()) - 1;
    Basis basis{.first = span + 1 - spline_order, .values = {1}};
    std::array<double, spline_order> left{}, right{};
    for (std::size_t degree = 1; degree < spline_order; ++degree) {
      left[degree] = frame - knots_[span + 1 - degree];
      right[degree] = knots_[span + degree] - frame;
      double saved = 0;
      for (std::size_t i = 0; i < degree; ++i) {
        const double share = basis.values[i] / (right[i + 1] + left[degree - i]);
        basis.values[i] = saved + right[i + 1] * share;
        saved = left[degree - i] * share;
      }
      basis.values[degree] = saved;
    }
    return basis;
  }

  /// At a rest the three outer coefficients are the position there.
  [[nodiscard]] bool is_of_rest(std::size_t coefficient) const {
    return (rests_.first && coefficient < spline_order - 1) ||
           (rests_.second && coefficient + spline_order > count());
  }

  double fit(std::size_t low, std::size_t high);
  void solve(std::size_t low, std::size_t high, std::span<const double> weights, std::int32_t begin);

  const RowsOnFrames* rows_;
  std::int32_t first_, last_;
  std::pair<bool, bool> rests_;
  std::vector<std::int32_t> keys_;
  std::vector<double> knots_;
  std::vector<std::vector<double>> coefficients_;  ///< of each axis
};

/// Coefficients low..high-1 by least squares, the others as they are. `weights` are of the frames from
/// `begin` on.
void KeyedCurves::solve(std::size_t low, std::size_t high, std::span<const double> weights,
                        std::int32_t begin) {
  const std::size_t size = high - low;
  BandMatrix matrix(size, spline_order - 1);
  std::vector<std::vector<double>> right(coefficients_.size(), std::vector<double>(size));
  const auto is_unknown = [&](std::size_t c) { return c >= low && c < high && !is_of_rest(c); };
  // One condition: the sum of factors and coefficients is `values` of each axis.
  const auto add = [&](std::size_t from, std::span<const double> factors, double weight,
                       const auto& value_of) {
    for (std::size_t i = 0; i < factors.size(); ++i) {
      if (!is_unknown(from + i)) continue;
      for (std::size_t k = 0; k < factors.size(); ++k) {
        if (is_unknown(from + k))
          matrix.add(from + i - low, from + k - low, weight * factors[i] * factors[k]);
      }
      for (std::size_t a = 0; a < coefficients_.size(); ++a) {
        double left = value_of(a);
        for (std::size_t k = 0; k < factors.size(); ++k) {
          if (!is_unknown(from + k)) left -= factors[k] * coefficients_[a][from + k];
        }
        right[a][from + i - low] += weight * factors[i] * left;
      }
    }
  };
  for (std::size_t f = 0; f < weights.size(); ++f) {
    const std::int32_t frame = begin + static_cast<std::int32_t>(f);
    const Basis basis = basis_at(frame);
    add(basis.first, basis.values, weights[f], [&](std::size_t a) { return row(a, frame); });
  }
  const auto add_free_end = [&](std::size_t from, double outer, double inner) {
    // The two slopes of the outer coefficients are equal.
    const std::array factors{-1 / outer, 1 / outer + 1 / inner, -1 / inner};
    add(from, factors, end_weight * outer * outer, [](std::size_t) { return 0.0; });
  };
  const std::size_t last = knots_.size() - spline_order;
  if (!rests_.first) add_free_end(0, knots_[spline_order] - knots_[1], knots_[spline_order + 1] - knots_[2]);
  if (!rests_.second)
    add_free_end(count() - 3, knots_[last + 1] - knots_[last - 2], knots_[last + 2] - knots_[last - 1]);
  for (std::size_t c = low; c < high; ++c) {
    if (!is_unknown(c)) matrix.add(c - low, c - low, 1);
  }
  matrix.factor();
  for (std::size_t a = 0; a < coefficients_.size(); ++a) {
    matrix.solve(right[a]);
    for (std::size_t c = low; c < high; ++c) {
      if (is_unknown(c)) coefficients_[a][c] = right[a][c - low];
    }
  }
}

/// Returns the largest miss where these coefficients count.
double KeyedCurves::fit(std::size_t low, std::size_t high) {
  for (std::size_t a = 0; a < coefficients_.size(); ++a) {
    for (std::size_t c = low; c < high; ++c) {
      if (is_of_rest(c)) coefficients_[a][c] = row(a, c < spline_order - 1 && rests_.first ? first_ : last_);
    }
  }
  const auto begin = static_cast<std::int32_t>(std::ceil(knots_[low]));
  const auto end = static_cast<std::int32_t>(std::floor(knots_[high + spline_order - 1]));
  std::vector<double> weights(static_cast<std::size_t>(end - begin) + 1, 1.0);
  std::vector<double> misses(weights.size());
  std::vector<std::vector<double>> best;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_reweighings; ++i) {
    solve(low, high, weights, begin);
    double largest = 0, sum = 0;
    for (std::size_t f = 0; f < misses.size(); ++f) {
      misses[f] = miss(begin + static_cast<std::int32_t>(f));
      largest = std::max(largest, misses[f]);
      sum += misses[f];
    }
    if (largest < least) {
      least = largest;
      best = coefficients_;
    }
    if (largest <= 1 || largest > hopeless_miss || !(sum > 0)) break;
    for (std::size_t f = 0; f < weights.size(); ++f)
      weights[f] *= (misses[f] + 0.01 * largest) * static_cast<double>(misses.size()) / sum;
  }
  if (!best.empty()) coefficients_ = std::move(best);
  return least;
}

/// Adds keys where the curves are farthest until every row is met.
void add_keys(KeyedCurves& curves) {
  double worst = curves.insert({});
  while (worst > 1) {
    const bool adds_one = curves.keys().size() < max_searched_keys;
    std::vector<std::int32_t> more;
    double most = 0;
    for (std::size_t k = 0; k + 1 < curves.keys().size(); ++k) {
      const std::int32_t begin = curves.keys()[k];
      const std::int32_t end = curves.keys()[k + 1];
      if (end - begin < 2) continue;
      double largest = 0;
      std::int32_t at = begin + (end - begin) / 2;
      for (std::int32_t frame = begin; frame <= end; ++frame) {
        const double miss = curves.miss(frame);
        if (miss > largest) largest = miss, at = frame;
      }
      if (!(largest > 1)) continue;
      // Near an end of the interval it would leave nearly all of the interval as it is.
      const std::int32_t least = std::max(1, (end - begin) / 4);
      at = std::clamp(at, begin + least, end - least);
      if (!adds_one) {
        more.push_back(at);
      } else if (largest > most) {
        most = largest;
        more = {at};
      }
    }
    if (more.empty()) return;
    worst = curves.insert(more);
  }
}

/// Leaves out the key that is missed least, as long as all rows are met without it.
bool leave_out_one(KeyedCurves& curves) {
  std::optional<KeyedCurves> best;
  double least = 1;
  for (std::size_t key = 1; key + 1 < curves.keys().size(); ++key) {
    KeyedCurves without = curves;
    const double miss = without.remove(key);
    if (miss <= least) {
      least = miss;
      best = std::move(without);
    }
  }
  if (!best) return false;
  curves = std::move(*best);
  return true;
}

/// The same without a choice: each key in turn.
void leave_out_in_turn(KeyedCurves& curves, const std::function<void(double)>& progress) {
  bool is_left_out = true;
  while (is_left_out) {
    is_left_out = false;
    for (std::size_t key = 1; key + 1 < curves.keys().size(); ++key) {
      KeyedCurves without = curves;
      if (without.remove(key) <= 1) {
        curves = std::move(without);
        is_left_out = true;
      }
      progress(static_cast<double>(key) / static_cast<double>(curves.keys().size()));
    }
  }
}

/// Moves inner keys, each to the frame between its neighbours from which the largest miss is less, as long as
/// some do. Returns it.
double move_keys(KeyedCurves& curves) {
  double worst = curves.worst();
  for (std::int32_t step = std::max(1, (curves.keys().back() - curves.keys().front()) / 8); step > 0;
       step /= 2) {
    bool is_moved = true;
    for (int i = 0; i < max_reweighings && is_moved && worst > 1; ++i) {
      is_moved = false;
      for (std::size_t key = 1; key + 1 < curves.keys().size(); ++key) {
        for (const std::int32_t by : {-step, step}) {
          const std::int32_t to = curves.keys()[key] + by;
          if (to <= curves.keys()[key - 1] || to >= curves.keys()[key + 1]) continue;
          KeyedCurves moved = curves;
          moved.move(key, to);
          const double miss = moved.worst();
          if (!(miss < worst)) continue;
          worst = miss;
          curves = std::move(moved);
          is_moved = true;
        }
      }
    }
  }
  return worst;
}

/// One key less, and the others moved until all rows are met again.
bool leave_out_and_move(KeyedCurves& curves) {
  std::optional<KeyedCurves> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t key = 1; key + 1 < curves.keys().size(); ++key) {
    KeyedCurves without = curves;
    without.remove(key);
    const double miss = without.worst();
    if (miss < least) {
      least = miss;
      best = std::move(without);
    }
  }
  if (!best || move_keys(*best) > 1) return false;
  curves = std::move(*best);
  return true;
}

/// Inner frames that are as far apart as each other.
std::vector<std::int32_t> even_frames(std::int32_t first, std::int32_t last, std::size_t count) {
  std::vector<std::int32_t> frames;
  for (std::size_t k = 1; k <= count; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(count + 1);
    const auto at = first + static_cast<std::int32_t>(share * (last - first));
    if (at > first && (frames.empty() || at > frames.back())) frames.push_back(at);
  }
  return frames;
}

/// Inner frames on which the rows bend anew, the strongest first: the fourth difference of a cubic spline is
/// 0 but at its knots.
std::vector<std::int32_t> bending_frames(const RowsOnFrames& rows, std::int32_t first, std::int32_t last) {
  std::vector<double> bends(static_cast<std::size_t>(last - first) + 1);
  for (std::size_t a = 0; a < rows.rows.size(); ++a) {
    for (std::int32_t frame = first + 2; frame + 2 <= last; ++frame) {
      const auto row = rows.rows[a].begin() + frame;
      const double bend = row[-2] - 4 * row[-1] + 6 * row[0] - 4 * row[1] + row[2];
      double& most = bends[static_cast<std::size_t>(frame - first)];
      most = std::max(most, std::fabs(bend) / rows.tolerances[a]);
    }
  }
  std::vector<std::size_t> peaks;
  const double largest = std::ranges::max(bends);
  for (std::size_t i = 1; i + 1 < bends.size(); ++i) {
    if (bends[i] > min_bend_share * largest && bends[i] > bends[i - 1] && bends[i] >= bends[i + 1])
      peaks.push_back(i);
  }
  std::ranges::stable_sort(peaks, std::ranges::greater{}, [&](std::size_t i) { return bends[i]; });
  // Beside a rest there is one more knot, a quarter into the interval: it is no key.
  const auto is_quarter = [&](std::size_t outer, const auto& from_end) {
    return std::ranges::any_of(peaks, [&](std::size_t peak) {
      const auto away = static_cast<double>(from_end(peak)), quarter = static_cast<double>(from_end(outer));
      return peak != outer && std::fabs(away - 4 * quarter) <= 2;
    });
  };
  const std::size_t end = bends.size() - 1;
  peaks.resize(std::min(peaks.size(), 2 * max_started_keys));
  std::vector<std::int32_t> frames;
  for (const std::size_t peak : peaks) {
    if (is_quarter(peak, [](std::size_t i) { return i; })) continue;
    if (is_quarter(peak, [&](std::size_t i) { return end - i; })) continue;
    frames.push_back(first + static_cast<std::int32_t>(peak));
  }
  return frames;
}

/// Fewer keys from other starts, which are then moved: evenly apart, and where the rows bend.
std::optional<KeyedCurves> other_keys(const RowsOnFrames& rows, const KeyedCurves& ends,
                                      std::size_t max_count) {
  const std::int32_t first = ends.keys().front(), last = ends.keys().back();
  const std::vector<std::int32_t> bending = bending_frames(rows, first, last);
  const auto is_enough = [&](std::span<const std::int32_t> frames, std::optional<KeyedCurves>& found) {
    found = ends;
    found->insert(frames);
    return move_keys(*found) <= 1;
  };
  std::optional<KeyedCurves> found;
  for (std::size_t inner = 0; inner + 2 <= max_count; ++inner) {
    if (is_enough(even_frames(first, last, inner), found)) return found;
    if (inner > bending.size()) continue;
    if (is_enough(std::span(bending).first(inner), found)) return found;
  }
  return std::nullopt;
}

KeyedCurves fewest_keys(const RowsOnFrames& rows, const KeyedCurves& ends,
                        const std::function<void(double)>& progress) {
  KeyedCurves curves = ends;
  add_keys(curves);
  if (curves.keys().size() > max_searched_keys) leave_out_in_turn(curves, progress);
  if (curves.keys().size() > max_searched_keys) return curves;
  while (leave_out_one(curves)) {
  }
  while (leave_out_and_move(curves)) {
  }
  const auto other = other_keys(rows, ends, std::min(curves.keys().size() - 1, max_started_keys));
  return other ? *other : curves;
}

struct Hold {
  std::int32_t first = 0, last = 0;
};

/// Where no axis moves for `least` frames or more.
std::vector<Hold> holds_of(const RowsOnFrames& rows, std::int32_t least) {
  std::vector<Hold> holds;
  const auto count = static_cast<std::int32_t>(rows.rows.front().size());
  std::int32_t first = 0;
  for (std::int32_t frame = 1; frame <= count; ++frame) {
    const bool stays =
        frame < count && std::ranges::all_of(rows.rows, [&](const std::vector<double>& axis) {
          return axis[static_cast<std::size_t>(frame)] == axis[static_cast<std::size_t>(first)];
        });
    if (stays) continue;
    if (frame - 1 - first >= least) holds.push_back({first, frame - 1});
    first = frame;
  }
  return holds;
}

}  // namespace

bool rows_rest_at_start(std::span<const double> rows) {
  if (rows.size() < 3) return true;
  const double first = std::fabs(rows[1] - rows[0]);
  const double second = std::fabs(rows[2] - rows[1]);
  return first <= max_ease_share * second || first == 0;
}

KeysOnFrames keys_on_frames(const RowsOnFrames& rows, std::int32_t min_hold,
                            const std::function<void(double)>& progress) {
  const auto last = static_cast<std::int32_t>(rows.rows.front().size()) - 1;
  KeysOnFrames found;
  for (const std::vector<double>& axis : rows.rows) {
    found.rests_at_start = found.rests_at_start && rows_rest_at_start(axis);
    found.rests_at_end = found.rests_at_end && rows_rest_at_start(std::vector(axis.rbegin(), axis.rend()));
  }
  const auto add_key = [&](std::int32_t frame, const auto& position_of) {
    found.frames.push_back(frame);
    std::vector<double>& at = found.at.emplace_back();
    for (std::size_t a = 0; a < rows.rows.size(); ++a) at.push_back(position_of(a));
  };
  const auto as_row = [&](std::int32_t frame) {
    return [&rows, frame](std::size_t a) { return rows.rows[a][static_cast<std::size_t>(frame)]; };
  };
  std::vector<Hold> holds = holds_of(rows, min_hold);
  holds.push_back({last, last});
  std::int32_t begin = 0;
  bool is_behind_hold = false;
  for (const Hold& hold : holds) {
    if (hold.first > begin) {
      const KeyedCurves curves =
          fewest_keys(rows,
                      KeyedCurves(rows, begin, hold.first, is_behind_hold || found.rests_at_start,
                                  hold.first < last || found.rests_at_end),
                      [&](double share) { progress((begin + share * (hold.first - begin)) / last); });
      found.worst = std::max(found.worst, curves.worst());
      for (const std::int32_t frame : curves.keys()) {
        if (frame == begin && is_behind_hold) continue;
        add_key(frame, [&](std::size_t a) { return curves.position(a, frame); });
      }
    } else if (begin == 0 && !is_behind_hold) {
      add_key(0, as_row(0));
    }
    if (hold.last > hold.first) add_key(hold.last, as_row(hold.last));
    is_behind_hold = true;
    begin = hold.last;
    progress(static_cast<double>(begin) / last);
  }
  return found;
}

}  // namespace inbetween
