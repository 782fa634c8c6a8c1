#include "host_tools/move_model/taught_move.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "host_tools/move_model/move_rewrite.hpp"
#include "host_tools/rig_model/move_unit.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

/// Why a step does nothing.
struct NotTaught {
  std::string why;
};

std::string message_of(int error) {
  return std::generic_category().message(error);
}

std::string target_of(const std::string& path) {
  std::error_code error;
  const std::filesystem::path behind = std::filesystem::canonical(path, error);
  return error ? path : behind.string();
}

/// With quotes. TOML's basic strings have all of JSON's escapes.
std::string toml_string(const std::string& text) {
  return nlohmann::json(text).dump();
}

MoveUnit unit_in(const MoveTrack& track, std::size_t axis) {
  return track.units.empty() ? MoveUnit::of_rig : track.units[axis];
}

/// The nearest number with a decimal more than the counts need, inside the limits: a limit itself has more
/// decimals where it must.
double decimal_near(double position, double count, double min, double max) {
  constexpr int max_decimals = 9;
  const int needed = count > 0 ? static_cast<int>(std::ceil(-std::log10(count))) + 1 : max_decimals;
  const double power = std::pow(10.0, std::clamp(needed, 0, max_decimals));
  return std::clamp(std::round(position * power) / power, min, max);
}

/// Outside by so little is a rounding of the drive.
bool is_inside(double position, const RigAxis& axis) {
  const double slack = std::max(count_of(axis), 1e-9 * (axis.max - axis.min));
  return position >= axis.min - slack && position <= axis.max + slack;
}

}  // namespace

TaughtMove::TaughtMove(FileLayer files, const std::string& path, const RigFile& rig,
                       std::vector<std::size_t> axes_of_new)
    : files_(std::move(files)),
      name_(path),
      target_(target_of(path)),
      rig_(rig),
      axes_of_new_(std::move(axes_of_new)) {
  std::string text;
  const int error = files_.read(target_, max_file_bytes, text);
  if (error == ENOENT) return;
  if (error != 0) {
    throw InputError({path}, fmt::format("cannot be read: {}; name a move, or a file that is not there yet",
                                         message_of(error)));
  }
  take(std::move(text));
}

void TaughtMove::take(std::string text) {
  MoveFile move = parse_move(text, name_);
  for (const MoveTrack& track : move.tracks) {
    for (std::size_t d = 0; d < track.axes.size(); ++d) {
      if (std::ranges::find(rig_.axes, track.axes[d], &RigAxis::name) != rig_.axes.end()) continue;
      throw InputError(track.axis_places[d], fmt::format("the rig {} has no axis {}; correct the name",
                                                         in_quotes(rig_.name), in_quotes(track.axes[d])));
    }
  }
  move_ = std::move(move);
  text_ = std::move(text);
  chosen_.resize(move_.tracks.size());
  for (std::size_t t = 0; t < chosen_.size(); ++t) {
    chosen_[t] = std::min(chosen_[t], move_.tracks[t].keys.size() - 1);
  }
}

const RigAxis& TaughtMove::rig_axis(const std::string& name) const {
  return *std::ranges::find(rig_.axes, name, &RigAxis::name);
}

std::optional<std::size_t> TaughtMove::track_of(std::size_t axis) const {
  for (std::size_t t = 0; t < move_.tracks.size(); ++t) {
    if (std::ranges::find(move_.tracks[t].axes, rig_.axes[axis].name) != move_.tracks[t].axes.end()) return t;
  }
  return std::nullopt;
}

std::size_t TaughtMove::known_track_of(std::size_t axis) const {
  if (!text_) throw NotTaught{fmt::format("{} is not there yet: Enter makes it", name_)};
  if (const auto track = track_of(axis)) return *track;
  throw NotTaught{
      fmt::format("{} has no track of axis {}: choose another axis", name_, in_quotes(rig_.axes[axis].name))};
}

template <class Action>
void TaughtMove::guarded(const Action& action) {
  try {
    action();
  } catch (const NotTaught& refused) {
    words_ = refused.why;
  } catch (const std::exception& error) {
    words_ = error.what();
  }
}

void TaughtMove::refuse_changed_file() {
  std::string now;
  const int error = files_.read(target_, max_file_bytes, now);
  if (error == ENOENT && !text_) return;
  if (error == 0 && text_ == now) return;
  undos_.clear();
  if (error == ENOENT) {
    text_.reset();
    move_ = {};
    chosen_.clear();
    throw NotTaught{fmt::format("{} is gone: the next key makes it anew", name_)};
  }
  if (error != 0) throw NotTaught{fmt::format("{} cannot be read: {}", name_, message_of(error))};
  take(std::move(now));
  throw NotTaught{fmt::format("{} was changed by somebody else and is read again: press again", name_)};
}

