#include "host_tools/move_model/move_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <utility>

#include "host_tools/move_model/move_readers.hpp"
#include "host_tools/text/toml_source.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 7> move_fields = {"name", "fps",     "frames", "track",
                                                         "cue",  "clapper", "start"};
constexpr std::array<std::string_view, 28> track_fields = {
    "axes",     "unit",     "wrap",    "spline",  "closed",  "periodic",  "keys",
    "timing",   "speed",    "rest",    "kinetic", "weights", "overshoot", "corners",
    "ease_in",  "ease_out", "through", "space",   "aim",     "elbow",     "near",
    "distance", "overlap",  "round",   "network", "places",  "drawn",     "table"};

constexpr std::int64_t max_fps = 1'000;
constexpr std::int64_t max_fps_part = 1'000'000;

/// The fraction to write instead of a rate that was given as a decimal number.
std::string exact_rate(double fps) {
  // 23.976, 29.97 and their like stand for these rates times 1000/1001 (SMPTE ST 12-1); half a hundredth also
  // takes in 23.98 and 47.95.
  for (const int nominal : {24, 30, 48, 60, 96, 120, 240}) {
    if (std::abs(fps - nominal * 1000.0 / 1001.0) <= 0.005) return fmt::format("\"{}/1001\"", nominal * 1000);
  }
  for (int denominator = 1; denominator <= 1000; ++denominator) {
    const double numerator = std::round(fps * denominator);
    if (std::abs(fps * denominator - numerator) > 1e-9 * numerator) continue;
    if (numerator < 1 || numerator > static_cast<double>(max_fps_part)) break;
    return denominator == 1 ? fmt::format("{:.0f}", numerator)
                            : fmt::format("\"{:.0f}/{}\"", numerator, denominator);
  }
  return R"(a fraction such as "24000/1001")";
}

std::optional<std::int32_t> positive_whole_number(std::string_view digits) {
  std::int32_t number = 0;
  const char* end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number);
  if (error != std::errc() || stopped != end || number < 1 || number > max_fps_part) return std::nullopt;
  return number;
}

WrittenFrameRate read_frame_rate(const TomlValue& value) {
  if (const auto* decimal = value.node().as_floating_point()) {
    const double fps = decimal->get();
    if (std::isfinite(fps) && fps > 0 && fps <= static_cast<double>(max_fps)) {
      value.refuse(fmt::format("is {}, a decimal number, which is not exact; use {}", fps, exact_rate(fps)));
    }
    value.number(1, static_cast<double>(max_fps));
  }
  if (!value.node().is_string()) {
    const std::int64_t fps = value.integer(1, max_fps);
    return {{static_cast<std::int32_t>(fps), 1}, fmt::format("{}", fps), true};
  }
  const std::string text = value.text();
  const std::size_t slash = text.find('/');
  const auto numerator = positive_whole_number(std::string_view(text).substr(0, slash));
  if (slash == std::string::npos && numerator && *numerator <= max_fps) {
    value.refuse(fmt::format("is the text {}; use {} without quotes", in_quotes(text), *numerator));
  }
  const auto denominator = slash == std::string::npos
                               ? std::nullopt
                               : positive_whole_number(std::string_view(text).substr(slash + 1));
  if (!numerator || !denominator) {
    value.refuse(fmt::format(
        R"(is {}; write two whole numbers from 1 to {} with a slash, as in "24000/1001", or a whole number)",
        in_quotes(text), max_fps_part));
  }
  if (*numerator / *denominator > max_fps ||
      (*numerator / *denominator == max_fps && *numerator % *denominator > 0)) {
    value.refuse(fmt::format("is {}; write a rate of at most {}", in_quotes(text), max_fps));
  }
  return {{*numerator, *denominator}, text, false};
}

void read_axes(const TomlTable& table, MoveTrack& track, std::map<std::string, Place>& taken) {
  for (const TomlValue& axis : table.required("axes", R"(axes = ["name of an axis"])").list(max_track_axes)) {
    track.axes.push_back(axis.text());
    track.axis_places.push_back(axis.place());
    const auto [earlier, is_new] = taken.emplace(track.axes.back(), axis.place());
    if (!is_new) {
      axis.refuse(fmt::format("is {}, which line {} has already; name each axis once in one track",
                              in_quotes(track.axes.back()), earlier->second.line));
    }
  }
}

/// Keys that say when each of them is met need no speed.
bool may_be_timed_by_frames(const MoveTrack& track, std::int32_t frames) {
  const auto has_frame = [](const MoveKey& key) { return key.frame.has_value(); };
  return track.keys.size() > 1 && std::ranges::all_of(track.keys, has_frame) &&
         track.keys.front().frame == 0 && (track.closed || track.keys.back().frame == frames) &&
         std::ranges::none_of(track.keys,
                              [](const MoveKey& key) { return key.hold || key.breaks || key.ease; });
}

