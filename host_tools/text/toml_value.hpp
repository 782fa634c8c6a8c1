// The values and tables of a parsed TOML file, each with its place, checked as they are read.
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// The bound of a name or a path: long enough for any, short enough for a diagnostic or a picture.
inline constexpr std::size_t max_text_bytes = 255;
/// Largest magnitude of a number in a file: moves of scale 1e100 work, and the squares and cubes that lengths
/// and speeds are made of stay far inside the range of double.
inline constexpr double max_magnitude = 1e100;

/// One value of a file, with the name by which diagnostics call it: "frames", "speed[3]".
/// Refers into the toml::table that it came from.
class TomlValue {
 public:
  TomlValue(const toml::node& node, std::string name) : node_(&node), name_(std::move(name)) {}

  Place place() const;
  const std::string& name() const { return name_; }
  const toml::node& node() const { return *node_; }

  /// Text of 1 to max_text_bytes bytes, no control characters.
  std::string text() const;
  /// The index of the text in `choices`.
  std::size_t choice(std::span<const std::string_view> choices) const;
  std::size_t choice(std::initializer_list<std::string_view> choices) const {
    return choice(std::span(choices.begin(), choices.size()));
  }
  bool boolean() const;
  /// A whole number written as one (240, not 240.0), from `min` to `max`.
  std::int64_t integer(std::int64_t min, std::int64_t max) const;
  /// A finite number, whole or not, from `min` to `max`.
  double number(double min = -max_magnitude, double max = max_magnitude) const;
  /// A finite number above 0, at most max_magnitude.
  double positive_number() const;
  /// The elements of an array of 1 to `max` elements, named name[0], name[1] and so on.
  std::vector<TomlValue> list(std::size_t max) const;
  /// An array of tables: [[name]] sections or { } in brackets. At least one, at most `max`.
  std::vector<TomlValue> tables(std::size_t max) const;
  const toml::table& table() const;

  /// Throws InputError at this value: "name problem".
  [[noreturn]] void refuse(std::string_view problem) const;

 private:
  [[noreturn]] void refuse_type(std::string_view wanted) const;

  const toml::node* node_;
  std::string name_;
};

/// One table of a file and the fields that it may have.
class TomlTable {
 public:
  /// `name` stands in sentences: "a track", "the rig". Throws InputError at the first key, in file order,
  /// that is not in `fields`; the message names the field that was probably meant, or all fields.
  TomlTable(const toml::table& table, std::string name, std::span<const std::string_view> fields);

  /// The place where the table begins; 1:1 for the table that is the whole file.
  Place place() const;
  std::optional<TomlValue> optional(std::string_view field) const;
  /// Throws InputError at place() if the field is missing; `example` is what one would write, "fps = 24".
  TomlValue required(std::string_view field, std::string_view example) const;
  /// Throws InputError at the first of these fields that is there: "field problem".
  void refuse_any(std::initializer_list<std::string_view> fields, std::string_view problem) const;

 private:
  const toml::table* table_;
  std::string name_;
};

}  // namespace inbetween