void TaughtMove::write(const std::string& text) {
  const FileFailure failure = replace_expected(files_, target_, text_, text);
  if (failure.error == ESTALE) refuse_changed_file();
  if (failure) {
    throw NotTaught{fmt::format("{} {}: {}", failure.path, failure.what, message_of(failure.error))};
  }
}

std::vector<double> TaughtMove::position_of(const MoveTrack& track, const StandingAxes& standing) const {
  std::vector<double> at;
  for (std::size_t d = 0; d < track.axes.size(); ++d) {
    const RigAxis& axis = rig_axis(track.axes[d]);
    const auto& stands = standing[static_cast<std::size_t>(&axis - rig_.axes.data())];
    if (!stands) {
      throw NotTaught{fmt::format("{} does not know where it is: home it, or goto --set-zero", named(axis))};
    }
    if (!is_inside(*stands, axis)) {
      throw NotTaught{
          fmt::format("{} stands at {:g}, outside {}", named(axis), *stands, range_in_words(axis))};
    }
    const std::optional<double> size = converted(1, unit_in(track, d), axis.unit);
    if (!size) {
      throw NotTaught{fmt::format("{} counts {} in the rig, and {} in the move", named(axis),
                                  to_string(axis.unit), to_string(unit_in(track, d)))};
    }
    at.push_back(decimal_near(*stands / *size, count_of(axis) / *size, axis.min / *size, axis.max / *size));
  }
  return at;
}

/// One track of all these axes passes its keys with all of them at once. It stands still until it has a
/// second key.
void TaughtMove::make(const StandingAxes& standing) {
  MoveTrack track;
  std::vector<std::string> names;
  for (const std::size_t axis : axes_of_new_) {
    track.axes.push_back(rig_.axes[axis].name);
    names.push_back(toml_string(track.axes.back()));
  }
  const std::string text = fmt::format(
      "# Keys taught with inbetween jog. frames says how long the move takes, speed how fast it is where.\n"
      "name   = {}\nfps    = 24\nframes = 96\n\n[[track]]\naxes  = [{}]\nkeys  = [\n  {{ at = [{}] }},\n]\n"
      "speed = [0, 0, 10, 10, 0, 0]\n",
      toml_string(std::filesystem::path(name_).stem().string()), fmt::join(names, ", "),
      fmt::join(position_of(track, standing), ", "));
  static_cast<void>(parse_move(text, name_));
  write(text);
  take(text);
  undos_.push_back({.text = "", .chosen = {}, .has_made = true});
  ++stored_;
  words_ = fmt::format("{} is made, with key 0", name_);
}

void TaughtMove::ask_if_near(std::size_t t, std::size_t index, Where where, const std::vector<double>& at) {
  Asked asked{t, index, where, at};
  const MoveTrack& track = move_.tracks[t];
  // Over frames a place that comes twice is a hold.
  if (asked_ == asked || track.timing == Timing::frames) return;
  const std::size_t behind = where == Where::in_place ? index + 1 : index;
  for (const std::size_t k : {index - 1, behind}) {
    if (k >= track.keys.size()) continue;
    std::vector<std::string> distances;
    bool is_near = true;
    for (std::size_t d = 0; d < at.size(); ++d) {
      const RigAxis& axis = rig_axis(track.axes[d]);
      const double size = *converted(1, unit_in(track, d), axis.unit);
      const double distance = std::fabs(track.keys[k].at[d] - at[d]) * size;
      is_near = is_near && distance <= std::max(near_share * (axis.max - axis.min), 2 * count_of(axis));
      if (distance > 0)
        distances.push_back(fmt::format("{} {:.3g} {}", axis.name, distance, to_string(axis.unit)));
    }
    if (!is_near) continue;
    asked_ = std::move(asked);
    const char* again = where == Where::in_place ? "t" : where == Where::before_chosen ? "i" : "Enter";
    throw NotTaught{fmt::format(
        "key {} is here already ({}): {} again stores it all the same", k,
        distances.empty() ? "the same place" : fmt::format("{} away", fmt::join(distances, ", ")), again)};
  }
}

