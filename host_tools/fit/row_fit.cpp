#include "host_tools/fit/row_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "host_tools/fit/motion_fit.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_rows.hpp"

namespace inbetween {
namespace {

/// A path and its pace are looked for as a whole, in a time that grows with rows and keys. A move of more
/// rows than this is no drawn move.
constexpr std::size_t max_drawn_rows = 2'000;
/// Pairs of axes are tried in so many numbers of the table at most: their number grows with its square.
constexpr std::size_t max_paired_numbers = 50'000;
/// What is looked for first is as near as the whole tolerance; then nearer, where path and pace together
/// missed more.
constexpr std::array<double, 3> tolerance_shares{1, 0.5, 0.25};
/// Numbers are written to this share of the tolerance.
constexpr double written_share = 1e-3;
/// A curve of fewer decimals may miss this share of the tolerance:
/// RowFit.ADrawnMoveHasItsKeysAndItsSpeedCurveAgain.
constexpr double brief_share = 0.1;
/// Where axes stay for so long, in seconds, they hold, and get two keys: RowFit.AHoldHasAKeyOnEitherSide.
constexpr double min_hold_s = 0.25;
/// And no shorter than this: rounding makes a turning point as flat.
constexpr std::int32_t min_hold_frames = 6;

/// How much axes may count as distance beside the one that goes farthest. People draw with small whole
/// numbers, and only with the drawn weights is a path that of as few keys.
constexpr std::array<double, 3> weights_at_first{1, 3, 10};
constexpr std::array<double, 10> weights_at_last{1, 2, 3, 4, 5, 6, 8, 10, 12, 20};

/// For one axis alone nothing else is known to be better.
constexpr std::size_t any_number = std::numeric_limits<std::size_t>::max();

using AxisSet = std::vector<std::size_t>;

struct FittedGroup {
  MoveTrack track;
  std::vector<double> worst;  // of each axis of the group
  std::size_t numbers = 0;
};

/// With as many digits as the tolerance asks for.
double rounded_to(double value, double tolerance) {
  const double step = std::pow(10.0, std::floor(std::log10(tolerance * written_share)));
  const double rounded = step >= 1 ? std::round(value / step) * step
                                   : std::round(value * std::round(1 / step)) / std::round(1 / step);
  return rounded == 0 ? 0 : rounded;
}

class RowGroups {
 public:
  RowGroups(const RowsToFit& rows, const std::function<void(double)>& progress)
      : rows_(rows), progress_(progress) {}

  RowFit fit();

 private:
  [[nodiscard]] std::size_t row_count() const { return rows_.table.rows.front().size(); }
  [[nodiscard]] RowsOnFrames table_of(const AxisSet& axes) const;
  [[nodiscard]] MoveTrack track_of(const AxisSet& axes) const;
  [[nodiscard]] MoveFile move_of(std::vector<MoveTrack> tracks) const;
  [[nodiscard]] std::vector<double> misses_of(const MoveTrack& track, const AxisSet& axes) const;
  [[nodiscard]] bool is_met(const std::vector<double>& misses, const AxisSet& axes) const;
  void write_curve_briefly(MoveTrack& track, std::vector<double>& misses, const AxisSet& axes) const;
  [[nodiscard]] std::vector<double> weights_of(const AxisSet& axes, double beside_the_farthest) const;
  [[nodiscard]] std::optional<FittedGroup> drawn_with(const AxisSet& axes, const std::vector<double>& weights,
                                                      std::size_t max_numbers) const;
  [[nodiscard]] std::optional<FittedGroup> drawn(const AxisSet& axes, std::span<const double> weights,
                                                 std::size_t max_numbers) const;
  [[nodiscard]] std::optional<FittedGroup> on_frames(const AxisSet& axes) const;
  [[nodiscard]] FittedGroup fitted(const AxisSet& axes, std::size_t max_drawn_numbers) const;
  void try_other_weights(std::map<AxisSet, FittedGroup>& groups) const;

  const RowsToFit& rows_;
  const std::function<void(double)>& progress_;
  double begun_ = 0, share_ = 1;  // of the work: what is done, and what is being done
};

RowsOnFrames RowGroups::table_of(const AxisSet& axes) const {
  RowsOnFrames table;
  for (const std::size_t axis : axes) {
    table.rows.push_back(rows_.table.rows[axis]);
    table.tolerances.push_back(rows_.table.tolerances[axis]);
  }
  return table;
}

MoveTrack RowGroups::track_of(const AxisSet& axes) const {
  MoveTrack track;
  for (const std::size_t axis : axes) {
    track.axes.push_back(rows_.axes[axis]);
    track.axis_places.emplace_back();
  }
  return track;
}

MoveFile RowGroups::move_of(std::vector<MoveTrack> tracks) const {
  return {.path = {},
          .name = {},
          .fps = rows_.fps,
          .frames = static_cast<std::int32_t>(row_count()) - 1,
          .tracks = std::move(tracks),
          .frames_place = {}};
}

std::vector<double> RowGroups::misses_of(const MoveTrack& track, const AxisSet& axes) const {
  const Plan plan(move_of({track}), std::nullopt, {});
  std::vector<double> misses;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const AxisColumn column(plan, plan.axes()[a], PlanRows::frame);
    double worst = 0;
    for (std::size_t row = 0; row < row_count(); ++row) {
      const double position = column.position(static_cast<std::int64_t>(row));
      worst = std::max(worst, std::fabs(position - rows_.table.rows[axes[a]][row]));
    }
    misses.push_back(worst);
  }
  return misses;
}

bool RowGroups::is_met(const std::vector<double>& misses, const AxisSet& axes) const {
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (!(misses[a] <= rows_.table.tolerances[axes[a]])) return false;
  }
  return true;
}