void read_speed(const TomlTable& table, std::int32_t frames, MoveTrack& track) {
  track.speed_place = track.place;
  if (track.timing == Timing::frames) {
    return table.refuse_any(
        {"speed"},
        R"(has no meaning with timing = "frames", where the keys say when; remove one of the two)");
  }
  if (!table.optional("speed") && may_be_timed_by_frames(track, frames)) {
    throw InputError(table.place(),
                     "a track has no speed, and every key has a frame; add timing = \"frames\", or "
                     "speed = [0, 0, 10, 0, 0], say");
  }
  const TomlValue speed = table.required("speed", "speed = [0, 0, 10, 0, 0], say");
  track.speed_place = speed.place();
  for (const TomlValue& value : speed.list(max_control_values)) {
    track.speed.push_back(value.number(0, max_control_value));
    track.speed_places.push_back(value.place());
  }
}

void read_weights(const TomlTable& table, MoveTrack& track) {
  const auto weights = table.optional("weights");
  if (!weights) return;
  if (track.space || track.distance) {
    weights->refuse("say how far axes count, and here the distance is that of a link in space; remove them");
  }
  for (const TomlValue& weight : weights->list(max_track_axes)) {
    track.weights.push_back(weight.number(0, max_magnitude));
    track.weight_places.push_back(weight.place());
  }
  if (track.weights.size() != track.axes.size()) {
    weights->refuse(fmt::format("has {}; write {}, one for each of its axes ({})",
                                counted(static_cast<std::int64_t>(track.weights.size()), "number"),
                                track.axes.size(), comma_separated(track.axes)));
  }
  if (std::all_of(track.weights.begin(), track.weights.end(), [](double weight) { return weight == 0; })) {
    weights->refuse("are all 0, so that nothing has a length; make at least one positive");
  }
}

/// Of keys on frames, a track may rest whose motion takes its time: the keys are known.
void refuse_rest(const TomlTable& table, const MoveTrack& track) {
  const auto rest = table.optional("rest");
  if (!rest || has_speed_curve(track) || is_over_time(track) || has_overlap(track)) return;
  rest->refuse(R"(needs a drawn speed, kinetic = "curves" or "pace", or overlap; remove it)");
}

/// Where a link is keyed, or its path measured, the corners are those of axes that follow.
void refuse_round_in_space(const TomlTable& table, const MoveTrack& track) {
  if (!has_round(track) || !(track.space || track.distance)) return;
  const auto written = table.optional("round");
  throw InputError(written ? written->place() : track.place,
                   "round is for a path of axes, and here a link in space is measured; remove round, or use "
                   "spline = \"smooth\"");
}

void read_rest(const TomlTable& table, MoveTrack& track) {
  const auto rest = table.optional("rest");
  if (!rest) return;
  constexpr std::array ends = {RestingEnds{true, true}, RestingEnds{true, false}, RestingEnds{false, true},
                               RestingEnds{false, false}};
  track.rest = ends.at(rest->choice({"both", "start", "end", "none"}));
}

void read_kinetic(const TomlTable& table, MoveTrack& track) {
  if (const auto kinetic = table.optional("kinetic")) {
    if (track.timing != Timing::frames)
      kinetic->refuse(R"(needs timing = "frames"; add that or remove kinetic)");
    if (kinetic->node().value<std::string_view>() == "smooth") {
      kinetic->refuse(
          R"(is "smooth", which is called "monotone"; write that, or "curves", which does not step)");
    }
    track.kinetic = static_cast<MoveKinetic>(kinetic->choice(kinetic_words));
    if (track.kinetic == MoveKinetic::curves && track.spline == Spline::linear) {
      kinetic->refuse(
          R"(is "curves", and spline = "linear" has none; write kinetic = "linear" or another spline)");
    }
  }
  const CornerFields corners = read_corner_fields(table, track);
  track.overlap = corners.overlap;
  track.round = corners.round;
  read_rest(table, track);
  if (const auto at_corners = table.optional("corners")) {
    track.ease_corners = at_corners->choice({"pass", "ease"}) == 1;
    if (track.ease_corners && !has_speed_curve(track)) {
      at_corners->refuse(R"(is "ease", which is for a speed curve: timing = "speed", or kinetic = "pace")");
    }
  }
}

