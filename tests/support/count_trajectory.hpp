// A count trajectory with exactly the memory that it asks for.
#pragma once

#include <stdexcept>
#include <vector>

#include "inbetween/trajectory/count_trajectory.hpp"

namespace inbetween {

class CountsOfTrajectory {
 public:
  CountsOfTrajectory(const Trajectory& trajectory, const std::vector<double>& counts_per_unit)
      : pieces_(value_of(CountTrajectory::piece_count(trajectory, counts_per_unit))),
        polynomials_(pieces_.size() * trajectory.axis_count()),
        counts_(value_of(CountTrajectory::make(trajectory, counts_per_unit, {pieces_, polynomials_}))) {}
  CountsOfTrajectory(const CountsOfTrajectory&) = delete;
  CountsOfTrajectory& operator=(const CountsOfTrajectory&) = delete;

  CountTrajectory& operator*() { return counts_; }
  CountTrajectory* operator->() { return &counts_; }

 private:
  template <class T>
  static T value_of(const Result<T>& result) {
    if (!result) throw std::runtime_error(result.error().what);
    return *result;
  }

  std::vector<CountTrajectoryPiece> pieces_;
  std::vector<CountPolynomial> polynomials_;
  CountTrajectory counts_;
};

}  // namespace inbetween
