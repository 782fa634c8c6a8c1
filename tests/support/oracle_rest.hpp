// How fast and how hard a move goes that rests on its way, or is broken in two there: a dense search in long
// double, also where the path and the speed vanish together. It shares no line and no method with the
// product, and takes its derivatives by the parameter of the path, not by distance.
#pragma once

#include <utility>
#include <vector>

#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/oracle_spline.hpp"

namespace inbetween::oracle {

/// A key, or a place so far behind it in its segment, that is met exactly where the curve is at `alpha`: at a
/// rest, or at a break.
struct MetKey {
  int key = 0;
  long double alpha = 0;
  long double t = 0;
};

/// Of the magnitude, in axis units and seconds, and a frame near which it is found. The true value there is
/// not below `value` and nowhere that was searched above `most`: between them is rounding, of which there is
/// little but where a line nearly stands still at a speed.
struct Found {
  long double value = 0;
  long double most = 0;
  long double frame = 0;
};
struct RestPeaks {
  Found velocity, acceleration, jerk;
};

/// From one key that is met to the next distance = K Phi(a), with a K of its own for each such section: a
/// curve whose integrals meet the keys to 1e-12 alone is taken to meet them exactly.
class RestingMotion {
 public:
  /// `met` are places inside the path, in order. Throws as Path and Profile do, and std::invalid_argument
  /// where the curve stands still from one key that is met to the next.
  RestingMotion(const Keys& keys, const std::vector<double>& control_values, int frames,
                long double frames_per_second, std::vector<MetKey> met);

  /// Whether the path stands still somewhere (to 1e-12 of its speed) while the curve does not: there an axis
  /// may need an acceleration without bound, and the search stays a hundredth of the way away from it.
  bool passes_standstill() const { return passes_standstill_; }

  /// The largest values found on the open stretches between keys, knots of the curve and the places where the
  /// path is slowest. Every stretch is searched from both of its ends, in steps of 1.5 % of the distance from
  /// there, beginning with 1e-12 of it: a peak beside a rest or a near-cusp is as wide as it is far away.
  /// 1 850 samples from every end.
  std::vector<RestPeaks> peaks();

  /// The places inside segments where the path stands still, to 1e-12 of its speed: {segment, _, t}.
  std::vector<MetKey> standstills() const;
  /// Tells what is met only after the motion was made, from what it says of the path.
  void meet(std::vector<MetKey> met) { met_ = std::move(met); }

 private:
  struct Slope {
    long double a = 0, b = 0, c = 0;  ///< P' = a + b x + c x^2
  };
  /// Where the search begins: a place on the path and the moment at which it is passed, seen forward or
  /// backward in time.
  struct End {
    int segment = 0;
    long double t = 0;
    long double alpha = 0;
    int span = 0;
    long double constant = 0;
    bool forward = true;
  };
  using Phi = std::array<long double, 4>;

  void add_section(const MetKey& from, const MetKey& to);
  std::vector<long double> borders_within(int segment) const;
  long double distance_at(const MetKey& place) const;
  void search(const End& end, long double reach);
  std::vector<Slope> slopes_at(const End& end) const;
  Phi phi_at(const End& end) const;
  long double alpha_after(long double alpha, long double area, long double last) const;
  void take(const End& end, const std::vector<Slope>& slopes, const Phi& phi, long double x, long double y);

  Path path_;
  Profile profile_;
  std::vector<std::vector<Cubic>> cubics_;
  std::vector<long double> values_;  ///< control values with a phantom at either end
  std::vector<long double> weights_;
  int frames_;
  long double spans_per_second_;
  std::vector<MetKey> met_;
  std::vector<long double> distance_;  ///< of every key
  std::vector<RestPeaks> best_;
  bool passes_standstill_ = false;
};

}  // namespace inbetween::oracle
