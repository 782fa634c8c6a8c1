#include "host_tools/plan/turns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace inbetween {
namespace {

/// Of a lap: what the sum of many may be off by.
constexpr double lap_rounding = 1e-9;

double lap_of(const MoveTrack& track, std::size_t axis) {
  return track.lap.empty() ? 0 : track.lap[axis];
}

/// A constant speed needs no more control values.
bool is_even(const std::vector<double>& speed) {
  return std::ranges::all_of(speed, [&](double value) { return value == speed.front(); });
}

/// The speed as it is played, and nothing left that would change it again.
void settle_speed(MoveTrack& track, const std::vector<double>& played) {
  replace_curve(track, played);
  track.speed_places.assign(played.size(), track.speed_place);
  track.ease_corners = false;
  for (MoveKey& key : track.keys) {
    key.frame.reset();
    key.hold.reset();
    key.ease = false;
  }
}

void repeat_track(MoveTrack& track, std::int32_t frames, std::int32_t turns) {
  const MoveTrack once = track;
  for (std::int32_t turn = 1; turn < turns; ++turn) {
    for (MoveKey key : once.keys) {
      for (std::size_t d = 0; d < key.at.size(); ++d) key.at[d] += turn * lap_of(once, d);
      if (key.frame) *key.frame += turn * frames;
      track.keys.push_back(std::move(key));
    }
    if (is_even(once.speed)) continue;
    for (std::size_t i = 1; i < once.speed.size(); ++i) {
      track.speed.push_back(once.speed[i]);
      track.speed_places.push_back(once.speed_places[i]);
    }
  }
  for (double& lap : track.lap) lap *= turns;
}

void repeat_cue(MoveCue& cue, std::int32_t frames, std::int32_t turns) {
  if (!cue.frames.empty() && cue.frames.back() == frames) {
    throw InputError(cue.frame_places.back(),
                     fmt::format("frame {} of a periodic move is frame 0 of its next turn; write 0", frames));
  }
  std::vector<std::int32_t> of_turn = cue.frames;
  std::vector<Place> places = cue.frame_places;
  for (std::int32_t frame = 0; cue.every > 0 && frame < frames; frame += cue.every) of_turn.push_back(frame);
  places.resize(of_turn.size(), cue.place);
  cue.every = 0;
  cue.frames.clear();
  cue.frame_places.clear();
  for (std::int32_t turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 0; i < of_turn.size(); ++i) {
      cue.frames.push_back(of_turn[i] + turn * frames);
      cue.frame_places.push_back(places[i]);
    }
  }
}

/// The lowest and the highest position of an axis on one turn and its rolls.
std::pair<double, double> range_of(const Plan& plan, std::size_t move_axis) {
  const Move& move = plan.played();
  const PlayedMotion& motion = plan.motion();
  std::vector<double> positions(move.axis_count());
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::int32_t frame = move.first_frame(); frame <= move.last_frame(); ++frame) {
    motion.positions({frame, 0}, positions);
    low = std::min(low, positions[move_axis]);
    high = std::max(high, positions[move_axis]);
  }
  return {low, high};
}

}  // namespace

bool is_periodic(const MoveFile& move) {
  return std::ranges::all_of(move.tracks, &MoveTrack::periodic);
}

MoveFile turns_of(const Plan& plan, std::int32_t turns) {
  const MoveFile& move = plan.move();
  for (const MoveTrack& track : move.tracks) {
    if (track.periodic) continue;
    if (track.network) {
      throw InputError(track.network->place,
                       "only a periodic move has turns, and a network is played once; leave out --turns");
    }
    if (track.table) {
      throw InputError(track.table->place,
                       "only a periodic move has turns, and a table is played once; leave out --turns");
    }
    throw InputError(
        track.place,
        "only a periodic move has turns, and this track is none; add closed = true and periodic = "
        "true, or leave out --turns");
  }
  if (turns > max_frames / move.frames) {
    throw InputError(move.frames_place,
                     fmt::format("{} of {} are more than {} frames; play fewer turns", counted(turns, "turn"),
                                 counted(move.frames, "frame"), max_frames));
  }
  MoveFile all = move;
  for (std::size_t t = 0; t < all.tracks.size(); ++t) {
    MoveTrack& track = all.tracks[t];
    if (track.timing == Timing::speed) settle_speed(track, plan.tracks()[t].control_values());
    repeat_track(track, move.frames, turns);
  }
  for (MoveCue& cue : all.cues) repeat_cue(cue, move.frames, turns);
  all.frames = move.frames * turns;
  return all;
}

bool comes_back(const MoveFile& move) {
  return std::ranges::all_of(move.tracks, [](const MoveTrack& track) {
    return std::ranges::all_of(track.lap, [](double lap) { return std::fabs(lap) < lap_rounding; });
  });
}

FittingTurns fitting_turns(const Plan& plan) {
  const MoveFile& move = plan.move();
  const std::int32_t turns_of_frames = max_frames / move.frames;
  double most = turns_of_frames;
  std::string border = fmt::format("a move has {} frames at most", max_frames);
  const auto narrow = [&](double turns, const auto& words) {
    if (!(turns < most)) return;
    most = turns;
    border = words();
  };
  for (std::size_t t = 0; t < move.tracks.size(); ++t) {
    const std::vector<double>& speed = plan.tracks()[t].control_values();
    const std::size_t turns_of_keys = max_keys / move.tracks[t].keys.size();
    narrow(static_cast<double>(turns_of_keys),
           [] { return fmt::format("a track has {} keys at most", max_keys); });
    if (move.tracks[t].timing == Timing::frames || is_even(speed)) continue;
    const double product = static_cast<double>(speed.size() - 1) * move.frames;
    narrow(std::sqrt(std::numeric_limits<std::int32_t>::max() / product),
           [] { return std::string("a speed curve has no more values"); });
  }
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    const double lap = axis.track ? lap_of(move.tracks[*axis.track], axis.track_axis) : 0;
    if (lap == 0) continue;
    const auto [low, high] = range_of(plan, axis.move_axis);
    const RigAxis& limits = plan.rig()->axes[a];
    const double room = lap > 0 ? limits.max - high : low - limits.min;
    narrow(1 + room / std::abs(lap) + lap_rounding,
           [&] { return fmt::format("{} has the limits {}", named(limits), range_in_words(limits)); });
  }
  return {static_cast<std::int32_t>(std::max(most, 1.0)), border};
}

PlayedTurns turns_to_go_round(const Plan& plan) {
  constexpr double seconds_around = 30;
  const MoveFile& move = plan.move();
  const FittingTurns fitting = fitting_turns(plan);
  if (fitting.turns < 2) {
    throw InputError(move.frames_place,
                     fmt::format("the move cannot go round and round: its turns are planned "
                                 "two at a time, and {}; give it fewer",
                                 fitting.border));
  }
  const double around =
      std::ceil(seconds_around * plan.played().frame_rate().frames_per_second() / move.frames);
  const double wanted = 1 + 2 * around;
  return {.frames = move.frames,
          .turns = static_cast<std::int32_t>(std::min(wanted, static_cast<double>(fitting.turns))),
          .goes_round = true};
}

}  // namespace inbetween
