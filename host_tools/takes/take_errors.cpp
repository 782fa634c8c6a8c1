#include "host_tools/takes/take_errors.hpp"

#include <algorithm>

namespace inbetween {

TakeErrors errors_of(const TakeSamples& samples, const RigMeasures& measures) {
  measures.refuse_other_axes(samples);
  TakeErrors errors{.number = samples.number(), .samples = static_cast<std::int64_t>(samples.size())};
  for (const Measure& measure : measures.all()) {
    errors.measures.push_back({.measure = measure});
    const std::size_t axis = errors.measures.size() - 1;
    if (measure.kind == Measure::Kind::axis) errors.measures.back().is_held = !samples.axes()[axis].move_axis;
  }
  std::vector<double> values(errors.measures.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    measures.take(samples.commanded(i), samples.actual(i), values);
    for (std::size_t m = 0; m < values.size(); ++m) {
      const bool is_at_rest =
          std::ranges::all_of(measures.axes_of(m), [&](std::size_t axis) { return samples.rests(i, axis); });
      errors.measures[m].errors.add(values[m], samples[i].time, is_at_rest);
    }
  }
  return errors;
}

}  // namespace inbetween
