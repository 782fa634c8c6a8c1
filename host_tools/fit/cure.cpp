#include "host_tools/fit/cure.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "host_tools/fit/fewest_fit.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/plan/near_keys.hpp"
#include "host_tools/plan/rest_keys.hpp"

namespace inbetween {
namespace {

/// How often more keys are eased, where the first ones show others. Each round is a solution of the move
/// (find_cure promises fifty at most).
constexpr int max_ease_rounds = 3;
/// The same of keys that are written twice: a round shows one place of each axis, so that more of them are
/// needed (Cure.OfSixKeysThatTurnBackThoseThatNeedItRest needs two).
constexpr int max_rest_rounds = 8;

/// A move that may be better, and what was changed of the one that was refused.
struct Tried {
  MoveFile move;
  std::vector<std::string> words = {};
  Place place = {};
};

std::string keys_in_words(const std::set<std::size_t>& keys) {
  std::vector<std::string> numbers;
  numbers.reserve(keys.size());
  for (const std::size_t key : keys) numbers.push_back(std::to_string(key));
  return fmt::format("key{} {}", keys.size() == 1 ? "" : "s", listed_with_and(numbers));
}

/// The search in one move.
class CureSearch {
 public:
  explicit CureSearch(const Plan& plan) : plan_(plan) {}

  [[nodiscard]] std::optional<Tried> run(const CheckReport& report) const {
    std::set<std::size_t> tracks;
    for (const CheckRefusal& refusal : report.refusals) {
      if (const auto track = plan_.axes()[refusal.axis].track) tracks.insert(*track);
    }
    Tried better{plan_.move()};
    for (const std::size_t track : tracks) {
      std::optional<Tried> cured = cured_track(better, track);
      if (!cured) return std::nullopt;
      better = std::move(*cured);
    }
    return better;
  }
  [[nodiscard]] bool fits(const MoveFile& move) const {
    const std::optional<Judged> whole = judged(move, check_until_refused);
    return whole && whole->report.fits();
  }
  /// The fewest frames of the changed move, if they are fewer than those of the move as it is.
  [[nodiscard]] std::optional<std::int32_t> frames_of(const MoveFile& move,
                                                      const SmallestFrames& as_it_is) const {
    const std::optional<Judged> whole = judged(move, check);
    if (!whole) return std::nullopt;
    const std::optional<std::int32_t> frames = smallest_frames(whole->plan, whole->report, {}).frames;
    return frames && (!as_it_is.frames || *frames < *as_it_is.frames) ? frames : std::nullopt;
  }

 private:
  struct Judged {
    Plan plan;
    CheckReport report;
  };
  [[nodiscard]] std::optional<Judged> judged(const MoveFile& move, CheckReport (*judge)(const Plan&)) const {
    try {
      Plan plan(move, plan_.rig(), {.kinematics = plan_.kinematics()});
      CheckReport report = judge(plan);
      return Judged{std::move(plan), std::move(report)};
    } catch (const InputError&) {  // such a move is none: it is no cure
      return std::nullopt;
    }
  }
  /// The faults of the axes of a track.
  [[nodiscard]] static std::vector<CheckRefusal> refusals_of(const Judged& judged, std::size_t track) {
    std::vector<CheckRefusal> refusals = judged.report.refusals;
    std::erase_if(refusals, [&](const CheckRefusal& refusal) {
      return judged.plan.axes()[refusal.axis].track != track;
    });
    return refusals;
  }

  /// Keys of the track at which an axis steps as its drive cannot. A refusal names the worst one alone.
  [[nodiscard]] static std::vector<std::size_t> keys_that_step(const Judged& judged, std::size_t track) {
    std::vector<std::size_t> keys;
    for (const CheckedStep& step : judged.report.steps) {
      const bool is_refused =
          step.velocity > 0 || breaks_jerk_limit(step, judged.plan.rig()->axes[step.axis]);
      if (step.key && is_refused && judged.plan.axes()[step.axis].track == track)
        keys.push_back(static_cast<std::size_t>(*step.key));
    }
    return keys;
  }

