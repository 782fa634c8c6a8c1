#include "host_tools/edit/edit_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>

#include "host_tools/move_model/move_rewrite.hpp"
#include "host_tools/plan/drawn_curve.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {
namespace {

/// What the core of the page holds of a track (editor/solver/track_slot.hpp). More of a table would only be a
/// long wait before it refuses.
constexpr std::int32_t max_page_segments = 4'000;
constexpr std::size_t max_page_axes = 16;
constexpr std::int32_t max_page_frames = 50'000;

/// Whether the program makes the path, which the page cannot.
bool is_given_path(const MoveTrack& track) {
  return track.space || track.distance || track.network || track.table;
}

/// Whether the core alone solves the track: the page has nothing else.
bool is_live(const MoveTrack& track) {
  if (is_given_path(track) || track.ease_corners) return false;
  if (track.timing == Timing::frames) return kinetic_of(track) != MoveKinetic::pace;
  return track.curve_requests.empty();
}

void write_key(JsonWriter& json, const MoveKey& key, std::size_t index) {
  json.begin_object();
  json.member("from", index);
  json.member("at", key.at);
  json.member("tension", key.tension);
  json.member("continuity", key.continuity);
  json.member("bias", key.bias);
  json.member("frame", key.frame);
  json.member("hold", key.hold);
  json.member("break", key.breaks);
  json.member("ease", key.ease);
  json.member("overlap", key.overlap);
  json.member("round", key.round);
  json.end_object();
}

/// A path that the page cannot make itself: its cubics, segment after segment, with the weights of their
/// rows.
void write_cubics(JsonWriter& json, const Path& path) {
  json.begin_object();
  std::vector<double> numbers;
  std::vector<std::int32_t> knots;
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    for (const Cubic& cubic : path.segment(i)) {
      numbers.insert(numbers.end(), {cubic.c0, cubic.c1, cubic.c2, cubic.c3});
    }
    const FrameKnot& knot = path.knots()[static_cast<std::size_t>(i)];
    knots.insert(knots.end(), {knot.key, knot.part, knot.parts, knot.length});
  }
  json.member("coefficients", numbers);
  json.member("weights", path.weights());
  json.member("knots", knots);
  json.end_object();
}

/// The keys that have a position of their own for this axis, and not the one that is drawn.
std::vector<std::size_t> keys_with(const MoveTrack& track, std::size_t axis) {
  std::vector<std::size_t> keys;
  for (std::size_t k = 0; k < track.keys.size(); ++k) {
    const std::vector<bool>& is_left_out = track.keys[k].is_left_out;
    if (is_left_out.empty() || !is_left_out[axis]) keys.push_back(k);
  }
  return keys;
}

/// The places of the row, and the points of each curve that is drawn.
void write_network(JsonWriter& json, const MoveTrack& track) {
  json.begin_object();
  json.member("places", track.network->places);
  json.objects("drawn", track.network->drawn, [&](const DrawnAxis& drawn) {
    json.member("axis", drawn.axis);
    json.member("frames", drawn.frames);
    json.member("at", drawn.at);
    json.member("keys", keys_with(track, drawn.axis));
  });
  json.end_object();
}

