#include "host_tools/rig/pipe_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

/// Many boards start anew when their port is opened, and their boot loader listens for so long.
constexpr std::int64_t boot_ns = 2'000'000'000;
/// The longest whole number, and what is beside the axes in a line; and that in a line of the first hours.
constexpr std::size_t number_bytes = 20;
constexpr std::size_t beside_bytes = 2 * number_bytes + 4;
constexpr std::size_t usual_beside_bytes = 20;

/// The digits of an axis' counts, with a sign.
std::size_t count_bytes(const RigAxis& axis, const PipeDrive& drive) {
  std::size_t bytes = 0;
  for (const double end : {axis.min, axis.max}) {
    bytes = std::max(bytes, fmt::formatted_size("{:.0f}", end * drive.counts_per_unit + drive.count_at_zero));
  }
  return bytes;
}

void refuse_axis(const RigAxis& axis, const PipeDrive& drive) {
  if (axis.name.find_first_of(" \t=") != std::string::npos) {
    throw InputError(
        axis.place,
        fmt::format("{}: its name stands in lines of text; write it without spaces and =", named(axis)));
  }
  if (drive.has_no_watchdog) return;
  throw InputError(axis.place,
                   fmt::format("{}: this program cannot see whether what reads {} stops by itself when lines "
                               "cease; let it do so, then write no_watchdog = \"accepted\" in the drive",
                               named(axis), in_quotes(drive.path)));
}

}  // namespace

PipeDrives::PipeDrives(const RigFile& rig, std::span<const std::size_t> axes)
    : rig_(rig), axes_(axes.begin(), axes.end()) {
  for (const std::size_t a : axes_) {
    const RigAxis& axis = rig.axes[a];
    const auto& drive = std::get<PipeDrive>(axis.drive);
    refuse_axis(axis, drive);
    auto pipe = std::ranges::find(pipes_, drive.path, &Pipe::path);
    if (pipe == pipes_.end()) {
      pipes_.emplace_back().path = drive.path;
      pipe = pipes_.end() - 1;
    }
    pipe->lanes.push_back(lanes_.size());
    lanes_.push_back({.pipe = static_cast<std::size_t>(pipe - pipes_.begin()),
                      .before = " " + axis.name + "=",
                      .drive = &drive});
  }
  for (Pipe& pipe : pipes_) open(pipe);
}

void PipeDrives::open(Pipe& pipe) {
  const RigAxis& first = rig_.axes[axes_[pipe.lanes.front()]];
  const std::int32_t baud = lanes_[pipe.lanes.front()].drive->baud;
  std::size_t room = beside_bytes;
  std::size_t bytes = usual_beside_bytes;
  for (const std::size_t lane : pipe.lanes) {
    room += lanes_[lane].before.size() + number_bytes;
    bytes += lanes_[lane].before.size() + count_bytes(rig_.axes[axes_[lane]], *lanes_[lane].drive);
    if (lanes_[lane].drive->baud == baud) continue;
    const RigAxis& other = rig_.axes[axes_[lane]];
    throw InputError(other.place, fmt::format("{}: {} has another baud for {}; write the same", named(other),
                                              in_quotes(pipe.path), named(first)));
  }
  pipe.line.resize(room);
  if (const auto refusal = pipe.pipe.open(pipe.path, baud)) refuse_at(first.place, *refusal, named(first));
  // A tenth of a second may wait, and always a few lines.
  constexpr std::int64_t few = 4;
  max_waiting_lines_ = static_cast<std::size_t>(std::max<std::int64_t>(few, rig_.rate_hz / 10));
  if (!pipe.pipe.is_terminal()) return;
  ready_after_ns_ = boot_ns;
  // Ten bits a byte; a fifth is left so that a line which was late is made up for.
  const std::int64_t bits = static_cast<std::int64_t>(bytes) * 10 * rig_.rate_hz;
  if (5 * bits > 4 * std::int64_t{baud}) {
    throw InputError(
        first.place,
        fmt::format("{}: lines of up to {} bytes at {} Hz need {} bit/s of the {} of {}; raise baud or "
                    "lower rate_hz",
                    named(first), bytes, rig_.rate_hz, bits, baud, in_quotes(pipe.path)));
  }
}

void PipeDrives::read(std::span<DriveState> states, std::int64_t now_ns) {
  if (opened_ns_ == 0) opened_ns_ = now_ns;
  now_ns_ = now_ns;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const bool has_failed = pipes_[lanes_[i].pipe].has_failed;
    states[i] = {.actual = lanes_[i].told,
                 .is_on = is_enabled_ && now_ns - opened_ns_ >= ready_after_ns_,
                 .condition = has_failed ? DriveCondition::cannot_follow : DriveCondition::fine};
  }
}

void PipeDrives::write(std::span<const Setpoint> setpoints, std::int64_t now_ns) {
  if (setpoints.empty() || !is_enabled_) return;
  if (line_ == 0) first_line_ns_ = now_ns;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    if (!pipes_[lanes_[i].pipe].has_failed) lanes_[i].told = setpoints[i].position;
  }
  for (Pipe& pipe : pipes_) send_line(pipe, now_ns);
  ++line_;
}

void PipeDrives::send_line(Pipe& pipe, std::int64_t now_ns) {
  if (pipe.has_failed) return;
  char* end = fmt::format_to(pipe.line.data(), "{} {}", line_, (now_ns - first_line_ns_) / (ns_per_s / 1000));
  for (const std::size_t i : pipe.lanes) {
    const PipeDrive& drive = *lanes_[i].drive;
    const double count = std::floor(lanes_[i].told * drive.counts_per_unit + drive.count_at_zero + 0.5);
    end = fmt::format_to(end, "{}{}", lanes_[i].before, static_cast<std::int64_t>(count));
    ++lanes_[i].lines;
  }
  *end++ = '\n';
  const std::string_view line(pipe.line.data(), static_cast<std::size_t>(end - pipe.line.data()));
  pipe.has_failed = pipe.pipe.waiting() > max_waiting_lines_ * line.size() || !pipe.pipe.send(line);
}

void PipeDrives::enable() {
  is_enabled_ = true;
  line_ = 0;
}

void PipeDrives::disable() {
  if (!is_enabled_) return;
  is_enabled_ = false;
  for (Pipe& pipe : pipes_) {
    if (!pipe.has_failed) pipe.has_failed = !pipe.pipe.send("off\n");
  }
}

std::string PipeDrives::trouble() const {
  for (const Pipe& pipe : pipes_) {
    if (!pipe.has_failed) continue;
    return fmt::format(
        "{} is not read any more; look at the program or board at its other end, and say where {} "
        "stands",
        in_quotes(pipe.path), named(rig_.axes[axes_[pipe.lanes.front()]]));
  }
  return "";
}

void PipeDrives::count(Counters& counts) const {
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const bool has_failed = pipes_[lanes_[i].pipe].has_failed;
    counts.drives.push_back({rig_.axes[axes_[i]].name,
                             {{.name = "lines", .count = lanes_[i].lines, .is_traffic = true},
                              {.name = "unread", .count = has_failed ? 1 : 0}}});
  }
}

}  // namespace inbetween