  /// The first change after which no axis of the track is refused; or else the one that needs the least of
  /// slowing down.
  [[nodiscard]] std::optional<Tried> cured_track(const Tried& from, std::size_t track) const {
    // Its keys go together with what is drawn, or are rows.
    if (from.move.tracks[track].network || from.move.tracks[track].table) return std::nullopt;
    using Change = bool (CureSearch::*)(Tried&, std::size_t) const;
    using Self = CureSearch;
    const std::vector<std::vector<Change>> attempts{{&Self::join_near_keys},
                                                    {&Self::ease},
                                                    {&Self::hold},
                                                    {&Self::hold, &Self::ease},
                                                    {&Self::stop_overshoot},
                                                    {&Self::stop_overshoot, &Self::ease},
                                                    {&Self::stop_overshoot, &Self::hold},
                                                    {&Self::stop_overshoot, &Self::hold, &Self::ease},
                                                    {&Self::allow_overshoot},
                                                    {&Self::rest},
                                                    {&Self::allow_overshoot, &Self::rest},
                                                    {&Self::ease_corners},
                                                    {&Self::stop_overshoot, &Self::ease_corners},
                                                    {&Self::smooth},
                                                    {&Self::allow_overshoot, &Self::smooth},
                                                    {&Self::curve},
                                                    {&Self::curve, &Self::rest},
                                                    {&Self::pace},
                                                    {&Self::pace, &Self::ease},
                                                    {&Self::stop_overshoot, &Self::pace, &Self::ease}};
    std::optional<Tried> best;
    double best_rate = 0;
    for (const std::vector<Change>& attempt : attempts) {
      Tried tried = from;
      const bool is_changed =
          std::ranges::all_of(attempt, [&](const Change change) { return (this->*change)(tried, track); });
      if (!is_changed) continue;
      const std::optional<Judged> found = judged(tried.move, check);
      if (!found) continue;
      const std::vector<CheckRefusal> left = refusals_of(*found, track);
      if (left.empty()) return tried;
      if (!std::ranges::all_of(left, &CheckRefusal::slower_helps) || found->report.highest_rate <= best_rate)
        continue;
      best_rate = found->report.highest_rate;
      best = std::move(tried);
    }
    return best;
  }

  static void say(Tried& tried, std::size_t index, const Place& place, std::string words) {
    if (tried.words.empty()) tried.place = place;
    if (tried.move.tracks.size() > 1)
      words += fmt::format(" in the track of {}", in_quotes(tried.move.tracks[index].axes.front()));
    tried.words.push_back(std::move(words));
  }

  bool join_near_keys(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    const std::vector<NearKeys> pairs = near_keys(track);
    for (const NearKeys& pair : pairs) {
      say(tried, index, track.keys[pair.first + 1].place,
          fmt::format("keys {} and {}, which are {} apart, at one place", pair.first, pair.first + 1,
                      plan_.distance_in_words(index, pair)));
      track.keys[pair.first + 1].at = track.keys[pair.first].at;
    }
    return !pairs.empty();
  }

