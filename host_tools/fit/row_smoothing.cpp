#include "host_tools/fit/row_smoothing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "host_tools/numerics/band_program.hpp"

namespace inbetween {
namespace {

/// Rows on either side that say what a row should be. The cost of a third difference falls by a thousand
/// within six rows: RowSmoothing.ASpikeIsNamedAtEitherEndAsWell.
constexpr std::size_t rows_around = 8;
/// Without the rows of a spike the sum of squares falls to less than this share:
/// RowSmoothing.CornersAndFastPassagesAreNoSpikes.
constexpr double spike_share = 0.25;
/// Or to less than this one, and then to less than this share of what is left with a corner there:
/// RowSmoothingProperty.AFlatSpotHardlyEverDoublesTheAcceleration.
constexpr double clear_share = 0.06;
/// A true corner leaves nothing.
constexpr double corner_share = 0.75;
/// A spike is farther off than this share of the resolution. Half of it is the rounding of the row, and the
/// rest the rounding of its neighbours: RowSmoothingProperty.RoundedRowsHaveNoSpikes.
constexpr double min_off = 1.25;
/// What the square of a change costs, so that rows about which nothing else is said stay as they are.
constexpr double as_they_are = 1e-12;
/// Of the first and last rows, which only the rows on one side contradict.
constexpr double min_off_at_end = 4;
/// The linear parts of a third difference that a row at an end has fewer of.
constexpr std::size_t rows_at_end = 2;
/// A fourth difference so many times the usual one around it is looked at.
constexpr double unusual = 4;
/// A third difference at an end below this share of the resolution is no jolt, but the rounding of its rows.
constexpr double min_jolt = 0.1;
/// More equal rows than these are a rest.
constexpr std::size_t max_repeated = 6;
/// Rows that are equal for so long are a hold, and no turning point: RowSmoothing.AHoldStaysWhereItIs.
constexpr std::size_t min_hold_rows = 6;
/// And so many times as long as the runs of equal rows beside them. Beside a turning point they are 2.7 times
/// as long, in an even motion once.
constexpr std::size_t times_longer = 4;
/// Each round finds the spikes that stronger ones hid.
constexpr int max_spike_rounds = 4;

constexpr std::array<double, 4> third_difference{-1, 3, -3, 1};
/// A third difference is of so many rows.
constexpr std::size_t rows_of_a_difference = third_difference.size();

enum class RowRole : unsigned char {
  bounded,  ///< within half the resolution
  kept,     ///< exactly as it is
  freed,    ///< anywhere
};

struct RowProgram {
  std::span<const double> rows;
  std::vector<RowRole> roles;
  std::vector<bool> is_corner = {};  ///< no smoothness is asked there; empty: nowhere
  double resolution = 1;
  bool rests_at_start = false, rests_at_end = false;
  RowRange range = {};
};

struct RowSolution {
  std::vector<double> rows;
  double cost = 0;  ///< the sum of squared third differences, in resolutions
};

/// Whether a difference of rows first..first+3 goes across a corner.
bool crosses_corner(const RowProgram& program, std::ptrdiff_t first) {
  if (program.is_corner.empty()) return false;
  for (std::ptrdiff_t row = first + 1; row <= first + 2; ++row) {
    if (row >= 0 && row < std::ssize(program.rows) && program.is_corner[static_cast<std::size_t>(row)])
      return true;
  }
  return false;
}

/// Beyond an end that rests the rows go on as its own value.
std::size_t row_within(std::ptrdiff_t row, std::size_t count) {
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(row, 0, static_cast<std::ptrdiff_t>(count) - 1));
}

/// The third difference of rows d..d+3, in resolutions.
double difference_at(const RowProgram& program, std::span<const double> rows, std::ptrdiff_t d) {
  double sum = 0;
  for (std::size_t i = 0; i < third_difference.size(); ++i)
    sum += third_difference[i] * rows[row_within(d + static_cast<std::ptrdiff_t>(i), rows.size())];
  return sum / program.resolution;
}

/// Of all differences that count, in order.
template <typename Visit>
void for_each_difference(const RowProgram& program, const Visit& visit) {
  const std::ptrdiff_t beyond = 2;
  const std::ptrdiff_t end = std::ssize(program.rows) - 3 + (program.rests_at_end ? beyond : 0);
  for (std::ptrdiff_t d = program.rests_at_start ? -beyond : 0; d < end; ++d) {
    if (!crosses_corner(program, d)) visit(d);
  }
}

/// An unknown for every row that may change: by how much, in resolutions.
std::vector<std::optional<std::size_t>> unknowns_of(const RowProgram& program) {
  std::vector<std::optional<std::size_t>> unknowns(program.rows.size());
  std::size_t count = 0;
  for (std::size_t row = 0; row < unknowns.size(); ++row) {
    if (program.roles[row] != RowRole::kept) unknowns[row] = count++;
  }
  return unknowns;
}

std::vector<Term> terms_of_difference(const std::vector<std::optional<std::size_t>>& unknowns,
                                      std::ptrdiff_t d) {
  std::vector<Term> terms;
  for (std::size_t i = 0; i < third_difference.size(); ++i) {
    const auto& unknown = unknowns[row_within(d + static_cast<std::ptrdiff_t>(i), unknowns.size())];
    if (!unknown) continue;
    const auto same = std::ranges::find(terms, *unknown, &Term::unknown);
    if (same == terms.end()) {
      terms.push_back({*unknown, third_difference[i]});
    } else {
      same->weight += third_difference[i];
    }
  }
  return terms;
}

/// By how much a row may change, in resolutions.
struct ChangeBounds {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

ChangeBounds bounds_of(const RowProgram& program, std::size_t row) {
  ChangeBounds bounds;
  const double at = program.rows[row];
  if (at >= program.range.min && at <= program.range.max) {
    bounds = {(program.range.min - at) / program.resolution, (program.range.max - at) / program.resolution};
  }
  if (program.roles[row] == RowRole::freed) return bounds;
  return {std::max(bounds.min, -0.5), std::min(bounds.max, 0.5)};
}

RowSolution solved_rows(const RowProgram& asked) {
  const auto unknowns = unknowns_of(asked);
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(unknowns, [](const auto& unknown) { return unknown.has_value(); }));
  BandProgram program(count);
  for_each_difference(asked, [&](std::ptrdiff_t d) {
    const std::vector<Term> terms = terms_of_difference(unknowns, d);
    program.add_cost(terms, terms, 1);
    program.add_gain(terms, -difference_at(asked, asked.rows, d));
  });
  for (std::size_t row = 0; row < unknowns.size(); ++row) {
    if (!unknowns[row]) continue;
    const std::array change{Term{*unknowns[row], 1}};
    program.add_cost(change, change, as_they_are);
    const ChangeBounds bounds = bounds_of(asked, row);
    if (std::isfinite(bounds.min)) program.demand_at_least(change, bounds.min);
    if (std::isfinite(bounds.max)) program.demand_at_least(std::array{Term{*unknowns[row], -1}}, -bounds.max);
  }
  RowSolution found{.rows = {asked.rows.begin(), asked.rows.end()}};
  if (count > 0 && !program.solve(std::vector<double>(count))) {
    // The rows as they are keep all conditions: only rounding hides the answer.
    throw std::runtime_error(
        "the rows cannot be made smooth; state a resolution that is nearer to their own");
  }
  for (std::size_t row = 0; row < unknowns.size(); ++row) {
    if (!unknowns[row]) continue;
    const double change = program.value(std::array{Term{*unknowns[row], 1}});
    const ChangeBounds bounds = bounds_of(asked, row);
    // Rounding may leave it beyond its bound.
    found.rows[row] += asked.resolution * std::clamp(change, bounds.min, bounds.max);
  }
  for_each_difference(
      asked, [&](std::ptrdiff_t d) { found.cost += std::pow(difference_at(asked, found.rows, d), 2); });
  return found;
}

/// What is known of the rows as a whole.
struct KnownOfRows {
  bool rests_at_start = false, rests_at_end = false;
  std::vector<RowSpike> spikes = {};
};

/// Rows that stand still for long between rows that do not are kept, but for those at either end of them, in
/// which the axis may still come to rest: a hold does not drift within its rounding. A slow motion has a long
/// run of equal rows beside another.
void keep_holds(RowProgram& program) {
  struct Run {
    std::size_t first = 0, count = 0;
  };
  std::vector<Run> runs;
  for (std::size_t row = 0; row < program.rows.size(); ++row) {
    if (runs.empty() || program.rows[row] != program.rows[runs.back().first]) runs.push_back({row, 0});
    ++runs.back().count;
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::size_t before = i > 0 ? runs[i - 1].count : 0;
    const std::size_t behind = i + 1 < runs.size() ? runs[i + 1].count : 0;
    if (runs[i].count < min_hold_rows || runs[i].count < times_longer * std::max(before, behind)) continue;
    const std::size_t first = runs[i].first + 2 * before;
    const std::size_t end = runs[i].first + runs[i].count - std::min(runs[i].count, 2 * behind);
    for (std::size_t row = first; row < end; ++row) program.roles[row] = RowRole::kept;
  }
}

RowProgram whole_program(std::span<const double> rows, double resolution, const KnownOfRows& known,
                         const RowRange& range = {}) {
  RowProgram program{.rows = rows,
                     .roles = std::vector<RowRole>(rows.size(), RowRole::bounded),
                     .resolution = resolution,
                     .rests_at_start = known.rests_at_start,
                     .rests_at_end = known.rests_at_end,
                     .range = range};
  if (known.rests_at_start) program.roles[0] = program.roles[1] = RowRole::kept;
  if (known.rests_at_end) program.roles[rows.size() - 1] = program.roles[rows.size() - 2] = RowRole::kept;
  keep_holds(program);
  for (const RowSpike& spike : known.spikes) {
    for (std::size_t row = spike.first; row < spike.first + spike.count; ++row)
      program.roles[row] = RowRole::freed;
  }
  return program;
}

/// A part of a program: the rows around some that are looked at.
struct RowWindow {
  std::size_t first = 0, end = 0;
};

RowWindow window_around(std::size_t row, std::size_t count, std::size_t rows) {
  return {row > rows_around ? row - rows_around : 0, std::min(rows, row + count + rows_around)};
}

RowProgram part_of(const RowProgram& whole, const RowWindow& window) {
  const std::size_t count = window.end - window.first;
  return {.rows = whole.rows.subspan(window.first, count),
          .roles = {whole.roles.begin() + static_cast<std::ptrdiff_t>(window.first),
                    whole.roles.begin() + static_cast<std::ptrdiff_t>(window.end)},
          .resolution = whole.resolution,
          .rests_at_start = window.first == 0 && whole.rests_at_start,
          .rests_at_end = window.end == whole.rows.size() && whole.rests_at_end,
          .range = whole.range};
}

/// Two equal rows at an end are a rest, unless they are two rows of a motion that were rounded to one number:
/// then a rest would be one jolt, and the rows behind it go on evenly.
bool is_rest(std::span<const double> rows, double resolution, bool is_start) {
  const std::size_t count = std::min(rows.size(), 3 * rows_around);
  std::vector<double> outwards(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(count));
  if (!is_start)
    std::ranges::copy(rows.rbegin(), rows.rbegin() + static_cast<std::ptrdiff_t>(count), outwards.begin());
  if (outwards[0] != outwards[1]) return false;
  if (std::fabs(outwards[2] - outwards[1]) > min_off * resolution) return true;
  const RowProgram program = whole_program(outwards, resolution, {.rests_at_start = true});
  const std::vector<double> resting = solved_rows(program).rows;
  double jolt = 0, behind = 0;
  for_each_difference(program, [&](std::ptrdiff_t d) {
    double& largest = d < static_cast<std::ptrdiff_t>(rows_of_a_difference) ? jolt : behind;
    largest = std::max(largest, std::fabs(difference_at(program, resting, d)));
  });
  return jolt < min_jolt || jolt < unusual * behind;
}

struct FoundSpike {
  RowSpike spike;
  double gain = 0;  ///< the cost with its rows over that without them
};

/// Whether rows first..first+count-1 are a spike.
std::optional<FoundSpike> spike_at(const RowProgram& whole, std::size_t first, std::size_t count) {
  const RowWindow window = window_around(first, count, whole.rows.size());
  const RowProgram program = part_of(whole, window);
  const double cost = solved_rows(program).cost;
  const std::size_t begin = first - window.first;
  RowProgram without = program;
  for (std::size_t row = begin; row < begin + count; ++row) without.roles[row] = RowRole::freed;
  const RowSolution freed = solved_rows(without);
  if (!(freed.cost < spike_share * cost)) return std::nullopt;
  double off = 0;
  for (std::size_t row = begin; row < begin + count; ++row) {
    const double by = program.rows[row] - freed.rows[row];
    if (std::fabs(by) > std::fabs(off)) off = by;
  }
  const bool is_at_end = first < rows_at_end || first + count + rows_at_end > whole.rows.size();
  if (!(std::fabs(off) > (is_at_end ? min_off_at_end : min_off) * whole.resolution)) return std::nullopt;
  RowProgram cornered = program;
  cornered.is_corner.assign(program.rows.size(), false);
  if (begin > 0 && count > 1) cornered.is_corner[begin - 1] = true;
  cornered.is_corner[begin + count - 1] = true;
  // Two corners in a turn explain nearly all that a turn may do, and then the cost without the rows decides.
  const double as_corner = solved_rows(cornered).cost;
  const bool is_no_corner = freed.cost < spike_share * as_corner ||
                            (freed.cost < clear_share * cost && freed.cost < corner_share * as_corner);
  if (!is_no_corner) return std::nullopt;
  // All that is left is the rounding of so many sums.
  const double least_cost = 1e-12;
  return FoundSpike{{.first = first, .count = count, .off = off}, cost / std::max(freed.cost, least_cost)};
}

/// Rows at which the smooth rows still bend in an unusual way.
std::vector<std::size_t> suspects(std::span<const double> rows) {
  std::vector<double> bends(rows.size());
  for (std::size_t i = 2; i + 2 < rows.size(); ++i)
    bends[i] = std::fabs(rows[i - 2] - 4 * rows[i - 1] + 6 * rows[i] - 4 * rows[i + 1] + rows[i + 2]);
  std::vector<std::size_t> found;
  std::vector<double> near;
  const std::size_t reach = 3 * rows_around;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t first = i > 2 ? i - 2 : 0;
    const std::size_t end = std::min(rows.size(), i + 3);
    double bend = 0;
    for (std::size_t k = first; k < end; ++k) bend = std::max(bend, bends[k]);
    if (bend == 0) continue;
    const std::size_t low = i > reach ? i - reach : 0;
    const std::size_t high = std::min(rows.size(), i + reach + 1);
    near.assign(bends.begin() + static_cast<std::ptrdiff_t>(low),
                bends.begin() + static_cast<std::ptrdiff_t>(high));
    const auto middle = near.begin() + std::ssize(near) / 2;
    std::ranges::nth_element(near, middle);
    if (bend > unusual * *middle) found.push_back(i);
  }
  return found;
}

