// The limits of the axes of one track as conditions on its speed curve. They are taken at moments so dense
// that a peak between two of them is hardly higher. check() judges the motion between the moments.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host_tools/fit/control_curve.hpp"
#include "host_tools/fit/path_turns.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

enum class LimitedQuantity : std::uint8_t { velocity, acceleration, jerk, acceleration_step };
/// Velocity, acceleration, jerk, and the step of the acceleration.
inline constexpr std::size_t limited_quantities = 4;

/// The share of each limit of one axis that may be used, indexed by LimitedQuantity.
using Allowance = std::array<double, limited_quantities>;

/// A quantity of one axis as a share of its limit, with sign, at one moment.
struct LimitedValue {
  std::uint32_t axis = 0;
  LimitedQuantity quantity = LimitedQuantity::velocity;
  double share = 0;
  CurveWeights weights;  ///< how the share follows the curve at the moment's place
};

/// Values [first, end) of MotionSamples::values() belong to one moment.
struct Moment {
  CurvePlace place;
  std::size_t first = 0, end = 0;
  bool is_linearized_here = true;  ///< false: a neighbouring moment of the other kind is nearer to the truth
};

/// The limit that is used most. The share is above 0 if it is used beyond the allowance.
struct Excess {
  double share = -1;  ///< |share| / allowance - 1
  std::uint32_t axis = 0;
  LimitedQuantity quantity = LimitedQuantity::velocity;
};

/// Tells whether the acceleration steps at the first and the last frame, beside the steps at keys.
struct EndSteps {
  bool begin = false, end = false;
};

/// The motion of one track under a speed curve that may change. Phi at its breaks and at its end stays, and
/// therefore every K.
///
/// The speed along the path is w = K phi da/dt. With T = dP/dL an axis has velocity T w, acceleration T' w^2
/// + T w' and jerk T'' w^3 + 3 T' w w' + T w''. There are two kinds of moments. The first kind stays on the
/// curve while the path passes under it; these moments are evenly spaced in a. The second kind stays on the
/// path, on both sides of each key and denser where the path turns. Each kind is linearized in its own way.
/// The second kind is nearer to the truth where the path turns within the distance that is travelled in one
/// span, the first kind elsewhere.
class MotionSamples {
 public:
  /// The played curve has been refined `refinements` times. `axes` are the axes of the track, which has a
  /// speed curve; both must outlive this object.
  MotionSamples(const Track& track, std::span<const RigAxis> axes, int refinements, EndSteps steps,
                CurveEnds ends = CurveEnds::natural);

  /// Adds moments of both kinds at one more frame, which need not be a whole one. The place on the path is
  /// where `curve` is at that frame.
  void add_moment(double frame, const ControlCurve& curve);
  /// Evaluates every moment for a curve.
  void evaluate(const ControlCurve& curve);

  /// Of every curve that is evaluated.
  [[nodiscard]] CurveEnds ends() const { return ends_; }
  [[nodiscard]] std::span<const Moment> moments() const { return moments_; }
  [[nodiscard]] std::span<const LimitedValue> values() const { return values_; }
  /// Finds the worst excess over all moments that are linearized. `allowances` has an entry for every axis.
  [[nodiscard]] Excess worst(std::span<const Allowance> allowances) const;
  /// The largest |share| of every axis and quantity.
  [[nodiscard]] std::vector<Allowance> peaks() const;

 private:
  struct PathMoment {
    double distance = 0;
    bool is_key = false;
    PathTurns turns;
    std::vector<double> turn_steps;  ///< of T' at a key, one per axis; otherwise empty
  };
  /// The move between two breaks. There distance = offset + constant * Phi.
  struct Stretch {
    double begin = 0;  ///< a
    double begin_distance = 0;
    double constant = 0;
    double offset = 0;
  };
  struct Pace;
  struct KnownPlace;

  void find_stretches();
  [[nodiscard]] const Stretch& stretch_at(double a) const;
  void sample_segment(std::int32_t segment);
  void add_turning(std::int32_t segment, double begin, double end, int depth);
  void add_path_moment(std::int32_t segment, double t);
  void add_key_steps(std::int32_t key);
  [[nodiscard]] Pace pace(const ControlCurve& curve, const CurvePlace& place, const Stretch& stretch) const;
  void add_end_step(std::size_t first);
  void evaluate_curve_moment(const ControlCurve& curve, double a);
  /// `near` is the place of a moment beside it on the path, and becomes its own.
  void evaluate_path_moment(const ControlCurve& curve, const PathMoment& moment, KnownPlace& near);
  void add_values(const Pace& pace, const PathMoment& moment, bool stays_on_path);
  void add_step(const Pace& pace, const PathMoment& moment);

  const Track& track_;
  std::span<const RigAxis> axes_;
  EndSteps steps_;
  CurveEnds ends_;
  double factor_;    ///< 2^refinements
  double per_span_;  ///< da/dt
  double spans_;     ///< f
  double standing_;  ///< phi below this is none
  std::vector<Stretch> stretches_;
  std::vector<double> curve_moments_;
  std::vector<PathMoment> path_moments_;
  std::vector<Moment> moments_;
  std::vector<LimitedValue> values_;
};

}  // namespace inbetween
