#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>

#include "inbetween/base/processor_clones.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// A trajectory as the counts of drives: what a processor without double precision evaluates every tick.

namespace inbetween {

/// A stretch of time of all axes, which lasts until the next begins. The last one is the end, at rest.
struct CountTrajectoryPiece {
  FloatFrameTime begin;
  float inverse_frames = 0;  ///< 1 / length in frames; 0 for the end
};

/// One axis on one piece: base + c[0] + c[1] u + ... + c[5] u^5 counts, u from 0 to 1 over the piece. The
/// base is the position at its begin, rounded, and |c[0]| is little more than the 1/2 that the rounding left.
struct CountPolynomial {
  /// Adding this to an offset puts its whole part, rounded to nearest even, into the lowest bits of the sum:
  /// one addition instead of a comparison and a conversion. It holds for offsets up to 2^22.
  static constexpr float rounder = 12582912.0F;

  std::uint32_t rounded_base = 0;  ///< base - bits of the rounder, modulo 2^32
  std::array<float, 6> c{};

  /// By Horner's rule with fused multiply-adds: an instruction and a rounding each on every processor with a
  /// floating-point unit, and the same bits on all (IEEE 754).
  template <std::size_t First = 0>
  [[nodiscard]] INBETWEEN_PART_OF_CLONES float offset(float u) const {
    if constexpr (First + 1 == std::tuple_size_v<decltype(c)>) {
      return c[First];
    } else {
      return std::fma(offset<First + 1>(u), u, c[First]);
    }
  }
  [[nodiscard]] INBETWEEN_PART_OF_CLONES std::int32_t count(float u) const {
    return static_cast<std::int32_t>(rounded_base + std::bit_cast<std::uint32_t>(offset(u) + rounder));
  }
  [[nodiscard]] std::int32_t base() const {
    return static_cast<std::int32_t>(rounded_base + std::bit_cast<std::uint32_t>(rounder));
  }
};

/// The memory of a CountTrajectory, owned by the caller: `pieces` of them by CountTrajectory::piece_count(),
/// and a polynomial for each piece and axis.
struct CountTrajectoryMemory {
  std::span<CountTrajectoryPiece> pieces;
  std::span<CountPolynomial> polynomials;
};

/// The motion of a trajectory in integer counts. Every floating-point number in it is local to a piece, and
/// pieces are cut until a float's digits are enough: within 0.05 counts, in moves of at least 12 frames (in
/// fewer, the fraction of a frame is too coarse). It remembers the piece of the last tick. Refers to the
/// caller's memory, not to the trajectory.
class CountTrajectory {
 public:
  /// Pieces of a trajectory in counts, the end included. `counts_per_unit` has one number per axis, negative
  /// where the drive counts the other way. Errors: as of make(), but for the capacity. O(pieces * axes).
  static Result<std::size_t> piece_count(const Trajectory& trajectory,
                                         std::span<const double> counts_per_unit);
  /// Worked out in double precision. Errors: wrong_count (counts_per_unit), out_of_range (counts_per_unit
  /// that is no number other than 0; a position that does not fit 32 bits or goes too fast, with the axis),
  /// capacity.
  static Result<CountTrajectory> make(const Trajectory& trajectory, std::span<const double> counts_per_unit,
                                      const CountTrajectoryMemory& memory);

  [[nodiscard]] std::size_t axis_count() const { return axis_count_; }
  [[nodiscard]] std::span<const CountTrajectoryPiece> pieces() const { return pieces_; }

  /// The position of every axis in whole counts, rounded to nearest: the tick. `out` has axis_count()
  /// entries. Before its begin the trajectory's first position and from its end on the last one. O(axes) in
  /// the piece of the last call and the next one, otherwise O(log pieces + axes); no allocation, no library
  /// call; the same bits on every target.
  INBETWEEN_PROCESSOR_CLONES void counts(const FloatFrameTime& time, std::span<std::int32_t> out) {
    const float u = parameter(time);
    const CountPolynomial* polynomial = current_polynomials_;
    for (std::int32_t& count : out) count = (polynomial++)->count(u);
  }
  /// One axis with its part of a count, for drives that interpolate: CountPolynomial::base() and offset(u).
  struct Position {
    std::int32_t base = 0;
    float offset = 0;
  };
  [[nodiscard]] INBETWEEN_PROCESSOR_CLONES Position position(const FloatFrameTime& time, std::size_t axis) {
    const float u = parameter(time);
    return {current_polynomials_[axis].base(), current_polynomials_[axis].offset(u)};
  }

 private:
  CountTrajectory() = default;

  /// In the current piece, which is found anew where the time is not in it.
  [[nodiscard]] INBETWEEN_PART_OF_CLONES float parameter(const FloatFrameTime& time) {
    const float u = frames_between(current_->begin, time) * current_->inverse_frames;
    // Below zero is a large number here, also -0.
    if (std::bit_cast<std::uint32_t>(u) < std::bit_cast<std::uint32_t>(1.0F)) [[likely]]
      return u;
    return find(time);
  }
  float find(const FloatFrameTime& time);

  std::span<const CountTrajectoryPiece> pieces_;
  const CountPolynomial* polynomials_ = nullptr;
  const CountTrajectoryPiece* current_ = nullptr;
  const CountPolynomial* current_polynomials_ = nullptr;
  std::size_t axis_count_ = 0;
};

}  // namespace inbetween