  /// At the keys where axes of the track step, or that are nearest to where they are refused; and where that
  /// shows others, there.
  bool ease(Tried& tried, std::size_t index) const {
    if (!has_speed_curve(tried.move.tracks[index])) return false;
    std::set<std::size_t> eased;
    for (int round = 0; round < max_ease_rounds; ++round) {
      const std::optional<Judged> now = judged(tried.move, check_motion);
      if (!now) break;
      const std::size_t before = eased.size();
      for (const std::size_t k : troubled_keys(*now, index)) {
        MoveKey& key = tried.move.tracks[index].keys[k];
        if (key.ease || key.hold || key.breaks) continue;
        key.ease = true;
        eased.insert(k);
      }
      if (eased.size() == before) break;
    }
    if (eased.empty()) return false;
    say(tried, index, tried.move.tracks[index].keys[*eased.begin()].place,
        "ease = true at " + keys_in_words(eased));
    return true;
  }
  /// At the same keys, where they have frames of their own: the speed can touch 0 on knots of its curve
  /// alone, and such a frame may be on none.
  bool hold(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    if (track.timing != Timing::speed) return false;
    const std::optional<Judged> now = judged(tried.move, check_motion);
    if (!now) return false;
    std::set<std::size_t> held;
    for (const std::size_t k : troubled_keys(*now, index)) {
      MoveKey& key = track.keys[k];
      if (!key.frame || key.hold || key.breaks) continue;
      key.hold = 1;
      key.ease = false;
      held.insert(k);
    }
    if (held.empty()) return false;
    say(tried, index, track.keys[*held.begin()].place, "hold = 1 at " + keys_in_words(held));
    return true;
  }
  /// Between the ends: there ease has no meaning.
  [[nodiscard]] static std::set<std::size_t> troubled_keys(const Judged& judged, std::size_t index) {
    std::set<std::size_t> keys;
    const Track& track = judged.plan.tracks()[index].track();
    const std::size_t last = judged.plan.move().tracks[index].keys.size() - 1;
    for (const CheckRefusal& refusal : refusals_of(judged, index)) {
      const double whole = std::floor(refusal.frame);
      const PathPoint point = track.locate({static_cast<std::int32_t>(whole), refusal.frame - whole});
      const auto nearest = static_cast<std::size_t>(std::lround(track.path().parameter(point)));
      if (nearest > 0 && nearest < last) keys.insert(nearest);
    }
    for (const std::size_t key : keys_that_step(judged, index)) {
      if (key > 0 && key < last) keys.insert(key);
    }
    return keys;
  }

  bool stop_overshoot(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    const bool has_a_meaning = track.spline == Spline::smooth || track.spline == Spline::catmull_rom;
    if (!track.overshoot || !has_a_meaning || track.space) return false;
    track.overshoot = false;
    say(tried, index, track.place, "overshoot = false");
    return true;
  }
  /// Over time what keeps an axis between its keys lets the acceleration step there.
  bool allow_overshoot(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    if (track.overshoot || !is_over_time(track)) return false;
    track.overshoot = true;
    say(tried, index, track.place, "overshoot = true in place of false");
    return true;
  }
  /// At the keys where axes of the track step, and at those between which they leave their range: each is
  /// written twice.
  bool rest(Tried& tried, std::size_t index) const {
    const MoveTrack written = tried.move.tracks[index];
    if (!is_over_time(written) || written.space) return false;
    std::set<std::size_t> resting;
    for (int round = 0; round < max_rest_rounds; ++round) {
      const std::optional<Judged> now = judged(tried.move, check_motion);
      if (!now) break;
      const std::size_t before = resting.size();
      for (const std::int32_t frame : frames_to_rest(*now, index)) {
        const auto key = std::ranges::find(written.keys, frame, &MoveKey::frame);
        if (key != written.keys.end()) resting.insert(static_cast<std::size_t>(key - written.keys.begin()));
      }
      if (resting.size() == before) break;
      tried.move.tracks[index] = written;
      write_twice(tried.move.tracks[index], resting);
    }
    if (resting.empty()) return false;
    say(tried, index, written.keys[*resting.begin()].place, twice_in_words(written, resting));
    return true;
  }
  /// Those of the keys that can rest.
  [[nodiscard]] static std::set<std::int32_t> frames_to_rest(const Judged& judged, std::size_t index) {
    const MoveTrack& track = judged.plan.move().tracks[index];
    const auto is_of_track = [&](std::size_t axis) { return judged.plan.axes()[axis].track == index; };
    std::set<std::int32_t> frames;
    for (const std::size_t key : keys_that_step(judged, index)) {
      if (rest_at_key(track, key)) frames.insert(*track.keys[key].frame);
    }
    for (std::size_t a = 0; a < judged.report.axes.size(); ++a) {
      const CheckedAxis& axis = judged.report.axes[a];
      if (!axis.range || !is_of_track(a)) continue;
      const auto add = [&](double frame, bool low) {
        const auto key = key_to_rest(track, frame, judged.plan.axes()[a].track_axis, low);
        if (key) frames.insert(*track.keys[*key].frame);
      };
      if (axis.range->lowest.value < axis.limit_min) add(axis.range->lowest.frame, true);
      if (axis.range->highest.value > axis.limit_max) add(axis.range->highest.frame, false);
    }
    return frames;
  }
  bool pace(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    if (!is_over_time(track)) return false;
    track.kinetic = MoveKinetic::pace;
    say(tried, index, track.place, "kinetic = \"pace\"");
    return true;
  }
  bool ease_corners(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    if (track.ease_corners || !has_speed_curve(track)) return false;
    track.ease_corners = true;
    say(tried, index, track.place, "corners = \"ease\"");
    return true;
  }
  /// A path that is not straight has no corners to round.
  static void leave_corners(MoveTrack& track) {
    track.overlap.reset();
    track.round.reset();
    for (MoveKey& key : track.keys) {
      key.overlap.reset();
      key.round.reset();
    }
  }
  bool smooth(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    if (track.spline == Spline::smooth || !(has_speed_curve(track) || is_over_time(track))) return false;
    track.spline = Spline::smooth;
    for (MoveKey& key : track.keys) key.tension = key.continuity = key.bias = 0;
    say(tried, index, track.place,
        has_round(track) ? "spline = \"smooth\" in place of round" : "spline = \"smooth\"");
    leave_corners(track);
    return true;
  }
  bool curve(Tried& tried, std::size_t index) const {
    MoveTrack& track = tried.move.tracks[index];
    if (has_speed_curve(track) || kinetic_of(track) == MoveKinetic::curves) return false;
    track.kinetic = MoveKinetic::curves;
    std::string words = "kinetic = \"curves\"";
    if (track.spline == Spline::linear) {
      track.spline = Spline::smooth;
      words += " and spline = \"smooth\"";
    }
    if (has_overlap(track)) words += " in place of overlap";
    leave_corners(track);
    say(tried, index, track.place, words);
    return true;
  }

