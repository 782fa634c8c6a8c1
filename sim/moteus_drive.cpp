#include "sim/moteus_drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace inbetween {
namespace {

using can::FdFrame;
using can::MoteusItem;
using can::MoteusMode;
using can::MoteusRegister;
using can::MoteusType;

constexpr std::int64_t boot_delay_ns = 50'000'000;
constexpr std::uint32_t everybody = 0x7F;
constexpr int outside_limits = 39;
constexpr int at_bound = 103;  // no fault, but said where faults are
constexpr std::uint32_t unknown_register = 1;

bool is_reserved_for_int32(MoteusRegister reg) {
  return reg == MoteusRegister::model || reg == MoteusRegister::firmware;
}

}  // namespace

SimulatedMoteus::SimulatedMoteus(const SimulatedMoteusSettings& settings, std::int64_t now_ns)
    : SimulatedServo(settings, settings.turns, now_ns, boot_delay_ns), settings_(settings) {}

const char* SimulatedMoteus::state_name() const {
  switch (mode_) {
    case MoteusMode::stopped:
      return "stopped";
    case MoteusMode::fault:
      return "fault";
    case MoteusMode::position:
      return "position";
    case MoteusMode::timeout:
      return "timeout";
    default:
      return "enabling";
  }
}

// --- its time

void SimulatedMoteus::live(double seconds) {
  const std::int64_t underway_ns = now_ns_ - enabling_ns_;
  // It is enabling, then calibrates its current sensors, in three parts of the delay.
  if (mode_ == MoteusMode::enabling && 3 * underway_ns >= settings_.enable_delay_ns) {
    enter(MoteusMode::calibrating);
  } else if (mode_ == MoteusMode::calibrating && 3 * underway_ns >= 2 * settings_.enable_delay_ns) {
    enter(MoteusMode::calibrated);
  } else if (mode_ == MoteusMode::calibrated && underway_ns >= settings_.enable_delay_ns) {
    begin_position();
  }
  step(seconds);
  // Not a number: it never expires. 0: as the settings say.
  const double said_ns = command_.watchdog_s * 1e9;
  const double wait_ns = said_ns == 0 ? static_cast<double>(settings_.watchdog_ns) : said_ns;
  const bool is_silent = static_cast<double>(now_ns_ - fed_ns_) > wait_ns;
  if (mode_ == MoteusMode::position && watches_ && is_silent) enter(MoteusMode::timeout);
  flood();
}

void SimulatedMoteus::step(double seconds) {
  motor_.hold(has_trouble(Kind::stick));
  const bool has_power = (mode_ == MoteusMode::position && has_torque()) || mode_ == MoteusMode::timeout;
  const std::optional<double> speed = troubles_.place(Kind::run_away, now_ns_);
  if (has_power && speed) return motor_.follow_speed(*speed, seconds);
  if (mode_ == MoteusMode::position && has_torque()) {
    control_ += command_.velocity * seconds;
    const double inside = std::clamp(control_, settings_.min_turns, settings_.max_turns);
    fault_ = inside == control_ ? 0 : at_bound;
    control_ = inside;
    return motor_.follow({.position = control_ + zero_, .velocity = fault_ == 0 ? command_.velocity : 0},
                         seconds);
  }
  if (mode_ == MoteusMode::timeout) return motor_.follow({.position = motor_.position()}, seconds);
  coast(seconds);
}

void SimulatedMoteus::flood() {
  for (std::int64_t due = troubles_.flood(now_ns_); due > 0; --due) {
    FdFrame frame{.id = can::FrameId::shortest(std::uint32_t{settings_.node.value()} << 8)};
    can::MoteusWriter writer(frame);
    writer.reply(MoteusRegister::torque, MoteusType::float32, std::array{0.0});
    if (writer.finish()) send(frame);
  }
}

void SimulatedMoteus::enter(MoteusMode mode) {
  if (mode == mode_) return;
  mode_ = mode;
  record_entered();
  // Without torque nobody waits for it.
  if (mode == MoteusMode::timeout && has_torque()) record_reported(can::moteus_timeout_error);
}

void SimulatedMoteus::fail(int fault) {
  if (mode_ == MoteusMode::fault) return;
  fault_ = fault;
  record_reported(static_cast<std::uint32_t>(fault));
  enter(MoteusMode::fault);
}

void SimulatedMoteus::start_anew() {
  settings_.home_state = 0;
  fault_ = 0;
  command_ = {};
  enter(MoteusMode::stopped);
}

void SimulatedMoteus::meet(const DriveTrouble& trouble) {
  switch (trouble.kind) {
    case Kind::emergency:
      return fail(trouble.value);
    case Kind::no_watchdog:
      watches_ = false;
      return;
    case Kind::foreign_sender: {
      // Host 1 wants it to stay where it is, and no answer.
      FdFrame frame{.id = can::FrameId::standard(1U << 8 | settings_.node.value())};
      can::MoteusWriter writer(frame);
      writer.write(MoteusRegister::mode, MoteusType::int8, std::array{10.0});
      writer.write(MoteusRegister::command_position, MoteusType::float32, std::array{here()});
      if (!writer.finish()) return;
      send(frame);
      return receive(frame);
    }
    default:
      return;  // while it lasts, something else is done where it would be
  }
}

// --- its frames

