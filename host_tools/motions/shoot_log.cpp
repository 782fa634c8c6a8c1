#include "host_tools/motions/shoot_log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace inbetween {
namespace {

const std::string head = "at,frame,shots,whole";

/// The first line of the log: none where the file has one already.
std::string head_of(const std::string& name) {
  if (name == "-") return head + "\n";
  std::ifstream file(name);
  std::string line;
  if (!std::getline(file, line)) return head + "\n";
  if (line == head) return "";
  throw std::runtime_error(fmt::format(
      "{}: error: its first line is not {}, so it is no shoot log; name another file", name, head));
}

/// A number between commas.
std::optional<std::int32_t> number_in(std::string_view cell) {
  std::int32_t number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return error == std::errc() && end == cell.data() + cell.size() ? std::optional(number) : std::nullopt;
}

/// at,frame,shots,whole
std::optional<LoggedShot> shot_of(std::string_view line) {
  std::array<std::string_view, 4> cells;
  for (std::string_view& cell : cells) {
    cell = line.substr(0, line.find(','));
    line.remove_prefix(std::min(cell.size() + 1, line.size()));
  }
  const auto frame = number_in(cells[1]);
  const auto shots = number_in(cells[2]);
  if (!frame || !shots || (cells[3] != "0" && cells[3] != "1")) return std::nullopt;
  return LoggedShot{.frame = *frame, .shots = *shots, .is_whole = cells[3] == "1"};
}

void put(const LoggedShot& shot, std::string& text) {
  fmt::format_to(std::back_inserter(text), "{:%Y-%m-%dT%H:%M:%SZ},{},{},{}\n",
                 fmt::gmtime(std::time(nullptr)), shot.frame, shot.shots, shot.is_whole ? 1 : 0);
}

}  // namespace

std::vector<LoggedShot> read_shoot_log(const std::string& name, std::int32_t last) {
  std::ifstream file(name);
  std::string line;
  if (!std::getline(file, line)) {
    throw std::runtime_error(fmt::format(
        "{}: error: there is no log to go on with; leave out --resume to begin, or name another file", name));
  }
  static_cast<void>(head_of(name));
  std::vector<LoggedShot> shots;
  for (int number = 2; std::getline(file, line); ++number) {
    const std::optional<LoggedShot> shot = shot_of(line);
    if (!shot) {
      throw std::runtime_error(
          fmt::format("{}:{}: error: this is no line of a shoot log; remove it, and its frame is shot again",
                      name, number));
    }
    if (shot->frame < 0 || shot->frame > last) {
      throw std::runtime_error(fmt::format(
          "{}:{}: error: frame {} was shot, and the move has the frames 0..{}; name the log of this move",
          name, number, shot->frame, last));
    }
    shots.push_back(*shot);
  }
  return shots;
}

ShootLog::ShootLog(const std::string& file, bool waits)
    : log_(file, head_of(file), waits, put, LogWriting{.goes_on = true, .at_once = true}) {}

}  // namespace inbetween
