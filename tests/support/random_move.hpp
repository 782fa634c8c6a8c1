// Random moves for property tests (RapidCheck).
#pragma once

#include <rapidcheck.h>

#include <iosfwd>
#include <string>
#include <vector>

#include "tests/support/oracle_path.hpp"

namespace inbetween {

/// What a key says about time: the rig rests there for some frames, or the move is broken in two on a frame.
struct RandomKeyTime {
  int hold = 0;
  int break_frame = -1;
};

/// A move that has an answer: its path can be measured, and its speed curve is not all zero.
struct RandomMove {
  oracle::Keys keys;          ///< every number is a double; weights and parameters may be empty
  std::vector<double> speed;  ///< 1 to 20 control values in 0..100
  int frames = 1;             ///< 1 to 400
  /// Of every key; empty: none says anything.
  std::vector<RandomKeyTime> times;
  /// Somewhere in a moving segment |dP/dt| is below 1e-6 of its maximum there: a tension of exactly 1, a
  /// cusp, keys that turn back on a line. Position and speed are still as drawn; derivatives of s are not
  /// bounded.
  bool singular = false;
};

/// Every kind, open and closed, 1 to 6 axes, 2 to 12 keys, scales from 1e-3 to 1e6, offsets up to a million
/// times the scale; more rarely repeated keys, keys on one line, an axis that stands still, a tension of 1 or
/// nearly 1, weights of zero, coordinates near 1e100 or 1e-100. Shrinks towards few keys, few axes and small
/// whole numbers.
rc::Gen<RandomMove> random_move();

/// The same, without the singular ones.
rc::Gen<RandomMove> regular_move();

/// Moves whose path stands still or turns back: keys that go back the same way or are repeated, a tension of
/// 1 or nearly 1. Some rest at inner keys, some are broken in two there, some go on; they begin and end at
/// rest, or with no speed alone.
rc::Gen<RandomMove> turning_move();

/// The move as a file that the program reads, every number in full.
std::string as_toml(const RandomMove& move);

/// How RapidCheck prints a counterexample.
void showValue(const RandomMove& move, std::ostream& out);

/// Where a property draws a move by itself: a counterexample prints this one, too.
void show(const RandomMove& move);

}  // namespace inbetween

namespace rc {

template <>
struct Arbitrary<inbetween::RandomMove> {
  static Gen<inbetween::RandomMove> arbitrary() { return inbetween::random_move(); }
};

}  // namespace rc