/// How many rows from `row` on repeat the row before it.
std::size_t repeats_at(std::span<const double> rows, std::size_t row) {
  std::size_t count = 0;
  while (row > 0 && row + count < rows.size() && rows[row + count] == rows[row - 1]) ++count;
  return count;
}

bool is_part_of_a_spike(std::span<const RowSpike> spikes, std::size_t row) {
  return std::ranges::any_of(
      spikes, [&](const RowSpike& spike) { return row >= spike.first && row < spike.first + spike.count; });
}

/// The strongest spikes of a program, none within the rows around another.
std::vector<RowSpike> strongest_spikes(const RowProgram& program, std::span<const double> smooth,
                                       std::span<const RowSpike> known) {
  std::vector<FoundSpike> found;
  for (const std::size_t row : suspects(smooth)) {
    if (is_part_of_a_spike(known, row) || program.roles[row] != RowRole::bounded) continue;
    if (const auto spike = spike_at(program, row, 1)) found.push_back(*spike);
    const std::size_t repeats = repeats_at(program.rows, row);
    if (repeats < 2 || repeats > max_repeated || row + repeats >= program.rows.size()) continue;
    if (const auto spike = spike_at(program, row, repeats)) found.push_back(*spike);
  }
  std::ranges::stable_sort(found, std::ranges::greater{}, &FoundSpike::gain);
  std::vector<RowSpike> strongest;
  for (const FoundSpike& candidate : found) {
    const bool is_alone = std::ranges::none_of(strongest, [&](const RowSpike& other) {
      return candidate.spike.first < other.first + other.count + rows_around &&
             other.first < candidate.spike.first + candidate.spike.count + rows_around;
    });
    if (is_alone) strongest.push_back(candidate.spike);
  }
  return strongest;
}

}  // namespace

SmoothRows smooth_rows(std::span<const double> rows, double resolution, const RowRange& range) {
  SmoothRows found{.rows = {rows.begin(), rows.end()}, .spikes = {}};
  if (rows.size() < rows_of_a_difference) return found;
  KnownOfRows known{.rests_at_start = is_rest(rows, resolution, true),
                    .rests_at_end = is_rest(rows, resolution, false)};
  for (int round = 0;; ++round) {
    const RowProgram program = whole_program(rows, resolution, known, range);
    found.rows = solved_rows(program).rows;
    if (round == max_spike_rounds) break;
    const std::vector<RowSpike> more = strongest_spikes(program, found.rows, known.spikes);
    if (more.empty()) break;
    known.spikes.insert(known.spikes.end(), more.begin(), more.end());
  }
  found.spikes = std::move(known.spikes);
  std::ranges::sort(found.spikes, {}, &RowSpike::first);
  return found;
}

double largest_second_difference(std::span<const double> rows) {
  double largest = 0;
  for (std::size_t i = 1; i + 1 < rows.size(); ++i)
    largest = std::max(largest, std::fabs(rows[i - 1] - 2 * rows[i] + rows[i + 1]));
  return largest;
}

}  // namespace inbetween
