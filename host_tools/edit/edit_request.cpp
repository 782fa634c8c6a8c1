#include "host_tools/edit/edit_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "host_tools/move_model/move_file.hpp"

namespace inbetween {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(std::string_view name, std::string_view problem) {
  throw RequestError(fmt::format("{} {}; load the page again", name, problem));
}

/// One object of the request. Each member is taken by its name, and nothing may be left over.
class Members {
 public:
  Members(const json& object, std::string name, std::initializer_list<std::string_view> known)
      : object_(object), name_(std::move(name)) {
    if (!object.is_object()) refuse(name_, "is no object");
    for (const auto& [key, value] : object.items()) {
      if (std::ranges::find(known, key) == known.end()) refuse(name_, "has a member that is not known");
    }
  }

  [[nodiscard]] const json* find(const char* member) const {
    const auto found = object_.find(member);
    return found == object_.end() || found->is_null() ? nullptr : &*found;
  }
  [[nodiscard]] const json& get(const char* member) const {
    const json* found = find(member);
    if (found == nullptr) refuse(name_ + "." + member, "is missing");
    return *found;
  }
  [[nodiscard]] const std::string& get_text(const char* member, std::size_t max) const {
    const json& value = get(member);
    if (!value.is_string() || value.get_ref<const std::string&>().size() > max)
      refuse(name_ + "." + member, "is no text of that length");
    return value.get_ref<const std::string&>();
  }
  [[nodiscard]] std::string text(const char* member, std::size_t max) const { return get_text(member, max); }
  [[nodiscard]] double number(const char* member) const { return number(get(member), name_ + "." + member); }
  [[nodiscard]] std::int32_t integer(const char* member) const {
    return integer(get(member), name_ + "." + member);
  }
  [[nodiscard]] std::optional<std::int32_t> optional_integer(const char* member) const {
    const json* value = find(member);
    if (value == nullptr) return std::nullopt;
    return integer(*value, name_ + "." + member);
  }
  [[nodiscard]] std::int32_t integer_of(const json& element) const { return integer(element, name_); }
  [[nodiscard]] std::optional<double> optional_number(const char* member) const {
    if (find(member) == nullptr) return std::nullopt;
    return number(member);
  }
  [[nodiscard]] bool boolean(const char* member) const {
    const json& value = get(member);
    if (!value.is_boolean()) refuse(name_ + "." + member, "is neither true nor false");
    return value.get<bool>();
  }
  [[nodiscard]] const json& list(const char* member, std::size_t max) const {
    const json& value = get(member);
    if (!value.is_array() || value.size() > max) refuse(name_ + "." + member, "is no list of that length");
    return value;
  }
  [[nodiscard]] std::vector<double> numbers(const char* member, std::size_t max) const {
    std::vector<double> numbers;
    for (const json& value : list(member, max)) numbers.push_back(number(value, name_ + "." + member));
    return numbers;
  }

 private:
  static double number(const json& value, const std::string& name) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) refuse(name, "is no number");
    return value.get<double>();
  }
  static std::int32_t integer(const json& value, const std::string& name) {
    constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
    if (!value.is_number_integer() || value.get<double>() < 0 ||
        value.get<double>() > static_cast<double>(most))
      refuse(name, "is no whole number from 0");
    return value.get<std::int32_t>();
  }

  const json& object_;
  std::string name_;
};

EditedKey read_key(const json& object) {
  const Members key(
      object, "a key",
      {"from", "at", "tension", "continuity", "bias", "frame", "hold", "break", "ease", "overlap", "round"});
  EditedKey edited{.at = key.numbers("at", max_track_axes),
                   .tension = key.number("tension"),
                   .continuity = key.number("continuity"),
                   .bias = key.number("bias"),
                   .frame = key.optional_integer("frame"),
                   .hold = key.optional_integer("hold"),
                   .breaks = key.boolean("break"),
                   .ease = key.boolean("ease"),
                   .overlap = key.optional_integer("overlap"),
                   .round = key.optional_number("round")};
  if (const auto from = key.optional_integer("from")) edited.from = static_cast<std::size_t>(*from);
  return edited;
}

EditedCurve read_curve(const json& object) {
  const Members curve(object, "a curve", {"axis", "frames", "at"});
  EditedCurve drawn{.axis = static_cast<std::size_t>(curve.integer("axis")),
                    .frames = {},
                    .at = curve.numbers("at", max_keys)};
  for (const json& frame : curve.list("frames", max_keys)) drawn.frames.push_back(curve.integer_of(frame));
  if (drawn.frames.size() != drawn.at.size() || drawn.at.empty())
    refuse("a curve", "has not a place for every frame");
  return drawn;
}

EditedTrack read_track(const json& object) {
  const Members track(object, "a track", {"keys", "speed", "spline", "closed", "drawn"});
  EditedTrack edited{.keys = {}, .speed = std::nullopt, .closed = track.boolean("closed"), .drawn = {}};
  if (track.find("keys") != nullptr) {  // null: as they are
    for (const json& key : track.list("keys", max_keys)) edited.keys.push_back(read_key(key));
    if (edited.keys.empty()) refuse("track.keys", "is empty");
  }
  if (track.find("speed") != nullptr) {
    edited.speed = track.numbers("speed", max_control_values);
    for (const double value : *edited.speed) {
      if (!(value >= 0 && value <= max_control_value)) refuse("a control value", "is not within 0..100");
    }
    if (edited.speed->empty()) refuse("track.speed", "is empty");
  }
  if (track.find("drawn") != nullptr) {
    for (const json& curve : track.list("drawn", max_track_axes)) edited.drawn.push_back(read_curve(curve));
  }
  const auto word = std::ranges::find(spline_words, track.text("spline", 16));
  if (word == spline_words.end()) refuse("track.spline", "is none");
  edited.spline = static_cast<Spline>(word - spline_words.begin());
  return edited;
}

