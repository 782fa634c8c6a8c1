#include "host_tools/cli/screen_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace inbetween {
namespace {

using Lines = std::vector<std::string>;

/// The first `columns` characters of UTF-8; one that has begun is left out whole.
void cut(std::string& line, int columns) {
  std::size_t end = 0;
  for (int shown = 0; end < line.size(); ++shown) {
    std::size_t next = end + 1;
    while (next < line.size() && (static_cast<unsigned char>(line[next]) & 0xC0U) == 0x80U) ++next;
    if (shown == columns) break;
    end = next;
  }
  line.resize(end);
}

std::string bar_of(double share, int columns) {
  const int width = std::max(columns - 2, 0);
  const int filled = std::clamp(static_cast<int>(std::lround(share * width)), 0, width);
  return fmt::format("[{:#>{}}{:.>{}}]", "", filled, "", width - filled);
}

/// Nothing is shown of what nobody knows yet.
std::string number_in_column(double number, bool is_known) {
  return is_known ? fmt::format("{:.4f}", number) : std::string("-");
}

/// A line an axis: where it was told to be and where it is, or by hand its limits.
Lines axis_lines(const RigFile& rig, const RunSnapshot& snapshot) {
  Lines all;
  for (std::size_t a = 0; a < std::min(snapshot.axis_count, rig.axes.size()); ++a) {
    const RigAxis& axis = rig.axes[a];
    const AxisPlace& place = snapshot.axes[a];
    const std::string actual = number_in_column(place.actual, place.is_known);
    if (snapshot.jog) {
      all.push_back(fmt::format("{} {:<16}{:>13}{:>13g}{:>13g}  {}",
                                axis.name == snapshot.jog->axis ? ">" : " ", axis.name, actual, axis.min,
                                axis.max, to_string(axis.unit)));
      continue;
    }
    all.push_back(fmt::format(
        "  {:<16}{:>13}{:>13}{:>17}  {}", axis.name, number_in_column(place.commanded, place.is_commanded),
        actual, number_in_column(place.following_error, place.is_commanded), to_string(axis.unit)));
  }
  return all;
}

/// Broken at spaces, as far as there are any.
Lines wrapped(const Lines& notes, std::size_t columns) {
  Lines lines;
  for (std::string rest : notes) {
    while (rest.size() > columns) {
      const std::size_t space = rest.rfind(' ', columns);
      if (space == std::string::npos || space == 0) break;
      lines.push_back(rest.substr(0, space));
      rest.erase(0, space + 1);
    }
    lines.push_back(rest);
  }
  return lines;
}

}  // namespace

std::vector<std::string> screen_text(const std::string& title, const RigFile& rig,
                                     const RunSnapshot& snapshot, int columns, int lines,
                                     const std::vector<std::string>& notes) {
  const auto room = static_cast<std::size_t>(std::max(lines, 2));
  constexpr std::size_t around_axes = 4;  // a space and the heads of the columns, a space and the keys
  Lines text{title, "", state_line(snapshot)};
  Lines axes = axis_lines(rig, snapshot);
  if (!notes.empty()) {
    Lines told = wrapped(notes, static_cast<std::size_t>(std::max(columns, 1)));
    const std::size_t taken = text.size() + 1 + axes.size() + around_axes;
    told.resize(std::min(told.size(), std::max<std::size_t>(room > taken ? room - taken : 0, 3)));
    text.emplace_back();
    text.insert(text.end(), told.begin(), told.end());
  }
  if (text.size() + axes.size() + around_axes > room) text.erase(text.begin(), text.begin() + 2);
  if (!snapshot.jog && text.size() + axes.size() + around_axes < room)
    text.push_back(bar_of(snapshot.share, columns));
  if (!axes.empty() && text.size() + around_axes < room) {
    text.emplace_back();
    text.push_back(snapshot.jog ? fmt::format("  {:<16}{:>13}{:>13}{:>13}", "axis", "position", "from", "to")
                                : fmt::format("  {:<16}{:>13}{:>13}{:>17}", "axis", "commanded", "actual",
                                              "following error"));
    const std::size_t left = room - text.size() - around_axes / 2;
    if (axes.size() > left) {
      const std::size_t shown = left - 1;
      const std::string more = fmt::format("  and {} more; they need a higher window", axes.size() - shown);
      axes.resize(shown);
      axes.push_back(more);
    }
    text.insert(text.end(), axes.begin(), axes.end());
  }
  text.resize(room - 1);
  text.push_back(hint_line(snapshot));
  for (std::string& line : text) cut(line, columns);
  return text;
}

}  // namespace inbetween
