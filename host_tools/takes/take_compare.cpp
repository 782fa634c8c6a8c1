#include "host_tools/takes/take_compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host_tools/takes/take_line.hpp"

namespace inbetween {
TakeComparison compare_takes(const TakeSamples& first, const TakeSamples& second,
                             const RigMeasures& measures) {
  measures.refuse_other_axes(first);
  measures.refuse_other_axes(second);
  const std::size_t axes = first.axes().size();
  TakeComparison comparison{.first = first.number(), .second = second.number()};
  for (const Measure& measure : measures.all()) comparison.measures.push_back({.measure = measure});
  std::vector<std::vector<double>> worst(measures.all().size());  // where the first take was then
  std::vector<double> there(axes), missed(axes), values(measures.all().size());
  const TakeLine line(first), leading(second);
  std::size_t near = 0;
  for (const std::size_t i : leading.samples()) {
    if (!line.actual_at({second[i].turn, second[i].time}, there, missed, near)) {
      ++comparison.only_second;
      continue;
    }
    ++comparison.places;
    measures.take(there, second.actual(i), values);
    for (std::size_t m = 0; m < values.size(); ++m) {
      const bool is_at_rest =
          std::ranges::all_of(measures.axes_of(m), [&](std::size_t axis) { return second.rests(i, axis); });
      const double before = std::fabs(comparison.measures[m].errors.all().worst());
      comparison.measures[m].errors.add(values[m], second[i].time, is_at_rest);
      if (worst[m].empty() || std::fabs(values[m]) > before) worst[m] = there;
    }
  }
  if (comparison.places == 0) {
    throw std::runtime_error(
        fmt::format("inbetween: error: takes {} and {} have no frame in common; compare takes of one move",
                    first.number(), second.number()));
  }
  for (std::size_t m = 0; m < worst.size(); ++m)
    comparison.measures[m].interpolation = measures.effect_of(missed, worst[m], m);
  return comparison;
}

namespace {

/// What the sentence names: the largest of each unit.
std::vector<const TakeComparison::Of*> worst_of_units(const TakeComparison& comparison) {
  const bool has_tips = std::ranges::any_of(comparison.measures, [](const TakeComparison::Of& of) {
    return of.measure.kind == Measure::Kind::distance;
  });
  std::vector<const TakeComparison::Of*> largest;
  for (const TakeComparison::Of& of : comparison.measures) {
    const Measure::Kind kind = of.measure.kind;
    if (has_tips ? kind == Measure::Kind::axis || kind == Measure::Kind::angle : kind != Measure::Kind::axis)
      continue;
    const auto same = std::ranges::find(largest, of.measure.unit,
                                        [](const TakeComparison::Of* one) { return one->measure.unit; });
    if (same == largest.end()) {
      largest.push_back(&of);
    } else if (std::fabs(of.errors.all().worst()) > std::fabs((*same)->errors.all().worst())) {
      *same = &of;
    }
  }
  return largest;
}

}  // namespace

std::string in_one_sentence(const TakeComparison& comparison) {
  const std::vector<const TakeComparison::Of*> largest = worst_of_units(comparison);
  const bool is_same = std::ranges::all_of(comparison.measures, [](const TakeComparison::Of& of) {
    return of.errors.all().worst() == 0 && of.interpolation == 0;
  });
  if (is_same)
    return fmt::format("take {} was where take {} was, to the last count", comparison.second,
                       comparison.first);
  const auto frame_of = [](const TakeComparison::Of* of) { return of->errors.all().worst_at().frame; };
  const bool is_one_frame =
      std::ranges::all_of(largest, [&](const auto* of) { return frame_of(of) == frame_of(largest.front()); });
  std::string words =
      fmt::format("take {} differs from take {} by at most", comparison.second, comparison.first);
  std::string separator = " ";
  for (const TakeComparison::Of* of : largest) {
    words += separator + in_words(of->errors.all().worst(), of->measure);
    if (!is_one_frame) words += fmt::format(" at frame {}", frame_of(of));
    separator = ", ";
  }
  return is_one_frame ? words + fmt::format(", at frame {}", frame_of(largest.front())) : words;
}

}  // namespace inbetween
