#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "base/lanes.hpp"
#include "inbetween/trajectory/fit.hpp"
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

namespace judging {

/// A piece is compared with what is asked at these places: the derivative of the error of a septic,
/// u^4 (1 - u)^4, is largest at the first two, and the speed may be that of a rest near the others.
inline constexpr std::array<double, 4> compared_at{0.31, 0.69, 0.88, 0.12};
/// Between the places at which a piece is compared it may be further off: in the middle 1.9 times, beside the
/// others its velocity.
inline constexpr double margin = 0.4;
/// If the first two looks find no more than this share, the other two are left out, but not at the ends of a
/// stretch.
inline constexpr double sure_share = 0.25;
/// The estimate from the middle may take this share of a tolerance: it knows more than single looks do.
inline constexpr double margin_of_middle = 0.7;
/// The speed is even if both ends have this share of that in the middle; otherwise a tolerance is much
/// smaller at an end.
inline constexpr double even_share = 0.5;
inline constexpr double min_speed_share = 1e-6;
inline constexpr double rounding = distance_roundings * std::numeric_limits<double>::epsilon();
inline constexpr double tiny = std::numeric_limits<double>::min();

/// Memory of a judge, in numbers for each axis.
inline constexpr std::size_t numbers = 6;

/// A number that is none is beyond all.
inline double share_of(double off, double tolerance) {
  if (off <= 0) return 0;
  const double share = off / tolerance;
  return share <= std::numeric_limits<double>::max() ? share : std::numeric_limits<double>::infinity();
}

/// This is known of all axes at the middle of a septic.
struct MiddleLook {
  PieceRows rows;
  const double* middle;
  double seconds;
  double speed;                        ///< asked, along the path
  double path_rate;                    ///< of the whole path, in a second
  double path_seconds;                 ///< for the whole path at that speed
  double position_share, speed_share;  ///< with their margin
  std::span<const double> travel, min_speeds, inverse_weights;
  std::span<const double> off;  ///< of the position, beside rounding
};

/// A septic, by how far it is off in its middle.
bool is_near_by_middle(const MiddleLook& look);

/// The tolerance of an axis' velocity is a share of this: the drawn speed; of an axis that does not count
/// along the path its own velocity, and its share of the path, so that it may stand still. A distance of less
/// than a millionth in a frame is as good as a rest. Of one axis or of a group.
template <class Number>
Number counted_speed(const Number& velocity, const Number& travel, const Number& inverse_weight,
                     const Number& min_speed, double speed, double path_rate) {
  const Number by_weight = speed * inverse_weight;
  const Number by_path = absolute(velocity) + path_rate * travel;
  return greatest(if_less(Number(0), inverse_weight, by_weight, by_path), min_speed);
}
/// Rounding leaves this open of a position: that of the number itself, and of the distance along the path. No
/// piece is so short that this were a speed. Of one axis or of a group.
template <class Number>
Number noise_of(const Number& position, const Number& velocity, double path_seconds) {
  return rounding * (absolute(position) + path_seconds * absolute(velocity));
}

template <class Sampler>
void measure_travel(const Sampler& sampler, std::span<AxisMotion> samples, std::span<double> out) {
  const auto joints = sampler.joints();
  std::array<double, max_trajectory_axes> lowest{}, highest{};
  lowest.fill(std::numeric_limits<double>::infinity());
  highest.fill(-std::numeric_limits<double>::infinity());
  const auto take = [&](const SampledSpeed&) {
    for (std::size_t d = 0; d < out.size(); ++d) {
      lowest[d] = std::min(lowest[d], samples[d].position);
      highest[d] = std::max(highest[d], samples[d].position);
    }
  };
  take(sampler.leaving(joints.front(), samples));
  for (std::size_t i = 1; i < joints.size(); ++i) {
    const double frames = frames_between(joints[i - 1].time, joints[i].time);
    take(sampler.sample(moved_by(joints[i - 1].time, frames / 2), samples));
    take(sampler.arriving(joints[i], samples));
  }
  for (std::size_t d = 0; d < out.size(); ++d) out[d] = highest[d] - lowest[d];
}

}  // namespace judging

