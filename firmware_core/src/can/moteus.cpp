#include "inbetween/can/moteus.hpp"

#include <array>

#include "inbetween/can/moteus_register.hpp"
#include "words.hpp"

namespace inbetween::can {
namespace {

using enum MoteusRegister;

constexpr std::array wanted_mode{static_cast<double>(MoteusMode::position)};
constexpr std::array stopped_mode{static_cast<double>(MoteusMode::stopped)};

FdFrame frame_for(MoteusNode node, bool asks) {
  return {.id = FrameId::shortest(node.value() | (asks ? moteus_asks_for_answer : 0U))};
}

/// 24 bytes of answer.
void ask(MoteusWriter& writer) {
  writer.read(mode, MoteusType::int8, 1);
  writer.read(position, MoteusType::float32, 3);
  writer.read(voltage, MoteusType::int8, 3);
}

/// The frames here have room for what is written into them: 32 bytes at most.
void finish(MoteusWriter& writer) {
  if (!writer.finish()) __builtin_trap();
}

constexpr std::array words{
    Words{32, "it has not been calibrated"},
    Words{33, "its motor driver has failed"},
    Words{34, "its supply voltage is too high"},
    Words{35, "its encoder has failed"},
    Words{36, "its motor has not been set up"},
    Words{37, "its control loop takes too long"},
    Words{38, "it is too hot"},
    Words{39, "it was switched on outside its position limits"},
    Words{40, "its supply voltage is too low"},
    Words{41, "its settings were changed while it was on"},
    Words{42, "its commutation angle is not valid"},
    Words{43, "its position is not valid"},
    Words{44, "its motor driver could not be enabled"},
    Words{45, "it was told a stop position together with limits"},
    Words{46, "its timing has failed"},
    Words{47, "it has a feed-forward of its motor's voltage without an acceleration limit"},
    Words{48, "its limits are not valid"},
    Words{49, "it was too far from its position"},
    Words{50, "it was too far from its velocity"},
    Words{moteus_timeout_error, "its watchdog has expired"}};

/// What the registers of an answer say together.
struct Answer {
  std::optional<double> mode, turns, turns_per_s, fault, home_state, map_version;
  bool is_bad = false;

