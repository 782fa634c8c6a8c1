#include "host_tools/text/ini_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

constexpr std::string_view spaces = " \t\r\f\v";

template <class Number>
bool is_hexadecimal(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  return error == std::errc{} && end == text.data() + text.size() && !text.empty();
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& letter : lower) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return lower;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(spaces);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(spaces) - begin + 1);
}

std::string_view IniValue::number_text() const {
  return trimmed(std::string_view(text_).substr(0, text_.find(';')));
}

IniFault IniValue::fault(const std::string& message) const {
  return {.line = place_.line, .words = key_ + " " + message};
}

std::optional<IniSection::Object> IniSection::object() const {
  Object object;
  const std::size_t sub = name_.find("sub");
  if (!is_hexadecimal(std::string_view(name_).substr(0, sub), object.index)) return {};
  if (sub == name_.npos) return object;
  std::uint8_t number = 0;
  if (!is_hexadecimal(std::string_view(name_).substr(sub + 3), number)) return {};
  object.sub = number;
  return object;
}

const IniValue* IniSection::find(std::string_view key) const {
  const auto found = values_.find(key);
  return found == values_.end() || found->second.text().empty() ? nullptr : &found->second;
}

void IniSection::add(const std::string& key, const std::string& text, std::uint32_t line) {
  const auto [place, is_new] = values_.try_emplace(lower_case(key), key, text, Place{place_.file, line, 0});
  if (is_new || place->second.text() == text) return;
  doubt({line,
         fmt::format("{} is in section {} already, with another value", in_quotes(key), in_quotes(name_))});
}

void IniSections::begin_section(std::string_view line, const Place& place) {
  const std::size_t close = line.find(']');
  if (close == line.npos) {  // what follows belongs to nothing
    sections_.emplace_back("", place);
    return faults_.push_back({place.line, fmt::format("section {} has no ]", in_quotes(line))});
  }
  const std::string name = lower_case(trimmed(line.substr(1, close - 1)));
  const auto [earlier, is_new] = by_name_.try_emplace(name, sections_.size());
  // The second one is read by itself, so that its keys are not taken for those of the first.
  sections_.emplace_back(name, place);
  if (is_new) return;
  const std::string words =
      fmt::format("section {} is in line {} already", in_quotes(name), sections_[earlier->second].line());
  sections_[earlier->second].doubt({place.line, words});
}

void IniSections::read_line(std::string_view line, const Place& place) {
  constexpr char end_of_file = 0x1A;  // of DOS
  if (line.empty() || line.front() == ';' || line.front() == '#' || line.front() == end_of_file) return;
  if (line.front() == '[') return begin_section(line, place);
  const std::size_t equals = line.find('=');
  if (equals != line.npos && !sections_.empty()) {
    return sections_.back().add(std::string(trimmed(line.substr(0, equals))),
                                std::string(trimmed(line.substr(equals + 1))), place.line);
  }
  IniFault fault{place.line,
                 fmt::format("{} is no [SECTION], no KEY=VALUE in one and no comment", in_quotes(line))};
  sections_.empty() ? faults_.push_back(std::move(fault)) : sections_.back().doubt(std::move(fault));
}

IniSections::IniSections(std::string_view text, const std::string& file_name) {
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  std::uint32_t number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    read_line(line, {file_name, ++number, 0});
  }
}

const IniSection* IniSections::find(std::string_view name) const {
  const auto found = by_name_.find(name);
  return found == by_name_.end() ? nullptr : &sections_[found->second];
}

}  // namespace inbetween
