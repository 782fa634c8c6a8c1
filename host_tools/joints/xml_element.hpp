// The elements and attributes of a parsed XML file, each with its line, checked as they are read.
#pragma once

#include <tinyxml2.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/files/diagnostics.hpp"

namespace inbetween {

/// Refers into the document that it came from.
class XmlElement {
 public:
  XmlElement(const tinyxml2::XMLElement& element, const std::string& file_name)
      : element_(&element), file_name_(&file_name) {}

  [[nodiscard]] std::string_view name() const { return element_->Name(); }
  [[nodiscard]] Place place() const;
  /// The elements within, those of one name or all.
  [[nodiscard]] std::vector<XmlElement> children(const char* name = nullptr) const;
  /// The only element of this name within; refuses a second one.
  [[nodiscard]] std::optional<XmlElement> child(const char* name) const;
  [[nodiscard]] XmlElement required_child(const char* name, std::string_view example) const;

  /// Refuses the first attribute that is not one of these.
  void allow_attributes(std::initializer_list<std::string_view> known) const;
  /// Refuses the first element within that is not one of these.
  void allow_children(std::span<const std::string_view> known) const;

  [[nodiscard]] bool has(const char* attribute) const { return element_->Attribute(attribute) != nullptr; }
  /// Text of 1 to 255 bytes without control characters.
  [[nodiscard]] std::string text(const char* attribute, std::string_view example) const;
  /// A finite number within the magnitude, or what stands in for an attribute that is not there.
  [[nodiscard]] double number(const char* attribute, std::optional<double> otherwise, double magnitude) const;
  /// Three of them with blanks between.
  [[nodiscard]] std::array<double, 3> numbers(const char* attribute, const std::array<double, 3>& otherwise,
                                              double magnitude) const;

  [[noreturn]] void refuse(std::string_view problem) const;

 private:
  [[nodiscard]] std::string_view value(const char* attribute, std::string_view example) const;
  [[noreturn]] void refuse_value(const char* attribute, std::string_view problem) const;

  const tinyxml2::XMLElement* element_;
  const std::string* file_name_;
};

}  // namespace inbetween