  void take(const MoteusItem& item) {
    if (item.kind == MoteusItem::Kind::read_error) {
      // A drive that does not know the version of its registers has others.
      if (item.reg == MoteusRegister::map_version) map_version = 0;
      return;
    }
    if (item.kind == MoteusItem::Kind::stream) return;
    if (item.kind != MoteusItem::Kind::reply) {
      is_bad = true;
      return;
    }
    switch (item.reg) {
      case MoteusRegister::mode:
        mode = item.value;
        return;
      case position:
        turns = item.value;
        return;
      case velocity:
        turns_per_s = item.value;
        return;
      case MoteusRegister::fault:
        fault = item.value;
        return;
      case MoteusRegister::home_state:
        home_state = item.value;
        return;
      case MoteusRegister::map_version:
        map_version = item.value;
        return;
      default:
        return;
    }
  }
};

/// A small number that a register tells; 255 for what is none.
std::uint32_t number_of(double told) {
  return told >= 0 && told < 255 ? static_cast<std::uint32_t>(told) : 255U;
}

std::uint32_t errors_of(double told_mode, double told_fault) {
  if (told_mode == static_cast<double>(MoteusMode::fault)) {
    // Numbers from 96 on only say what limits it; in this mode they would still be the reason.
    return number_of(told_fault) > 0 ? number_of(told_fault)
                                     : moteus_mode_error + static_cast<std::uint32_t>(MoteusMode::fault);
  }
  const bool is_on_its_way = told_mode == static_cast<double>(MoteusMode::stopped) ||
                             (told_mode >= static_cast<double>(MoteusMode::enabling) &&
                              told_mode <= static_cast<double>(MoteusMode::calibrated));
  if (is_on_its_way || told_mode == static_cast<double>(MoteusMode::position)) return 0;
  return moteus_mode_error + number_of(told_mode);
}

ServoStatus status_of(double told_mode, double told_fault) {
  const bool is_position = told_mode == static_cast<double>(MoteusMode::position);
  return {.is_on = is_position,
          .is_off = told_mode == static_cast<double>(MoteusMode::stopped) ||
                    told_mode == static_cast<double>(MoteusMode::fault),
          .has_missed_host = told_mode == static_cast<double>(MoteusMode::timeout),
          .is_watching = is_position,
          .errors = errors_of(told_mode, told_fault)};
}

}  // namespace

FdFrame moteus_command_frame(MoteusNode node, const MoteusCommand& command) {
  FdFrame frame = frame_for(node, true);
  MoteusWriter writer(frame);
  // The mode first: writing it forgets everything else.
  writer.write(mode, MoteusType::int8, wanted_mode);
  const std::array motion{command.turns, command.turns_per_s};
  writer.write(command_position, MoteusType::float32, motion);
  if (command.max_torque_nm) writer.write(max_torque, MoteusType::float32, {&*command.max_torque_nm, 1});
  if (command.watchdog_s) writer.write(watchdog, MoteusType::float32, {&*command.watchdog_s, 1});
  ask(writer);
  finish(writer);
  return frame;
}

FdFrame moteus_stop_frame(MoteusNode node) {
  FdFrame frame = frame_for(node, false);
  MoteusWriter writer(frame);
  writer.write(mode, MoteusType::int8, stopped_mode);
  finish(writer);
  return frame;
}

FdFrame moteus_question(MoteusNode node) {
  FdFrame frame = frame_for(node, true);
  MoteusWriter writer(frame);
  ask(writer);
  finish(writer);
  return frame;
}

FdFrame moteus_identity_question(MoteusNode node) {
  FdFrame frame = frame_for(node, true);
  MoteusWriter writer(frame);
  writer.read(model, MoteusType::int32, 3);
  writer.read(home_state, MoteusType::int8, 1);
  finish(writer);
  return frame;
}

const char* words_of_moteus_error(std::uint32_t error) {
  return words_in(words, error,
                  error >= moteus_mode_error ? "it is in a mode that this program does not use"
                                             : "an error that this program does not know");
}

ServoReport Moteus::read(const FdFrame& frame) const {
  if (!is_answer(frame)) return {.is_of_a_host = true};
  Answer answer;
  MoteusReader reader(frame);
  while (const std::optional<MoteusItem> item = reader.next()) answer.take(*item);
  // An answer that breaks off somewhere is not believed in its other parts either.
  if (answer.is_bad || reader.is_bad()) return {.is_bad = true};
  ServoReport report;
  if (answer.mode && std::isfinite(*answer.mode)) {
    report.status = status_of(*answer.mode, answer.fault.value_or(0));
  }
  if (answer.turns && answer.turns_per_s) {
    const ServoPlace place{.turns = *answer.turns, .turns_per_s = *answer.turns_per_s};
    const bool is_known = std::isfinite(place.turns) && std::isfinite(place.turns_per_s);
    if (is_known) report.place = place;
    report.is_bad = !is_known;
  }
  if (answer.map_version) {
    report.version = number_of(*answer.map_version);
    report.is_expected_device = report.version == moteus_map_version;
  }
  constexpr double of_output = 2;
  if (answer.home_state && settings_.must_know_place) report.knows_place = answer.home_state == of_output;
  return report;
}

std::optional<FdFrame> Moteus::order(ServoOrder order) const {
  switch (order) {
    case ServoOrder::say_what_you_are:
      return moteus_identity_question(settings_.node);
    case ServoOrder::clear_errors:
    case ServoOrder::switch_off:
    case ServoOrder::stop_at_once:
      return moteus_stop_frame(settings_.node);
    case ServoOrder::take_positions:
    case ServoOrder::switch_on:
    case ServoOrder::set_watchdog:
      return {};  // a command does all three
  }
  return {};
}

std::optional<FdFrame> Moteus::command(const ServoTarget& target) const {
  if (!fits(target)) return {};
  return moteus_command_frame(
      settings_.node,
      {.turns = target.turns, .turns_per_s = target.turns_per_s, .watchdog_s = settings_.watchdog_s});
}

std::optional<FdFrame> Moteus::hold(ServoHold how, double turns) const {
  switch (how) {
    case ServoHold::off:
      return question();
    case ServoHold::watched:
      return moteus_command_frame(settings_.node, {.max_torque_nm = 0, .watchdog_s = settings_.watchdog_s});
    case ServoHold::switching_on:
      return moteus_command_frame(settings_.node, {.watchdog_s = settings_.watchdog_s});
    case ServoHold::stopping:
      return command({.turns = turns});
  }
  return {};
}

}  // namespace inbetween::can
