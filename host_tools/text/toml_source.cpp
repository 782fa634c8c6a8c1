#include "host_tools/text/toml_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace inbetween {
namespace {

bool continues_a_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xc0U) == 0x80U;
}

/// Line and column of the byte at `offset`.
Place place_at(std::string_view text, std::size_t offset, const std::string& file_name) {
  const std::string_view before = text.substr(0, offset);
  const std::size_t last_break = before.rfind('\n');
  std::string_view line = last_break == before.npos ? before : before.substr(last_break + 1);
  const auto line_breaks = std::count(before.begin(), before.end(), '\n');
  const auto columns =
      std::count_if(line.begin(), line.end(), [](char c) { return !continues_a_character(c); });
  return {file_name, static_cast<std::uint32_t>(line_breaks) + 1, static_cast<std::uint32_t>(columns) + 1};
}

/// Length in bytes of the character that `text` begins with, 0 if it is not well-formed UTF-8
/// (The Unicode Standard, table 3-7).
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(text[i])); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!continues_a_character(text[i])) return 0;
  }
  const bool overlong = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xf0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xed && byte(1) > 0x9f;
  const bool beyond_unicode = lead == 0xf4 && byte(1) > 0x8f;
  return overlong || surrogate || beyond_unicode ? 0 : length;
}

void refuse_invalid_utf8(std::string_view text, const std::string& file_name) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text.substr(at));
    if (length == 0) {
      throw InputError(place_at(text, at, file_name),
                       fmt::format("byte 0x{:02x} is not UTF-8 text; save the file as UTF-8",
                                   static_cast<unsigned>(static_cast<unsigned char>(text[at]))));
    }
    at += length;
  }
}

/// Refuses a character beyond ASCII behind the backslash at `backslash`, or behind the white space that it
/// joins.
void refuse_beyond_ascii_behind(std::string_view text, std::size_t backslash, const std::string& file_name) {
  const std::size_t at = text.find_first_not_of(" \t\r\n\v\f", backslash + 1);
  if (at == text.npos || static_cast<unsigned char>(text[at]) < 0x80) return;
  throw InputError(place_at(text, at, file_name),
                   fmt::format("{} directly after a backslash; leave the backslash out",
                               in_quotes(text.substr(at, character_length(text.substr(at))))));
}

/// Offset behind the string, one-line or multi-line, that begins at `begin`. A one-line string that its line
/// does not close ends there: toml++ refuses it.
std::size_t end_of_string(std::string_view text, std::size_t begin, const std::string& file_name) {
  const char quote = text[begin];
  const std::string three(3, quote);
  const bool multi_line = text.substr(begin, 3) == three;
  std::size_t at = begin + (multi_line ? 3 : 1);
  while (at < text.size()) {
    if (text[at] == '\\' && quote == '"') {
      // Only in a string of several lines does toml++ ask whether what follows is white space.
      if (multi_line) refuse_beyond_ascii_behind(text, at, file_name);
      at += 2;
    } else if (multi_line && text.substr(at, 3) == three) {
      at += 3;
      for (int extra = 0; extra < 2 && at < text.size() && text[at] == quote; ++extra) ++at;
      return at;
    } else if (!multi_line && (text[at] == quote || text[at] == '\n')) {
      return at + (text[at] == quote ? 1 : 0);
    } else {
      ++at;
    }
  }
  return text.size();
}

/// The brackets that are open, and whether a value or a name comes next.
class TomlPosition {
 public:
  /// Takes up a character outside strings and comments.
  void pass(char c, bool line_begins) {
    if (c == '[' || c == '{') {
      const bool of_header =
          c == '[' && !after_equals_ && (open_.empty() ? line_begins : open_.back() == header);
      open_ += of_header ? header : c;
      after_equals_ = false;
    } else if (c == ']' || c == '}') {
      if (!open_.empty()) {
        // What is closed here was the value of a name, unless it was a header.
        after_equals_ = open_.back() != header;
        open_.pop_back();
      }
    } else if (c == '=') {
      after_equals_ = true;
    } else if (c == ',' || (c == '\n' && open_.empty())) {
      after_equals_ = false;
    }
  }

