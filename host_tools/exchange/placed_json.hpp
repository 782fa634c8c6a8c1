// A JSON text whose every value knows its place. nlohmann-json parses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// A document of JSON is held in memory, 24 bytes for each value.
inline constexpr std::size_t max_json_bytes = std::size_t{8} << 20U;
inline constexpr std::size_t max_json_nesting = 8;

/// Of documents of other kinds.
struct JsonBounds {
  std::size_t bytes = max_json_bytes;
  std::size_t nesting = max_json_nesting;
};

enum class JsonKind : std::uint8_t { null, boolean, number, text, object, array };

/// Those within it stand behind it.
struct JsonNode {
  JsonKind kind = JsonKind::null;
  std::uint32_t offset = 0;  // of the number or bracket in the text; of a text's last quote
  std::uint32_t size = 1;    // itself and all within
  std::uint32_t key = 0;     // in the list of texts
  double number = 0;         // of a text: its place in the list of texts
};

class PlacedJson;

/// Refers into the document that it came from.
class JsonValue {
 public:
  JsonValue(const PlacedJson& document, std::size_t node) : document_(&document), node_(node) {}

  [[nodiscard]] JsonKind kind() const;
  [[nodiscard]] Place place() const;
  [[nodiscard]] std::uint32_t line() const { return place().line; }
  /// Its name in the object around it.
  [[nodiscard]] const std::string& key() const;
  /// Of an object or an array.
  [[nodiscard]] std::vector<JsonValue> items() const;
  [[nodiscard]] std::optional<JsonValue> find(std::string_view key) const;
  /// Refuses an object that has none.
  [[nodiscard]] JsonValue required(std::string_view key, std::string_view example) const;
  /// Refuse what is of another kind. `what` stands in the sentence: "fps".
  [[nodiscard]] const std::string& text(std::string_view what) const;
  [[nodiscard]] double number(std::string_view what) const;
  [[nodiscard]] std::int64_t whole_number(std::string_view what, std::int64_t min, std::int64_t max) const;
  [[noreturn]] void refuse(const std::string& message) const;

 private:
  [[nodiscard]] const JsonNode& node() const;
  const PlacedJson* document_;
  std::size_t node_;
};

class PlacedJson {
 public:
  /// Throws InputError at line and column where it is not JSON, nests deeper than the bound, or names a
  /// member of an object twice; at the file where it has more bytes. O(bytes log bytes). The text must live
  /// as long as the document.
  PlacedJson(std::string_view text, const std::string& file, const JsonBounds& bounds = {});
  [[nodiscard]] JsonValue root() const { return {*this, 0}; }

 private:
  friend class JsonValue;
  friend struct JsonEvents;
  [[nodiscard]] Place place_of(std::size_t offset) const;
  void refuse_second_names() const;

  std::string_view text_;
  std::string file_;
  JsonBounds bounds_;
  std::vector<JsonNode> nodes_;
  std::vector<std::string> texts_;
};

}  // namespace inbetween
