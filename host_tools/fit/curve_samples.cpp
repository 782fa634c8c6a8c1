#include "host_tools/fit/curve_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

/// What differences of neighbouring control values cost, as a share of what the samples do. Only curves
/// with more control values than the samples can tell apart feel it.
constexpr double smoothing = 1e-9;

}  // namespace

CurveSamples::CurveSamples(std::span<const double> moments, std::size_t spans) : spans_(spans) {
  for (const double moment : moments) {
    places_.push_back(place_at(moment * static_cast<double>(spans), spans));
  }
}

BandProgram CurveSamples::programme(const CurveSums& sums, std::span<const double> samples,
                                    double unit) const {
  // A control value is so counted that 1 of it moves the end by about 1.
  const double area = 1 / static_cast<double>(spans_);
  const double share = 1 / static_cast<double>(samples.size());
  BandProgram program(sums.unknown_count());
  for (std::size_t m = 0; m < samples.size(); ++m) {
    const CurveSums::Terms terms = sums.at(places_[m], {.area = area});
    program.add_cost(terms, terms, share);
    program.add_gain(terms, share * samples[m] / unit);
  }
  for (std::size_t i = 0; i <= spans_; ++i) {
    CurveSums::Terms rise = sums.value(i);
    program.add_cost(rise, rise, smoothing * area);
    if (i == 0) continue;
    for (const Term& term : sums.value(i - 1)) rise.push_back({term.unknown, -term.weight});
    program.add_cost(rise, rise, smoothing);
  }
  sums.demand_ends(program);
  return program;
}

CurveSamples::Free CurveSamples::fit(std::span<const double> samples) const {
  const double unit =
      std::max(std::fabs(std::ranges::max(samples, {}, [](double s) { return std::fabs(s); })),
               std::numeric_limits<double>::min());
  const CurveSums sums(std::vector<bool>(spans_ + 1), CurveEnds::natural);
  BandProgram program = programme(sums, samples, unit);
  static_cast<void>(program.solve(std::vector<double>(sums.unknown_count())));  // nothing is in its way
  const double area = unit / static_cast<double>(spans_);
  Free found{.offset = area * program.value(sums.at({}, {.area = 1})), .values = {}};
  for (std::size_t i = 0; i <= spans_; ++i) found.values.push_back(area * program.value(sums.value(i)));
  return found;
}

std::optional<std::vector<double>> CurveSamples::fit(std::span<const double> samples,
                                                     const CurveBounds& bounds) const {
  std::vector<bool> rests(spans_ + 1);
  for (std::size_t i = 0; i < rests.size(); ++i) {
    rests[i] = (bounds.rests_at_start && i < 2) || (bounds.rests_at_end && i + 2 >= rests.size());
  }
  const CurveSums sums(rests, CurveEnds::natural);
  BandProgram program = programme(sums, samples, bounds.total);
  sums.demand_start(program);
  const double area = 1 / static_cast<double>(spans_);
  program.demand(sums.at(place_at(static_cast<double>(spans_), spans_), {.area = area}), 1);
  for (std::size_t i = 0; i <= spans_; ++i) {
    if (!rests[i]) program.demand_at_least(sums.value(i), 0);
  }
  if (!program.solve(std::vector<double>(sums.unknown_count()))) return std::nullopt;
  std::vector<double> values;
  for (std::size_t i = 0; i <= spans_; ++i) {
    values.push_back(std::max(bounds.total * area * program.value(sums.value(i)), 0.0));
  }
  return values;
}

double information(double square, std::size_t samples, std::size_t parameters) {
  const auto n = static_cast<double>(samples);
  return n * std::log(square) + static_cast<double>(parameters) * std::log(n);
}

}  // namespace inbetween
