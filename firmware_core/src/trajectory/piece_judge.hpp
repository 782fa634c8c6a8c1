#pragma once

#include <cstddef>
#include <span>

#include "inbetween/trajectory/fit.hpp"
#include "trajectory/drawn_sampler.hpp"
#include "trajectory/hermite.hpp"
#include "trajectory/sampled_rows.hpp"

/// Whether a piece is as near to what is asked as the tolerances want.

namespace inbetween {

/// A piece whose rows need not be in a trajectory yet.
struct JudgedPiece {
  const TrajectoryPiece* piece;
  PieceRows rows;
  double loosened = 1;                     ///< so many times the tolerances
  double slowest = 0;                      ///< the lower SampledSpeed::speed of both ends
  bool is_first = false, is_last = false;  ///< between two joints
};

class PieceJudge {
 public:
  /// Memory, in numbers for each axis.
  static constexpr std::size_t numbers = 6;

  /// `samples` has an entry for each axis, and `memory` `numbers` for each.
  PieceJudge(const TrackSampler& sampler, const FitTolerances& tolerances,
             std::span<AxisMotion<double>> samples, std::span<double> memory);

  /// The piece that is judged ends like this, and so does the one before it that is taken. At rest the place
  /// is known as well as the curve has come to it.
  void end_at(const SampledSpeed& known);
  void go_on();

  /// A septic, by how far it is off in its middle, and beside a joint once more.
  [[nodiscard]] bool is_near(const JudgedPiece& judged, const SampledRow& middle);
  /// Any piece, by two or four places inside.
  [[nodiscard]] bool is_near(const JudgedPiece& judged);
  /// Marks every axis that is off at one of the four.
  void mark_off(const JudgedPiece& judged, std::span<bool> axes);

 private:
  template <class Visit>
  void visit_shares(const JudgedPiece& judged, double u, const Visit& visit);
  [[nodiscard]] double share_of_axis(const JudgedPiece& judged, const SampledSpeed& known, std::size_t d,
                                     double position, double velocity) const;
  [[nodiscard]] double worst_share(const JudgedPiece& judged, double u);
  [[nodiscard]] double way_rate(double speed) const;
  [[nodiscard]] double way_seconds(double speed) const;

  const TrackSampler& sampler_;
  FitTolerances tolerances_;
  std::span<AxisMotion<double>> asked_;
  std::span<double> travel_, min_speeds_, inverse_weights_;
  /// How far positions may be from where the curve has come to: at either end at rest, and both together.
  std::span<double> off_at_begin_, off_at_end_, off_;
  bool begin_is_off_ = false, end_is_off_ = false;
  bool has_off_ = false;  ///< not all of off_ are 0
  double whole_seconds_ = 0;
  SampledSegment known_;
};

}  // namespace inbetween