void TaughtMove::store(std::size_t axis, const StandingAxes& standing, Where where) {
  refuse_changed_file();
  if (!text_) return make(standing);
  const std::size_t t = known_track_of(axis);
  const MoveTrack& track = move_.tracks[t];
  if (track.table) throw NotTaught{"this track plays the rows of a table: edit that file"};
  if (track.timing == Timing::frames && where != Where::in_place) {
    throw NotTaught{"the keys of this track have frames, and a new one would need one: add it in the file"};
  }
  if (track.space) {
    throw NotTaught{
        "the keys of this track are places in the world, and no positions of axes: edit the file"};
  }
  EditedMove edited = edits_of(move_);
  EditedTrack& changed = edited.tracks[t];
  changed.in_own_units = true;
  const bool is_behind = where == Where::behind_all;
  const std::size_t index = is_behind ? track.keys.size() : chosen_[t];
  const std::vector<double> at = position_of(track, standing);
  ask_if_near(t, index, where, at);
  asked_.reset();
  if (where == Where::in_place) {
    changed.keys[index].at = at;
  } else {
    changed.keys.insert(changed.keys.begin() + static_cast<std::ptrdiff_t>(index), EditedKey{.at = at});
  }
  const std::string text = with_edits(*text_, name_, edited);
  write(text);
  Undo undo{.text = std::exchange(text_, text).value(), .chosen = chosen_};
  take(text);
  undos_.push_back(std::move(undo));
  ++stored_;
  if (where == Where::before_chosen) ++chosen_[t];
  if (is_behind) chosen_[t] = index;
  words_ = fmt::format("{} key {}: {}",
                       where == Where::in_place ? "replaced"
                       : is_behind              ? "appended"
                                                : "inserted",
                       index, key_words(move_.tracks[t], index));
}

void TaughtMove::choose(std::size_t axis, int by) {
  guarded([&] {
    const std::size_t t = known_track_of(axis);
    const std::size_t last = move_.tracks[t].keys.size() - 1;
    if (by > 0 ? chosen_[t] == last : chosen_[t] == 0) {
      throw NotTaught{by > 0 ? "this is the last key" : "this is the first key"};
    }
    chosen_[t] += static_cast<std::size_t>(by);
    words_.clear();
    asked_.reset();
  });
}

void TaughtMove::insert(std::size_t axis, const StandingAxes& standing) {
  guarded([&] { store(axis, standing, Where::before_chosen); });
}

void TaughtMove::replace(std::size_t axis, const StandingAxes& standing) {
  guarded([&] { store(axis, standing, Where::in_place); });
}

void TaughtMove::append(std::size_t axis, const StandingAxes& standing) {
  guarded([&] { store(axis, standing, Where::behind_all); });
}

void TaughtMove::undo() {
  guarded([&] {
    asked_.reset();
    refuse_changed_file();
    if (undos_.empty()) throw NotTaught{"there is no key to take back"};
    const Undo& last = undos_.back();
    if (last.has_made) throw NotTaught{fmt::format("key 0 made {}: replace it, or remove the file", name_)};
    write(last.text);
    chosen_ = last.chosen;
    take(last.text);
    undos_.pop_back();
    --stored_;
    words_ = "the last key is taken back";
  });
}

std::string TaughtMove::key_words(const MoveTrack& track, std::size_t key) const {
  const std::vector<std::string> names = coordinates_of(track);
  std::string words;
  for (std::size_t d = 0; d < names.size(); ++d) {
    words += fmt::format("{}{} {:g}", d == 0 ? "" : ", ", names[d], track.keys[key].at[d]);
  }
  if (track.keys[key].frame) words += fmt::format(", frame {}", *track.keys[key].frame);
  return words;
}

std::vector<std::string> TaughtMove::shown(std::size_t axis, std::size_t max_rows) const {
  const auto t = text_ ? track_of(axis) : std::nullopt;
  if (!text_) return {fmt::format("{} is not there yet", name_), words_};
  if (!t) return {fmt::format("{} has no track of axis {}", name_, in_quotes(rig_.axes[axis].name)), words_};
  const MoveTrack& track = move_.tracks[*t];
  const std::size_t count = track.keys.size();
  std::vector<std::string> lines{fmt::format("{}: key {} of 0 to {}", name_, chosen_[*t], count - 1), words_};
  const std::size_t rows = std::min(count, max_rows);
  const std::size_t before = std::min(chosen_[*t], rows / 2);
  const std::size_t first = std::min(chosen_[*t] - before, count - rows);
  for (std::size_t k = first; k < first + rows; ++k) {
    lines.push_back(fmt::format("{} {:<4}{}", k == chosen_[*t] ? ">" : " ", k, key_words(track, k)));
  }
  return lines;
}

}  // namespace inbetween
