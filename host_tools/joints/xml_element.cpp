#include "host_tools/joints/xml_element.hpp"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <system_error>
#include <utility>

#include "host_tools/text/spelling.hpp"

namespace inbetween {
namespace {

/// As long as the name of a file may be. A name stands in messages, which are lines.
constexpr std::size_t max_name_bytes = 255;
constexpr std::string_view blanks = " \t\n\r";

constexpr bool is_blank(char c) {
  return blanks.find(c) != blanks.npos;
}

/// Numbers with blanks between; nothing where something else stands there. Independent of the locale.
std::optional<std::vector<double>> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    if (text.empty()) return numbers;
    if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (!text.empty() && !is_blank(text.front())) return std::nullopt;
    numbers.push_back(number);
  }
}

/// Whether a word that is none of these was probably meant to be one that is read: misspelt, cut off, in
/// another case, or with its letters in another order.
bool is_one_meant(std::string_view word, std::span<const std::string_view> read,
                  std::span<const std::string_view> unread) {
  constexpr std::size_t few = 3;
  std::vector<std::string_view> all(read.begin(), read.end());
  all.insert(all.end(), unread.begin(), unread.end());
  if (const auto closest = probably_meant(word, all)) return std::ranges::find(read, *closest) != read.end();
  const auto sorted = [](std::string_view text) {
    std::string letters(text);
    for (char& c : letters) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    std::ranges::sort(letters);
    return letters;
  };
  return std::ranges::any_of(read, [&](std::string_view one) {
    return sorted(one) == sorted(word) || (word.size() >= few && one.starts_with(word));
  });
}

/// Where a tag ends that begins there.
std::size_t end_of_tag(std::string_view text, std::size_t at) {
  while ((at = text.find_first_of("\"'>", at)) != text.npos && text[at] != '>') {
    at = text.find(text[at], at + 1);
    if (at == text.npos) break;
    ++at;
  }
  return at;
}

/// The text with blanks for its comments and its declaration. People write dashes into comments, and programs
/// something before the declaration; neither is XML, and neither means anything.
std::string without_comments(std::string_view text) {
  constexpr std::string_view declaration = "<?xml";
  std::string result(text);
  std::size_t at = 0;
  while ((at = text.find('<', at)) != text.npos) {
    const std::string_view rest = text.substr(at);
    const bool is_comment = rest.starts_with("<!--");
    const bool is_declaration = rest.starts_with(declaration) && rest.size() > declaration.size() &&
                                is_blank(rest[declaration.size()]);
    if (!is_comment && !is_declaration) {
      at = rest.starts_with("<![CDATA[") ? text.find("]]>", at) : end_of_tag(text, at);
      continue;
    }
    const std::string_view last = is_comment ? "-->" : "?>";
    const std::size_t end = text.find(last, at + 4);
    if (end == text.npos) break;  // the parser says so
    for (; at < end + last.size(); ++at) {
      if (result[at] != '\n') result[at] = ' ';
    }
  }
  return result;
}

/// A file that is still a program for xacro says so by its first expression.
std::string_view hint_for(std::string_view value) {
  return value.find("${") != value.npos ? "; this file is for xacro, run that first" : "";
}

/// What expat calls back for each element.
struct XmlReading {
  XML_Parser parser;
  std::string_view text;
  std::vector<XmlNode>& nodes;
  std::vector<std::size_t> open = {};  // the nodes that have begun and not ended

  [[nodiscard]] std::uint32_t line() const {
    return static_cast<std::uint32_t>(XML_GetCurrentLineNumber(parser));
  }

  /// expat says where an element begins, and not where its attributes are. They come in their order, and
  /// well-formed: the first quote behind a name opens its value, and the same quote closes it.
  void begin(const char* name, const char** names_and_values) {
    open.push_back(nodes.size());
    XmlNode& node = nodes.emplace_back(XmlNode{.name = name, .line = line(), .attributes = {}});
    std::uint32_t line = node.line;
    node.begin = static_cast<std::size_t>(XML_GetCurrentByteIndex(parser));
    std::size_t at = node.begin + 1 + node.name.size();
    const auto go_to = [&](std::size_t next) {
      line += static_cast<std::uint32_t>(std::ranges::count(text.substr(at, next - at), '\n'));
      at = next;
    };
    for (const char** pair = names_and_values; pair[0] != nullptr; pair += 2) {
      go_to(text.find_first_not_of(blanks, at));
      node.attributes.push_back({.name = pair[0], .value = pair[1], .line = line});
      go_to(text.find_first_of("\"'", at));
      go_to(text.find(text[at], at + 1) + 1);
    }
  }

