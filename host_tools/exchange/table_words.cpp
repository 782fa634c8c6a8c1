#include "host_tools/exchange/table_words.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>

#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

constexpr std::int32_t max_rate_term = 1'000'000;  // as `fps` of a move
constexpr double max_word_rate = 1'000;
constexpr std::string_view word_of_rig = "rig";

template <class Number>
std::optional<Number> whole_word(std::string_view word, std::string_view* rest = nullptr) {
  Number number{};
  const auto [stopped, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc()) return std::nullopt;
  const std::string_view left = word.substr(static_cast<std::size_t>(stopped - word.data()));
  if (rest != nullptr) *rest = left;
  if (rest == nullptr && !left.empty()) return std::nullopt;
  return number;
}

/// The two sides of the last =; nothing where there is none or the left one is empty.
struct Sides {
  std::string_view left, right;
};
std::optional<Sides> sides_of(std::string_view text) {
  const std::size_t at = text.rfind('=');
  if (at == std::string_view::npos) return std::nullopt;
  const Sides sides{trimmed(text.substr(0, at)), trimmed(text.substr(at + 1))};
  if (sides.left.empty() || sides.right.empty()) return std::nullopt;
  return sides;
}

}  // namespace

std::optional<FrameRate> frame_rate_of_word(std::string_view word) {
  std::string_view rest;
  const auto numerator = whole_word<std::int32_t>(trimmed(word), &rest);
  if (!numerator) return std::nullopt;
  FrameRate rate{*numerator, 1};
  if (!rest.empty()) {
    const auto denominator =
        rest.starts_with('/') ? whole_word<std::int32_t>(rest.substr(1)) : std::optional<std::int32_t>();
    if (!denominator) return std::nullopt;
    rate.denominator = *denominator;
  }
  const auto is_term = [](std::int32_t term) { return term >= 1 && term <= max_rate_term; };
  if (!is_term(rate.numerator) || !is_term(rate.denominator)) return std::nullopt;
  if (rate.frames_per_second() > max_word_rate) return std::nullopt;
  return rate;
}

std::optional<AxisWord> axis_word_of(std::string_view text) {
  if (text.find('=') == std::string_view::npos) {
    const std::string name(trimmed(text));
    if (name.empty()) return std::nullopt;
    return AxisWord{name, name};
  }
  const auto sides = sides_of(text);
  if (!sides) return std::nullopt;
  AxisWord word{std::string(sides->left), std::string(sides->right)};
  if (sides->right == "-") return AxisWord{.column = word.column, .axis = {}, .is_left_out = true};
  if (!sides->right.starts_with('-')) return word;
  word.is_reversed = true;
  word.axis = std::string(trimmed(sides->right.substr(1)));
  return word;
}

std::optional<MoveUnit> move_unit_of_word(std::string_view word) {
  if (word == word_of_rig) return MoveUnit::of_rig;
  const auto* const found = std::ranges::find(move_unit_words, word);
  if (found == move_unit_words.end()) return std::nullopt;
  return static_cast<MoveUnit>(found - move_unit_words.begin() + 1);
}

std::optional<UnitWord> unit_word_of(std::string_view text) {
  const auto sides = sides_of(text);
  const auto unit = move_unit_of_word(sides ? sides->right : trimmed(text));
  if (!unit) return std::nullopt;
  UnitWord word{.unit = *unit};
  if (sides) word.column = std::string(sides->left);
  return word;
}

std::optional<CountWord> count_word_of(std::string_view text) {
  const auto sides = sides_of(text);
  if (!sides) return std::nullopt;
  CountWord word{.column = std::string(sides->left)};
  std::string_view rest;
  const auto zero = whole_word<double>(sides->right, &rest);
  if (!zero || !rest.starts_with(',')) return std::nullopt;
  const auto count = whole_word<double>(trimmed(rest.substr(1)), &rest);
  if (!count) return std::nullopt;
  const auto unit = move_unit_of_word(trimmed(rest));
  const bool is_right = unit && std::isfinite(*zero) && std::isfinite(*count) && *count != 0;
  if (!is_right) return std::nullopt;
  word.zero = *zero;
  word.count = *count;
  word.unit = *unit;
  return word;
}

std::optional<UpAxis> up_axis_of_word(std::string_view word) {
  if (word == "y") return UpAxis::y;
  if (word == "z") return UpAxis::z;
  return std::nullopt;
}

std::optional<ShutterPhase> phase_of_word(std::string_view word) {
  if (word == "centre") return ShutterPhase::exposure_centre;
  if (word == "boundary") return ShutterPhase::frame_boundary;
  return std::nullopt;
}

std::string_view to_string(ShutterPhase phase) {
  return phase == ShutterPhase::exposure_centre ? "centre" : "boundary";
}

}  // namespace inbetween