  const Plan& plan_;
};

std::size_t size_of(const MoveFile& move) {
  std::size_t size = 0;
  for (const MoveTrack& track : move.tracks) size += track.keys.size() * track.axes.size();
  return size;
}

/// In so many times as many frames it is another move: one that was tried and fitted took 940 576 frames for
/// 96. Cure.InTwentyTimesAsManyFramesItIsNoAdvice.
constexpr std::int64_t max_times_slower = 20;

/// A speed curve is named before other changes if it differs by no more than this share of its mean: one that
/// differs by more is another motion than the one that was drawn.
constexpr double small_change = 0.1;

bool is_small(const SpeedFit& fit) {
  return std::ranges::all_of(fit.tracks,
                             [](const TrackFit& track) { return track.change_share <= small_change; });
}

}  // namespace

std::optional<Cure> find_cure(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest) {
  if (report.fits() || !plan.is_whole() || size_of(plan.move()) > max_cure_size) return std::nullopt;
  std::optional<Cure> by_curve;
  if (is_quick_to_fit(plan)) {
    const SpeedFit fit = fit_speed(plan, report, {.start = FitStart::drawn, .refinements = 0});
    if (fit.found) {
      by_curve = {plan.move().tracks[fit.tracks.front().track].speed_place,
                  "the speed curve that --fit OUT writes", plan.move().frames};
      if (is_small(fit)) return by_curve;
    }
  }
  const CureSearch search(plan);
  const std::optional<Tried> better = search.run(report);
  const auto cure_with = [&](std::int32_t frames) {
    return Cure{better->place, fmt::format("{}", fmt::join(better->words, ", and ")), frames};
  };
  if (better && search.fits(better->move)) return cure_with(plan.move().frames);
  if (by_curve || !better) return by_curve;
  const std::optional<std::int32_t> frames = search.frames_of(better->move, smallest);
  if (!frames || *frames > max_times_slower * plan.move().frames) return std::nullopt;
  return cure_with(*frames);
}

}  // namespace inbetween
