#include "host_tools/rig/cue_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/linux/monotonic_clock.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t ns_between_looks = 5'000'000;
/// More than begin in a tick of any move that a machine can play; beyond it they are counted.
constexpr std::size_t begun_in_a_tick = 256;

[[noreturn]] void refuse(std::string_view line, const Place& place, const std::string& what,
                         const std::string& remedy) {
  throw InputError(place, fmt::format("output {}: {}; {}", in_quotes(std::string(line)), what, remedy));
}

}  // namespace

CueOutputs::CueOutputs(const MoveFile& move, const RigFile& rig, const WholeFrames& line,
                       const WholeFrames& part, RigHardware& hardware)
    : pulses_(cue_pulses(move, part)),
      begun_(begun_in_a_tick),
      instants_(instants_for(begun_in_a_tick)),
      chain_(rig.rate_hz, played_lead_ns(rig)) {
  for (const Output& output : rig.outputs) {
    lines_.push_back({{output.name, &output.line, &output.place}, hardware.chip_of(output.line.address)});
  }
  if (const std::optional<Camera>& camera = rig.camera) {
    lines_.push_back(
        {{"camera", &camera->shutter, &camera->place}, hardware.chip_of(camera->shutter.address)});
  }
  std::ranges::stable_sort(lines_, {}, &Line::chip);
  if (lines_.size() > CueTimer::max_lines) {
    refuse(lines_.back().name, *lines_.back().place, "the rig has more than 64 outputs, the camera included",
           "remove some");
  }
  camera_ = number_of("camera");
  for (const CuePulse& pulse : pulses_) {
    const std::optional<std::size_t> number = number_of(pulse.line);
    if (!number) refuse(pulse.line, *pulse.place, "the rig does not have it", "add it to the rig");
    timed_.push_back({{pulse.frame, pulse.phase}, pulse.width_ns, static_cast<std::int32_t>(*number)});
  }
  timer_.emplace(value_or_refuse(CueTimer::make(timed_, line.first, line.last, move.fps.rate),
                                 pulses_.empty() ? move.frames_place : *pulses_.front().place));
  open_chips(hardware);
}

void CueOutputs::open_chips(RigHardware& hardware) {
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (chips_.empty() || chips_.back().label != lines_[i].chip) {
      chips_.push_back({.label = lines_[i].chip, .first = i, .outputs = {}});
    }
    ++chips_.back().lines;
  }
  const std::vector<PulseLine> wanted(lines_.begin(), lines_.end());
  for (Chip& chip : chips_) {
    chip.outputs = hardware.open_pulses(chip.label, std::span(wanted).subspan(chip.first, chip.lines));
  }
}

std::unique_ptr<CueOutputs> CueOutputs::open(const MoveFile& move, const RigFile& rig,
                                             const WholeFrames& line, const WholeFrames& part,
                                             RigHardware& hardware) {
  if (rig.outputs.empty() && !rig.camera) return nullptr;
  return std::unique_ptr<CueOutputs>(new CueOutputs(move, rig, line, part, hardware));
}

std::optional<std::size_t> CueOutputs::number_of(std::string_view line) const {
  const auto found = std::ranges::find(lines_, line, &Line::name);
  if (found == lines_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - lines_.begin());
}

void CueOutputs::tick(const CuePassage& passage, std::int32_t ticks, std::int64_t now_ns) {
  if (steps_ != nullptr && steps_->chain().is_running()) {
    chain_ = steps_->chain();
  } else {
    chain_.next(now_ns, ticks);
  }
  const CueTick tick{.from = passage.from,
                     .to = passage.to,
                     .repeated = passage.repeated,
                     .start_ns = chain_.start_ns(),
                     .end_ns = chain_.end_ns()};
  const Result<CueCount> count = timer_->advance(tick, {begun_, instants_});
  if (!count) {
    has_refused_ = true;
    return;
  }
  put_out(*count);
}

