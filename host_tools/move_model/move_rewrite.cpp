#include "host_tools/move_model/move_rewrite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "host_tools/move_model/key_list_text.hpp"
#include "host_tools/move_model/speed_rewrite.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/text_changes.hpp"
#include "host_tools/text/toml_source.hpp"

namespace inbetween {
namespace {

/// What the reader of moves has found there.
template <class Node>
const Node& there(const Node* node) {
  if (node == nullptr) throw std::logic_error("the move is not what its reader said");
  return *node;
}

/// The bytes of a value. toml++ tells where it ends as well.
Extent extent_of(std::string_view text, const toml::source_region& source) {
  return {offset_of(text, {"", source.begin.line, source.begin.column}),
          offset_of(text, {"", source.end.line, source.end.column})};
}

/// As short as it reads back, with a decimal point if the number in its place had one.
std::string number_like(double number, std::string_view old) {
  std::string text = fmt::format("{}", number == 0 ? 0.0 : number);
  const bool is_whole = text.find_first_of(".e") == std::string::npos;
  if (is_whole && old.find('.') != std::string_view::npos) text += ".0";
  return text;
}

std::string list_of(const std::vector<double>& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

/// Sets, adds and removes the fields of one table within braces.
class InlineFields {
 public:
  InlineFields(std::string_view text, const toml::table& table, TextChanges& changes)
      : text_(text), table_(table), changes_(changes), extent_(extent_of(text, table.source())) {
    for (const auto& [key, value] : table) {
      fields_.push_back(
          {std::string(key.str()), extent_of(text, key.source()), extent_of(text, value.source())});
    }
    std::ranges::sort(fields_, {}, [](const Field& field) { return field.key.begin; });
  }

  /// Nothing takes the field away.
  void set(std::string_view name, const std::optional<std::string>& value) {
    const auto found = std::ranges::find(fields_, name, &Field::name);
    if (found == fields_.end()) {
      if (value) added_ += fmt::format(", {} = {}", name, *value);
    } else if (value) {
      if (text_.substr(found->value.begin, found->value.end - found->value.begin) != *value) {
        changes_.replace(found->value, *value);
      }
    } else if (found == fields_.begin()) {  // `at` is never taken away, so another one follows
      changes_.replace({found->key.begin, std::next(found)->key.begin}, "");
    } else {
      changes_.replace({std::prev(found)->value.end, found->value.end}, "");
    }
  }
  [[nodiscard]] const toml::node* get(std::string_view name) const { return table_.get(name); }

  void finish() {
    if (!added_.empty()) changes_.insert(fields_.back().value.end, added_);
  }

 private:
  struct Field {
    std::string name;
    Extent key, value;
  };

  std::string_view text_;
  const toml::table& table_;
  TextChanges& changes_;
  Extent extent_;
  std::vector<Field> fields_;
  std::string added_;
};

/// The position of a key: single numbers of a list where they differ; a table, in which axes may be left out,
/// becomes a list as soon as it does not say the same any more.
void set_position(std::string_view text, const MoveKey& old, const EditedKey& key, bool inherits_same,
                  InlineFields& fields, TextChanges& changes) {
  const toml::node& at = there(fields.get("at"));
  if (const toml::array* list = at.as_array()) {
    for (std::size_t d = 0; d < key.at.size(); ++d) {
      if (key.at[d] == old.at[d]) continue;
      const Extent extent = extent_of(text, there(list->get(d)).source());
      changes.replace(extent, number_like(key.at[d], text.substr(extent.begin, extent.end - extent.begin)));
    }
  } else if (key.at != old.at || !inherits_same) {
    fields.set("at", list_of(key.at));
  }
}

/// A field that is left out where it has its usual value, and stays as it is where it says the same.
template <class Value>
void set_field(InlineFields& fields, std::string_view name, const Value& old, const Value& now,
               const Value& usual, const std::string& written) {
  if (now == old) return;
  fields.set(name, now == usual ? std::nullopt : std::optional(written));
}

template <class Value>
std::string written(const std::optional<Value>& value) {
  return value ? fmt::format("{}", *value) : "";
}

void set_fields(const MoveKey& old, const EditedKey& key, InlineFields& fields) {
  set_field(fields, "tension", old.tension, key.tension, 0.0, number_like(key.tension, ""));
  set_field(fields, "continuity", old.continuity, key.continuity, 0.0, number_like(key.continuity, ""));
  set_field(fields, "bias", old.bias, key.bias, 0.0, number_like(key.bias, ""));
  set_field(fields, "frame", old.frame, key.frame, {}, written(key.frame));
  set_field(fields, "hold", old.hold, key.hold, {}, written(key.hold));
  set_field(fields, "break", old.breaks, key.breaks, false, "true");
  set_field(fields, "ease", old.ease, key.ease, false, "true");
  set_field(fields, "overlap", old.overlap, key.overlap, {}, written(key.overlap));
  set_field(fields, "round", old.round, key.round, {}, key.round ? number_like(*key.round, "") : "");
}

std::string new_key(const EditedKey& key) {
  std::string text = fmt::format("{{ at = {}", list_of(key.at));
  for (const auto& [name, value] : {std::pair("tension", key.tension),
                                    std::pair("continuity", key.continuity), std::pair("bias", key.bias)}) {
    if (value != 0) text += fmt::format(", {} = {}", name, number_like(value, ""));
  }
  if (key.frame) text += fmt::format(", frame = {}", *key.frame);
  if (key.hold) text += fmt::format(", hold = {}", *key.hold);
  if (key.breaks) text += ", break = true";
  if (key.ease) text += ", ease = true";
  if (key.overlap) text += fmt::format(", overlap = {}", *key.overlap);
  if (key.round) text += fmt::format(", round = {}", number_like(*key.round, ""));
  return text + " }";
}

bool says_the_same(const MoveKey& old, const EditedKey& key) {
  return old.at == key.at && old.tension == key.tension && old.continuity == key.continuity &&
         old.bias == key.bias && old.frame == key.frame && old.hold == key.hold && old.breaks == key.breaks &&
         old.ease == key.ease && old.overlap == key.overlap && old.round == key.round;
}

bool same_keys(const MoveTrack& track, const std::vector<EditedKey>& keys) {
  if (keys.empty()) return true;
  if (track.keys.size() != keys.size()) return false;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].from != i || !says_the_same(track.keys[i], keys[i])) return false;
  }
  return true;
}