  void end() {
    nodes[open.back()].end = static_cast<std::size_t>(XML_GetCurrentByteIndex(parser)) +
                             static_cast<std::size_t>(XML_GetCurrentByteCount(parser));
    nodes[open.back()].size = std::ssize(nodes) - static_cast<std::ptrdiff_t>(open.back());
    open.pop_back();
  }
};

}  // namespace

XmlDocument::XmlDocument(std::string_view written, const std::string& file_name) : file_name_(file_name) {
  // Where every second byte is zero, expat would read UTF-16, and a byte would not be a character.
  if (written.find('\0') != written.npos) {
    throw InputError({file_name}, "not valid XML (it has bytes that are zero); save it as UTF-8");
  }
  const std::string text = without_comments(written);
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate("UTF-8"),
                                                                            &XML_ParserFree);
  XmlReading reading{.parser = parser.get(), .text = text, .nodes = nodes_};
  XML_SetUserData(parser.get(), &reading);
  XML_SetElementHandler(
      parser.get(),
      [](void* to, const char* name, const char** attributes) {
        static_cast<XmlReading*>(to)->begin(name, attributes);
      },
      [](void* to, const char*) { static_cast<XmlReading*>(to)->end(); });
  XML_SetStartDoctypeDeclHandler(parser.get(), [](void* to, const char*, const char*, const char*, int) {
    XML_StopParser(static_cast<XmlReading*>(to)->parser, XML_FALSE);
  });
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK) return;
  const XML_Error error = XML_GetErrorCode(parser.get());
  throw InputError({file_name, reading.line(), 0},
                   error == XML_ERROR_ABORTED
                       ? "a document type is not read; remove <!DOCTYPE ...>"
                       : fmt::format("not valid XML ({}); correct it here", XML_ErrorString(error)));
}

Place XmlElement::place() const {
  return {*file_name_, node_->line, 0};
}

std::vector<XmlElement> XmlElement::children(std::string_view name) const {
  std::vector<XmlElement> found;
  for (const XmlNode* child = node_ + 1; child != node_ + node_->size; child += child->size) {
    if (name.empty() || child->name == name) found.emplace_back(*child, *file_name_);
  }
  return found;
}

std::optional<XmlElement> XmlElement::child(std::string_view name) const {
  const std::vector<XmlElement> found = children(name);
  if (found.size() > 1) found[1].refuse("is given a second time; keep one of the two");
  return found.empty() ? std::nullopt : std::optional(found.front());
}

XmlElement XmlElement::required_child(std::string_view name, std::string_view example) const {
  const std::optional<XmlElement> found = child(name);
  if (!found) refuse(fmt::format("has no <{}>; add {}", name, example));
  return *found;
}

void PassedOver::add(std::string name, const Place& place) {
  if (names.empty()) first = place;
  if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
}

std::optional<XmlElement> XmlDocument::first_with_prefix(std::string_view prefix) const {
  const auto found =
      std::ranges::find_if(nodes_, [&](const XmlNode& node) { return node.name.starts_with(prefix); });
  return found == nodes_.end() ? std::nullopt : std::optional(XmlElement(*found, file_name_));
}

int XmlElement::decimals(std::string_view attribute) const {
  const XmlAttribute* const found = find(attribute);
  if (found == nullptr || found->value.find_first_of("eE") != std::string::npos) return 0;
  const std::size_t point = found->value.find('.');
  if (point == std::string::npos) return 0;
  const std::size_t end = found->value.find_first_not_of("0123456789", point + 1);
  return static_cast<int>(std::min(end, found->value.size()) - point - 1);
}

