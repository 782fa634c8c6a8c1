// How far, how fast and how hard a move goes on every axis: a dense search of the exact motion, by which a
// certificate of limits is judged. It shares no line and no method with the product.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/oracle_spline.hpp"

namespace inbetween::oracle {

/// The largest (of `lowest`: the smallest) value found, and where.
struct Extreme {
  long double value = 0;
  long double place = 0;
};

/// The largest value of a function on [from, to]: `samples` + 1 points evenly spaced, ends included, and
/// every one that might lie beside a larger maximum refined by golden section. Never above the true supremum,
/// rounding apart; below it only where a peak is narrower than the spacing, otherwise by less than 1e-12 of
/// what the function changes between samples. Throws std::invalid_argument unless samples >= 1 and
/// from <= to, std::domain_error where the function is not a number. An infinite value is a value.
Extreme peak_of(const std::function<long double(long double)>& function, long double from, long double to,
                int samples);

/// One axis at one moment: axis units and seconds.
struct AxisState {
  long double position = 0;
  long double velocity = 0;
  long double acceleration = 0;
  long double jerk = 0;
};

/// One axis over the whole move. The place of each extreme is a frame, which need not be a whole one.
struct AxisExtremes {
  Extreme lowest, highest;               ///< position
  Extreme velocity, acceleration, jerk;  ///< of the magnitude, >= 0
};

/// What jumps at a key: magnitudes of the differences between the two sides.
struct Step {
  int key = 0;
  long double frame = 0;
  int axis = 0;
  long double velocity = 0;
  long double acceleration = 0;
};

struct Extremes {
  std::vector<AxisExtremes> axes;
  /// Of every key and axis, zeros too, by key and then by axis. Key 0 and the last are held against rest
  /// outside the move; on a closed path the arrival is listed as key n, which is key 0 again. Keys in one
  /// place share their frame and their step.
  std::vector<Step> steps;
};

/// One-sided limits, where a function steps.
enum class Side { before, after };

/// How near to a standstill in t nothing is sampled.
inline constexpr long double standstill_reach = 1e-9L;

/// What becomes of the maxima between samples.
enum class Between { skipped, climbed };

/// The motion that solves ds/da = K phi(a) / |diag(w) dP/ds| exactly. Not for moves with locked keys, holds
/// or timing by frames.
class IdealMotion {
 public:
  /// Throws as Path and Profile do, and as frame_table().
  IdealMotion(const Keys& keys, Profile profile, int frames, long double frames_per_second);

  const Path& path() const { return path_; }
  const Profile& profile() const { return profile_; }
  int frames() const { return frames_; }

  /// Every axis at a frame in [0, frames], elsewhere std::out_of_range. On a key (within 1e-15 of the length)
  /// or a knot of phi the side decides; frame 0 has no side but after, frame N none but before, both inside
  /// the move. Where the path stands still while the move does not (a cusp), velocity and what follows are
  /// not defined: std::domain_error.
  std::vector<AxisState> at(long double frame, Side side = Side::after) const;
  /// The same at a key 0..path().segments(); before the first and after the last, at rest.
  std::vector<AxisState> at_key(int key, Side side) const;
  /// The frame on which the move reaches a key 0..path().segments(). Where it dwells, the first; with phi = 0
  /// there it is no sharper than the fourth root of the precision.
  long double key_frame(int key) const;

  /// The extremes of the open stretches between keys and knots of phi, and of their one-sided limits. Each
  /// stretch is sampled evenly in t and evenly in a, `samples` points to a whole segment and as many to a
  /// whole span, at least 16 to a stretch; where |diag(w) dP/dt| has a minimum the samples gather so that a
  /// near-cusp of any width is resolved; maxima are refined as by peak_of().
  ///
  /// Where |diag(w) dP/dt| falls below 1e-12 of its largest in the segment, the path stands still. Inside a
  /// segment, while phi > 0, the direction jumps or turns there without bound: acceleration and jerk are
  /// infinite on every axis that moves at that place. At an end of a segment (a tension of 1), and where
  /// phi = 0, they are infinite where they grow by half or more with each of four tenfold approaches, down to
  /// 1e-7 of the segment; a divergence slower than that, as of a logarithm, is not seen. Within 1e-9 of such
  /// a place nothing is sampled, and its steps are taken at that distance.
  ///
  /// Time: 2 to 3 us a sample for two axes.
  Extremes extremes(int samples) const { return extremes_between(0, frames_, samples); }
  /// The same of the motion from one frame to a later one, as if there were no other. The steps are all.
  Extremes extremes_between(int first, int last, int samples) const;

 private:
  /// A time in which the motion is one smooth function: one segment, one span.
  struct Stretch {
    int segment = 0;
    int span = 0;
    long double from_u = 0, to_u = 0;  ///< a - span
    long double from_t = 0, to_t = 0;
  };
  /// phi on one span: powers of u.
  struct SpanCubic {
    long double c0 = 0, c1 = 0, c2 = 0, c3 = 0;
    long double value(long double u) const { return c0 + u * (c1 + u * (c2 + u * c3)); }
    long double derivative(long double u) const { return c1 + u * (2 * c2 + u * 3 * c3); }
    long double second_derivative(long double u) const { return 2 * c2 + 6 * u * c3; }
    long double integral(long double u) const { return u * (c0 + u * (c1 / 2 + u * (c2 / 3 + u * c3 / 4))); }
    /// The u in [low, high] up to which the integral is `wanted`, the nearer end where there is none.
    long double inverse(long double wanted, long double low, long double high, long double guess) const;
  };
  struct Segment {
    std::vector<Cubic> axis;
    long double largest_speed = 0;
  };
  class Cursor;

  const SpanCubic& span_cubic(int span) const { return spans_[static_cast<std::size_t>(span)]; }
  const Segment& segment(int i) const { return segments_[static_cast<std::size_t>(i)]; }
  long double alpha_at(long double distance) const;
  long double frame_of(int span, long double u) const;
  long double speed(int segment, long double t) const;
  long double half_slope_of_squared_speed(int segment, long double t) const;
  bool stands_still(int segment, long double t) const;
  long double length(int segment, long double from, long double to) const;
  std::vector<long double> slowest_places(const Stretch& stretch) const;
  std::vector<std::vector<long double>> sweeps_by_t(const Stretch& stretch,
                                                    const std::vector<long double>& slowest,
                                                    int samples) const;
  std::vector<Stretch> stretches(int first, int last) const;
  /// False where the path stands still at t and the move does not.
  bool evaluate(int segment, long double t, int span, long double u, std::vector<AxisState>& axes) const;
  std::vector<AxisState> beside_key(int key, Side side, int span, long double u) const;
  std::vector<AxisState> required(int segment, long double t, int span, long double u) const;
  void search(const Stretch& stretch, int samples, Between between, std::vector<Extreme>& best) const;
  void search_standstill(const Stretch& stretch, long double place, std::vector<Extreme>& best) const;

  Path path_;
  Profile profile_;
  std::vector<long double> weights_;
  int frames_ = 1;
  long double spans_per_second_ = 0;
  long double k_ = 0;
  std::vector<Segment> segments_;
  std::vector<long double> distance_;  ///< of every key
  std::vector<SpanCubic> spans_;
};

}  // namespace inbetween::oracle
