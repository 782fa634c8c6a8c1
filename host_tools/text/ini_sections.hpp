// The sections of an INI file with the line of each value, as device descriptions have them: [SECTION],
// KEY=VALUE, comments behind ; and lines that begin with #. Names are the same in capitals and in small
// letters.
//
// Makers write such files by hand. What is wrong in one is kept for whoever judges it, and the rest is read.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

std::string lower_case(std::string_view text);
/// Without the spaces at either end.
std::string_view trimmed(std::string_view text);

/// Something that is wrong in a file, at a line of it: "KEY is ...".
struct IniFault {
  std::uint32_t line = 0;
  std::string words;
};

class IniValue {
 public:
  IniValue(std::string key, std::string text, Place place)
      : key_(std::move(key)), text_(std::move(text)), place_(std::move(place)) {}
  /// As it is written, without spaces around it.
  [[nodiscard]] const std::string& text() const { return text_; }
  /// Without a comment behind it.
  [[nodiscard]] std::string_view number_text() const;
  /// "KEY message".
  [[nodiscard]] IniFault fault(const std::string& message) const;

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
  /// Null where it is missing or empty. `key` in small letters.
  [[nodiscard]] const IniValue* find(std::string_view key) const;
  /// A key that is there already with another text is a fault of the section; nobody knows which one is
  /// right.
  void add(const std::string& key, const std::string& text, std::uint32_t line);
  /// Something in this section is not believed, and so is none of its values.
  void doubt(IniFault fault) { faults_.push_back(std::move(fault)); }
  [[nodiscard]] const std::vector<IniFault>& faults() const { return faults_; }

 private:
  std::string name_;
  Place place_;
  std::map<std::string, IniValue, std::less<>> values_;
  std::vector<IniFault> faults_;
};

class IniSections {
 public:
  /// Never throws: a line that is neither is a fault, and so is a section that comes twice.
  IniSections(std::string_view text, const std::string& file_name);
  /// Faults of lines that belong to no section.
  [[nodiscard]] const std::vector<IniFault>& faults() const { return faults_; }
  [[nodiscard]] const std::vector<IniSection>& all() const { return sections_; }
  /// Null where it is missing. `name` in small letters, without zeros before it.
  [[nodiscard]] const IniSection* find(std::string_view name) const;

 private:
  void read_line(std::string_view line, const Place& place);
  void begin_section(std::string_view line, const Place& place);

  std::vector<IniSection> sections_;
  std::map<std::string, std::size_t, std::less<>> by_name_;
  std::vector<IniFault> faults_;
};

}  // namespace inbetween
