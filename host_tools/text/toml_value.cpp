#include "host_tools/text/toml_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host_tools/text/spelling.hpp"
#include "host_tools/text/toml_source.hpp"

namespace inbetween {
namespace {

// In the order of toml::node_type.
constexpr std::array<std::string_view, 10> type_names = {
    "nothing",        "a table",
    "an array",       "text",
    "a whole number", "a number with a fraction or exponent",
    "true or false",  "a date",
    "a time",         "a date with time"};

}  // namespace

Place TomlValue::place() const {
  return place_of(*node_);
}

void TomlValue::refuse(std::string_view problem) const {
  throw InputError(place(), fmt::format("{} {}", name_, problem));
}

void TomlValue::refuse_type(std::string_view wanted) const {
  refuse(fmt::format("is {}; write {}", type_names.at(static_cast<std::size_t>(node_->type())), wanted));
}

std::string TomlValue::text() const {
  const auto* value = node_->as_string();
  if (value == nullptr) refuse_type("text in double quotes");
  const std::string& text = value->get();
  if (text.empty()) refuse("is empty; write at least one character");
  if (text.size() > max_text_bytes)
    refuse(fmt::format("has {} bytes; write at most {}", text.size(), max_text_bytes));
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::any_of(text.begin(), text.end(), is_control)) {
    refuse(fmt::format("is {} with a control character; remove it", in_quotes(text)));
  }
  return text;
}

std::size_t TomlValue::choice(std::span<const std::string_view> choices) const {
  std::string listed;
  for (const std::string_view word : choices) {
    if (!listed.empty()) listed += word == choices.back() ? " or " : ", ";
    listed += fmt::format("\"{}\"", word);
  }
  const auto* value = node_->as_string();
  if (value == nullptr) refuse_type(listed);
  const auto found = std::find(choices.begin(), choices.end(), value->get());
  if (found == choices.end()) refuse(fmt::format("is {}; write {}", in_quotes(value->get()), listed));
  return static_cast<std::size_t>(found - choices.begin());
}

bool TomlValue::boolean() const {
  const auto* value = node_->as_boolean();
  if (value == nullptr) refuse_type("true or false, without quotes");
  return value->get();
}

std::int64_t TomlValue::integer(std::int64_t min, std::int64_t max) const {
  const auto* value = node_->as_integer();
  const std::string wanted = fmt::format("a whole number from {} to {}", min, max);
  if (value == nullptr) refuse_type(wanted + " without a decimal point");
  if (value->get() < min || value->get() > max) {
    refuse(fmt::format("is {}; write {}", value->get(), wanted));
  }
  return value->get();
}

double TomlValue::number(double min, double max) const {
  const std::optional<double> value = node_->is_number() ? node_->value<double>() : std::nullopt;
  const std::string wanted = fmt::format("a number from {} to {}", min, max);
  if (!value) refuse_type(wanted);
  if (!(*value >= min && *value <= max)) refuse(fmt::format("is {}; write {}", *value, wanted));
  return *value;
}

double TomlValue::positive_number() const {
  const double value = number();
  if (!(value > 0)) refuse(fmt::format("is {}; write a number above 0", value));
  return value;
}

std::vector<TomlValue> TomlValue::list(std::size_t max) const {
  const auto* array = node_->as_array();
  if (array == nullptr) refuse_type("a list in [ ]");
  if (array->empty()) refuse("is empty; write at least one element");
  if (array->size() > max) refuse(fmt::format("has {} elements; write at most {}", array->size(), max));
  std::vector<TomlValue> elements;
  elements.reserve(array->size());
  for (const toml::node& element : *array) {
    elements.emplace_back(element, fmt::format("{}[{}]", name_, elements.size()));
  }
  return elements;
}

std::vector<TomlValue> TomlValue::tables(std::size_t max) const {
  if (node_->is_table()) refuse("is a single table; write a list of tables, [[...]] or [ {...}, {...} ]");
  std::vector<TomlValue> elements = list(max);
  for (const TomlValue& element : elements) element.table();
  return elements;
}

const toml::table& TomlValue::table() const {
  const auto* table = node_->as_table();
  if (table == nullptr) refuse_type("a table, its fields in { }");
  return *table;
}

TomlTable::TomlTable(const toml::table& table, std::string name, std::span<const std::string_view> fields)
    : table_(&table), name_(std::move(name)) {
  const toml::key* first_unknown = nullptr;
  for (const auto& [key, value] : table) {
    const bool known = std::find(fields.begin(), fields.end(), key.str()) != fields.end();
    if (!known && (first_unknown == nullptr || key.source().begin < first_unknown->source().begin)) {
      first_unknown = &key;
    }
  }
  if (first_unknown == nullptr) return;
  const auto meant = probably_meant(first_unknown->str(), fields);
  const std::string remedy = meant ? fmt::format("did you mean \"{}\"?", *meant)
                                   : fmt::format("its fields are {}", comma_separated(fields));
  const toml::source_region& source = first_unknown->source();
  throw InputError({place().file, source.begin.line, source.begin.column},
                   fmt::format("{} has no field {}; {}", name_, in_quotes(first_unknown->str()), remedy));
}

Place TomlTable::place() const {
  return place_of(*table_);
}

std::optional<TomlValue> TomlTable::optional(std::string_view field) const {
  const toml::node* node = table_->get(field);
  if (node == nullptr) return std::nullopt;
  return TomlValue(*node, std::string(field));
}

TomlValue TomlTable::required(std::string_view field, std::string_view example) const {
  std::optional<TomlValue> value = optional(field);
  if (!value) throw InputError(place(), fmt::format("{} has no {}; add {}", name_, field, example));
  return *std::move(value);
}

void TomlTable::refuse_any(std::initializer_list<std::string_view> fields, std::string_view problem) const {
  for (const std::string_view field : fields) {
    if (const auto value = optional(field)) value->refuse(problem);
  }
}

}  // namespace inbetween
