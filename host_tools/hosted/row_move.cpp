#include "host_tools/hosted/row_move.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "host_tools/check/check.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/motions/transit.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

using dragonframe::RigAnswer;

/// Where errors say that a move is wrong which no file has.
const std::string name_of_upload = "the uploaded move";

MoveFile move_of(const RigFile& rig, const MoveRows& rows) {
  const Place nowhere{name_of_upload, 0, 0};
  const auto thousand = std::uint32_t{1000};
  const std::uint32_t divisor = std::gcd(rows.frames_per_1000_s, thousand);
  MoveFile move;
  move.path = name_of_upload;
  move.name = "upload";
  move.fps = {.rate = {.numerator = static_cast<std::int32_t>(rows.frames_per_1000_s / divisor),
                       .denominator = static_cast<std::int32_t>(thousand / divisor)},
              .as_written = fmt::format("{}/1000", rows.frames_per_1000_s)};
  move.frames = rows.frames.back();
  move.frames_place = nowhere;
  MoveTrack track;
  for (const std::size_t axis : rows.axes) track.axes.push_back(rig.axes[axis].name);
  track.axis_places.assign(rows.axes.size(), nowhere);
  track.timing = Timing::frames;
  track.kinetic = MoveKinetic::curves;
  track.speed_place = track.place = nowhere;
  track.keys.reserve(rows.frames.size());
  for (std::size_t r = 0; r < rows.frames.size(); ++r) {
    const auto first = rows.positions.begin() + static_cast<std::ptrdiff_t>(r * rows.axes.size());
    MoveKey key;
    key.at.assign(first, first + static_cast<std::ptrdiff_t>(rows.axes.size()));
    key.at_places.assign(rows.axes.size(), nowhere);
    key.frame = rows.frames[r];
    key.place = key.frame_place = nowhere;
    track.keys.push_back(std::move(key));
  }
  move.tracks.push_back(std::move(track));
  return move;
}

/// A host has codes for the ends of an axis, and one for everything else.
RigAnswer answer_of(const RigFile& rig, const CheckReport& report, const CheckRefusal& refusal) {
  const CheckedAxis& axis = report.axes[refusal.axis];
  if (!axis.range) return RigAnswer::general;
  const bool is_above = axis.range->highest.value > axis.limit_max;
  const bool is_below = axis.range->lowest.value < axis.limit_min;
  if (!is_above && !is_below) return RigAnswer::general;
  const bool is_turned = rig.dragonframe && rig.dragonframe->steps_per_unit[refusal.axis] < 0;
  return is_above != is_turned ? RigAnswer::soft_upper : RigAnswer::soft_lower;
}

ProvenRows refused(const RigFile& rig, const CheckReport& report, const CheckRefusal& refusal) {
  return {.answer = answer_of(rig, report, refusal), .why = refusal.what, .frame = refusal.frame};
}

ProvenRows staged(const RigFile& rig, std::unique_ptr<RowMove> move, RowUse use) {
  const CheckReport report = check(*move->plan);
  for (const CheckRefusal& refusal : report.refusals) {
    if (use == RowUse::play || refusal.at_any_rate) return refused(rig, report, refusal);
  }
  if (use == RowUse::play) {
    move->staged = checked_move(*move->plan, 1, Repeat::none);
    return {.move = std::move(move)};
  }
  double share = 0;
  for (const CheckedAxis& axis : report.axes) share = std::max(share, axis.velocity.share());
  move->staged = checked_shoot(*move->plan, 1, {});
  const double top = move->staged->playhead().top_rate();
  move->slow_rate = share > transit_share ? std::min(top, transit_share / share) : std::min(top, 1.0);
  return {.move = std::move(move)};
}

}  // namespace

ProvenRows prove_rows(const RigFile& rig, const MoveRows& rows, RowUse use) {
  constexpr std::uint32_t most_frames_per_1000_s = 1'000'000;
  if (rows.frames_per_1000_s == 0 || rows.frames_per_1000_s > most_frames_per_1000_s) {
    return {.answer = RigAnswer::range, .why = "a frame rate is above 0 and 1000 at most"};
  }
  if (rows.frames.size() < 2 || rows.axes.empty()) {
    return {.answer = RigAnswer::general, .why = "nothing moves in it"};
  }
  if (rows.frames.size() > max_keys) {
    return {.answer = RigAnswer::range, .why = fmt::format("it has more than {} frames", max_keys)};
  }
  try {
    auto move = std::make_unique<RowMove>();
    move->plan = std::make_unique<const Plan>(move_of(rig, rows), rig, PlanOptions{});
    move->frames = rows.frames.back();
    return staged(rig, std::move(move), use);
  } catch (const InputError& error) {
    return {.answer = RigAnswer::general, .why = error.message()};
  } catch (const std::runtime_error& error) {
    return {.answer = RigAnswer::general, .why = error.what()};
  }
}

}  // namespace inbetween
