// What lets a move that is refused fit in its own frames: found by trying.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

struct Cure {
  Place place;              ///< of the first line to change
  std::string words;        ///< what to change, after "with": "ease = true at key 1"
  std::int32_t frames = 0;  ///< in which it fits then: those of the move, unless that is not enough
};

/// Tries small changes of the move as it is written, each judged by check(), and returns the first that lets
/// it fit in as many frames. First another speed curve (`check --fit`), where the search for it is quick
/// (is_quick_to_fit) and the curve differs by 10 % of its mean at most. Then for each track that is refused,
/// in this order: keys that are nearly in one place at one place, ease at the keys where it is refused, hold
/// at those of them that have frames of their own, both; the same with overshoot = false; of a track over
/// frames overshoot = true, keys that are written twice for a rest, both; corners = "ease", that and
/// overshoot = false, a smooth spline, that and overshoot = true, kinetic = "curves", that and rests, kinetic
/// = "pace", that and ease, all three. Then a speed curve that differs by more. Where nothing of this does,
/// the change that needs the least of slowing down, if with it fewer frames would do than `smallest`, which
/// are those of the plan, and no more than 20 times as many as the move has.
///
/// Nothing where the move fits, where only a part of it is planned, where it has more than max_cure_size keys
/// times axes, or where nothing of this helps. Cost: at most fifty solutions of the move for each track.
std::optional<Cure> find_cure(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest);

/// In a larger move nothing is tried: one try would take longer than a person waits.
inline constexpr std::size_t max_cure_size = 4000;

}  // namespace inbetween
