// Texts that a reader must refuse, with the place that its diagnostic must name marked in the text itself.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// `text` with `from`, which must be in it exactly once, replaced by `to`.
inline std::string with(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  const bool once = at != std::string::npos && text.find(from, at + 1) == std::string::npos;
  if (!once) {
    ADD_FAILURE() << "\"" << from << "\" is not in the text exactly once";
    return text;
  }
  return text.replace(at, from.size(), to);
}

struct MarkedText {
  std::string text;  ///< without the mark
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

/// Finds and removes the mark @, which stands before the place that a diagnostic must name.
inline MarkedText without_mark(std::string marked) {
  MarkedText found{std::move(marked)};
  const std::size_t mark = found.text.find('@');
  if (mark == std::string::npos) {
    ADD_FAILURE() << "no place is marked in the text";
    return found;
  }
  for (std::size_t i = 0; i < mark; ++i) {
    const bool continues_a_character = (static_cast<unsigned char>(found.text[i]) & 0xc0U) == 0x80U;
    if (!continues_a_character) ++found.column;
    if (found.text[i] == '\n') {
      ++found.line;
      found.column = 1;
    }
  }
  found.text.erase(mark, 1);
  return found;
}

/// Expects `parse(text, "file.toml")` to throw InputError at the place marked with @ in `marked` (the mark is
/// not part of the text), as one line that says what to do and contains all of `words`.
template <typename Parse>
void expect_refused(Parse parse, std::string marked, std::initializer_list<std::string_view> words) {
  const MarkedText input = without_mark(std::move(marked));
  const Place place{"file.toml", input.line, input.column};
  try {
    parse(input.text, place.file);
    FAIL() << "accepted:\n" << input.text;
  } catch (const InputError& error) {
    const std::string line = error.what();
    EXPECT_EQ(to_string(error.place()), to_string(place)) << line;
    EXPECT_THAT(line, testing::StartsWith(to_string(error.place()) + ": error: "));
    EXPECT_THAT(line, testing::Not(testing::HasSubstr("\n")));
    const std::size_t remedy = line.find("; ");
    EXPECT_TRUE(remedy != std::string::npos && remedy + 3 < line.size()) << "no remedy in: " << line;
    for (const std::string_view word : words) EXPECT_THAT(line, testing::HasSubstr(std::string(word)));
  }
}

}  // namespace inbetween
