// What somebody meant who wrote a word wrong.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace inbetween {

/// The one of `words` that `word` is probably meant to be: the closest within two edits, and fewer edits than
/// half its letters.
std::optional<std::string_view> probably_meant(std::string_view word,
                                               std::span<const std::string_view> words);

}  // namespace inbetween