/// The requests about the drawn curve. Each is kept with its place, so that a curve which has it already
/// can be written into the file.
void read_curve_requests(const TomlTable& table, MoveTrack& track, std::int32_t frames) {
  const auto keep = [&](const TomlValue& value, std::string_view as_drawn) {
    if (track.timing == Timing::frames) {
      value.refuse(R"(belongs to a drawn speed, and timing = "frames" has none; remove one of the two)");
    }
    track.curve_requests.push_back({value.place(), as_drawn});
  };
  const auto ease = [&](std::string_view field, bool may_rest) -> std::optional<EaseRequest> {
    const auto value = table.optional(field);
    if (!value) return std::nullopt;
    const EaseRequest request{static_cast<std::int32_t>(value->integer(0, frames)), value->place()};
    keep(*value, "0");
    if (request.frames > 0 && !may_rest)
      value->refuse("contradicts rest, by which this end is as drawn; remove one");
    return request;
  };
  const RestingEnds rest = track.rest.value_or(RestingEnds{});
  track.ease_in = ease("ease_in", rest.start);
  track.ease_out = ease("ease_out", rest.end);
  if (track.ease_in && track.ease_out && track.ease_in->frames > frames - track.ease_out->frames) {
    throw InputError(track.ease_out->place,
                     fmt::format("ease_in and ease_out take {} frames together, and the move "
                                 "has {}; shorten one",
                                 track.ease_in->frames + track.ease_out->frames, frames));
  }
  if (const auto through = table.optional("through")) {
    track.through = through->boolean();
    keep(*through, "false");
  }
  if (const auto written = table.optional("rest"); written && track.timing == Timing::speed) {
    keep(*written, "\"none\"");
  }
  std::ranges::sort(track.curve_requests, [](const CurveRequest& one, const CurveRequest& other) {
    return std::pair(one.place.line, one.place.column) < std::pair(other.place.line, other.place.column);
  });
}

/// A loop has no ends at which anything could be said to happen, and its curve is one all round.
void read_periodic(const TomlTable& table, MoveTrack& track) {
  const auto periodic = table.optional("periodic");
  if (!periodic) return;
  track.periodic = periodic->boolean();
  if (!track.periodic) return;
  if (!track.closed || track.keys.size() < 2) {
    periodic->refuse("needs a closed path of two keys or more; add closed = true, or remove it");
  }
  const RestingEnds none{false, false};
  if (track.rest.value_or(none) != none) {
    periodic->refuse(R"(contradicts rest: a loop does not rest at its seam; remove one of the two)");
  }
  if (track.timing == Timing::frames) {
    if (kinetic_of(track) != MoveKinetic::curves && !has_overlap(track)) {
      periodic->refuse(R"(needs a drawn speed, kinetic = "curves" or overlap; change kinetic or remove it)");
    }
    track.rest = none;
    return;
  }
  const auto takes_time = [](const std::optional<EaseRequest>& ease) { return ease && ease->frames > 0; };
  if (takes_time(track.ease_in) || takes_time(track.ease_out)) {
    periodic->refuse(
        "has a speed curve without ends; remove ease_in and ease_out, and where the speed shall fall to 0 "
        "give "
        "a key ease = true or a hold");
  }
  for (const MoveKey& key : track.keys) {
    if (!key.breaks) continue;
    throw InputError(key.place,
                     "a break gives each side a scale of its own, so with periodic = true the speed would "
                     "step at the seam too; remove break, and the curve meets the frame without a step");
  }
  if (track.speed.front() == track.speed.back()) return;
  throw InputError(track.speed_places.back(),
                   fmt::format("the speed is {:g} at the end and {:g} at the start, and with periodic = true "
                               "the one goes on as the other; write the same",
                               track.speed.back(), track.speed.front()));
}

MoveTrack read_track(const TomlValue& value, std::int32_t frames, const TextReader& read,
                     std::map<std::string, Place>& taken_axes) {
  const TomlTable table(value.table(), "a track", track_fields);
  MoveTrack track;
  track.place = table.place();
  read_axes(table, track, taken_axes);
  if (table.optional("table")) {
    read_rest(table, track);
    read_table(table, frames, read, track);
    return track;
  }
  if (const auto spline = table.optional("spline")) {
    track.spline = static_cast<Spline>(spline->choice(spline_words));
  }
  if (const auto closed = table.optional("closed")) track.closed = closed->boolean();
  if (const auto timing = table.optional("timing")) {
    track.timing = timing->choice({"speed", "frames"}) == 0 ? Timing::speed : Timing::frames;
  }
  read_kinetic(table, track);
  read_curve_requests(table, track, frames);
  if (const auto overshoot = table.optional("overshoot")) {
    track.overshoot = overshoot->boolean();
    if (!track.overshoot && track.spline != Spline::smooth && track.spline != Spline::catmull_rom) {
      overshoot->refuse(R"(has a meaning with spline = "smooth" and "catmull-rom"; remove it)");
    }
  }
  read_space(table, track);
  if (!track.space) read_counting(table, track);
  read_network(table, frames, read, track);
  read_keys(table, frames, track);
  if (track.network) check_network_keys(track, frames);
  refuse_rest(table, track);
  refuse_round_in_space(table, track);
  read_speed(table, frames, track);
  read_weights(table, track);
  read_periodic(table, track);
  return track;
}

}  // namespace

