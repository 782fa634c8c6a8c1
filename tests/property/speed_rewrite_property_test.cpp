#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/move_model/speed_rewrite.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace speed_rewrite_property_test {

int number(int below) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, below));
}

std::vector<double> random_speed() {
  std::vector<double> speed(static_cast<std::size_t>(1 + number(12)));
  for (double& value : speed) value = number(3) == 0 ? number(101) : number(100'000'001) / 1e6;
  return speed;
}

/// Blanks, line ends and comments, which may hold whatever has a meaning outside them.
std::string random_gap(std::string_view line_end) {
  constexpr std::array<std::string_view, 5> comments = {"#", "# ], 5", "#\"", "# \xC3\xBC [", "# '''#"};
  std::string gap;
  for (int pieces = number(4); pieces > 0; --pieces) {
    const int kind = number(4);
    if (kind == 3) gap += comments[static_cast<std::size_t>(number(static_cast<int>(comments.size())))];
    gap += kind == 0 ? " " : kind == 1 ? "\t" : line_end;
  }
  return gap;
}

std::string random_list(const std::vector<double>& speed, std::string_view line_end) {
  std::string list = "[" + random_gap(line_end);
  for (std::size_t i = 0; i < speed.size(); ++i) {
    const bool last = i + 1 == speed.size();
    list += fmt::format("{}", speed[i]) + random_gap(line_end);
    if (!last || number(2) == 1) list += "," + random_gap(line_end);
  }
  return list + "]";
}

struct Story {
  std::string before, list, after;
  std::string text() const { return before + list + after; }
};

Story random_story(const std::vector<double>& speed) {
  const std::string line_end = number(2) == 0 ? "\n" : "\r\n";
  const std::string track = "axes = ['x'], keys = [{at = [0]}, {at = [1]}], ";
  Story story;
  story.before = (number(2) == 0 ? "" : "\xef\xbb\xbf") + random_gap(line_end) + line_end +
                 "name = '\xC3\xBC'" + line_end + "fps = 24" + line_end + "frames = 9" + line_end +
                 "track = [" + random_gap(line_end) + "{" + track + "speed =" + (number(2) == 0 ? "" : " \t");
  story.list = random_list(speed, line_end);
  story.after = " }" + random_gap(line_end) + ", {axes = ['y'], speed = [1], keys = [{at = [0]}]}]" +
                random_gap(line_end);
  return story;
}

/// The text without its numbers, which stand outside comments here.
std::string without_numbers(std::string_view list) {
  std::string rest;
  bool comment = false;
  for (const char c : list) {
    if (c == '#') comment = true;
    if (c == '\n') comment = false;
    if (comment || std::string_view("0123456789.e-+").find(c) == std::string_view::npos) rest += c;
  }
  return rest;
}

std::ptrdiff_t comments(std::string_view list) {
  return std::count(list.begin(), list.end(), '#');
}

TEST(SpeedRewriteProperty, OnlyTheNumbersOfOneListChange) {
  check_property(2000, [] {
    const Story story = random_story(random_speed());
    RC_LOG(story.text());
    const std::vector<double> wanted = random_speed();
    const std::vector<double> drawn = parse_move(story.text(), "m").tracks[0].speed;
    const std::string changed = with_speed(story.text(), "m", 0, wanted);
    RC_ASSERT(parse_move(changed, "m").tracks[0].speed == wanted);
    RC_ASSERT(changed.starts_with(story.before));
    RC_ASSERT(changed.ends_with(story.after));
    const std::string list =
        changed.substr(story.before.size(), changed.size() - story.before.size() - story.after.size());
    if (wanted.size() == drawn.size()) RC_ASSERT(without_numbers(list) == without_numbers(story.list));
    RC_ASSERT(comments(list) == comments(story.list));
    RC_ASSERT(with_speed(story.text(), "m", 0, drawn) == story.text());
    RC_ASSERT(parse_move(with_speed(changed, "m", 0, drawn), "m").tracks[0].speed == drawn);
  });
}

}  // namespace speed_rewrite_property_test
}  // namespace inbetween
