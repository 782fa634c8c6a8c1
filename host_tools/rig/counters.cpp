#include "host_tools/rig/counters.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace inbetween {
namespace {

Count count_of(const char* name, std::uint64_t count) {
  return {.name = name, .count = static_cast<std::int64_t>(count)};
}
Count traffic_of(const char* name, std::uint64_t count) {
  return {.name = name, .count = static_cast<std::int64_t>(count), .is_traffic = true};
}

void add_trouble(const std::string& of, const std::vector<Count>& counts, std::string& words) {
  bool is_first = true;
  for (const Count& count : counts) {
    if (count.is_traffic || count.count == 0) continue;
    std::string name = count.name;
    std::ranges::replace(name, '_', ' ');
    if (is_first && !words.empty()) words += "; ";
    words += fmt::format("{}{} {}", is_first ? of + ": " : ", ", name, count.count);
    is_first = false;
  }
}

}  // namespace

std::vector<Count> counts_of(const can::LaneCounters& lane, const can::CanCounters* socket) {
  std::vector<Count> counts{count_of("unsent", lane.unsent), count_of("floods", lane.floods),
                            traffic_of("drained", lane.drained)};
  if (socket == nullptr) return counts;
  for (const Count& count :
       {traffic_of("sent", socket->sent), traffic_of("received", socket->received),
        count_of("full_queue", socket->full_queue), count_of("failed_sends", socket->failed_sends),
        count_of("failed_receives", socket->failed_receives),
        count_of("receive_drops", socket->receive_drops), count_of("malformed", socket->malformed),
        count_of("error_frames", socket->error_frames),
        count_of("controller_overflows", socket->controller_overflows),
        count_of("unacknowledged", socket->unacknowledged), count_of("passives", socket->passives),
        count_of("bus_offs", socket->bus_offs), count_of("restarts", socket->restarts)}) {
    counts.push_back(count);
  }
  return counts;
}

std::vector<Count> counts_of(const can::DriveCounters& drive) {
  return {traffic_of("feedback", drive.feedback),          count_of("missed", drive.missed),
          count_of("bad_frames", drive.bad_frames),        count_of("duplicates", drive.duplicates),
          count_of("stray_answers", drive.stray_answers),  count_of("emergencies", drive.emergencies),
          count_of("foreign_frames", drive.foreign_frames)};
}

std::vector<Count> counts_of(const StepDelays& delays) {
  return {Count{.name = "late_steps", .count = delays.late_steps, .is_traffic = true},
          Count{.name = "longest_delay_ns", .count = delays.longest_ns, .is_traffic = true},
          Count{.name = "cancelled_pairs", .count = delays.cancelled_pairs, .is_traffic = true}};
}

std::vector<Count> counts_of(const gpio::StepPlayerCounters& edges) {
  return {traffic_of("played", edges.played), traffic_of("discarded", edges.discarded),
          count_of("refused", edges.refused), count_of("late", edges.late),
          Count{.name = "worst_late_ns", .count = edges.worst_late_ns, .is_traffic = true}};
}

std::vector<Count> counts_of(const CueCounters& pulses) {
  return {count_of("merged", pulses.merged), count_of("lost", pulses.lost),
          count_of("late_ends", pulses.late_ends)};
}

std::string trouble_of(const Counters& counts) {
  std::string words;
  for (const Counted& bus : counts.buses) add_trouble("bus " + bus.of, bus.counts, words);
  for (const Counted& drive : counts.drives) add_trouble(drive.of, drive.counts, words);
  for (const Counted& chip : counts.chips) add_trouble("chip " + chip.of, chip.counts, words);
  add_trouble("pulses", counts.pulses, words);
  return words;
}

}  // namespace inbetween
