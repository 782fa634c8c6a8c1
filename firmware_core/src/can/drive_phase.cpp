#include "inbetween/can/drive_phase.hpp"

#include <array>

namespace inbetween::can {
namespace {

using enum DrivePhase;
using Event = DriveEvent;

constexpr std::size_t index_of(DrivePhase phase) {
  return static_cast<std::size_t>(phase);
}
constexpr std::size_t index_of(DriveEvent event) {
  return static_cast<std::size_t>(event);
}

using Row = std::array<DriveStep, drive_events>;

/// The default: connect, enable and leave are refused, everything else changes nothing.
constexpr Row usual(DrivePhase phase) {
  Row row;
  row.fill({phase, false});
  row[index_of(Event::connect)] = {phase, true};
  row[index_of(Event::enable)] = {phase, true};
  row[index_of(Event::leave)] = {phase, true};
  row[index_of(Event::disconnect)] = {off, false};
  return row;
}

constexpr std::array<Row, drive_phases> make_table() {
  std::array<Row, drive_phases> table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = usual(static_cast<DrivePhase>(i));
  const auto on = [&](DrivePhase from, DriveEvent event, DrivePhase to) {
    table[index_of(from)][index_of(event)] = {to, false};
  };
  for (const DrivePhase from :
       {off, idle, DrivePhase::disabled, leaving, abandoned, DrivePhase::refused, gone}) {
    on(from, Event::connect, booting);
  }
  on(booting, Event::booted, configuring);
  on(booting, Event::timed_out, DrivePhase::refused);
  on(configuring, Event::configured, starting);
  on(configuring, Event::refused, DrivePhase::refused);
  on(starting, Event::started, idle);
  on(starting, Event::timed_out, DrivePhase::refused);

  for (const DrivePhase from : {idle, stopping}) on(from, Event::enable, clearing);
  on(clearing, Event::cleared, enabling);
  on(clearing, Event::timed_out, idle);
  on(clearing, Event::dropped_out, idle);
  on(enabling, Event::enabled, following);
  on(enabling, Event::timed_out, idle);
  on(enabling, Event::dropped_out, idle);
  on(following, Event::dropped_out, idle);
  on(following, Event::stopped_itself, stopping);

  for (const DrivePhase from : {clearing, enabling, following}) on(from, Event::quick_stop, stopping);
  on(booting, Event::disable, off);
  for (const DrivePhase from :
       {configuring, starting, idle, clearing, enabling, following, stopping, DrivePhase::refused, gone}) {
    on(from, Event::disable, disabling);
  }
  on(disabling, Event::disabled, DrivePhase::disabled);
  on(disabling, Event::timed_out, abandoned);
  on(DrivePhase::disabled, Event::leave, leaving);
  on(leaving, Event::left, off);
  on(leaving, Event::timed_out, abandoned);
  for (const DrivePhase from : {configuring, starting, idle, clearing, enabling, following, stopping}) {
    on(from, Event::vanished, gone);
  }
  return table;
}

constexpr std::array<Row, drive_phases> table = make_table();

}  // namespace

DriveStep next_phase(DrivePhase phase, DriveEvent event) {
  return table[index_of(phase)][index_of(event)];
}

}  // namespace inbetween::can
