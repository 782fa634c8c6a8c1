// The move that a host has uploaded: a position per motor and frame, and what is switched at which frame. Its
// memory is fixed when it is made, and its size is what HI states.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/dragonframe/rig_port.hpp"

namespace inbetween::dragonframe {

/// A block of positions of one motor, as it is uploaded.
struct UploadBlock {
  std::uint8_t motor = 0;
  std::uint32_t index = 0;  ///< of its first position; 0 is the start frame
  bool is_last = false;     ///< its last position holds to the end of the move
  std::span<const std::int32_t> positions;
};

class UploadedMove {
 public:
  /// `capacity` frames of `motors` motors: 4.5 bytes each, all taken here.
  UploadedMove(std::size_t motors, std::uint32_t capacity);

  /// Forgets the old move. `range` where the end is before the start or the frames are more than the
  /// capacity: then there is no move at all.
  RigAnswer begin(std::int32_t start, std::int32_t end);
  /// In any order. `range`: a motor or a frame that is not there, and nothing is written; `general`: no
  /// begin(), or a block without a position.
  RigAnswer put(const UploadBlock& block);
  /// Of a frame index, 0 being the start frame: what is on. Elsewhere all of `mask` is off. Answers as put().
  RigAnswer set_trigger_mask(std::uint32_t mask);
  RigAnswer put_trigger(std::uint32_t index, std::uint32_t values);
  /// `general` where a motor that has positions misses some, or nothing was begun.
  RigAnswer finish();
  void clear();

  /// Whether there is a whole move. What follows is of such a move.
  [[nodiscard]] bool is_loaded() const { return is_loaded_; }
  [[nodiscard]] std::int32_t start() const { return start_; }
  [[nodiscard]] std::int32_t end() const {
    return static_cast<std::int32_t>(start_ + std::int64_t{count_} - 1);
  }
  [[nodiscard]] bool has(std::int32_t frame) const { return is_loaded_ && frame >= start_ && frame <= end(); }
  [[nodiscard]] MotorMask motors() const { return motors_with_positions_; }

  /// Steps at any time, in frames. Straight between frames. Up to one frame before the start it goes on as
  /// between the first two frames, as the maker's table does; before that and behind the end it stands.
  [[nodiscard]] double position(std::uint8_t motor, double frame) const;

  [[nodiscard]] std::uint32_t trigger_mask() const { return trigger_mask_; }
  [[nodiscard]] std::uint32_t triggers_at(std::int32_t frame) const;

 private:
  [[nodiscard]] std::size_t place(std::size_t motor, std::size_t index) const {
    return motor * capacity_ + index;
  }

  std::size_t motor_count_ = 0;
  std::uint32_t capacity_ = 0;
  std::vector<std::int32_t> positions_;  ///< motor after motor
  std::vector<bool> is_there_;           ///< likewise
  std::vector<std::uint32_t> triggers_;
  std::int32_t start_ = 0;
  std::uint32_t count_ = 0;
  MotorMask motors_with_positions_ = 0;
  std::uint32_t trigger_mask_ = 0;
  bool is_open_ = false;
  bool is_loaded_ = false;
};

}  // namespace inbetween::dragonframe