void write_track(JsonWriter& json, const Plan& plan, std::size_t index, std::string_view text,
                 const std::string& file) {
  const MoveTrack& track = plan.move().tracks[index];
  const SolvedTrack& solved = plan.tracks()[index];
  const bool by_frames = track.timing == Timing::frames;
  const bool is_pace = by_frames && kinetic_of(track) == MoveKinetic::pace;
  const bool live = is_live(track);
  json.begin_object();
  json.member("axes", track.axes);
  json.member("unit", plan.length_unit(index));
  json.member("coordinates", coordinates_of(track));
  json.member("spline", spline_words.at(static_cast<std::size_t>(track.spline)));
  json.member("closed", track.closed);
  json.member("periodic", track.periodic);
  json.member("timing", by_frames ? "frames" : "speed");
  json.member("kinetic", by_frames
                             ? std::optional(kinetic_words.at(static_cast<std::size_t>(kinetic_of(track))))
                             : std::nullopt);
  json.member("live", live);
  json.member("fixed_keys", why_keys_are_fixed(text, file, index));
  json.member("overshoot", track.overshoot);
  json.member("overlap", track.overlap);
  json.member("round", track.round);
  json.key("keys");
  json.begin_array();
  for (std::size_t k = 0; k < track.keys.size(); ++k) {
    json.line();
    write_key(json, track.keys[k], k);
  }
  json.end_array();
  json.member("lap", track.lap);
  json.member("weights", track.weights);
  const RestingEnds rest = track.rest.value_or(RestingEnds{});
  json.member("rests", std::array{rest.start, rest.end});
  // What is played where a page cannot work it out from what is drawn; as drawn, its requests about the ends
  // included, where it can.
  const bool is_played = is_pace || track.ease_corners;
  json.key("speed");
  if (by_frames && !is_pace) {
    json.null();
  } else {
    json.value(is_played ? solved.control_values() : drawn_curve(track, plan.move().frames));
  }
  json.member("speed_as_written", track.speed);
  json.member("speed_is_played", is_played);
  json.member("table", track.table
                           ? std::optional(std::filesystem::path(track.table->file).filename().string())
                           : std::nullopt);
  json.key("network");
  if (track.network && !is_row_of_points(track)) {
    write_network(json, track);
  } else {
    json.null();
  }
  json.key("path");
  if (is_given_path(track)) {
    write_cubics(json, solved.track().path());
  } else {
    json.null();
  }
  json.end_object();
}

void write_limits(JsonWriter& json, const AxisLimits& limits) {
  json.begin_object();
  json.member("min", limits.min());
  json.member("max", limits.max());
  json.member("max_velocity", limits.max_velocity());
  json.member("max_acceleration", limits.max_acceleration());
  json.member("max_jerk", limits.max_jerk());
  const double step = limits.max_acceleration_step();
  json.member("max_acceleration_step", step > 0 ? std::optional(step) : std::nullopt);
  json.member("stop_acceleration", limits.stop_acceleration());
  json.member("stop_jerk", limits.stop_jerk());
  json.end_object();
}

/// With what the take-up of its backlash leaves of its limits.
void write_motor(JsonWriter& json, const RigAxis& axis) {
  json.begin_object();
  json.member("unit", to_string(axis.calibration->unit));
  json.key("marks");
  json.begin_array();
  for (const CalibrationMark& mark : axis.calibration->marks) {
    json.value(mark.axis);
    json.value(mark.motor);
  }
  json.end_array();
  json.key("limits");
  write_limits(json, limits_beside_take_up(axis));
  json.end_object();
}

void write_axis(JsonWriter& json, const Plan& plan, std::size_t move_axis) {
  const PlanAxis& axis = plan.axes()[plan.axis_of(move_axis)];
  json.line();
  json.begin_object();
  json.member("name", axis.name);
  json.member("unit", unit_of(axis));
  json.key("limits");
  if (!plan.rig()) {
    json.null();
  } else {
    const RigAxis& rig = plan.rig()->axes[plan.axis_of(move_axis)];
    write_limits(json, limits_of(rig));
    json.key("motor");
    rig.calibration ? write_motor(json, rig) : json.null();
  }
  json.end_object();
}

std::array<double, 3> numbers_of(const Vector3& vector) {
  return {vector.x, vector.y, vector.z};
}

