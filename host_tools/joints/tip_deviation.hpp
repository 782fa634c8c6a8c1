// How far the motion of a link is from a drawn path between the places where the two are the same: bounds
// that hold everywhere on a stretch, from a few samples and a bound on the fourth derivative.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "host_tools/joints/kinematics.hpp"
#include "inbetween/path/path.hpp"

namespace inbetween {

/// Bounds of the magnitude of a function and of its first four derivatives on a stretch.
using Jet = std::array<double, 5>;

/// Of the position of a link (m), whose coordinates have these bounds, each in its unit.
Jet position_jet(const Kinematics& kinematics, std::int32_t link, std::span<const Jet> coordinates);

/// On t from 0 to 1: axes, each a cubic in its unit, and where the link is drawn to be and to look (m).
struct TipStretch {
  std::span<const Cubic> axes;
  std::span<const std::size_t> coordinates;  // of the tree, one for each axis
  std::span<const Cubic> position;           // x, y, z; empty: nothing is drawn
  std::span<const Cubic> aim;                // x, y, z; empty: nowhere
};

/// Upper bounds on the stretch, up to the rounding of double.
struct TipDeviation {
  double off = 0;      // m
  double speed = 0;    // of the derivatives by t, m
  double slowest = 0;  // a lower bound of the drawn |dP/dt|, m
  double fastest = 0;  // an upper bound of it
  double aim = 0;      // rad
};

/// The difference e of the two is interpolated at the Chebyshev places of t, 4 of e and 3 of e': it is within
/// 1.85 (1.67) times what is found there, and |e''''| / 3072 (/ 192). The fourth derivative of the link is
/// bounded by the product rule along the branch, where a joint that turns by q(t) has the derivatives of a
/// rotation: at most the Bell polynomials of |q'|, |q''|, |q'''|.
TipDeviation tip_deviation(const Kinematics& kinematics, std::int32_t link, const TipStretch& stretch);

}  // namespace inbetween
