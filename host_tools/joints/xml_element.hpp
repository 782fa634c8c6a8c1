// The elements and attributes of a parsed XML file, each with its line, checked as they are read. expat
// parses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

struct XmlAttribute {
  std::string name, value;
  std::uint32_t line = 0;
};

/// In an XmlDocument. The nodes within it stand behind it.
struct XmlNode {
  std::string name;
  std::uint32_t line = 0;
  std::vector<XmlAttribute> attributes;
  std::ptrdiff_t size = 0;         // itself and all within
  std::size_t begin = 0, end = 0;  // its bytes in the text of the document
};

/// Words of other programs in a file.
struct PassedOver {
  std::vector<std::string> names = {};  // each once, as it is written
  Place first = {};
  void add(std::string name, const Place& place);
};

/// Refers into the document that it came from.
class XmlElement {
 public:
  XmlElement(const XmlNode& node, const std::string& file_name) : node_(&node), file_name_(&file_name) {}

  [[nodiscard]] std::string_view name() const { return node_->name; }
  [[nodiscard]] Place place() const;
  /// The elements within, those of one name or all.
  [[nodiscard]] std::vector<XmlElement> children(std::string_view name = {}) const;
  /// The only element of this name within; refuses a second one.
  [[nodiscard]] std::optional<XmlElement> child(std::string_view name) const;
  [[nodiscard]] XmlElement required_child(std::string_view name, std::string_view example) const;

  /// Refuses the first attribute that is probably meant to be one of those that are read, and passes over
  /// what is none. Those that are known and not read are no words of other programs either.
  void allow_attributes(std::initializer_list<std::string_view> read, PassedOver& passed,
                        std::initializer_list<std::string_view> unread = {}) const;
  /// The same of the elements within.
  void allow_children(std::span<const std::string_view> read, PassedOver& passed,
                      std::span<const std::string_view> unread) const;

  /// All of them, in the order of the file.
  [[nodiscard]] std::span<const XmlAttribute> attributes() const { return node_->attributes; }
  /// The element as it stands in the text that its document was made of.
  [[nodiscard]] std::string_view written_in(std::string_view text) const {
    return text.substr(node_->begin, node_->end - node_->begin);
  }

  /// The digits behind the point of a number; 0 where the attribute is not there, or has an exponent.
  [[nodiscard]] int decimals(std::string_view attribute) const;
  [[nodiscard]] bool has(std::string_view attribute) const { return find(attribute) != nullptr; }
  /// Text of 1 to 255 bytes without control characters.
  [[nodiscard]] std::string text(std::string_view attribute, std::string_view example) const;
  /// A finite number within the magnitude, or what stands in for an attribute that is not there.
  [[nodiscard]] double number(std::string_view attribute, std::optional<double> otherwise,
                              double magnitude) const;
  /// Three of them with blanks between.
  [[nodiscard]] std::array<double, 3> numbers(std::string_view attribute,
                                              const std::array<double, 3>& otherwise, double magnitude) const;

  [[noreturn]] void refuse(std::string_view problem) const;

 private:
  [[nodiscard]] const XmlAttribute* find(std::string_view attribute) const;
  [[nodiscard]] std::string_view value(std::string_view attribute, std::string_view example) const;
  [[noreturn]] void refuse_value(std::string_view attribute, std::string_view problem) const;

  const XmlNode* node_;
  const std::string* file_name_;
};

class XmlDocument {
 public:
  /// Refuses text that is not well-formed, and a document type, which could define words and defaults of its
  /// own. Comments may have dashes in them, and anything may stand before the declaration.
  XmlDocument(std::string_view written, const std::string& file_name);
  /// The first element whose name begins so.
  [[nodiscard]] std::optional<XmlElement> first_with_prefix(std::string_view prefix) const;
  [[nodiscard]] XmlElement root() const { return {nodes_.front(), file_name_}; }

 private:
  std::string file_name_;
  std::vector<XmlNode> nodes_;  // in the order of the file
};

}  // namespace inbetween
