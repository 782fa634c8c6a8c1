#include "host_tools/exchange/placed_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "host_tools/text/toml_source.hpp"

namespace inbetween {
namespace {

/// Tells how far the parser has read, which nlohmann-json keeps to itself.
class ReadBytes {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  ReadBytes(const char* at, const char** furthest) : at_(at), furthest_(furthest) {}
  reference operator*() const { return *at_; }
  ReadBytes& operator++() {
    *furthest_ = ++at_;
    return *this;
  }
  ReadBytes operator++(int) {
    ReadBytes before = *this;
    ++*this;
    return before;
  }
  friend bool operator==(const ReadBytes& a, const ReadBytes& b) { return a.at_ == b.at_; }

 private:
  const char* at_;
  const char** furthest_;
};

constexpr std::string_view number_letters = "+-.0123456789eE";

}  // namespace

/// What the parser calls back, value by value. Returning false ends it.
struct JsonEvents {
  PlacedJson& document;
  const char* furthest;
  std::vector<std::size_t> open = {};
  std::uint32_t key_of_next = 0;

  [[nodiscard]] std::size_t read() const {
    return static_cast<std::size_t>(furthest - document.text_.data());
  }
  bool add(JsonKind kind, std::size_t offset, double number = 0) {
    document.nodes_.push_back({.kind = kind,
                               .offset = static_cast<std::uint32_t>(offset),
                               .size = 1,
                               .key = key_of_next,
                               .number = number});
    return true;
  }
  /// The parser has read a character behind the number, where there is one.
  bool add_number(double number) {
    std::size_t at = read();
    const auto is_letter = [&](std::size_t i) {
      return number_letters.find(document.text_[i]) != std::string_view::npos;
    };
    if (at > 0 && !is_letter(at - 1)) --at;
    while (at > 0 && is_letter(at - 1)) --at;
    return add(JsonKind::number, at, number);
  }
  bool begin(JsonKind kind) {
    if (open.size() == document.bounds_.nesting) {
      throw InputError(document.place_of(read() - 1),
                       fmt::format("this nests deeper than {}; write it flatter", document.bounds_.nesting));
    }
    open.push_back(document.nodes_.size());
    return add(kind, read() - 1);
  }
  bool end() {
    document.nodes_[open.back()].size = static_cast<std::uint32_t>(document.nodes_.size() - open.back());
    open.pop_back();
    return true;
  }

  // The names that nlohmann-json asks for.
  bool null() { return add(JsonKind::null, read() - 1); }
  bool boolean(bool value) { return add(JsonKind::boolean, read() - 1, value ? 1 : 0); }
  bool number_integer(std::int64_t value) { return add_number(static_cast<double>(value)); }
  bool number_unsigned(std::uint64_t value) { return add_number(static_cast<double>(value)); }
  bool number_float(double value, const std::string&) { return add_number(value); }
  bool string(std::string& value) {
    document.texts_.push_back(value);
    return add(JsonKind::text, read() - 1, static_cast<double>(document.texts_.size() - 1));
  }
  static bool binary(std::vector<std::uint8_t>&) { return false; }
  bool start_object(std::size_t) { return begin(JsonKind::object); }
  bool key(std::string& name) {
    document.texts_.push_back(name);
    key_of_next = static_cast<std::uint32_t>(document.texts_.size() - 1);
    return true;
  }
  bool end_object() { return end(); }
  bool start_array(std::size_t) { return begin(JsonKind::array); }
  bool end_array() { return end(); }
  /// Python writes NaN and Infinity as numbers, which JSON has not.
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) const {
    const std::size_t at = std::min(position > 0 ? position - 1 : 0, document.text_.size());
    const char found = at < document.text_.size() ? document.text_[at] : ' ';
    throw InputError(
        document.place_of(at),
        found == 'N' || found == 'I'
            ? "this is no number of JSON; have the program that wrote NaN or Infinity correct this frame"
            : "this is not JSON; correct it here, or write the file again");
  }
};

PlacedJson::PlacedJson(std::string_view text, const std::string& file, const JsonBounds& bounds)
    : text_(text), file_(file), bounds_(bounds) {
  if (text.size() > bounds.bytes) {
    throw InputError({file}, fmt::format("the file has {} bytes; write it in parts of at most {}",
                                         text.size(), bounds.bytes));
  }
  texts_.emplace_back();  // the key of what has none
  JsonEvents events{.document = *this, .furthest = text.data()};
  const char* const end = text.data() + text.size();
  nlohmann::json::sax_parse(ReadBytes(text.data(), &events.furthest), ReadBytes(end, &events.furthest),
                            &events);
  refuse_second_names();
}

void PlacedJson::refuse_second_names() const {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].kind != JsonKind::object) continue;
    std::set<std::string_view> names;
    for (const JsonValue& item : JsonValue(*this, i).items()) {
      if (!names.insert(item.key()).second) {
        item.refuse(fmt::format("{} is there a second time; keep one of the two", in_quotes(item.key())));
      }
    }
  }
}

Place PlacedJson::place_of(std::size_t offset) const {
  Place place{file_, 1, 1};
  std::size_t at = text_.starts_with(byte_order_mark) ? byte_order_mark.size() : 0;
  for (; at < offset; ++at) {
    const bool continues_a_character = (static_cast<unsigned char>(text_[at]) & 0xc0U) == 0x80U;
    if (!continues_a_character) ++place.column;
    if (text_[at] != '\n') continue;
    ++place.line;
    place.column = 1;
  }
  return place;
}

const JsonNode& JsonValue::node() const {
  return document_->nodes_[node_];
}
JsonKind JsonValue::kind() const {
  return node().kind;
}
Place JsonValue::place() const {
  return document_->place_of(node().offset);
}
const std::string& JsonValue::key() const {
  return document_->texts_[node().key];
}

std::vector<JsonValue> JsonValue::items() const {
  std::vector<JsonValue> items;
  for (std::size_t i = node_ + 1; i < node_ + node().size; i += document_->nodes_[i].size) {
    items.emplace_back(*document_, i);
  }
  return items;
}

std::optional<JsonValue> JsonValue::find(std::string_view key) const {
  if (kind() != JsonKind::object) return std::nullopt;
  for (const JsonValue& item : items()) {
    if (item.key() == key) return item;
  }
  return std::nullopt;
}

JsonValue JsonValue::required(std::string_view key, std::string_view example) const {
  if (kind() != JsonKind::object) refuse(fmt::format("this is no object; write {{ {} }}", example));
  const std::optional<JsonValue> found = find(key);
  if (!found) refuse(fmt::format("{} is missing; write {}", in_quotes(key), example));
  return *found;
}

const std::string& JsonValue::text(std::string_view what) const {
  if (kind() != JsonKind::text) refuse(fmt::format("{} is no text; write it in quotes", what));
  return document_->texts_[static_cast<std::size_t>(node().number)];
}

double JsonValue::number(std::string_view what) const {
  if (kind() != JsonKind::number) refuse(fmt::format("{} is no number; write one such as 25", what));
  return node().number;
}

std::int64_t JsonValue::whole_number(std::string_view what, std::int64_t min, std::int64_t max) const {
  const double value = number(what);
  if (value != std::floor(value) || value < static_cast<double>(min) || value > static_cast<double>(max)) {
    refuse(fmt::format("{} is {}; write a whole number from {} to {}", what, value, min, max));
  }
  return static_cast<std::int64_t>(value);
}

void JsonValue::refuse(const std::string& message) const {
  throw InputError(place(), message);
}

}  // namespace inbetween
