// What somebody meant who wrote a word wrong.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace inbetween {

/// The one of `words` that `word` is probably meant to be: the closest within two edits, and fewer edits than
/// half its letters; two neighbours that are swapped are one edit. Of two letters one may be written twice.
std::optional<std::string_view> probably_meant(std::string_view word,
                                               std::span<const std::string_view> words);

}  // namespace inbetween