template <class Sampler>
class PieceJudge {
 public:
  /// Memory, in numbers for each axis.
  static constexpr std::size_t numbers = judging::numbers;

  /// `samples` has an entry for each axis, and `memory` `numbers` for each.
  PieceJudge(const Sampler& sampler, const FitTolerances& tolerances, std::span<AxisMotion> samples,
             std::span<double> memory);

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
  [[nodiscard]] double path_rate(double speed) const;
  [[nodiscard]] double path_seconds(double speed) const;

  const Sampler& sampler_;
  FitTolerances tolerances_;
  std::span<AxisMotion> asked_;
  std::span<double> travel_, min_speeds_, inverse_weights_;
  /// How far positions may be from where the curve has come to: at either end at rest, and both together.
  std::span<double> off_at_begin_, off_at_end_, off_;
  bool begin_is_off_ = false, end_is_off_ = false;
  bool has_off_ = false;  ///< not all of off_ are 0
  double whole_seconds_ = 0;
  typename Sampler::Known known_;
};

template <class Sampler>
PieceJudge<Sampler>::PieceJudge(const Sampler& sampler, const FitTolerances& tolerances,
                                std::span<AxisMotion> samples, std::span<double> memory)
    : sampler_(sampler), tolerances_(tolerances), asked_(samples) {
  const std::size_t axes = samples.size();
  std::size_t taken = 0;
  for (std::span<double>* own :
       {&travel_, &min_speeds_, &inverse_weights_, &off_at_begin_, &off_at_end_, &off_})
    *own = memory.subspan(axes * taken++, axes);
  if (tolerances.travel.empty()) {
    judging::measure_travel(sampler, asked_, travel_);
  } else {
    std::copy_n(tolerances.travel.begin(), axes, travel_.begin());
  }
  const FrameRate fps = sampler.frame_rate();
  const double seconds_per_frame = static_cast<double>(fps.denominator) / static_cast<double>(fps.numerator);
  for (std::size_t d = 0; d < axes; ++d) {
    min_speeds_[d] = judging::min_speed_share * travel_[d] / seconds_per_frame;
    inverse_weights_[d] = sampler.weight(d) > 0 ? 1 / sampler.weight(d) : 0;
  }
  std::ranges::fill(off_, 0.0);
  whole_seconds_ =
      seconds_per_frame * frames_between(sampler.joints().front().time, sampler.joints().back().time);
}

template <class Sampler>
void PieceJudge<Sampler>::end_at(const SampledSpeed& known) {
  end_is_off_ = known.off > 0;
  if (end_is_off_) sampler_.write_reach(known.point, known.off, off_at_end_);
  const bool is_off = begin_is_off_ || end_is_off_;
  if (!is_off && !has_off_) return;  // all are 0, as they were
  for (std::size_t d = 0; d < off_.size(); ++d)
    off_[d] = (begin_is_off_ ? off_at_begin_[d] : 0) + (end_is_off_ ? off_at_end_[d] : 0);
  has_off_ = is_off;
}

template <class Sampler>
void PieceJudge<Sampler>::go_on() {
  begin_is_off_ = end_is_off_;
  if (begin_is_off_) std::ranges::copy(off_at_end_, off_at_begin_.begin());
}

template <class Sampler>
bool PieceJudge<Sampler>::is_near(const JudgedPiece& judged, const SampledRow& middle) {
  const double speed = middle.known.speed;
  const double share = judging::margin_of_middle * judged.loosened;
  if (!judging::is_near_by_middle({.rows = judged.rows,
                                   .middle = middle.values,
                                   .seconds = judged.piece->seconds,
                                   .speed = speed,
                                   .path_rate = path_rate(speed),
                                   .path_seconds = path_seconds(speed),
                                   .position_share = share * tolerances_.position_share,
                                   .speed_share = share * tolerances_.speed_share,
                                   .travel = travel_,
                                   .min_speeds = min_speeds_,
                                   .inverse_weights = inverse_weights_,
                                   .off = off_}))
    return false;
  if (!(judged.slowest >= judging::even_share * speed)) return is_near(judged);
  // Beside a joint the path may turn sharply.
  return !(judged.is_first && worst_share(judged, judging::compared_at[3]) > 1) &&
         !(judged.is_last && worst_share(judged, judging::compared_at[2]) > 1);
}

