#include "host_tools/plan/passed_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "host_tools/numerics/hypotenuse.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// Nobody reads more lines of one track.
constexpr std::size_t max_lines = 20;
/// Of a tolerance: a corner that uses less is short of legs (Round.HalfOfTheShorterLegIsTheMostThatIsUsed),
/// and the rest is rounding.
constexpr double used_share = 1 - 1e-9;

std::string unit_of_axis(const Plan& plan, std::size_t track, std::size_t axis) {
  const auto planned = std::ranges::find_if(
      plan.axes(), [&](const PlanAxis& one) { return one.track == track && one.track_axis == axis; });
  const std::string unit = unit_of(*planned);
  return unit.empty() ? "" : " " + unit;
}

/// "pan by 0.42 deg and tilt by -0.13 deg"
std::string axes_in_words(const PassedKey& key, const Plan& plan, std::size_t track) {
  std::vector<std::string> words;
  for (std::size_t d = 0; d < key.missed.size(); ++d) {
    if (key.missed[d] == 0) continue;
    words.push_back(fmt::format("{} by {:.4g}{}", plan.move().tracks[track].axes[d], key.missed[d],
                                unit_of_axis(plan, track, d)));
  }
  return listed_with_and(words);
}

std::string in_words(const PassedKey& key, const Plan& plan, std::size_t track) {
  if (!(key.tolerance > 0))
    return fmt::format("key {} is missed on frame {:g}: {}", key.key, key.frame,
                       axes_in_words(key, plan, track));
  const std::string unit = plan.length_unit(track);
  const std::string space = unit.empty() ? "" : " " + unit;
  const bool is_short = key.distance < key.tolerance * used_share;
  return fmt::format(
      "key {} is missed by {:.4g}{} near frame {:.1f}{}", key.key, key.distance, space, key.frame,
      is_short ? fmt::format("; half of its shorter leg is used, and a round of {:g} would need more",
                             key.tolerance)
               : "");
}

/// A locked key is on its own frame: where the speed is 0, a place is passed at many moments.
double frame_of(const SolvedTrack& solved, std::int32_t segment, std::int32_t key) {
  if (const std::optional<KeyTiming>& timing = solved.key_timing()) {
    const auto lock = std::ranges::find(timing->locks, key, &KeyLock::key);
    if (lock != timing->locks.end()) return timing->frame_of(*lock, solved.track().frames());
  }
  return frame_of_segment(solved.track(), segment);
}

}  // namespace

std::vector<PassedKey> passed_keys(const Plan& plan, std::size_t track) {
  const MoveTrack& written = plan.move().tracks[track];
  std::vector<PassedKey> passed;
  if (!has_overlap(written) && !has_round(written)) return passed;
  const Track& solved = plan.tracks()[track].track();
  const Path& path = solved.path();
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    const std::optional<std::int32_t> number = path.key_at(i);
    if (!number) continue;
    const MoveKey& key = written.keys[static_cast<std::size_t>(*number)];
    PassedKey found{.key = static_cast<std::size_t>(*number), .tolerance = round_of(written, key)};
    for (std::size_t d = 0; d < key.at.size(); ++d) {
      found.missed.push_back(path.segment(i)[d].c0 - key.at[d]);
      found.distance = hypotenuse(found.distance, path.weights()[d] * found.missed.back());
    }
    if (std::ranges::all_of(found.missed, [](double missed) { return missed == 0; })) continue;
    found.frame = frame_of(plan.tracks()[track], i, *number);
    passed.push_back(std::move(found));
  }
  return passed;
}

void print_passed(const Plan& plan, std::size_t track, std::string_view indent, std::FILE* out) {
  std::vector<PassedKey> passed = passed_keys(plan, track);
  const std::size_t all = passed.size();
  if (all > max_lines) {
    std::ranges::stable_sort(passed, std::ranges::greater{}, &PassedKey::distance);
    passed.resize(max_lines);
    std::ranges::sort(passed, {}, &PassedKey::key);
  }
  for (const PassedKey& key : passed) fmt::print(out, "{}{}\n", indent, in_words(key, plan, track));
  if (all > max_lines)
    fmt::print(out, "{}and {} more keys, which are missed by less\n", indent, all - max_lines);
}

}  // namespace inbetween