const toml::table& track_table(const toml::table& root, std::size_t track) {
  return there(there(there(root.get_as<toml::array>("track")).get(track)).as_table());
}

std::optional<std::string> why_fixed(const MoveTrack& track, const toml::table& table, bool in_own_units) {
  if (track.table) {
    return fmt::format("the motion is that of {}, row by row; edit that file",
                       in_quotes(std::filesystem::path(track.table->file).filename().string()));
  }
  if (track.space) return "the keys are in the world; edit them as text";
  if (track.network) return "the keys go together with the drawn curves of a network; edit both as text";
  if (!track.wraps.empty()) return "an axis counts round (wrap); edit its keys as text";
  const std::vector<MoveUnit> units = in_own_units ? track.units : std::vector<MoveUnit>{};
  const auto has_others = [&](const MoveKey& key) { return key.units != units || !key.ways.empty(); };
  if (track.units != units || std::ranges::any_of(track.keys, has_others)) {
    return "the keys have units of their own; edit them as text";
  }
  for (const toml::node& key : there(table.get_as<toml::array>("keys"))) {
    if (!there(key.as_table()).is_inline()) {
      return "the keys stand in sections [[track.keys]]; write keys = [ { at = [...] }, ... ]";
    }
  }
  return std::nullopt;
}

void write_keys(std::string_view text, const toml::table& table, const MoveTrack& old,
                const EditedTrack& edited, TextChanges& changes) {
  const toml::array& array = there(table.get_as<toml::array>("keys"));
  std::vector<Extent> extents;
  for (const toml::node& key : array) extents.push_back(extent_of(text, key.source()));
  const ListText list = list_text(text, offset_of(text, place_of(array)), extents);
  std::vector<NewElement> elements;
  for (std::size_t i = 0; i < edited.keys.size(); ++i) {
    const EditedKey& key = edited.keys[i];
    if (!key.from) {
      elements.push_back({nullptr, new_key(key)});
      continue;
    }
    TextChanges within(text);
    InlineFields fields(text, there(there(array.get(*key.from)).as_table()), within);
    // A table may leave an axis where the key before it has it.
    const bool inherits_same = *key.from == 0 || (i > 0 && edited.keys[i - 1].from == *key.from - 1 &&
                                                  edited.keys[i - 1].at == old.keys[*key.from - 1].at);
    set_position(text, old.keys[*key.from], key, inherits_same, fields, within);
    set_fields(old.keys[*key.from], key, fields);
    fields.finish();
    elements.push_back({&list.elements[*key.from], within.apply(list.elements[*key.from].element)});
  }
  changes.replace(list.inside, written_list_of(list, elements));
}