/// The joints of the rig, each with its link, as JointTree takes them; and of each coordinate the axis of the
/// move that is it, or else where it stays: at 0, or as near as it can.
void write_joints(JsonWriter& json, const Plan& plan) {
  const Kinematics& kinematics = *plan.kinematics();
  json.array("joints", [&] {
    for (std::size_t j = 0; j < kinematics.links().size(); ++j) {
      const Joint& joint = kinematics.tree().joints()[j];
      json.line();
      json.begin_object();
      json.member("link", kinematics.links()[j]);
      json.member("kind", static_cast<int>(joint.kind));
      json.member("parent", joint.parent);
      json.member("coordinate", joint.coordinate);
      std::vector<double> numbers = {joint.factor, joint.offset};
      const Rotation3& turned = joint.origin.rotation;
      for (const Vector3& vector : {joint.origin.position, turned.x, turned.y, turned.z, joint.axis}) {
        for (const double number : numbers_of(vector)) numbers.push_back(number);
      }
      json.member("numbers", numbers);
      json.end_object();
    }
  });
  json.array("coordinates", [&] {
    for (std::size_t i = 0; i < plan.rig()->axes.size(); ++i) {
      const PlanAxis& axis = plan.axes()[i];
      const RigAxis& limits = plan.rig()->axes[i];
      json.begin_object();
      json.member("axis", axis.track ? std::optional(axis.move_axis) : std::nullopt);
      json.member("stays_at", std::clamp(0.0, limits.min, limits.max));
      json.end_object();
    }
  });
  json.member("tip",
              kinematics.tips().empty() ? std::nullopt : std::optional(kinematics.tips().front().link));
}

/// What `write` writes, as text.
template <class Write>
std::string json_text(const Write& write) {
  char* bytes = nullptr;
  std::size_t size = 0;
  const auto close = [](std::FILE* file) { std::fclose(file); };
  std::unique_ptr<std::FILE, decltype(close)> file(::open_memstream(&bytes, &size), close);
  if (!file) throw std::runtime_error("there is no memory for an answer");
  {
    JsonWriter json(file.get());
    write(json);
    json.finish();
  }
  file.reset();
  std::string text(bytes, size);
  std::free(bytes);  // NOLINT(cppcoreguidelines-no-malloc): what open_memstream gives is freed so
  return text;
}

}  // namespace

void refuse_what_is_not_shown(const Plan& plan) {
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const MoveTrack& track = plan.move().tracks[t];
    if (!track.table) continue;
    const bool fits = plan.tracks()[t].track().path().segment_count() <= max_page_segments &&
                      track.axes.size() <= max_page_axes && plan.move().frames <= max_page_frames;
    if (fits) continue;
    throw InputError(
        track.table->place,
        fmt::format("the table has {} on {}, and the page does not show one of more than {} rows, {} axes or "
                    "{} frames; check and play the move with inbetween check and inbetween run",
                    counted(static_cast<std::int64_t>(track.table->frames.size()), "row"),
                    counted(plan.move().frames, "frame"), max_page_segments, max_page_axes, max_page_frames));
  }
}

std::string document_of(const Plan& plan, const DocumentSource& source) {
  refuse_what_is_not_shown(plan);
  return json_text([&](JsonWriter& json) {
    const MoveFile& move = plan.move();
    json.begin_object();
    json.member("format", 1);
    json.member("file", source.file);
    json.member("id", source.id);
    json.member("revision", source.revision);
    if (source.with_text) json.member("text", source.text);
    json.member("name", move.name);
    json.object("fps", [&] {
      json.member("text", move.fps.as_written);
      json.member("numerator", move.fps.rate.numerator);
      json.member("denominator", move.fps.rate.denominator);
    });
    json.member("frames", move.frames);
    json.key("rig");
    if (plan.rig()) {
      json.begin_object();
      json.member("name", plan.rig()->name);
      json.member("revision", source.rig_revision);
      json.member("rate_hz", plan.rig()->rate_hz);
      if (plan.kinematics()) write_joints(json, plan);
      json.end_object();
    } else {
      json.null();
    }
    json.array("axes", [&] {
      for (std::size_t d = 0; d < plan.played().axis_count(); ++d) write_axis(json, plan, d);
    });
    json.array("tracks", [&] {
      for (std::size_t t = 0; t < move.tracks.size(); ++t)
        write_track(json, plan, t, source.text, source.file);
    });
    json.end_object();
  });
}

}  // namespace inbetween