void XmlElement::allow_attributes(std::initializer_list<std::string_view> read, PassedOver& passed,
                                  std::initializer_list<std::string_view> unread) const {
  for (const XmlAttribute& attribute : node_->attributes) {
    if (std::ranges::find(read, attribute.name) != read.end()) continue;
    if (std::ranges::find(unread, attribute.name) != unread.end()) continue;
    if (!is_one_meant(attribute.name, {read.begin(), read.size()}, {unread.begin(), unread.size()})) {
      passed.add(attribute.name, {*file_name_, attribute.line, 0});
      continue;
    }
    throw InputError({*file_name_, attribute.line, 0},
                     fmt::format("<{}>: unknown attribute {}; its attributes are {}", name(),
                                 in_quotes(attribute.name), comma_separated(read)));
  }
}

void XmlElement::allow_children(std::span<const std::string_view> read, PassedOver& passed,
                                std::span<const std::string_view> unread) const {
  for (const XmlElement& child : children()) {
    if (std::ranges::find(read, child.name()) != read.end()) continue;
    if (std::ranges::find(unread, child.name()) != unread.end()) continue;
    if (!is_one_meant(child.name(), read, unread)) {
      passed.add(fmt::format("<{}>", child.name()), child.place());
      continue;
    }
    child.refuse(fmt::format("is not known in <{}>; write {}", name(), comma_separated(read)));
  }
}

const XmlAttribute* XmlElement::find(std::string_view attribute) const {
  const auto found = std::ranges::find(node_->attributes, attribute, &XmlAttribute::name);
  return found == node_->attributes.end() ? nullptr : &*found;
}

std::string_view XmlElement::value(std::string_view attribute, std::string_view example) const {
  const XmlAttribute* found = find(attribute);
  if (found == nullptr) refuse(fmt::format("has no {}; write {}", attribute, example));
  return found->value;
}

std::string XmlElement::text(std::string_view attribute, std::string_view example) const {
  const std::string_view text = value(attribute, example);
  if (text.empty()) refuse_value(attribute, fmt::format("is empty; write {}", example));
  if (text.size() > max_name_bytes) {
    refuse_value(attribute, fmt::format("has {} bytes; write at most {}", text.size(), max_name_bytes));
  }
  if (std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; })) {
    refuse_value(attribute, "has a control character; remove it");
  }
  return std::string(text);
}

double XmlElement::number(std::string_view attribute, std::optional<double> otherwise,
                          double magnitude) const {
  if (otherwise && !has(attribute)) return *otherwise;
  const std::string_view text = value(attribute, fmt::format("{}=\"1.0\", say", attribute));
  const auto found = numbers_in(text);
  if (!found || found->size() != 1 || std::fabs(found->front()) > magnitude) {
    refuse_value(attribute, fmt::format("is {}; write one number from {:g} to {:g}{}", in_quotes(text),
                                        -magnitude, magnitude, hint_for(text)));
  }
  return found->front();
}

std::array<double, 3> XmlElement::numbers(std::string_view attribute, const std::array<double, 3>& otherwise,
                                          double magnitude) const {
  if (!has(attribute)) return otherwise;
  const std::string_view text = value(attribute, "");
  const auto found = numbers_in(text);
  const bool is_good = found && found->size() == 3 && std::ranges::all_of(*found, [&](double number) {
                         return std::fabs(number) <= magnitude;
                       });
  if (!is_good) {
    refuse_value(attribute, fmt::format("is {}; write three numbers from {:g} to {:g} with blanks between{}",
                                        in_quotes(text), -magnitude, magnitude, hint_for(text)));
  }
  return {(*found)[0], (*found)[1], (*found)[2]};
}

void XmlElement::refuse(std::string_view problem) const {
  throw InputError(place(), fmt::format("<{}> {}", name(), problem));
}

void XmlElement::refuse_value(std::string_view attribute, std::string_view problem) const {
  throw InputError({*file_name_, find(attribute)->line, 0},
                   fmt::format("<{}>: {} {}", name(), attribute, problem));
}

}  // namespace inbetween
