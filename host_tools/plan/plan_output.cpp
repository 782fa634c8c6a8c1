#include "host_tools/plan/plan_output.hpp"

#include <fmt/format.h>

#include <array>
#include <numbers>
#include <optional>
#include <vector>

#include "host_tools/plan/link_rows.hpp"
#include "host_tools/plan/passed_keys.hpp"
#include "host_tools/text/csv_table.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/json_writer.hpp"
#include "inbetween/base/hash.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {
namespace {

void add_text(std::string_view text, Fnv1a& hash) {
  for (const char c : text) hash.add(static_cast<std::int32_t>(c));
}

void add_space(const MoveTrack& track, Fnv1a& hash) {
  if (track.distance) add_text(track.distance->tip, hash);
  if (!track.space) return;
  const MoveSpace& space = *track.space;
  for (const std::string& tip : space.tips) add_text(tip, hash);
  for (const bool flag : {space.has_at, space.has_aim, space.has_roll, space.elbow_up.has_value(),
                          space.elbow_up.value_or(false)}) {
    hash.add(static_cast<std::int32_t>(flag));
  }
  for (const double value : space.fixed_aim) hash.add(value);
  if (space.aim_node) add_text(*space.aim_node, hash);
  for (const std::optional<double>& value : space.near) {
    hash.add(static_cast<std::int32_t>(value.has_value()));
    hash.add(value.value_or(0));
  }
}

/// Nothing where no corner is rounded.
void add_corners(const MoveTrack& track, Fnv1a& hash) {
  for (const MoveKey& key : track.keys) {
    if (has_overlap(track)) hash.add(overlap_of(track, key));
    if (has_round(track)) hash.add(round_of(track, key));
  }
}

void add_network(const MoveTrack& track, Fnv1a& hash) {
  if (!track.network) return;
  for (const double place : track.network->places) hash.add(place);
  for (const DrawnAxis& drawn : track.network->drawn) {
    hash.add(static_cast<std::int32_t>(drawn.axis));
    hash.add(static_cast<std::int32_t>(drawn.frames.size()));
    for (const std::int32_t frame : drawn.frames) hash.add(frame);
    for (const double value : drawn.at) hash.add(value);
  }
}

void add_table(const MoveTrack& track, Fnv1a& hash) {
  if (!track.table) return;
  for (const std::int32_t frame : track.table->frames) hash.add(frame);
  for (const double value : track.table->at) hash.add(value);
}

/// The hash of everything that decides the motion. Two files that differ in comments or names only have the
/// same hash.
std::uint64_t hash_of(const MoveFile& move) {
  Fnv1a hash;
  for (const std::int32_t number : {move.fps.rate.numerator, move.fps.rate.denominator, move.frames}) {
    hash.add(number);
  }
  for (const MoveTrack& track : move.tracks) {
    hash.add(static_cast<std::int32_t>(track.axes.size()));
    hash.add(static_cast<std::int32_t>(track.spline));
    hash.add(static_cast<std::int32_t>(track.timing));
    hash.add(
        static_cast<std::int32_t>(track.timing == Timing::frames ? kinetic_of(track) : MoveKinetic::linear));
    hash.add(static_cast<std::int32_t>(track.closed));
    const RestingEnds rest = track.rest.value_or(RestingEnds{});
    for (const bool flag : {track.rest.has_value(), rest.start, rest.end, track.ease_corners, track.overshoot,
                            track.periodic}) {
      hash.add(static_cast<std::int32_t>(flag));
    }
    for (const MoveKey& key : track.keys) {
      for (const double value : key.at) hash.add(value);
      for (const double value : {key.tension, key.continuity, key.bias}) hash.add(value);
      hash.add(key.frame.value_or(-1));
      hash.add(key.hold.value_or(0));
      hash.add(static_cast<std::int32_t>(key.breaks));
      hash.add(static_cast<std::int32_t>(key.ease));
    }
    for (const std::optional<EaseRequest>& ease : {track.ease_in, track.ease_out}) {
      hash.add(ease ? ease->frames : 0);
    }
    hash.add(static_cast<std::int32_t>(track.through));
    add_corners(track, hash);
    add_space(track, hash);
    add_network(track, hash);
    add_table(track, hash);
    for (const std::vector<double>* list : {&track.speed, &track.weights, &track.lap}) {
      hash.add(static_cast<std::int32_t>(list->size()));
      for (const double value : *list) hash.add(value);
    }
  }
  return hash.value();
}

std::vector<const PlanAxis*> axes_that_move(const Plan& plan) {
  std::vector<const PlanAxis*> axes;
  for (const PlanAxis& axis : plan.axes()) {
    if (axis.track) axes.push_back(&axis);
  }
  return axes;
}

void write_segments(const Path& path, JsonWriter& json) {
  json.objects("segments", path.segment_count(), [&](std::int32_t i) {
    if (!path.knots().empty()) json.member("s", path.parameter({i, 0}));
    json.array("coefficients", [&] {
      for (const Cubic& cubic : path.segment(i).first(static_cast<std::size_t>(path.axis_count()))) {
        json.value(std::array{cubic.c0, cubic.c1, cubic.c2, cubic.c3});
      }
    });
  });
}

void write_table(const SolvedTrack& solved, const WholeFrames& part, JsonWriter& json) {
  json.objects("table", part.last - part.first + 1, [&](std::int32_t row_of_part) {
    const std::int32_t frame = part.first + row_of_part;
    const FrameRow row = frame_row(solved.track(), solved.table(), frame);
    json.member("frame", frame);
    json.member("alpha", row.alpha);
    json.member("s", solved.track().path().parameter(row.point));  // one number, for people
    json.member("distance", row.distance);
    json.member("speed", row.speed);
    json.member("acceleration", row.acceleration);
  });
}

/// K is null if no single K holds for the whole move.
void write_speed(const MoveTrack& track, const SolvedTrack& solved, JsonWriter& json) {
  const bool one_constant = solved.track().has_profile() && solved.track().portions().empty();
  json.member("K", one_constant ? std::optional(solved.table().provenance().constant) : std::nullopt);
  json.member("f", solved.track().profile().span_count());
  json.line();
  json.member("speed", solved.control_values());
  json.member("speed_drawn", track.speed);
  json.member("periodic", track.periodic);
  if (solved.track().portions().empty()) return;
  json.line();
  json.objects("portions", solved.track().portions(), [&](const Portion& portion) {
    json.member("frame", portion.begin_frame);
    json.member("K", portion.constant);
  });
}

/// Only where corners are rounded: the keys that are not met.
void write_passed(const Plan& plan, std::size_t track, JsonWriter& json) {
  const std::vector<PassedKey> passed = passed_keys(plan, track);
  if (passed.empty()) return;
  json.line();
  json.objects("passed_keys", passed, [&](const PassedKey& key) {
    json.member("key", key.key);
    json.member("frame", key.frame);
    json.member("missed", key.missed);
    json.member("distance", key.distance);
  });
}

void write_network(const MoveTrack& track, JsonWriter& json) {
  if (!track.network) return;
  json.line();
  json.object("network", [&] {
    json.member("places", track.network->places);
    json.objects("drawn", track.network->drawn, [&](const DrawnAxis& drawn) {
      json.member("axis", coordinates_of(track)[drawn.axis]);
      json.member("points", drawn.frames.size());
    });
  });
}

void write_rows_of_table(const MoveTrack& track, JsonWriter& json) {
  if (!track.table) return;
  json.line();
  json.object("rows", [&] {
    json.member("file", track.table->file);
    json.member("count", track.table->frames.size());
  });
}

void write_track(const Plan& plan, std::size_t index, JsonWriter& json) {
  const MoveTrack& track = plan.move().tracks[index];
  const SolvedTrack& solved = plan.tracks()[index];
  json.member("axes", track.axes);
  json.member("solver", solved.integrated() ? "runge-kutta" : "closed-form");
  json.member("speed_error", solved.table().provenance().speed_error);
  json.member("hash", fmt::format("{:016x}", hash_of(solved.table().points())));
  json.member("length", solved.track().arc_length().total());
  write_speed(track, solved, json);
  write_network(track, json);
  write_rows_of_table(track, json);
  json.line();
  write_segments(solved.track().path(), json);
  write_passed(plan, index, json);
  json.line();
  write_table(solved, plan.part(), json);
}

/// Rows of a column, both included.
struct Rows {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

Rows rows_of(const Plan& plan, PlanRows rows, const TimeLine& line) {
  if (rows == PlanRows::tick) return {0, line.last()};
  return {plan.part().first, plan.part().last};
}

/// Position, velocity and acceleration, number by number: a plan per tick may have more rows than memory.
void write_motion(AxisColumn& column, const Rows& rows, JsonWriter& json) {
  const auto write_column = [&](const char* name, auto number) {
    json.array(name, [&] {
      for (std::int64_t row = rows.first; row <= rows.last; ++row) json.value(number(row));
    });
  };
  write_column("position", [&](std::int64_t row) { return column.position(row); });
  write_column("velocity", [&](std::int64_t row) { return column.motion(row).velocity; });
  write_column("acceleration", [&](std::int64_t row) { return column.motion(row).acceleration; });
}

void write_axes(const Plan& plan, PlanRows rows, JsonWriter& json) {
  json.objects("axes", axes_that_move(plan), [&](const PlanAxis* axis) {
    AxisColumn column(plan, *axis, rows);
    json.member("name", axis->name);
    json.member("unit", axis->unit ? std::optional(to_string(*axis->unit)) : std::nullopt);
    write_motion(column, rows_of(plan, rows, column.line()), json);
  });
}

/// The frames of a roll, without the one on which it joins the move; null where there is none.
void write_roll(const Plan& plan, const char* name, const Rows& frames, JsonWriter& json) {
  json.line();
  if (frames.first > frames.last) return json.member(name, std::optional<double>());
  json.object(name, [&] {
    json.member("frames", frames.last - frames.first + 1);
    json.objects("axes", axes_that_move(plan), [&](const PlanAxis* axis) {
      AxisColumn column(plan, *axis, PlanRows::frame);
      json.member("name", axis->name);
      write_motion(column, frames, json);
    });
  });
}

/// A tip on the rows of the plan, a list of x, y and z for each.
void write_tip(const Tip& tip, LinkRows& links, const Rows& rows, JsonWriter& json) {
  json.member("name", tip.name);
  json.member("unit", "m");
  const auto write_column = [&](const char* name, auto vector_of) {
    json.array(name, [&] {
      for (std::int64_t row = rows.first; row <= rows.last; ++row) {
        const Vector3 v = vector_of(links.at(row)[static_cast<std::size_t>(tip.link)]);
        json.value(std::array{v.x, v.y, v.z});
      }
    });
  };
  using Motion = LinkMotion;
  write_column("position", [](const Motion& link) { return link.pose.position; });
  write_column("velocity", [](const Motion& link) { return link.velocity; });
  write_column("acceleration", [](const Motion& link) { return link.acceleration; });
  write_column("x_axis", [](const Motion& link) { return link.pose.rotation.x; });
  write_column("y_axis", [](const Motion& link) { return link.pose.rotation.y; });
  write_column("z_axis", [](const Motion& link) { return link.pose.rotation.z; });
}

void write_tips(const Plan& plan, PlanRows rows, JsonWriter& json) {
  if (plan.kinematics() == nullptr) return;
  json.line();
  LinkRows links(plan, rows);
  const Rows written = rows_of(plan, rows, links.line());
  json.objects("tips", plan.tips(), [&](const Tip& tip) { write_tip(tip, links, written, json); });
}

}  // namespace

std::string hash_in_words(const MoveFile& move) {
  return fmt::format("{:016x}", hash_of(move));
}

void write_plan_json(const Plan& plan, PlanRows rows, std::FILE* file) {
  const MoveFile& move = plan.move();
  JsonWriter json(file);
  json.begin_object();
  json.member("format", 1);
  json.member("name", move.name);
  if (move.fps.written_as_integer) {
    json.member("fps", move.fps.rate.numerator);
  } else {
    json.member("fps", move.fps.as_written);
  }
  json.member("frames", move.frames);
  if (plan.names_frames()) {
    json.member("first", plan.part().first);
    json.member("last", plan.part().last);
  }
  json.member("duration_s", plan.duration_s());
  json.member("hash", hash_in_words(move));
  json.line();
  json.objects("tracks", move.tracks.size(), [&](std::size_t t) { write_track(plan, t, json); });
  json.line();
  write_axes(plan, rows, json);
  write_tips(plan, rows, json);
  write_roll(plan, "pre_roll", {plan.played().first_frame(), plan.part().first - 1}, json);
  write_roll(plan, "post_roll", {plan.part().last + 1, plan.played().last_frame()}, json);
  json.end_object();
  json.finish();
}

void write_plan_csv(const Plan& plan, PlanRows rows, std::FILE* file) {
  const TimeLine line(plan, rows);
  std::string text = rows == PlanRows::frame ? "frame,time_s" : "tick,time_s";
  std::vector<AxisColumn> columns;
  for (const PlanAxis* axis : axes_that_move(plan)) {
    columns.emplace_back(plan, *axis, rows);
    const std::string unit = unit_of(*axis);
    text += "," + csv_field(unit.empty() ? axis->name : fmt::format("{} ({})", axis->name, unit));
  }
  for (const Tip& tip : plan.tips()) {
    for (const char* direction : {"x", "y", "z"})
      text += "," + csv_field(fmt::format("{} {} (m)", tip.name, direction));
  }
  text += "\n";
  std::optional<LinkRows> links;
  if (!plan.tips().empty()) links.emplace(plan, rows);
  for (std::int64_t row = line.first(); row <= line.last(); ++row) {
    fmt::format_to(std::back_inserter(text), "{},{}", row, line.seconds(row));
    for (const AxisColumn& column : columns) {
      fmt::format_to(std::back_inserter(text), ",{}", column.position(row));
    }
    for (const Tip& tip : plan.tips()) {
      const Vector3& at = links->at(row)[static_cast<std::size_t>(tip.link)].pose.position;
      fmt::format_to(std::back_inserter(text), ",{},{},{}", at.x, at.y, at.z);
    }
    text += '\n';
    if (text.size() > 60'000) {
      std::fwrite(text.data(), 1, text.size(), file);
      text.clear();
    }
  }
  std::fwrite(text.data(), 1, text.size(), file);
}

namespace {

std::string resting_places(const Plan& plan, std::span<const RollAxis> roll) {
  std::string words;
  for (const PlanAxis* axis : axes_that_move(plan)) {
    const double rest = roll[axis->move_axis].rest_position();
    words += fmt::format("{}{} {:.6g} {}", words.empty() ? "" : ", ", axis->name, rest, unit_of(*axis));
  }
  return words;
}

void print_roll(const Plan& plan, RollEnd end, std::FILE* out) {
  const bool before = end == RollEnd::before;
  const std::span<const RollAxis> roll = before ? plan.played().rolls().before : plan.played().rolls().after;
  if (!roll.empty()) {
    const std::int32_t frames = roll.front().span().frames;
    fmt::print(out, "  {}: {}, {} rest at {}\n", before ? "pre-roll" : "post-roll", counted(frames, "frame"),
               before ? "from" : "to", resting_places(plan, roll));
    return;
  }
  bool is_needed = false;
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) is_needed = is_needed || plan.is_moving(t, end);
  if (!is_needed) return;
  fmt::print(out, "  {} moving: {}\n", before ? "starts" : "ends",
             plan.rig()
                 ? fmt::format("no {} keeps the limits of the rig; inbetween check tells why",
                               before ? "pre-roll" : "post-roll")
                 : fmt::format("on a rig, --rig RIG, it gets a {}", before ? "pre-roll" : "post-roll"));
}

}  // namespace

