// The words of a text of USD, one by one: names, numbers, texts, paths, assets and brackets.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

enum class UsdaKind { end, name, number, text, asset, path, sign };

struct UsdaWord {
  UsdaKind kind = UsdaKind::end;
  std::string_view letters;  // of a text, an asset or a path what is between its quotes
  std::size_t offset = 0;
};

/// Refers to the text. Comments and blanks are passed over, and so are semicolons, which separate as lines
/// do.
class UsdaWords {
 public:
  UsdaWords(std::string_view text, const std::string& file);

  [[nodiscard]] const UsdaWord& peek() const { return next_; }
  UsdaWord take();
  /// Takes the word if it is this sign or name.
  bool take_if(std::string_view letters);
  /// Refuses another one.
  void require(std::string_view sign);
  /// Passes over a value: a word, or a bracket with all within. Nesting is bounded by max_scene_depth.
  void skip_value();

  [[nodiscard]] Place place_of(const UsdaWord& word) const;
  [[noreturn]] void refuse(const UsdaWord& word, const std::string& message) const;

 private:
  [[nodiscard]] UsdaWord read();
  void pass_blanks();
  [[nodiscard]] UsdaWord read_quoted();
  [[nodiscard]] UsdaWord read_between(char end, UsdaKind kind);

  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0;
  UsdaWord next_;
};

}  // namespace inbetween
