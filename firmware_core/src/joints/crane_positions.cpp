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
struct TurningHand {
  double x = 0;
  double y = 0;
};

struct TurnedHand {
  double angle = 0;
  double x = 0;
};

/// The angle at which the hand is `y` high, with x below 0 where it is `back`. Factors keep the digits of x
/// where the hand is almost upright.
Result<TurnedHand> turned_to_height(const TurningHand& hand, double y, bool back, const Error& too_far) {
  const std::array components{hand.x, hand.y};
  const double length = scaled_norm(2, [&](std::size_t i) { return components[i]; });
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
  const double x = std::sqrt((length - y) * (length + y));
  TurnedHand turned{0, back ? -x : x};
  turned.angle = angle_of(turned.x, y) - angle_of(hand.x, hand.y);
  return turned;
}

}  // namespace

Result<CranePositions> crane_positions(const CameraCrane& crane, const Vector3& head, CraneSides sides) {
  const Vector3 beside = cross(crane.column, crane.track);
  const Vector3 forward = cross(crane.column, crane.boom);
  const Vector3 reach = head - crane.foot;
  const auto boom = turned_to_height({dot(crane.raised, forward), dot(crane.raised, crane.column)},
                                     dot(reach - crane.level, crane.column), sides.leans_back,
                                     {.code = ErrorCode::no_solution,
                                      .what = "the place is higher or lower than the boom reaches",
                                      .remedy = "move it to a height that the boom reaches"});
  if (!boom) return boom.error();
  const Vector3 carried = forward * (dot(crane.level, forward) + boom->x) +
                          crane.boom * dot(crane.level + crane.raised, crane.boom);
  const auto swing =
      turned_to_height({dot(carried, crane.track), dot(carried, beside)}, dot(reach, beside), sides.is_behind,
                       {.code = ErrorCode::no_solution,
                        .what = "the place is farther from the track than the boom reaches",
                        .remedy = "move it nearer to the track"});
  if (!swing) return swing.error();
  return CranePositions{dot(reach, crane.track) - swing->x, swing->angle, boom->angle};
}

Result<HeadAngles> head_angles(const CameraHead& head, const Vector3& direction, bool over) {
  const Vector3 forward = cross(head.pan, head.tilt);
  const auto seen = [&](const Vector3& v) {
    return Vector3{dot(v, forward), -dot(v, head.tilt), dot(v, head.pan)};
  };
  const auto aimed = aim_at(seen(direction));
  if (!aimed) return aimed.error();
  const Vector3 at_zero = seen(head.roll);
  const double raised = angle_of(at_zero.x, at_zero.z);
  if (!over) return HeadAngles{aimed->pan, aimed->tilt - raised, 0};
  const auto half = static_cast<double>(half_turn);
  return HeadAngles{aimed->pan + half, half - aimed->tilt - raised, 0};
}

Result<HeadAngles> head_angles(const CameraHead& head, const Rotation3& turn, bool over) {
  auto angles = head_angles(head, turn * head.roll, over);
  if (!angles) return angles;
  const Rotation3 aimed =
      turned_about(head.pan, sine_cosine(angles->pan)) * turned_about(head.tilt, sine_cosine(angles->tilt));
  // What is left is a turn about the roll, to which the tilt is square.
  const Vector3 left = inverse(aimed) * (turn * head.tilt);
  angles->roll = angle_of(dot(left, head.tilt), dot(left, cross(head.roll, head.tilt)));
  return angles;
}

}  // namespace inbetween