json parse(std::string_view text) {
  if (text.size() > max_request_bytes) refuse("the request", "is too long");
  bool too_deep = false;
  const json::parser_callback_t limit = [&](int depth, json::parse_event_t, json&) {
    too_deep = too_deep || depth > max_request_nesting;
    return !too_deep;
  };
  json parsed = json::parse(text, limit, false);
  if (too_deep) refuse("the request", "is nested too deep");
  if (parsed.is_discarded()) refuse("the request", "is no JSON");
  return parsed;
}

/// Base64 as RFC 4648 has it, with its padding.
std::optional<std::string> bytes_of_base64(std::string_view text) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr std::size_t group = 4;
  if (text.size() % group != 0) return std::nullopt;
  const std::size_t padding = text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0;
  text.remove_suffix(padding);
  std::string bytes;
  bytes.reserve(text.size() / group * 3 + 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t digit = digits.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = (bits << 6U) | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(static_cast<unsigned char>(bits >> static_cast<unsigned>(count)));
    bits &= (1U << static_cast<unsigned>(count)) - 1U;
  }
  return bytes;
}

bool is_file_name(std::string_view name) {
  return !name.empty() && name.find('/') == std::string_view::npos &&
         std::ranges::none_of(name, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; });
}

}  // namespace

EditRequest parse_edit_request(std::string_view text) {
  const json parsed = parse(text);
  const Members request(parsed, "the request", {"id", "base", "frames", "fps", "tracks", "expects", "own"});
  EditRequest edit{.id = std::nullopt,
                   .base = request.text("base", max_file_bytes),
                   .edited = {},
                   .expects = std::nullopt,
                   .own = false};
  if (request.find("id") != nullptr) edit.id = request.text("id", 64);
  edit.edited.frames = request.integer("frames");
  edit.edited.fps = request.text("fps", 32);
  // It goes into the file as it is.
  if (edit.edited.fps.find_first_not_of("0123456789/") != std::string::npos || edit.edited.fps.empty())
    refuse("request.fps", "is no frame rate");
  for (const json& track : request.list("tracks", max_tracks))
    edit.edited.tracks.push_back(read_track(track));
  if (request.find("expects") != nullptr) edit.expects = request.text("expects", 64);
  if (request.find("own") != nullptr) edit.own = request.boolean("own");
  return edit;
}

ImportRequest parse_import_request(std::string_view text) {
  constexpr std::size_t max_name = 255;
  constexpr std::size_t max_answers = 1024;
  const json parsed = parse(text);
  const Members request(parsed, "the import", {"id", "file", "bytes", "answers", "writes"});
  ImportRequest import{.id = std::nullopt,
                       .file = request.text("file", max_name),
                       .bytes = {},
                       .answers = {},
                       .writes = request.boolean("writes")};
  if (request.find("id") != nullptr) import.id = request.text("id", 64);
  if (!is_file_name(import.file)) refuse("import.file", "is no name of a file");
  auto bytes = bytes_of_base64(request.get_text("bytes", max_request_bytes));
  if (!bytes) refuse("import.bytes", "are no Base64");
  import.bytes = std::move(*bytes);
  const json& answers = request.get("answers");
  if (!answers.is_object() || answers.size() > max_answers)
    refuse("import.answers", "is no object of that size");
  for (const auto& [question, answer] : answers.items()) {
    if (!answer.is_string() || answer.get_ref<const std::string&>().size() > max_name)
      refuse("import.answers", "has an answer that is no text of that length");
    import.answers.emplace(question, answer.get<std::string>());
  }
  return import;
}

std::string parse_base(std::string_view text) {
  const json parsed = parse(text);
  return Members(parsed, "the request", {"base"}).text("base", max_file_bytes);
}

SampledMotion parse_drawn_motion(std::string_view text) {
  const json parsed = parse(text);
  const Members drawn(parsed, "the motion",
                      {"times", "positions", "tolerances", "weights", "frames_per_second"});
  SampledMotion sampled{.times = drawn.numbers("times", max_motion_samples),
                        .positions = drawn.numbers("positions", max_motion_samples * max_track_axes),
                        .tolerances = {},
                        .weights = drawn.numbers("weights", max_track_axes),
                        .frames_per_second = drawn.number("frames_per_second")};
  for (const json& tolerance : drawn.list("tolerances", max_track_axes)) {
    if (!tolerance.is_null() && !tolerance.is_number()) refuse("motion.tolerances", "has no number");
    sampled.tolerances.push_back(tolerance.is_null() ? std::numeric_limits<double>::infinity()
                                                     : tolerance.get<double>());
  }
  if (sampled.positions.size() != sampled.times.size() * sampled.tolerances.size() ||
      sampled.weights.size() != sampled.tolerances.size())
    refuse("the motion", "has not every axis at every time");
  return sampled;
}

}  // namespace inbetween
