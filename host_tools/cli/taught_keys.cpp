#include "host_tools/cli/taught_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

constexpr std::size_t keys_on_screen = 5;

std::vector<std::size_t> axes_named(const RigFile& rig, const std::vector<std::string>& names) {
  std::vector<std::size_t> axes(names.empty() ? rig.axes.size() : names.size());
  std::iota(axes.begin(), axes.end(), std::size_t{0});
  for (std::size_t i = 0; i < names.size(); ++i) axes[i] = axis_named(rig, names[i]);
  return axes;
}

}  // namespace

TaughtKeys::TaughtKeys(const std::string& path, const std::vector<std::string>& axes_of_new,
                       const RigFile& rig, const RigReference& reference)
    : path_(path),
      rig_(rig),
      reference_(reference),
      move_(system_files(), path, rig, axes_named(rig, axes_of_new)) {
  check_output(path);
}

void TaughtKeys::press(TransportKey key, std::size_t axis, const std::vector<double>& positions) {
  StandingAxes standing(positions.size());
  for (std::size_t a = 0; a < positions.size(); ++a) {
    if (reference_.is_referenced(a)) standing[a] = positions[a];
  }
  switch (key) {
    case TransportKey::teach_next:
      return move_.choose(axis, 1);
    case TransportKey::teach_previous:
      return move_.choose(axis, -1);
    case TransportKey::teach_insert:
      return move_.insert(axis, standing);
    case TransportKey::teach_replace:
      return move_.replace(axis, standing);
    case TransportKey::teach_undo:
      return move_.undo();
    default:
      return move_.append(axis, standing);
  }
}

std::vector<std::string> TaughtKeys::shown(const char* axis) const {
  std::vector<std::string> lines = move_.shown(axis_named(rig_, axis), keys_on_screen);
  lines.emplace_back("n p choose a key, i inserts before it, t replaces it, Enter appends, u undoes");
  std::rotate(lines.begin() + 1, lines.end() - 1, lines.end());
  return lines;
}

std::string TaughtKeys::summary() const {
  return fmt::format("{}: {} stored", path_, counted(static_cast<std::int64_t>(move_.stored()), "key"));
}

}  // namespace inbetween
