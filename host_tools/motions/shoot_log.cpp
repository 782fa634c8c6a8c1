#include "host_tools/motions/shoot_log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <fstream>
#include <iterator>
#include <stdexcept>

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

void put(const LoggedShot& shot, std::string& text) {
  fmt::format_to(std::back_inserter(text), "{:%Y-%m-%dT%H:%M:%SZ},{},{},{}\n",
                 fmt::gmtime(std::time(nullptr)), shot.frame, shot.shots, shot.is_whole ? 1 : 0);
}

}  // namespace

ShootLog::ShootLog(const std::string& file, bool waits)
    : log_(file, head_of(file), waits, put, LogWriting{.goes_on = true, .at_once = true}) {}

}  // namespace inbetween
