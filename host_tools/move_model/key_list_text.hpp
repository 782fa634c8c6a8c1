// The keys of a track as they are written: one piece of text for each, with the comment beside it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/text_changes.hpp"

namespace inbetween {

/// An element of a list with all that belongs to it: `before` + element + `tail` + comma + `rest`.
struct ListedElement {
  Extent element;
  std::string_view before = {};  ///< blanks, and comments on the lines above
  std::string_view tail = {};    ///< between the element and its comma
  std::string_view rest =
      {};  ///< behind the comma, or the element where there is none: what is left of the line
  bool has_comma = false;
};

/// A list as it is written, '[' and ']' excluded.
struct ListText {
  Extent inside;
  std::vector<ListedElement> elements;
  std::string_view closing;  ///< blanks and comments before ']'
};

/// `elements` are the extents of the elements of a list whose '[' is at `begin`, in order; at least one.
ListText list_text(std::string_view text, std::size_t begin, std::span<const Extent> elements);

/// An element of the new list: one of the old, changed or not, or a new one.
struct NewElement {
  const ListedElement* old = nullptr;  ///< null: new
  std::string element;
};

/// What stands between the brackets of the new list. A new element is spaced as the one before it, or behind
/// it if it is the first. There is a comma behind the last one if there was one before.
std::string written_list_of(const ListText& list, std::span<const NewElement> elements);

}  // namespace inbetween
