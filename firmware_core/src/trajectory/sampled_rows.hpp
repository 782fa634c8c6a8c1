#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "inbetween/trajectory/sampler.hpp"

/// What a sampler says, in the layout of a trajectory's values.

namespace inbetween {

/// For each axis its position, velocity, acceleration and jerk.
inline constexpr std::size_t row_numbers = 4;

/// Positions of all axes, then their velocities, accelerations and jerks, as far as they are known.
struct SampledRow {
  SampledSpeed known;
  double* values = nullptr;
};

inline void write_row(std::span<const AxisMotion> motion, double* out) {
  const std::size_t axes = motion.size();
  for (std::size_t d = 0; d < axes; ++d) {
    out[d] = motion[d].position;
    out[axes + d] = motion[d].velocity;
    out[2 * axes + d] = motion[d].acceleration;
    out[3 * axes + d] = motion[d].jerk;
  }
}

/// The rows at the ends of halves of halves of a stretch between two joints. The middle of one that is too
/// long is the end of its first half: it is asked for once. Of each level one row is kept, up to `kept`
/// levels; what was forgotten is asked for again.
template <class Sampler>
class SampledRows {
  using Joint = typename Sampler::Joint;

 public:
  static constexpr std::size_t kept = 8;
  /// Memory, in numbers for each axis.
  static constexpr std::size_t numbers = (kept + 1) * row_numbers;

  /// `samples` has an entry for each axis, and `memory` `numbers` for each.
  SampledRows(const Sampler& sampler, std::span<AxisMotion> samples, std::span<double> memory)
      : sampler_(&sampler), samples_(samples) {
    const std::size_t row = row_numbers * samples.size();
    for (std::size_t i = 0; i < kept; ++i) slots_[i].row.values = &memory[i * row];
    middle_.row.values = &memory[kept * row];
  }

  void begin(const Joint& from, const Joint& to) {
    from_ = from.time;
    to_ = &to;
    frames_ = frames_between(from.time, to.time);
    for (Slot& slot : slots_) slot.level = nothing;
  }
  /// The place `index` 2^-level of the stretch.
  [[nodiscard]] FrameTime time(int level, std::uint64_t index) const {
    if (index == 0) return from_;
    if (index == std::uint64_t{1} << level) return to_->time;
    return moved_by(from_, frames_ * std::ldexp(1.0, -level) * static_cast<double>(index));
  }
  /// Where the part that ends at this place ends. The row is there until another is asked for.
  const SampledRow& end(int level, std::uint64_t index) {
    for (; index % 2 == 0; index /= 2) --level;
    Slot& slot = slots_[static_cast<std::size_t>(level) % kept];
    if (slot.level != level || slot.index != index) ask(level, index, slot);
    return slot.row;
  }
  /// The middle of the part with this number.
  const SampledRow& middle(int level, std::uint64_t part) {
    ask(level + 1, 2 * part + 1, middle_);
    return middle_.row;
  }
  /// The middle that was asked for last becomes an end.
  void keep_middle() { std::swap(slots_[static_cast<std::size_t>(middle_.level) % kept], middle_); }

 private:
  static constexpr int nothing = -1;
  struct Slot {
    int level = nothing;
    std::uint64_t index = 0;
    SampledRow row;
  };

  void ask(int level, std::uint64_t index, Slot& slot) {
    slot.level = level;
    slot.index = index;
    slot.row.known = level == 0 ? sampler_->arriving(*to_, samples_)
                                : sampler_->sample(time(level, index), known_, samples_);
    write_row(samples_, slot.row.values);
  }

  const Sampler* sampler_;
  std::span<AxisMotion> samples_;
  std::array<Slot, kept> slots_;
  Slot middle_;
  typename Sampler::Known known_;
  FrameTime from_;
  const Joint* to_ = nullptr;
  double frames_ = 0;
};

}  // namespace inbetween
