#include "host_tools/joints/xml_element.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace inbetween {
namespace {

constexpr std::size_t max_name_bytes = 255;

Place line_of(int line, const std::string& file_name) {
  return {file_name, static_cast<std::uint32_t>(std::max(line, 1)), 0};
}

constexpr bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
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

/// A file that is still a program for xacro says so by its first expression.
std::string_view hint_for(std::string_view value) {
  return value.find("${") != value.npos ? "; this file is for xacro, run that first" : "";
}

}  // namespace

Place XmlElement::place() const {
  return line_of(element_->GetLineNum(), *file_name_);
}

std::vector<XmlElement> XmlElement::children(const char* name) const {
  std::vector<XmlElement> found;
  for (const auto* child = element_->FirstChildElement(name); child != nullptr;
       child = child->NextSiblingElement(name)) {
    found.emplace_back(*child, *file_name_);
  }
  return found;
}

std::optional<XmlElement> XmlElement::child(const char* name) const {
  const std::vector<XmlElement> found = children(name);
  if (found.size() > 1) found[1].refuse("is given a second time; keep one of the two");
  return found.empty() ? std::nullopt : std::optional(found.front());
}

XmlElement XmlElement::required_child(const char* name, std::string_view example) const {
  const std::optional<XmlElement> found = child(name);
  if (!found) refuse(fmt::format("has no <{}>; add {}", name, example));
  return *found;
}

void XmlElement::allow_attributes(std::initializer_list<std::string_view> known) const {
  for (const auto* attribute = element_->FirstAttribute(); attribute != nullptr;
       attribute = attribute->Next()) {
    const std::string_view unknown = attribute->Name();
    if (std::ranges::find(known, unknown) != known.end()) continue;
    throw InputError(line_of(attribute->GetLineNum(), *file_name_),
                     fmt::format("<{}>: unknown attribute {}; its attributes are {}", name(),
                                 in_quotes(unknown), comma_separated(known)));
  }
}

void XmlElement::allow_children(std::span<const std::string_view> known) const {
  for (const XmlElement& child : children()) {
    if (std::ranges::find(known, child.name()) != known.end()) continue;
    child.refuse(fmt::format("is not known in <{}>; write {}", name(), comma_separated(known)));
  }
}

std::string_view XmlElement::value(const char* attribute, std::string_view example) const {
  const char* value = element_->Attribute(attribute);
  if (value == nullptr) refuse(fmt::format("has no {}; write {}", attribute, example));
  return value;
}

std::string XmlElement::text(const char* attribute, std::string_view example) const {
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

double XmlElement::number(const char* attribute, std::optional<double> otherwise, double magnitude) const {
  if (otherwise && !has(attribute)) return *otherwise;
  const std::string_view text = value(attribute, fmt::format("{}=\"1.0\", say", attribute));
  const auto found = numbers_in(text);
  if (!found || found->size() != 1 || std::fabs(found->front()) > magnitude) {
    refuse_value(attribute, fmt::format("is {}; write one number from {:g} to {:g}{}", in_quotes(text),
                                        -magnitude, magnitude, hint_for(text)));
  }
  return found->front();
}

std::array<double, 3> XmlElement::numbers(const char* attribute, const std::array<double, 3>& otherwise,
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

void XmlElement::refuse_value(const char* attribute, std::string_view problem) const {
  throw InputError(line_of(element_->FindAttribute(attribute)->GetLineNum(), *file_name_),
                   fmt::format("<{}>: {} {}", name(), attribute, problem));
}

}  // namespace inbetween
