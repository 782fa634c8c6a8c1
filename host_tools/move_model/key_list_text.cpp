#include "host_tools/move_model/key_list_text.hpp"

#include <algorithm>
#include <stdexcept>

namespace inbetween {
namespace {

/// Behind blanks and, with `comments`, comments.
std::size_t skip(std::string_view text, std::size_t at, std::string_view blanks, bool comments) {
  while (at < text.size()) {
    if (blanks.find(text[at]) != std::string_view::npos) {
      ++at;
    } else if (comments && text[at] == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      break;
    }
  }
  return at;
}

/// The rest of the line with its end, if there are only blanks and a comment on it; otherwise nothing.
std::size_t behind_rest_of_line(std::string_view text, std::size_t at) {
  const std::size_t behind = skip(text, at, " \t\r", true);
  return behind < text.size() && text[behind] == '\n' ? behind + 1 : at;
}

/// The blanks at the end of what stands before an element: its indentation.
std::string_view indentation(std::string_view before) {
  const std::size_t last = before.find_last_not_of(" \t");
  return last == std::string_view::npos ? before : before.substr(last + 1);
}

}  // namespace

ListText list_text(std::string_view text, std::size_t begin, std::span<const Extent> elements) {
  if (begin >= text.size() || text[begin] != '[')
    throw std::logic_error("a list does not begin where the reader says");
  ListText list;
  std::size_t at = begin + 1;
  if (const std::size_t behind = behind_rest_of_line(text, at); behind > at) at = behind;
  list.inside.begin = at;
  for (const Extent& element : elements) {
    ListedElement listed{.element = element, .before = text.substr(at, element.begin - at)};
    at = element.end;
    const std::size_t behind = skip(text, at, " \t\r\n", true);
    if (behind < text.size() && text[behind] == ',') {
      listed.has_comma = true;
      listed.tail = text.substr(at, behind - at);
      at = behind + 1;
    }
    const std::size_t line_end = behind_rest_of_line(text, at);
    listed.rest = text.substr(at, line_end - at);
    at = line_end;
    list.elements.push_back(listed);
  }
  const std::size_t end = skip(text, at, " \t\r\n", true);
  if (end >= text.size() || text[end] != ']')
    throw std::logic_error("a list does not end where the reader says");
  list.closing = text.substr(at, end - at);
  list.inside.end = end;
  return list;
}

std::string written_list_of(const ListText& list, std::span<const NewElement> elements) {
  const ListedElement* neighbour = &list.elements.front();
  const bool ends_with_comma = list.elements.back().has_comma;
  const std::string_view first_rest = list.elements.front().rest;
  const bool has_lines = first_rest.ends_with('\n');
  const std::string_view line_end = first_rest.ends_with("\r\n") ? "\r\n" : "\n";
  std::string result;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const NewElement& one = elements[i];
    const bool wants_comma = ends_with_comma || i + 1 < elements.size();
    if (one.old != nullptr) {
      neighbour = one.old;
      const bool is_moved_first = i == 0 && one.old != &list.elements.front() && !has_lines;
      result += is_moved_first ? list.elements.front().before : one.old->before;
      // A blank that an element of a line had because it was the first.
      if (!has_lines && i > 0 && one.old->before.empty()) result += ' ';
    } else {
      if (has_lines && !result.empty() && !result.ends_with('\n')) result += line_end;
      const std::string_view before = indentation(neighbour->before);
      result += has_lines || i == 0 ? before : std::string_view(" ");
    }
    result += one.element;
    if (one.old != nullptr && one.old->has_comma) result += one.old->tail;
    if (wants_comma) result += ',';
    result += one.old != nullptr ? one.old->rest : has_lines ? line_end : std::string_view();
  }
  if (list.elements.back().rest.ends_with('\n') && !result.ends_with('\n')) result += line_end;
  return result += list.closing;
}

}  // namespace inbetween