void SimulatedMoteus::send(FdFrame frame) {
  if (has_trouble(Kind::lose_feedback) || has_trouble(Kind::lose_heartbeat)) return;
  if (takes_frame(Kind::lose_sent)) return;
  if (takes_frame(Kind::shorten)) {
    do --frame.length;
    while (!can::is_fd_length(frame.length));
  }
  put_frame(frame);
}

void SimulatedMoteus::receive(const FdFrame& frame) {
  const std::uint32_t receiver = frame.id.number() & 0x7F;
  const bool is_meant =
      frame.id.number() <= 0xFFFF && (receiver == settings_.node.value() || receiver == everybody);
  if (!is_meant || now_ns_ < boot_ns_ || takes_frame(Kind::lose_heard)) return;
  Command command;
  can::MoteusReader reader(frame);
  while (const std::optional<MoteusItem> item = reader.next()) {
    if (item->kind == MoteusItem::Kind::write) write(*item, command);
  }
  if ((frame.id.number() & 0x8000) != 0) {
    if (const std::optional<FdFrame> answer = answer_to(frame)) send(*answer);
  }
  if (command.mode) obey(command);
}

void SimulatedMoteus::write(const MoteusItem& item, Command& command) {
  if (item.reg == MoteusRegister::mode) {
    command = {};
    command.mode = item.value;
  }
  if (!command.mode) return;  // what comes before the mode is forgotten by it
  switch (item.reg) {
    case MoteusRegister::command_position:
      command.position = item.value;
      return;
    case MoteusRegister::command_velocity:
      command.velocity = std::isnan(item.value) ? 0 : item.value;
      return;
    case MoteusRegister::max_torque:
      command.max_torque = item.value;
      return;
    case MoteusRegister::watchdog:
      command.watchdog_s = item.value;
      return;
    default:
      return;
  }
}

std::optional<double> SimulatedMoteus::register_value(const MoteusItem& item) const {
  if (is_reserved_for_int32(item.reg) && item.type != MoteusType::int32) return {};
  switch (item.reg) {
    case MoteusRegister::mode:
      return static_cast<double>(mode_);
    case MoteusRegister::position:
      return here();
    case MoteusRegister::velocity:
      return motor_.velocity();
    case MoteusRegister::torque:
      return 0;
    case MoteusRegister::home_state:
      return settings_.home_state;
    case MoteusRegister::voltage:
      return 24;
    case MoteusRegister::temperature:
      return 25;
    case MoteusRegister::fault:
      return fault_;
    case MoteusRegister::model:
    case MoteusRegister::firmware:
      return 1;
    case MoteusRegister::map_version:
      return settings_.map_version;
    default:
      return {};
  }
}

/// In the style of the question, registers that follow each other in one sub-frame. Nothing where none was
/// asked for, or where they have no room.
std::optional<FdFrame> SimulatedMoteus::answer_to(const FdFrame& question) const {
  const std::uint32_t asker = question.id.number() >> 8 & 0x7F;
  FdFrame answer{.id = can::FrameId::shortest(std::uint32_t{settings_.node.value()} << 8 | asker),
                 .has_fast_data = question.has_fast_data};
  can::MoteusWriter writer(answer);
  std::vector<double> values;
  MoteusItem first, last;
  const auto end_sub_frame = [&] {
    if (!values.empty()) writer.reply(first.reg, first.type, values);
    values.clear();
  };
  can::MoteusReader reader(question);
  while (const std::optional<MoteusItem> item = reader.next()) {
    if (item->kind != MoteusItem::Kind::read) continue;
    const bool goes_on = item->type == last.type &&
                         static_cast<std::uint32_t>(item->reg) == static_cast<std::uint32_t>(last.reg) + 1;
    const std::optional<double> value = register_value(*item);
    if (!goes_on || !value) end_sub_frame();
    if (!value) {
      writer.read_error(item->reg, unknown_register);
      continue;
    }
    if (values.empty()) first = *item;
    last = *item;
    values.push_back(*value);
  }
  end_sub_frame();
  if (!writer.finish() || answer.length == 0) return {};
  answer.is_classic = question.is_classic && answer.length <= 8;
  return answer;
}

// --- its orders

void SimulatedMoteus::obey(const Command& command) {
  const bool is_latched = mode_ == MoteusMode::fault || mode_ == MoteusMode::timeout;
  if (command.mode == static_cast<double>(MoteusMode::stopped)) {
    if (has_trouble(Kind::stay_on)) return;
    if (mode_ == MoteusMode::fault && has_trouble(Kind::emergency)) return;
    fault_ = 0;
    return enter(MoteusMode::stopped);
  }
  if (command.mode != static_cast<double>(MoteusMode::position) || is_latched) return;
  fed_ns_ = now_ns_;
  if (mode_ == MoteusMode::position) return take_target(command);
  command_ = command;
  if (mode_ != MoteusMode::stopped) return;
  enabling_ns_ = now_ns_;
  enter(MoteusMode::enabling);
}

void SimulatedMoteus::begin_position() {
  if (here() < settings_.min_turns || here() > settings_.max_turns) return fail(outside_limits);
  control_ = here();
  enter(MoteusMode::position);
  take_target(command_);
}

void SimulatedMoteus::take_target(const Command& command) {
  if (has_trouble(Kind::ignore_target)) return;
  command_ = command;
  control_ = std::isnan(command.position) ? here() : command.position;
  if (!has_torque()) return;
  note_target(control_);
  record_applied(control_);
}

}  // namespace inbetween