  std::size_t depth() const { return open_.size(); }
  bool in_value() const { return after_equals_ || (!open_.empty() && open_.back() == '['); }

 private:
  static constexpr char header = 'h';
  std::string open_;
  bool after_equals_ = false;
};

/// Refuses text that would nest too deep for the stack or have too many fields, by brackets, the dots of each
/// key and the equals signs outside strings and comments. Characters beyond ASCII are refused there as well:
/// TOML has none, and toml++ 3.3 does not define what it does with them (is_non_ascii_horizontal_whitespace
/// reaches its unreachable default). This pass need not be right about text that is not TOML: toml++ stops at
/// the first error, and up to there both agree.
void refuse_unsafe_structure(std::string_view text, const std::string& file_name) {
  TomlPosition position;
  std::size_t dots = 0;
  std::size_t fields = 0;
  bool line_begins = true;
  bool in_bare_value = false;  // within a number, a date or a word
  std::size_t at = 0;
  const auto refuse = [&](std::string message) {
    throw InputError(place_at(text, at, file_name), std::move(message));
  };
  while (at < text.size()) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      // toml++ takes what is in quotes that follow directly on a word for more of the word, where it must not
      // meet such characters. A part of a name may be in quotes: bus."can 0".
      const std::string_view may_precede = position.in_value() ? " \t\r\n=[,\"'" : " \t\r\n[{,.\"'";
      if (in_bare_value || (at > 0 && may_precede.find(text[at - 1]) == may_precede.npos)) {
        refuse(fmt::format("a quote directly after {}; is a blank or an = missing?",
                           in_quotes(text.substr(at - 1, 1))));
      }
      at = end_of_string(text, at, file_name);
      line_begins = false;
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '\0') refuse("a zero byte is not valid TOML; is this a text file?");
    if (static_cast<unsigned char>(c) >= 0x80) {
      const std::string_view character = text.substr(at, character_length(text.substr(at)));
      refuse(fmt::format("{} outside quotes; put the text in double quotes", in_quotes(character)));
    }
    if (std::string_view(" \t\r\n\v\f]},").find(c) != std::string_view::npos) {
      in_bare_value = false;
    } else if (position.in_value() && std::string_view("[{=").find(c) == std::string_view::npos) {
      in_bare_value = true;  // toml++ takes every =, quote and opening bracket up to its end for more of it
    }
    position.pass(c, line_begins);
    if (c == '.') ++dots;
    if (std::string_view("[]{}=,\n").find(c) != std::string_view::npos) dots = 0;
    if (c == '=' || (c == '[' && line_begins)) ++fields;
    line_begins = c == '\n' || (line_begins && (c == ' ' || c == '\t' || c == '\r'));
    if (position.depth() + dots > max_toml_nesting) {
      refuse(fmt::format("nested deeper than {} levels; remove brackets or dots", max_toml_nesting));
    }
    if (fields > max_toml_fields) {
      refuse(fmt::format("more than {} fields in one file; split the file", max_toml_fields));
    }
    ++at;
  }
}