void CueOutputs::signal(bool is_exposing, std::int64_t now_ns) {
  if (!camera_) return;
  const std::uint64_t line = std::uint64_t{1} << *camera_;
  if (((levels_ & line) != 0) == is_exposing) return;
  put_out({.at_ns = now_ns + chain_.lead_ns(), .levels = is_exposing ? line : 0, .mask = line});
}

void CueOutputs::put_out(const CueCount& count) {
  for (std::size_t i = 0; i < count.instants; ++i) put_out(instants_[i]);
  for (std::size_t i = 0; i < count.begun; ++i) {
    if (told_) told_(begun_[i].pulse);
    if (log_) log_pulse(begun_[i]);
  }
  log_played();
}

void CueOutputs::log_to(const std::string& file, bool waits) {
  log_.emplace(file, pulses_, waits);
  awaited_.emplace(gpio::StepPlayer::capacity);
}

void CueOutputs::log_pulse(const BegunPulse& begun) {
  const auto line = static_cast<std::size_t>(timed_[begun.pulse].line);
  for (std::size_t c = 0; c < chips_.size(); ++c) {
    const Chip& chip = chips_[c];
    if (line < chip.first || line >= chip.first + chip.lines) continue;
    if (!awaited_->add(begun, c, std::uint64_t{1} << (line - chip.first))) ++not_logged_;
  }
}

void CueOutputs::log_played() {
  if (!awaited_) return;
  for (std::size_t c = 0; c < chips_.size(); ++c) {
    while (const auto played = chips_[c].outputs->take_played()) {
      awaited_->note_played(c, played->instant.at_ns, played->instant.levels & played->instant.mask,
                            played->late_ns);
    }
  }
  while (const std::optional<PlayedPulse> pulse = awaited_->next()) log_->take(*pulse);
}

void CueOutputs::put_out(const EdgeInstant& instant) {
  levels_ = (levels_ & ~instant.mask) | instant.levels;
  for (Chip& chip : chips_) {
    const std::uint64_t all = chip.lines == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << chip.lines) - 1;
    const std::uint64_t mask = instant.mask >> chip.first & all;
    if (mask == 0) continue;
    const std::uint64_t levels = instant.levels >> chip.first & all;
    if (!chip.outputs->push({.at_ns = instant.at_ns, .levels = levels, .mask = mask})) has_refused_ = true;
  }
}

void CueOutputs::finish(const std::function<bool()>& interrupted) {
  const Result<CueCount> count = timer_->end_all({begun_, instants_});
  if (count) put_out(*count);
  const MonotonicClock clock;
  const auto is_busy = [](const Chip& chip) {
    return chip.outputs->waiting() > 0 && !chip.outputs->has_ended();
  };
  while (std::ranges::any_of(chips_, is_busy) && !(interrupted && interrupted())) {
    clock.sleep_until_ns(clock.now_ns() + ns_between_looks);
  }
}

std::optional<LoopLogEnd> CueOutputs::end_log() {
  if (!log_) return std::nullopt;
  log_played();
  while (awaited_) {
    const std::optional<PlayedPulse> pulse = awaited_->rest();
    if (!pulse) break;
    log_->take(*pulse);
  }
  LoopLogEnd end = log_->finish();
  end.lost += static_cast<std::int64_t>(not_logged_);
  return end;
}

std::string CueOutputs::trouble() const {
  for (const Chip& chip : chips_) {
    if (chip.outputs->has_ended()) {
      return fmt::format("chip {} of the outputs has gone; plug it in again", in_quotes(chip.label));
    }
    if (const auto late_us = chip.outputs->too_late_us()) {
      return fmt::format("pulses on chip {} came {:.0f} us late; free the machine of other work",
                         in_quotes(chip.label), *late_us);
    }
  }
  if (const auto lost = static_cast<std::int64_t>(counters().lost); lost > 0) {
    return fmt::format("{} found no room in a tick; let fewer begin at once", counted(lost, "pulse"));
  }
  return has_refused_ ? "an output did not take a pulse; look whether its chip is still there" : "";
}

bool CueOutputs::is_on(std::string_view line) const {
  const std::optional<std::size_t> number = number_of(line);
  return number && (levels_ >> *number & 1) != 0;
}

}  // namespace inbetween