/// Sets a field of a [[track]] section or adds it on a line behind `axes`.
void set_track_field(std::string_view text, const toml::table& table, std::string_view name,
                     const std::string& value, TextChanges& changes) {
  if (const toml::node* there = table.get(name)) {
    changes.replace(extent_of(text, there->source()), value);
    return;
  }
  const Extent axes = extent_of(text, there(table.get("axes")).source());
  if (table.is_inline()) {
    changes.insert(axes.end, fmt::format(", {} = {}", name, value));
    return;
  }
  const std::size_t line_end = std::min(text.find('\n', axes.end), text.size());
  changes.insert(line_end, fmt::format("\n{} = {}", name, value));
}

std::string points_of(const EditedCurve& curve) {
  std::string text = "[";
  for (std::size_t i = 0; i < curve.frames.size(); ++i) {
    text += fmt::format("{}{{ frame = {}, at = {} }}", i > 0 ? ", " : "", curve.frames[i],
                        number_like(curve.at[i], ""));
  }
  return text + "]";
}

/// A curve that is in the file is replaced, and a new one stands behind the others.
void write_curves(std::string_view text, const toml::table& table, const MoveTrack& old,
                  const std::vector<EditedCurve>& curves, TextChanges& changes) {
  if (!old.network) throw std::invalid_argument("a curve is drawn of a track that is no network");
  const toml::table& drawn = there(table.get_as<toml::table>("drawn"));
  const auto has_unit = [&](const DrawnAxis& axis) { return axis.unit != MoveUnit::of_rig; };
  if (!drawn.is_inline() || std::ranges::any_of(old.network->drawn, has_unit)) {
    throw InputError(place_of(drawn),
                     "the drawn curves have a unit or a section of their own; edit them as text");
  }
  InlineFields fields(text, drawn, changes);
  for (const EditedCurve& curve : curves) fields.set(old.axes[curve.axis], points_of(curve));
  fields.finish();
}

/// Whether a network has the curves that were asked for, and its others as they were.
bool has_curves(const MoveTrack& before, const MoveTrack& after, const std::vector<EditedCurve>& curves) {
  if (!before.network) return curves.empty();
  for (const DrawnAxis& found : after.network->drawn) {
    const auto wanted = std::ranges::find(curves, found.axis, &EditedCurve::axis);
    const auto old = std::ranges::find(before.network->drawn, found.axis, &DrawnAxis::axis);
    const bool is_wanted = wanted != curves.end();
    if (!is_wanted && old == before.network->drawn.end()) return false;
    if (found.frames != (is_wanted ? wanted->frames : old->frames)) return false;
    if (found.at != (is_wanted ? wanted->at : old->at)) return false;
  }
  const auto is_there = [&](const EditedCurve& curve) {
    return std::ranges::find(after.network->drawn, curve.axis, &DrawnAxis::axis) !=
           after.network->drawn.end();
  };
  return std::ranges::all_of(curves, is_there);
}

std::string quoted_spline(Spline spline) {
  return fmt::format("\"{}\"", spline_words.at(static_cast<std::size_t>(spline)));
}

void refuse_other_move(const MoveFile& move, const EditedMove& edited) {
  if (edited.tracks.size() != move.tracks.size())
    throw std::invalid_argument("the edited move has another number of tracks");
  for (std::size_t t = 0; t < edited.tracks.size(); ++t) {
    const std::size_t axes = coordinates_of(move.tracks[t]).size();
    const std::vector<EditedKey>& keys = edited.tracks[t].keys;
    std::vector<bool> is_used(move.tracks[t].keys.size());
    for (const EditedCurve& curve : edited.tracks[t].drawn) {
      if (curve.axis >= axes || curve.frames.size() != curve.at.size() || curve.frames.empty())
        throw std::invalid_argument("a drawn curve of no axis, or without points");
    }
    for (const EditedKey& key : keys) {
      if (key.at.size() != axes) throw std::invalid_argument("a key with another number of coordinates");
      if (!std::ranges::all_of(key.at, [](double x) { return std::isfinite(x); }))
        throw std::invalid_argument("a key that is no number");
      if (!key.from) continue;
      if (*key.from >= is_used.size() || is_used[*key.from])
        throw std::invalid_argument("a key that is not there, or is there twice");
      is_used[*key.from] = true;
    }
  }
}

