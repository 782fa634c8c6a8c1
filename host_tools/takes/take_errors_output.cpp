#include "host_tools/takes/take_errors_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

std::string_view name_of(Measure::Kind kind) {
  switch (kind) {
    case Measure::Kind::axis:
      return "axis";
    case Measure::Kind::distance:
      return "distance";
    case Measure::Kind::angle:
      return "angle";
    case Measure::Kind::picture:
      return "picture";
  }
  return "";
}

/// "pan", "camera, distance".
std::string label_of(const Measure& measure) {
  if (measure.kind == Measure::Kind::axis) return measure.name;
  return fmt::format("{}, {}", measure.name, name_of(measure.kind));
}

template <class Measures>
std::size_t width_of_labels(const Measures& measures) {
  std::size_t width = 8;
  for (const auto& of : measures) width = std::max(width, label_of(of.measure).size());
  return width;
}

std::string number_of(double value) {
  if (std::fabs(value) < measured_least) return "0";
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : std::string("out of sight");
}

void print_figures(const ErrorFigures& figures, std::string_view unit, std::FILE* out) {
  if (figures.count() == 0) {
    fmt::print(out, "{:>14}{:>10}", "-", "-");
  } else {
    fmt::print(out, "{:>14}{:>10.2f}", number_of(figures.worst()), in_frames(figures.worst_at()));
  }
  if (!unit.empty()) fmt::print(out, "  {}\n", unit);
}

template <class Measures>
void print_measures(const Measures& measures, std::FILE* out) {
  const std::size_t width = width_of_labels(measures);
  fmt::print(out, "  {:<{}}{:>14}{:>14}{:>14}{:>10}{:>14}{:>10}\n", "", width, "mean", "rms", "at rest, max",
             "frame", "moving, max", "frame");
  for (const auto& of : measures) {
    fmt::print(out, "  {:<{}}{:>14}{:>14}", label_of(of.measure), width, number_of(of.errors.all().mean()),
               number_of(of.errors.all().rms()));
    print_figures(of.errors.at_rest(), "", out);
    print_figures(of.errors.moving(), of.measure.unit, out);
  }
}

void print_verdict(const std::optional<BudgetVerdict>& verdict, std::FILE* out) {
  if (verdict) fmt::print(out, "{}\n", verdict->sentence);
}

void write_verdict(JsonWriter& json, const std::optional<BudgetVerdict>& verdict) {
  if (!verdict) return;
  json.line();
  json.object("budget", [&] {
    json.member("holds", verdict->holds);
    json.member("name", verdict->name);
    json.member("largest", verdict->largest);
    json.member("interpolation", verdict->interpolation);
    json.member("frame", verdict->frame);
  });
}

void write_measure(JsonWriter& json, const Measure& measure) {
  json.member("kind", name_of(measure.kind));
  json.member("name", measure.name);
  json.member("unit", measure.unit);
}

void write_members(JsonWriter& json, const ErrorFigures& figures) {
  json.member("count", figures.count());
  if (figures.count() == 0) return;
  json.member("worst", figures.worst());
  json.member("worst_frame", in_frames(figures.worst_at()));
  json.member("mean", figures.mean());
  json.member("rms", figures.rms());
}

void write_measured(JsonWriter& json, const MeasuredErrors& errors) {
  json.object("all", [&] { write_members(json, errors.all()); });
  json.object("at_rest", [&] { write_members(json, errors.at_rest()); });
  json.object("moving", [&] { write_members(json, errors.moving()); });
  json.objects("frames", errors.frames(), [&](const FrameFigures& frame) {
    json.member("frame", frame.frame);
    write_members(json, frame.figures);
  });
}

}  // namespace

void print_errors(const TakeErrors& errors, const std::optional<BudgetVerdict>& verdict, std::FILE* out) {
  fmt::print(out, "take {}: actual less commanded, at {}\n", errors.number, counted(errors.samples, "tick"));
  if (errors.samples > 0) print_measures(errors.measures, out);
  print_verdict(verdict, out);
}

void write_errors(JsonWriter& json, const TakeErrors& errors, const std::optional<BudgetVerdict>& verdict) {
  json.member("format", 1);
  json.member("take", errors.number);
  json.member("ticks", errors.samples);
  json.objects("measures", errors.measures, [&](const TakeErrors::Of& of) {
    write_measure(json, of.measure);
    if (of.measure.kind == Measure::Kind::axis) json.member("held", of.is_held);
    write_measured(json, of.errors);
  });
  write_verdict(json, verdict);
}

void print_comparison(const TakeComparison& comparison, const std::optional<BudgetVerdict>& verdict,
                      std::FILE* out) {
  fmt::print(out, "{}\n", in_one_sentence(comparison));
  print_measures(comparison.measures, out);
  if (comparison.only_second > 0) {
    fmt::print(out, "  {} of take {} were not in take {} and are not compared\n",
               counted(comparison.only_second, "tick"), comparison.second, comparison.first);
  }
  for (const TakeComparison::Of& of : comparison.measures) {
    if (of.interpolation == 0) continue;
    fmt::print(out, "  {}: between ticks of take {}, whose interpolation may be off by {}\n",
               label_of(of.measure), comparison.first, in_words(of.interpolation, of.measure));
  }
  print_verdict(verdict, out);
}