void print_rolls(const Plan& plan, std::FILE* out) {
  print_roll(plan, RollEnd::before, out);
  print_roll(plan, RollEnd::after, out);
}

void print_followed(const Plan& plan, std::size_t track, std::string_view indent, std::FILE* out) {
  const std::optional<FollowAccuracy>& accuracy = plan.accuracy(track);
  if (!accuracy) return;
  const MoveTrack& written = plan.move().tracks[track];
  std::vector<std::string> tips;
  if (written.distance) tips.push_back(in_quotes(written.distance->tip));
  if (written.space) {
    for (const std::string& tip : written.space->tips) tips.push_back(in_quotes(tip));
  }
  std::vector<std::string> bounds;
  if (!written.space || written.space->has_at) {
    bounds.push_back(fmt::format("within {:.2g} um of its path", accuracy->off_m * 1e6));
    bounds.push_back(fmt::format("its speed within {:.2g} of {}", accuracy->speed_share,
                                 accuracy->is_share_of_fastest ? "the fastest" : "what is drawn"));
  }
  if (accuracy->aim_rad > 0) {
    bounds.push_back(fmt::format("its aim within {:.2g} deg", accuracy->aim_rad * 180 / std::numbers::pi));
  }
  fmt::print(out, "{}{} in space: {} (proven, between all of {} places)\n", indent, fmt::join(tips, ", "),
             fmt::join(bounds, ", "), plan.tracks()[track].track().path().segment_count() + 1);
}

}  // namespace inbetween