/// With the fewest decimals that hardly take it further from the rows: 8 and not 8.00003, which is what
/// somebody has drawn.
void RowGroups::write_curve_briefly(MoveTrack& track, std::vector<double>& misses,
                                    const AxisSet& axes) const {
  const std::vector<double> exact = track.speed;
  for (const double digits : {1.0, 10.0, 100.0, 1'000.0}) {
    for (std::size_t i = 0; i < exact.size(); ++i) track.speed[i] = std::round(exact[i] * digits) / digits;
    try {
      std::vector<double> brief = misses_of(track, axes);
      bool is_as_near = true;
      for (std::size_t a = 0; a < axes.size(); ++a)
        is_as_near =
            is_as_near && brief[a] <= std::max(misses[a], brief_share * rows_.table.tolerances[axes[a]]);
      if (!is_as_near) continue;
      misses = std::move(brief);
      return;
    } catch (const InputError&) {
      // Rounded, the curve is 0 where it may not be.
    }
  }
  track.speed = exact;
}

std::vector<double> RowGroups::weights_of(const AxisSet& axes, double beside_the_farthest) const {
  std::vector<double> weights;
  std::size_t farthest = 0;
  double most = -1;
  for (const std::size_t axis : axes) {
    const auto [low, high] = std::ranges::minmax(rows_.table.rows[axis]);
    if (high - low > most) most = high - low, farthest = weights.size();
    weights.push_back(beside_the_farthest);
  }
  weights[farthest] = 1;
  return weights;
}

/// One path and one speed curve, with at most so many numbers.
std::optional<FittedGroup> RowGroups::drawn_with(const AxisSet& axes, const std::vector<double>& weights,
                                                 std::size_t max_numbers) const {
  const double fps = rows_.fps.rate.frames_per_second();
  for (const double share : tolerance_shares) {
    SampledMotion sampled{.times = {},
                          .positions = {},
                          .tolerances = {},
                          .weights = weights,
                          .frames_per_second = fps,
                          .is_exact = true,
                          .max_numbers = max_numbers};
    for (std::size_t row = 0; row < row_count(); ++row) {
      sampled.times.push_back(static_cast<double>(row) / fps);
      for (const std::size_t axis : axes) sampled.positions.push_back(rows_.table.rows[axis][row]);
    }
    for (const std::size_t axis : axes) sampled.tolerances.push_back(share * rows_.table.tolerances[axis]);
    try {
      const MotionFit fit = fit_motion(sampled);
      MoveTrack track = track_of(axes);
      track.speed = fit.speed;
      track.speed_places.resize(fit.speed.size());
      if (std::ranges::any_of(weights, [](double weight) { return weight != 1; })) {
        track.weights = weights;
        track.weight_places.resize(weights.size());
      }
      for (const std::vector<double>& at : fit.keys) {
        MoveKey& key = track.keys.emplace_back();
        for (std::size_t a = 0; a < axes.size(); ++a)
          key.at.push_back(rounded_to(at[a], rows_.table.tolerances[axes[a]]));
        key.at_places.resize(axes.size());
      }
      std::vector<double> misses = misses_of(track, axes);
      if (!is_met(misses, axes)) continue;
      write_curve_briefly(track, misses, axes);
      const std::size_t numbers = fit.keys.size() * axes.size() + fit.speed.size();
      return FittedGroup{std::move(track), std::move(misses), numbers};
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // too few rows, nothing moves, or too many numbers
    } catch (const InputError&) {
      // Two keys are so near that there is no path: nearer to the rows they are others.
    }
  }
  return std::nullopt;
}

std::optional<FittedGroup> RowGroups::drawn(const AxisSet& axes, std::span<const double> weights,
                                            std::size_t max_numbers) const {
  std::optional<FittedGroup> best;
  for (const double weight : axes.size() == 1 ? weights.first(1) : weights) {
    std::optional<FittedGroup> found = drawn_with(axes, weights_of(axes, weight), max_numbers);
    if (!found || found->numbers > max_numbers) continue;
    max_numbers = found->numbers - 1;
    best = std::move(found);
  }
  return best;
}

/// Keys on frames.
std::optional<FittedGroup> RowGroups::on_frames(const AxisSet& axes) const {
  const auto min_hold = std::max(
      min_hold_frames, static_cast<std::int32_t>(std::ceil(min_hold_s * rows_.fps.rate.frames_per_second())));
  for (const double share : tolerance_shares) {
    RowsOnFrames table = table_of(axes);
    // Room for the digits that are not written, and for what the played trajectory is off.
    for (double& tolerance : table.tolerances) tolerance *= share * (1 - 10 * written_share);
    const KeysOnFrames found =
        keys_on_frames(table, min_hold, [&](double part) { progress_(begun_ + part * share_); });
    if (found.frames.size() > max_keys) {
      throw std::runtime_error(
          fmt::format("\"{}\" would need {} keys, and a track has at most {}; allow more",
                      rows_.axes[axes.front()], found.frames.size(), max_keys));
    }
    MoveTrack track = track_of(axes);
    track.timing = Timing::frames;
    if (!found.rests_at_start || !found.rests_at_end)
      track.rest = RestingEnds{found.rests_at_start, found.rests_at_end};
    for (std::size_t k = 0; k < found.frames.size(); ++k) {
      MoveKey& key = track.keys.emplace_back();
      key.frame = found.frames[k];
      for (std::size_t a = 0; a < axes.size(); ++a)
        key.at.push_back(rounded_to(found.at[k][a], rows_.table.tolerances[axes[a]]));
      key.at_places.resize(axes.size());
    }
    std::vector<double> misses = misses_of(track, axes);
    if (!is_met(misses, axes)) continue;
    const std::size_t numbers = found.frames.size() * (axes.size() + 1);
    return FittedGroup{std::move(track), std::move(misses), numbers};
  }
  return std::nullopt;
}

/// `max_drawn_numbers`: a path with its curve is looked for only with so many.
FittedGroup RowGroups::fitted(const AxisSet& axes, std::size_t max_drawn_numbers) const {
  std::optional<FittedGroup> best = on_frames(axes);
  if (best) max_drawn_numbers = std::min(max_drawn_numbers, best->numbers - 1);
  if (row_count() <= max_drawn_rows) {
    std::optional<FittedGroup> other = drawn(axes, weights_at_first, max_drawn_numbers);
    if (other) best = std::move(other);
  }
  if (!best) {
    throw std::runtime_error(fmt::format(
        "no keys keep \"{}\" within the tolerance on every frame; allow more", rows_.axes[axes.front()]));
  }
  return std::move(*best);
}

/// When it is known which axes share a track.
void RowGroups::try_other_weights(std::map<AxisSet, FittedGroup>& groups) const {
  if (row_count() > max_drawn_rows) return;
  for (auto& [axes, group] : groups) {
    if (axes.size() == 1) continue;
    if (std::optional<FittedGroup> other = drawn(axes, weights_at_last, group.numbers - 1))
      group = std::move(*other);
  }
}

RowFit RowGroups::fit() {
  const std::size_t count = rows_.axes.size();
  std::map<AxisSet, FittedGroup> groups;
  // Pairs take about as long as the axes alone, and about two thirds of them are tried again with a third
  // axis.
  const bool pairs = count > 1 && count * row_count() <= max_paired_numbers;
  share_ = (pairs ? 0.5 : 1) / static_cast<double>(count);
  for (std::size_t axis = 0; axis < count; ++axis) {
    begun_ = share_ * static_cast<double>(axis);
    groups.emplace(AxisSet{axis}, fitted({axis}, any_number));
  }
  begun_ = 0.5;
  share_ = 0.3 / static_cast<double>(count * count);
  std::map<AxisSet, FittedGroup> tried;
  while (pairs) {
    const FittedGroup* best = nullptr;
    AxisSet best_axes, best_one, best_other;
    std::size_t most = 0;
    for (auto one = groups.begin(); one != groups.end(); ++one) {
      for (auto other = std::next(one); other != groups.end(); ++other) {
        AxisSet axes = one->first;
        axes.insert(axes.end(), other->first.begin(), other->first.end());
        std::ranges::sort(axes);
        auto found = tried.find(axes);
        const std::size_t apart = one->second.numbers + other->second.numbers;
        if (found == tried.end()) {
          found = tried.emplace(axes, fitted(axes, apart - 1)).first;
          begun_ = std::min(begun_ + share_, 1.0);
        }
        if (found->second.numbers + most >= apart) continue;
        most = apart - found->second.numbers;
        best = &found->second;
        best_axes = axes, best_one = one->first, best_other = other->first;
      }
    }
    if (best == nullptr) break;
    groups.erase(best_one);
    groups.erase(best_other);
    groups.emplace(best_axes, *best);
  }
  try_other_weights(groups);
  RowFit found{.move = {}, .worst = std::vector<double>(count), .numbers = 0};
  std::vector<MoveTrack> tracks;
  for (auto& [axes, group] : groups) {
    for (std::size_t a = 0; a < axes.size(); ++a) found.worst[axes[a]] = group.worst[a];
    found.numbers += group.numbers;
    tracks.push_back(std::move(group.track));
  }
  found.move = move_of(std::move(tracks));
  progress_(1);
  return found;
}

}  // namespace

RowFit fit_rows(const RowsToFit& rows, const std::function<void(double)>& progress) {
  return RowGroups(rows, progress).fit();
}

}  // namespace inbetween
