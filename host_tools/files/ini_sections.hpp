// The sections of an INI file with the line of each value, as device descriptions have them: [SECTION],
// KEY=VALUE, comments behind a semicolon. Names are the same in capitals and in small letters.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/files/diagnostics.hpp"

namespace inbetween {

std::string lower_case(std::string_view text);
/// Without the spaces at either end.
std::string_view trimmed(std::string_view text);

class IniValue {
 public:
  IniValue(std::string key, std::string text, Place place)
      : key_(std::move(key)), text_(std::move(text)), place_(std::move(place)) {}
  /// As it is written, without spaces around it.
  [[nodiscard]] const std::string& text() const { return text_; }
  /// Without a comment behind it.
  [[nodiscard]] std::string_view number_text() const;
  /// Throws InputError: "KEY message".
  [[noreturn]] void refuse(const std::string& message) const;

 private:
  std::string key_, text_;
  Place place_;
};

class IniSection {
 public:
  IniSection(std::string name, Place place) : name_(std::move(name)), place_(std::move(place)) {}
  /// The address that [1018] or [1018sub1] has for a name; nothing for other sections.
  struct Object {
    std::uint16_t index = 0;
    std::optional<std::uint8_t> sub{};
  };
  [[nodiscard]] std::optional<Object> object() const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint32_t line() const { return place_.line; }
  /// Null where it is missing. `key` in small letters.
  [[nodiscard]] const IniValue* find(std::string_view key) const;
  /// Throws InputError at the section where it is missing.
  [[nodiscard]] const IniValue& at(std::string_view key, std::string_view example = "") const;
  /// Throws InputError where it is there already.
  void add(const std::string& key, const std::string& text, std::uint32_t line);

 private:
  std::string name_;
  Place place_;
  std::map<std::string, IniValue, std::less<>> values_;
};

class IniSections {
 public:
  /// Throws InputError at a line that is neither, and at a section or key that comes twice.
  IniSections(std::string_view text, const std::string& file_name);
  [[nodiscard]] const std::vector<IniSection>& all() const { return sections_; }
  /// Null where it is missing. `name` in small letters, without zeros before it.
  [[nodiscard]] const IniSection* find(std::string_view name) const;

 private:
  std::vector<IniSection> sections_;
  std::map<std::string, std::size_t, std::less<>> by_name_;
};

}  // namespace inbetween