std::string coordinate_name(const std::string& tip, std::size_t coordinate) {
  return fmt::format("{}.{}", tip, "xyz"[coordinate]);
}

bool is_row_of_points(const MoveTrack& track) {
  return track.space && track.network;
}

std::vector<std::string> coordinates_of(const MoveTrack& track) {
  if (!track.space) return track.axes;
  std::vector<std::string> names;
  if (is_row_of_points(track)) {
    for (const std::string& tip : track.space->tips) {
      for (std::size_t c = 0; c < world_coordinates; ++c) names.push_back(coordinate_name(tip, c));
    }
    return names;
  }
  if (track.space->has_at) names = {"x", "y", "z"};
  if (track.space->has_aim) names.insert(names.end(), {"x of aim", "y of aim", "z of aim"});
  if (track.space->has_roll) names.emplace_back("roll");
  return names;
}

void replace_curve(MoveTrack& track, std::vector<double> control_values) {
  track.speed = std::move(control_values);
  if (track.rest && track.timing == Timing::speed) track.rest = RestingEnds{false, false};
  track.ease_in.reset();
  track.ease_out.reset();
  track.through = false;
  track.curve_requests.clear();
}

MoveKinetic kinetic_of(const MoveTrack& track) {
  return track.kinetic.value_or(track.spline == Spline::linear ? MoveKinetic::linear : MoveKinetic::curves);
}

bool has_speed_curve(const MoveTrack& track) {
  return track.timing == Timing::speed || kinetic_of(track) == MoveKinetic::pace;
}

std::int32_t overlap_of(const MoveTrack& track, const MoveKey& key) {
  return key.overlap.value_or(track.overlap.value_or(0));
}

double round_of(const MoveTrack& track, const MoveKey& key) {
  return key.round.value_or(track.round.value_or(0));
}

bool has_overlap(const MoveTrack& track) {
  return track.overlap ||
         std::ranges::any_of(track.keys, [](const MoveKey& key) { return key.overlap.has_value(); });
}

bool has_round(const MoveTrack& track) {
  return track.round ||
         std::ranges::any_of(track.keys, [](const MoveKey& key) { return key.round.has_value(); });
}

bool is_over_time(const MoveTrack& track) {
  return track.timing == Timing::frames && kinetic_of(track) == MoveKinetic::curves;
}

MoveFile parse_move_beside(const TextReader& read, std::string_view text, const std::string& file_name) {
  const toml::table root = parse_toml(text, file_name);
  if (root.empty()) {
    throw InputError(place_of(root), "the file is empty; a move has name, fps, frames and a [[track]]");
  }
  const TomlTable table(root, "the move", move_fields);
  MoveFile move;
  move.path = file_name;
  move.name = table.required("name", R"(name = "what the move is called")").text();
  move.fps = read_frame_rate(table.required("fps", R"(fps = 24, or "24000/1001")"));
  const TomlValue frames = table.required("frames", "frames = 240, say");
  move.frames_place = frames.place();
  move.frames = static_cast<std::int32_t>(frames.integer(1, max_frames));
  std::map<std::string, Place> taken_axes;
  for (const TomlValue& track :
       table.required("track", "a [[track]] with axes, keys and speed").tables(max_tracks)) {
    move.tracks.push_back(read_track(track, move.frames, read, taken_axes));
  }
  read_cues(table, move);
  return move;
}

MoveFile parse_move(std::string_view text, const std::string& file_name) {
  return parse_move_beside(read_text_file, text, file_name);
}

std::vector<std::string> files_beside(const MoveFile& move) {
  std::vector<std::string> files;
  for (const MoveTrack& track : move.tracks) {
    if (track.network) files.insert(files.end(), track.network->files.begin(), track.network->files.end());
    if (track.table) files.push_back(track.table->file);
  }
  return files;
}

MoveFile read_move_file(const std::filesystem::path& path) {
  return parse_move(read_text_file(path), path.string());
}

}  // namespace inbetween
