// The axes of a rig that look for their switches, as a motion loop plays them.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/motions/free_axes.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/homing/homing.hpp"
#include "inbetween/homing/line_event.hpp"
#include "inbetween/loop/ports.hpp"

namespace inbetween {

/// The lines of a rig as far as a homing needs them, in the tick that is under way.
template <class Lines>
concept HomeLines = requires(const Lines& lines, std::size_t axis) {
  { lines.homing_input(axis) } -> std::convertible_to<HomingInput>;
  { lines.events() } -> std::convertible_to<std::span<const LineEvent>>;
  { lines.home_switch(axis) } -> std::convertible_to<SwitchSettings>;
};

/// The spec of AxisHoming from the `home` of the rig. An axis that stands on its switch leaves it by at most
/// the distance that it runs over it and four times the distance to back off: a stuck switch does not send it
/// through the rig.
HomingSpec homing_spec_of(const RigAxis& axis, const SwitchSettings& home);

/// The homing of an axis with a `home`. Throws InputError at the place of a homing that is not possible.
AxisHoming axis_homing_of(const RigAxis& axis, const SwitchSettings& home, FreeAxis& free);

/// A FreeSource: the axes home together from where they stand when the loop begins. Refers to the rig, the
/// lines and the states of its drives. Allocates only when it is made.
template <HomeLines Lines>
class RigHoming {
 public:
  struct Setting {
    std::span<const double> positions;   ///< of all axes of the rig, now
    std::span<const DriveState> drives;  ///< of all axes, in every tick
    double tick_seconds = 0;
    std::int64_t delay_ns = 0;  ///< the setpoints of a tick are reached so much later
  };

  /// Throws InputError at the place of an axis that cannot home.
  RigHoming(const RigFile& rig, std::vector<std::size_t> axes, const Lines& lines, const Setting& setting)
      : rig_(rig),
        indices_(std::move(axes)),
        lines_(lines),
        drives_(setting.drives),
        inputs_(indices_.size()) {
    free_.reserve(indices_.size());
    homings_.reserve(indices_.size());
    for (const std::size_t a : indices_) {
      free_.push_back(free_axis_of(rig.axes[a], free_limits_of(rig.axes[a], 1), setting.positions[a],
                                   setting.tick_seconds));
      homings_.push_back(axis_homing_of(rig.axes[a], lines.home_switch(a), free_.back()));
    }
    homing_.emplace(homings_, setting.delay_ns);
  }
  RigHoming(const RigHoming&) = delete;
  RigHoming& operator=(const RigHoming&) = delete;

  void tick(std::int64_t now_ns, std::span<Setpoint> out) {
    look();
    if (!has_begun_) {
      has_begun_ = true;
      if (const Status begun = homing_->start(now_ns, inputs_); !begun) refusal_ = begun.error();
    }
    if (refusal_) {
      for (std::size_t i = 0; i < free_.size(); ++i) out[i] = free_[i].state();
      return;
    }
    homing_->tick(now_ns, inputs_, lines_.events(), out);
  }
  void stop() {
    note_cause();
    homing_->stop();
  }
  void halt() {
    note_cause();
    homing_->halt();
  }
  [[nodiscard]] bool is_resting() const { return has_begun_ && homing_->state() != HomingState::moving; }

  // Once it rests.

  [[nodiscard]] bool is_done() const { return !refusal_ && homing_->state() == HomingState::done; }
  /// The distance to add to what the drive of the i-th homing axis tells.
  [[nodiscard]] double shift(std::size_t i) const { return homings_[i].shift(); }
  /// Which axis was not referenced, why, and what to do; "" if nothing of the axes was the reason.
  [[nodiscard]] std::string reason() const {
    if (refusal_) return words(refusal_->axis, refusal_->what, refusal_->remedy);
    if (homing_->failed_axis() >= 0) return words(homing_->failed_axis());
    if (cause_axis_ >= 0) return words(cause_axis_, words_of(cause_), remedy_of(cause_));
    return "";
  }

 private:
  void look() {
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      inputs_[i] = lines_.homing_input(indices_[i]);
      inputs_[i].drive_fault =
          inputs_[i].drive_fault || drives_[indices_[i]].condition != DriveCondition::fine;
    }
  }
  /// The loop reads its lines and drives before this does, and stops for what it finds.
  void note_cause() {
    has_begun_ = true;
    if (cause_axis_ >= 0 || homing_->state() != HomingState::moving) return;
    look();
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      if (!inputs_[i].limit_hit && !inputs_[i].drive_fault) continue;
      cause_axis_ = static_cast<std::int32_t>(i);
      cause_ = inputs_[i].limit_hit ? HomingFailure::limit_hit : HomingFailure::drive_fault;
      return;
    }
  }
  [[nodiscard]] std::string words(std::int32_t axis) const {
    const HomingFailure failure = homings_[static_cast<std::size_t>(axis)].failure();
    return words(axis, words_of(failure), remedy_of(failure));
  }
  [[nodiscard]] std::string words(std::int32_t axis, const char* what, const char* remedy) const {
    std::string text;
    if (axis >= 0) {
      text = "axis " + in_quotes(rig_.axes[indices_[static_cast<std::size_t>(axis)]].name) + ": ";
    }
    return text + what + "; " + remedy;
  }

  const RigFile& rig_;
  std::vector<std::size_t> indices_;
  const Lines& lines_;
  std::span<const DriveState> drives_;
  std::vector<FreeAxis> free_;
  std::vector<AxisHoming> homings_;
  std::vector<HomingInput> inputs_;
  std::optional<Homing> homing_;
  std::optional<Error> refusal_;
  bool has_begun_ = false;
  std::int32_t cause_axis_ = -1;
  HomingFailure cause_ = HomingFailure::none;
};

}  // namespace inbetween