template <class Sampler>
bool PieceJudge<Sampler>::is_near(const JudgedPiece& judged) {
  double worst = 0;
  for (const double u : judging::compared_at) {
    const bool is_sure = worst <= judging::sure_share && !judged.is_first && !judged.is_last;
    if (u == judging::compared_at[2] && is_sure) break;
    worst = std::max(worst, worst_share(judged, u));
    if (worst > 1) return false;
  }
  return true;
}

template <class Sampler>
void PieceJudge<Sampler>::mark_off(const JudgedPiece& judged, std::span<bool> axes) {
  for (const double u : judging::compared_at)
    visit_shares(judged, u, [&](std::size_t d, double share) { axes[d] = axes[d] || share > 1; });
}

template <class Sampler>
double PieceJudge<Sampler>::worst_share(const JudgedPiece& judged, double u) {
  double worst = 0;
  visit_shares(judged, u, [&](std::size_t, double share) { worst = std::max(worst, share); });
  return worst;
}

/// Calls visit(axis, share): how far off it is at u, as a share of what it may be.
template <class Sampler>
template <class Visit>
void PieceJudge<Sampler>::visit_shares(const JudgedPiece& judged, double u, const Visit& visit) {
  const TrajectoryPiece& piece = *judged.piece;
  const SampledSpeed known = sampler_.sample(moved_by(piece.begin, u / piece.inverse_frames), known_, asked_);
  with_degree(piece.degree, [&](auto degree) {
    const HermiteWeights at = position_weights<degree>(u, piece.seconds);
    const HermiteWeights rate = hermite_weights<degree, 1>(u, piece.seconds);
    for (std::size_t d = 0; d < asked_.size(); ++d) {
      const double position = judged.rows.begin[d] + sum_of<known_of(degree)>(at, judged.rows, d);
      const double velocity = sum_of<known_of(degree)>(rate, judged.rows, d);
      visit(d, share_of_axis(judged, known, d, position, velocity));
    }
  });
}

/// How far a position and a velocity are off what was asked last, as a share of what they may be.
template <class Sampler>
double PieceJudge<Sampler>::share_of_axis(const JudgedPiece& judged, const SampledSpeed& known, std::size_t d,
                                          double position, double velocity) const {
  const AxisMotion& asked = asked_[d];
  const double share = judging::margin * judged.loosened;
  const double noise = judging::noise_of(asked.position, asked.velocity, path_seconds(known.speed)) + off_[d];
  const double of_position = judging::share_of(std::fabs(position - asked.position) - noise,
                                               share * tolerances_.position_share * travel_[d]);
  if (known.order == 0) return of_position;
  const double counted = judging::counted_speed(asked.velocity, travel_[d], inverse_weights_[d],
                                                min_speeds_[d], known.speed, path_rate(known.speed));
  return std::max(of_position,
                  judging::share_of(std::fabs(velocity - asked.velocity) - noise / judged.piece->seconds,
                                    share * tolerances_.speed_share * counted));
}

/// The share of the whole path that is passed in a second.
template <class Sampler>
double PieceJudge<Sampler>::path_rate(double speed) const {
  const double length = sampler_.length();
  return length > 0 ? speed / length : 1 / whole_seconds_;
}
/// The seconds that the whole path takes at a speed; 0 at rest.
template <class Sampler>
double PieceJudge<Sampler>::path_seconds(double speed) const {
  return speed > judging::tiny ? sampler_.length() / speed : 0;
}

}  // namespace inbetween
