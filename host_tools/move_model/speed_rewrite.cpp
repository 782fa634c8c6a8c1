#include "host_tools/move_model/speed_rewrite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "host_tools/text/text_changes.hpp"
#include "host_tools/text/toml_source.hpp"

namespace inbetween {
namespace {

/// A list of numbers as it is written: commas[i] is the one behind numbers[i].
struct WrittenList {
  std::vector<Extent> numbers;
  std::vector<std::size_t> commas;
};

/// The list whose '[' is at `begin`. The reader has found numbers in it and nothing else, so that every byte
/// is of a number, a comment, a comma or blank.
WrittenList written_list(std::string_view text, std::size_t begin) {
  if (begin >= text.size() || text[begin] != '[')
    throw std::logic_error("the speed of a track does not begin where the reader says");
  WrittenList list;
  for (std::size_t at = begin + 1; at < text.size() && text[at] != ']';) {
    if (text[at] == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else if (text[at] == ',') {
      list.commas.push_back(at++);
    } else if (std::string_view(" \t\r\n").find(text[at]) != std::string_view::npos) {
      ++at;
    } else {
      const std::size_t end = std::min(text.find_first_of(" \t\r\n,#]", at), text.size());
      list.numbers.push_back({at, end});
      at = end;
    }
  }
  return list;
}

/// The text between the last two numbers, with the comma.
std::string_view separator(std::string_view text, const WrittenList& list) {
  constexpr std::string_view plain = ", ";
  if (list.numbers.size() < 2) return plain;
  const std::size_t begin = list.numbers[list.numbers.size() - 2].end;
  const std::string_view between = text.substr(begin, list.numbers.back().begin - begin);
  return between.find('#') == std::string_view::npos ? between : plain;
}

/// Zero is written without a sign, which a whole number could not keep.
void append_number(std::string& text, double number) {
  fmt::format_to(std::back_inserter(text), "{}", number == 0 ? 0.0 : number);
}

std::string rewritten(std::string_view text, const WrittenList& list, std::span<const double> speed) {
  std::string result;
  std::size_t copied = 0;
  const auto copy_until = [&](std::size_t offset) {
    result += text.substr(copied, offset - copied);
    copied = offset;
  };
  for (std::size_t i = 0; i < list.numbers.size(); ++i) {
    if (i >= speed.size()) {
      copy_until(list.commas[i - 1]);
      ++copied;
    }
    copy_until(list.numbers[i].begin);
    copied = list.numbers[i].end;
    if (i < speed.size()) append_number(result, speed[i]);
  }
  // The text behind the last number is not copied yet.
  for (std::size_t i = list.numbers.size(); i < speed.size(); ++i) {
    result += separator(text, list);
    append_number(result, speed[i]);
  }
  copy_until(text.size());
  return result;
}

bool same_key(const MoveKey& a, const MoveKey& b) {
  return a.at == b.at && a.units == b.units && a.ways == b.ways && a.tension == b.tension &&
         a.continuity == b.continuity && a.bias == b.bias && a.frame == b.frame && a.breaks == b.breaks &&
         a.hold == b.hold && a.ease == b.ease && a.overlap == b.overlap && a.round == b.round;
}

std::int32_t frames_of(const std::optional<EaseRequest>& ease) {
  return ease ? ease->frames : 0;
}

bool same_but_speed(const MoveTrack& a, const MoveTrack& b) {
  return a.axes == b.axes && a.units == b.units && a.wraps == b.wraps && a.spline == b.spline &&
         a.closed == b.closed && a.periodic == b.periodic && a.weights == b.weights && a.timing == b.timing &&
         a.kinetic == b.kinetic && a.rest == b.rest && a.ease_corners == b.ease_corners &&
         a.overshoot == b.overshoot && a.through == b.through && a.overlap == b.overlap &&
         a.round == b.round && frames_of(a.ease_in) == frames_of(b.ease_in) &&
         frames_of(a.ease_out) == frames_of(b.ease_out) &&
         std::equal(a.keys.begin(), a.keys.end(), b.keys.begin(), b.keys.end(), same_key);
}

/// Whether `after` is the move `before` with `speed` in one track, played as it is.
bool only_speed_changed(MoveFile before, const MoveFile& after, std::size_t track,
                        std::span<const double> speed) {
  replace_curve(before.tracks[track], {speed.begin(), speed.end()});
  bool same = before.name == after.name && before.fps.as_written == after.fps.as_written &&
              before.fps.written_as_integer == after.fps.written_as_integer &&
              before.frames == after.frames && before.tracks.size() == after.tracks.size();
  for (std::size_t i = 0; same && i < before.tracks.size(); ++i) {
    const std::vector<double>& wanted = before.tracks[i].speed;
    const std::vector<double>& found = after.tracks[i].speed;
    same = same_but_speed(before.tracks[i], after.tracks[i]) &&
           std::equal(wanted.begin(), wanted.end(), found.begin(), found.end());
  }
  return same;
}

/// Where a word or number without quotes that begins there ends.
std::size_t end_of_word(std::string_view text, std::size_t begin) {
  return std::min(text.find_first_of(" \t\r\n,#}]", begin), text.size());
}

/// The file with every request of the track about its curve as drawn: the new one has what they asked for.
std::string without_requests(std::string text, const MoveTrack& track) {
  for (std::size_t i = track.curve_requests.size(); i-- > 0;) {
    const CurveRequest& request = track.curve_requests[i];
    const std::size_t begin = offset_of(text, request.place);
    const bool is_quoted = text[begin] == '"' || text[begin] == '\'';
    const std::size_t end = is_quoted ? text.find(text[begin], begin + 1) + 1 : end_of_word(text, begin);
    text.replace(begin, end - begin, request.as_drawn);
  }
  return text;
}

void refuse_unusable(std::span<const double> speed) {
  if (speed.empty()) throw std::invalid_argument("a speed curve needs a control value");
  for (const double value : speed) {
    if (!(value >= 0 && value <= max_control_value))
      throw std::invalid_argument(fmt::format("{} is no control value of a speed curve", value));
  }
}

}  // namespace

std::string with_numbers(std::string_view text, std::vector<NumberAt> numbers) {
  // From the last to the first, so that the places of those that are left stay.
  std::ranges::sort(numbers, std::ranges::greater{},
                    [](const NumberAt& number) { return std::pair(number.place.line, number.place.column); });
  std::string result(text);
  for (const NumberAt& number : numbers) {
    const std::size_t begin = offset_of(result, number.place);
    result.replace(begin, end_of_word(result, begin) - begin, fmt::format("{}", number.number));
  }
  return result;
}

void refuse_too_many_values(const MoveFile& move, std::size_t track, std::size_t values) {
  if (values <= max_control_values) return;
  throw InputError(move.tracks.at(track).speed_place,
                   fmt::format("the new speed curve of track {} has {} control values, and a file holds at "
                               "most {}; draw it with fewer",
                               track, values, max_control_values));
}

std::string with_speed(std::string_view text, const std::string& file_name, std::size_t track,
                       std::span<const double> speed) {
  refuse_unusable(speed);
  const MoveFile before = parse_move(text, file_name);
  const MoveTrack& changed = before.tracks.at(track);
  if (changed.timing == Timing::frames) {
    throw InputError(changed.place,
                     fmt::format("track {} has timing = \"frames\" and therefore no speed curve to change; "
                                 "give its keys other frames, or time it by speed",
                                 track));
  }
  refuse_too_many_values(before, track, speed.size());
  const std::string plain = without_requests(std::string(text), changed);
  const Place list = parse_move(plain, file_name).tracks.at(track).speed_place;
  std::string result = rewritten(plain, written_list(plain, offset_of(plain, list)), speed);
  if (result.size() > max_file_bytes) {
    throw InputError(changed.speed_place,
                     fmt::format("with the new speed curve the file would have {} bytes, more than the {} "
                                 "allowed; shorten its comments",
                                 result.size(), max_file_bytes));
  }
  if (!only_speed_changed(before, parse_move(result, file_name), track, speed))
    throw std::logic_error("the rewritten move is not the move with the new speed curve");
  return result;
}

}  // namespace inbetween
