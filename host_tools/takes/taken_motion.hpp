// What a take played, kept as numbers, so that it is the same whichever version of the program solves the
// move.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "inbetween/limits/played_motion.hpp"

namespace inbetween {

/// Trajectories and rolls as bytes: about 40 a piece and 8 a number of its values. Two motions that are the
/// same to the last bit have the same bytes. Motors behind a calibration are left out: they follow the axes.
std::string bytes_of(const PlayedMotion& motion);

/// The motion of such bytes, to the last bit.
class TakenMotion {
 public:
  /// Null where the bytes are no motion.
  static std::unique_ptr<TakenMotion> read(std::string_view bytes);
  TakenMotion(const TakenMotion&) = delete;
  TakenMotion& operator=(const TakenMotion&) = delete;

  [[nodiscard]] const PlayedMotion& motion() const { return *motion_; }

 private:
  struct Row {
    std::vector<TrajectoryPiece> pieces;
    std::vector<double> values;
    std::vector<TrajectoryBreak> breaks;
    std::vector<std::uint32_t> buckets;
  };
  TakenMotion() = default;

  std::vector<RollAxis> before_, after_;
  std::vector<std::unique_ptr<Row>> rows_;
  std::vector<Trajectory> trajectories_;
  std::optional<PlayedMotion> motion_;
};

}  // namespace inbetween