/// What was read from the result, against what was asked for.
void expect_edited(const MoveFile& before, const MoveFile& after, const EditedMove& edited) {
  bool same = after.frames == edited.frames && after.fps.as_written == edited.fps &&
              after.name == before.name && after.tracks.size() == edited.tracks.size();
  for (std::size_t t = 0; same && t < edited.tracks.size(); ++t) {
    const EditedTrack& wanted = edited.tracks[t];
    const MoveTrack& found = after.tracks[t];
    same = found.spline == wanted.spline && found.closed == wanted.closed &&
           found.axes == before.tracks[t].axes && found.weights == before.tracks[t].weights &&
           has_curves(before.tracks[t], found, wanted.drawn) &&
           (wanted.keys.empty()
                ? found.keys.size() == before.tracks[t].keys.size()
                : found.keys.size() == wanted.keys.size() &&
                      std::equal(found.keys.begin(), found.keys.end(), wanted.keys.begin(), says_the_same)) &&
           found.speed == wanted.speed.value_or(before.tracks[t].speed);
  }
  if (!same) throw std::logic_error("the rewritten move is not the move that was asked for");
}

}  // namespace

EditedMove edits_of(const MoveFile& move) {
  EditedMove edited{.frames = move.frames, .fps = move.fps.as_written, .tracks = {}};
  for (const MoveTrack& track : move.tracks) {
    EditedTrack same{.keys = {}, .speed = std::nullopt, .spline = track.spline, .closed = track.closed};
    for (std::size_t k = 0; k < track.keys.size(); ++k) {
      const MoveKey& key = track.keys[k];
      same.keys.push_back({.from = k,
                           .at = key.at,
                           .tension = key.tension,
                           .continuity = key.continuity,
                           .bias = key.bias,
                           .frame = key.frame,
                           .hold = key.hold,
                           .breaks = key.breaks,
                           .ease = key.ease,
                           .overlap = key.overlap,
                           .round = key.round});
    }
    edited.tracks.push_back(std::move(same));
  }
  return edited;
}

std::optional<std::string> why_keys_are_fixed(std::string_view text, const std::string& file_name,
                                              std::size_t track) {
  return why_fixed(parse_move(text, file_name).tracks.at(track),
                   track_table(parse_toml(text, file_name), track), false);
}

std::string with_edits(std::string_view text, const std::string& file_name, const EditedMove& edited) {
  const MoveFile before = parse_move(text, file_name);
  refuse_other_move(before, edited);
  const toml::table root = parse_toml(text, file_name);
  TextChanges changes(text);
  if (edited.frames != before.frames) {
    changes.replace(extent_of(text, there(root.get("frames")).source()), fmt::format("{}", edited.frames));
  }
  if (edited.fps != before.fps.as_written) {
    const bool is_fraction = edited.fps.find('/') != std::string::npos;
    changes.replace(extent_of(text, there(root.get("fps")).source()),
                    is_fraction ? fmt::format("\"{}\"", edited.fps) : edited.fps);
  }
  for (std::size_t t = 0; t < edited.tracks.size(); ++t) {
    const EditedTrack& track = edited.tracks[t];
    const MoveTrack& old = before.tracks[t];
    const toml::table& table = track_table(root, t);
    if (!same_keys(old, track.keys)) {
      if (const auto why = why_fixed(old, table, track.in_own_units)) throw InputError(old.place, *why);
      write_keys(text, table, old, track, changes);
    }
    if (track.spline != old.spline)
      set_track_field(text, table, "spline", quoted_spline(track.spline), changes);
    if (!track.drawn.empty()) write_curves(text, table, old, track.drawn, changes);
    if (track.closed != old.closed) {
      set_track_field(text, table, "closed", track.closed ? "true" : "false", changes);
    }
  }
  std::string result = changes.apply();
  for (std::size_t t = 0; t < edited.tracks.size(); ++t) {
    if (edited.tracks[t].speed) result = with_speed(result, file_name, t, *edited.tracks[t].speed);
  }
  if (result.size() > max_file_bytes) {
    throw InputError({file_name}, "the edited file would be larger than 8 MiB; shorten its comments");
  }
  expect_edited(before, parse_move(result, file_name), edited);
  return result;
}

}  // namespace inbetween
