#include "inbetween/joints/crane_positions.hpp"

#include <array>
#include <cmath>

#include "base/scaled_norm.hpp"
#include "inbetween/joints/angle_of.hpp"
#include "inbetween/joints/arm_angles.hpp"
#include "inbetween/joints/sine_cosine.hpp"

namespace inbetween {
namespace {

constexpr double half_turn = 3.14159265358979323846;

/// A hand that turns in a plane: it points to (x, y) at 0.
template <Precise Real>
struct TurningHand {
  Real x = 0;
  Real y = 0;
};

template <Precise Real>
struct TurnedHand {
  Real angle = 0;
  Real x = 0;
};

/// The angle at which the hand is `y` high, with x below 0 where it is `back`. Factors keep the digits of x
/// where the hand is almost upright.
template <Precise Real>
Result<TurnedHand<Real>> turned_to_height(const TurningHand<Real>& hand, Real y, bool back,
                                          const Error& too_far) {
  const std::array components{hand.x, hand.y};
  const Real length = scaled_norm<Real>(2, [&](std::size_t i) { return components[i]; });
  if (!std::isfinite(length) || !std::isfinite(y)) {
    return Error{.code = ErrorCode::not_finite,
                 .what = "a place or a length is not finite",
                 .remedy = "use finite numbers"};
  }
  if (length == 0) {
    return Error{.code = ErrorCode::singular,
                 .what = "the head is on an axis of the crane, which may then be anything",
                 .remedy = "lead the path round it"};
  }
  if (std::fabs(y) > length) return too_far;
  const Real x = std::sqrt((length - y) * (length + y));
  TurnedHand<Real> turned{0, back ? -x : x};
  turned.angle = angle_of(turned.x, y) - angle_of(hand.x, hand.y);
  return turned;
}

}  // namespace

template <Precise Real>
Result<CranePositions<Real>> crane_positions(const CameraCrane<Real>& crane, const Vector3<Real>& head,
                                             CraneSides sides) {
  const Vector3<Real> beside = cross(crane.column, crane.track);
  const Vector3<Real> forward = cross(crane.column, crane.boom);
  const Vector3<Real> way = head - crane.foot;
  const auto boom = turned_to_height<Real>({dot(crane.raised, forward), dot(crane.raised, crane.column)},
                                           dot(way - crane.level, crane.column), sides.leans_back,
                                           {.code = ErrorCode::no_solution,
                                            .what = "the place is higher or lower than the boom reaches",
                                            .remedy = "move it to a height that the boom reaches"});
  if (!boom) return boom.error();
  const Vector3<Real> carried = forward * (dot(crane.level, forward) + boom->x) +
                                crane.boom * dot(crane.level + crane.raised, crane.boom);
  const auto swing = turned_to_height<Real>(
      {dot(carried, crane.track), dot(carried, beside)}, dot(way, beside), sides.is_behind,
      {.code = ErrorCode::no_solution,
       .what = "the place is farther from the track than the boom reaches",
       .remedy = "move it nearer to the track"});
  if (!swing) return swing.error();
  return CranePositions<Real>{dot(way, crane.track) - swing->x, swing->angle, boom->angle};
}

template <Precise Real>
Result<HeadAngles<Real>> head_angles(const CameraHead<Real>& head, const Vector3<Real>& direction,
                                     bool over) {
  const Vector3<Real> forward = cross(head.pan, head.tilt);
  const auto seen = [&](const Vector3<Real>& v) {
    return Vector3<Real>{dot(v, forward), -dot(v, head.tilt), dot(v, head.pan)};
  };
  const auto aimed = aim_at(seen(direction));
  if (!aimed) return aimed.error();
  const Vector3<Real> at_zero = seen(head.roll);
  const Real raised = angle_of(at_zero.x, at_zero.z);
  if (!over) return HeadAngles<Real>{aimed->pan, aimed->tilt - raised, 0};
  const auto half = static_cast<Real>(half_turn);
  return HeadAngles<Real>{aimed->pan + half, half - aimed->tilt - raised, 0};
}

template <Precise Real>
Result<HeadAngles<Real>> head_angles(const CameraHead<Real>& head, const Rotation3<Real>& turn, bool over) {
  auto angles = head_angles(head, turn * head.roll, over);
  if (!angles) return angles;
  const Rotation3<Real> aimed =
      turned_about(head.pan, sine_cosine(angles->pan)) * turned_about(head.tilt, sine_cosine(angles->tilt));
  // What is left is a turn about the roll, to which the tilt is square.
  const Vector3<Real> left = inverse(aimed) * (turn * head.tilt);
  angles->roll = angle_of(dot(left, head.tilt), dot(left, cross(head.roll, head.tilt)));
  return angles;
}

template Result<CranePositions<double>> crane_positions(const CameraCrane<double>&, const Vector3<double>&,
                                                        CraneSides);
template Result<CranePositions<float>> crane_positions(const CameraCrane<float>&, const Vector3<float>&,
                                                       CraneSides);
template Result<HeadAngles<double>> head_angles(const CameraHead<double>&, const Rotation3<double>&, bool);
template Result<HeadAngles<float>> head_angles(const CameraHead<float>&, const Rotation3<float>&, bool);
template Result<HeadAngles<double>> head_angles(const CameraHead<double>&, const Vector3<double>&, bool);
template Result<HeadAngles<float>> head_angles(const CameraHead<float>&, const Vector3<float>&, bool);

}  // namespace inbetween