void write_comparison(JsonWriter& json, const TakeComparison& comparison,
                      const std::optional<BudgetVerdict>& verdict) {
  json.member("format", 1);
  json.member("first", comparison.first);
  json.member("second", comparison.second);
  json.member("sentence", in_one_sentence(comparison));
  json.member("ticks", comparison.places);
  json.member("only_second", comparison.only_second);
  json.objects("measures", comparison.measures, [&](const TakeComparison::Of& of) {
    write_measure(json, of.measure);
    json.member("interpolation", of.interpolation);
    write_measured(json, of.errors);
  });
  write_verdict(json, verdict);
}

void print_path_report(const PathReport& report, std::FILE* out) {
  fmt::print(out, "{} takes at {} (ISO 9283, at the same times of the move)\n", report.takes.size(),
             counted(report.places, "tick"));
  const std::size_t width = width_of_labels(report.measures);
  fmt::print(out, "  {:<{}}{:>14}{:>10}{:>14}{:>10}\n", "", width, "accuracy AT", "frame", "repeat. RT",
             "frame");
  for (const PathReport::Of& of : report.measures) {
    fmt::print(out, "  {:<{}}{:>14}{:>10.2f}{:>14}{:>10.2f}  {}\n", label_of(of.measure), width,
               number_of(of.largest.accuracy), in_frames(of.accuracy_at), number_of(of.largest.repeatability),
               in_frames(of.repeatability_at), of.measure.unit);
  }
  for (const PathReport::Of& of : report.measures) {
    if (of.interpolation == 0) continue;
    fmt::print(out, "  {}: some are between ticks, and their interpolation may be off by {}\n",
               label_of(of.measure), in_words(of.interpolation, of.measure));
  }
  if (report.left_out > 0) {
    fmt::print(out, "  {} of take {} were not in all takes and are left out\n",
               counted(report.left_out, "tick"), report.takes.front());
  }
}

void write_path_report(JsonWriter& json, const PathReport& report) {
  json.member("format", 1);
  json.member("takes", report.takes);
  json.member("ticks", report.places);
  json.member("left_out", report.left_out);
  json.objects("measures", report.measures, [&](const PathReport::Of& of) {
    write_measure(json, of.measure);
    json.member("interpolation", of.interpolation);
    json.member("accuracy", of.largest.accuracy);
    json.member("accuracy_frame", in_frames(of.accuracy_at));
    json.member("repeatability", of.largest.repeatability);
    json.member("repeatability_frame", in_frames(of.repeatability_at));
    json.objects("frames", of.frames, [&](const PathFrame& frame) {
      json.member("frame", frame.frame);
      json.member("accuracy", frame.figures.accuracy);
      json.member("repeatability", frame.figures.repeatability);
    });
  });
}

void print_trends(std::span<const TakeTrend> trends, std::FILE* out) {
  fmt::print(out, "  {:>6}  {:<16}{:>24}{:>12}{:>16}{:>8}\n", "take", "axis", "following error, peak",
             "settles", "reversal error", "turns");
  for (const TakeTrend& trend : trends) {
    for (const AxisTrend& axis : trend.axes) {
      const std::string settles = axis.settle_s ? fmt::format("{:.3f} s", *axis.settle_s) : "-";
      const std::string reversal = axis.reversal_error ? number_of(*axis.reversal_error) : "-";
      fmt::print(out, "  {:>6}  {:<16}{:>24}{:>12}{:>16}{:>8}  {}\n", trend.number, axis.name,
                 number_of(axis.following_error_peak), settles, reversal, axis.turns, axis.unit);
    }
  }
}

void write_trends(JsonWriter& json, std::span<const TakeTrend> trends) {
  json.member("format", 1);
  json.objects("takes", trends, [&](const TakeTrend& trend) {
    json.member("take", trend.number);
    json.objects("axes", trend.axes, [&](const AxisTrend& axis) {
      json.member("name", axis.name);
      json.member("unit", axis.unit);
      json.member("following_error_peak", axis.following_error_peak);
      json.member("peak_frame", in_frames(axis.peak_at));
      json.member("tolerance", axis.tolerance);
      json.member("settle_s", axis.settle_s);
      json.member("turns", axis.turns);
      json.member("reversal_error", axis.reversal_error);
      if (axis.reversal_error) json.member("reversal_frame", in_frames(axis.reversal_at));
    });
  });
}

TrendPlot trend_plot(std::string name, std::span<const TakeTrend> trends) {
  TrendPlot plot{.name = std::move(name),
                 .summary = counted(static_cast<std::int64_t>(trends.size()), "take"),
                 .takes = {},
                 .axes = {}};
  for (const TakeTrend& trend : trends) plot.takes.push_back(trend.number);
  if (trends.empty()) return plot;
  for (const AxisTrend& axis : trends.back().axes) {
    std::vector<std::optional<double>> peaks, settles, reversals;
    for (const TakeTrend& trend : trends) {
      const auto same = std::ranges::find_if(trend.axes, [&](const AxisTrend& other) {
        return other.name == axis.name && other.unit == axis.unit;
      });
      const bool is_there = same != trend.axes.end();
      peaks.push_back(is_there ? std::optional(same->following_error_peak) : std::nullopt);
      settles.push_back(is_there ? same->settle_s : std::nullopt);
      reversals.push_back(is_there ? same->reversal_error : std::nullopt);
    }
    plot.axes.push_back({axis.name,
                         {{"following error, peak", axis.unit, std::move(peaks)},
                          {"time to settle", "s", std::move(settles)},
                          {"reversal error", axis.unit, std::move(reversals)}}});
  }
  return plot;
}

}  // namespace inbetween