/// toml++ reports a second key and a number out of range where it has finished reading them. This is the
/// offset where `token` begins, in the line and before the column that toml++ gives.
std::size_t beginning_of_token(std::string_view text, toml::source_position reported,
                               std::string_view token) {
  std::size_t line_begin = 0;
  for (std::uint32_t line = 1; line < reported.line; ++line) line_begin = text.find('\n', line_begin) + 1;
  std::size_t end = line_begin;
  for (std::uint32_t column = 1; column < reported.column && end < text.size(); ++column) {
    do ++end;
    while (end < text.size() && continues_a_character(text[end]));
  }
  const std::size_t found = text.substr(line_begin, end - line_begin).rfind(token);
  return found == text.npos ? end : line_begin + found;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Where toml++ stopped behind the comma of a number, the number: "29,97".
std::string_view number_with_comma(std::string_view text, std::size_t stopped) {
  std::size_t end = std::min(stopped, text.size());
  while (end > 0 && text[end - 1] == ' ') --end;
  if (end == stopped && end + 1 < text.size() && text[end] == ',' && is_digit(text[end + 1])) ++end;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::size_t comma = end;
  while (comma > 0 && is_digit(text[comma - 1])) --comma;
  if (comma == end || comma < 2 || text[comma - 1] != ',' || !is_digit(text[comma - 2])) return {};
  std::size_t begin = comma - 1;
  while (begin > 0 && (is_digit(text[begin - 1]) || text[begin - 1] == '-')) --begin;
  return text.substr(begin, end - begin);
}

/// The word without quotes at which toml++ stopped; empty where there is none.
std::string_view bare_word(std::string_view text, std::size_t stopped) {
  const auto is_of_word = [](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
  };
  std::size_t begin = std::min(stopped, text.size());
  while (begin > 0 && is_of_word(text[begin - 1])) --begin;
  std::size_t end = begin;
  while (end < text.size() && is_of_word(text[end])) ++end;
  if (begin == end || is_digit(text[begin]) || text[begin] == '-') return {};
  return text.substr(begin, end - begin);
}

/// What is to be written in the place of such a word.
std::string meant_by(std::string_view word) {
  std::string small(word);
  std::ranges::transform(small, small.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (small == "yes" || small == "on" || small == "true") return "true";
  if (small == "no" || small == "off" || small == "false") return "false";
  return fmt::format("\"{}\"", word);
}

InputError not_toml(const toml::parse_error& error, std::string_view text, const std::string& file_name) {
  std::string_view description = error.description();
  constexpr std::string_view prefix = "Error while parsing ";
  if (description.starts_with(prefix)) description.remove_prefix(prefix.size());

  const std::size_t first = description.find('\'');
  const std::size_t last = description.rfind('\'');
  const std::string_view token = first < last ? description.substr(first + 1, last - first - 1) : "";
  const auto says = [&](std::string_view words) { return description.find(words) != description.npos; };
  const toml::source_position reported = error.source().begin;
  const auto at_token = [&] { return place_at(text, beginning_of_token(text, reported, token), file_name); };

  if (says("cannot redefine existing") && !token.empty()) {
    return {at_token(), fmt::format("{} is given a second time; keep one of the two", in_quotes(token))};
  }
  if (says("is not representable in 64 bits") || says("could not be interpreted as a value")) {
    return {at_token(),
            fmt::format("{} is too large or too long for a number; write a smaller one", in_quotes(token))};
  }
  const Place place{file_name, reported.line, reported.column};
  const std::size_t stopped = beginning_of_token(text, reported, "");
  if (says("key-value pair")) {
    const std::string_view number = number_with_comma(text, stopped);
    if (!number.empty()) {
      std::string with_point(number);
      std::ranges::replace(with_point, ',', '.');
      return {place, fmt::format("{} has a decimal comma; write {}", number, with_point)};
    }
  }
  if (says("value type") || says("boolean") || says("floating-point")) {
    const std::string_view word = bare_word(text, stopped);
    if (!word.empty())
      return {place, fmt::format("{} is neither a number nor in quotes; write {}", word, meant_by(word))};
  }
  return {place, fmt::format("not valid TOML, {}; correct it here", description)};
}

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& file_name) {
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  refuse_invalid_utf8(text, file_name);
  refuse_unsafe_structure(text, file_name);
  try {
    return toml::parse(text, std::string_view(file_name));
  } catch (const toml::parse_error& error) {
    throw not_toml(error, text, file_name);
  }
}

Place place_of(const toml::node& node) {
  const toml::source_region& source = node.source();
  return {source.path ? *source.path : std::string(), std::max(source.begin.line, 1U),
          std::max(source.begin.column, 1U)};
}

std::size_t offset_of(std::string_view text, const Place& place) {
  std::size_t at = text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0;
  for (std::uint32_t line = 1; line < place.line; ++line) at = text.find('\n', at) + 1;
  const auto continues_a_character = [&](std::size_t i) {
    return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xc0U) == 0x80U;
  };
  for (std::uint32_t column = 1; column < place.column; ++column) {
    do ++at;
    while (continues_a_character(at));
  }
  return at;
}

}  // namespace inbetween
