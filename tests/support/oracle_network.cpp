#include "tests/support/oracle_network.hpp"

#include <iterator>
#include <map>
#include <utility>

namespace inbetween::oracle {

NetworkOracle::NetworkOracle(std::vector<NetworkAxis> row) : row_(std::move(row)) {
  for (const NetworkAxis& axis : row_) {
    through_keys_.push_back(smooth_curve(axis.keys));
    drawn_.push_back(axis.drawn ? smooth_curve(*axis.drawn) : std::vector<TimedPiece>());
  }
}

long double NetworkOracle::residual(std::size_t axis, long double frame, int order) const {
  return curve_at(drawn_[axis], frame, order) - curve_at(through_keys_[axis], frame, order);
}

long double NetworkOracle::at(std::size_t axis, long double frame, int order) const {
  if (row_[axis].drawn) return curve_at(drawn_[axis], frame, order);
  // Every place at which something is drawn has the mean of it; and the ends of the row have at least
  // nothing.
  struct Sum {
    long double of = 0;
    int count = 0;
    [[nodiscard]] long double mean() const { return count > 0 ? of / count : 0; }
  };
  std::map<long double, Sum> sums;
  for (std::size_t i = 0; i < row_.size(); ++i) {
    if (!row_[i].drawn) continue;
    Sum& sum = sums[row_[i].place];
    sum.of += residual(i, frame, order);
    ++sum.count;
  }
  sums[row_.front().place];
  sums[row_.back().place];
  const long double place = row_[axis].place;
  const auto behind = sums.lower_bound(place);
  long double added = behind->second.mean();
  if (behind->first != place) {
    const auto before = std::prev(behind);
    const long double share = (place - before->first) / (behind->first - before->first);
    added = before->second.mean() + share * (behind->second.mean() - before->second.mean());
  }
  return curve_at(through_keys_[axis], frame, order) + added;
}

}  // namespace inbetween::oracle
