#include "host_tools/check/check_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "host_tools/check/checked_peaks.hpp"
#include "host_tools/plan/passed_keys.hpp"
#include "host_tools/plan/plan_output.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/frame_range.hpp"

namespace inbetween {
namespace {

/// The table for people ends after this many steps; the JSON has all of them.
constexpr std::size_t max_steps_shown = 20;

// --- table

/// The table and how wide its first column is.
struct Table {
  std::FILE* out;
  std::size_t names = 0;
};

Table table_of(const CheckReport& report, std::FILE* out) {
  Table table{out, 14};
  for (const CheckedAxis& axis : report.axes) table.names = std::max(table.names, axis.name.size());
  return table;
}

void print_row(const Table& table, std::string_view axis, std::string_view quantity, const std::string& peak,
               const std::string& frame, const std::string& limit, const std::string& share) {
  std::string line = fmt::format("  {:<{}}  {:<14}{:>24}{:>12}{:>20}{:>10}", axis, table.names, quantity,
                                 peak, frame, limit, share);
  line.erase(line.find_last_not_of(' ') + 1);
  fmt::print(table.out, "{}\n", line);
}

void print_range(const CheckedAxis& axis, const Table& table) {
  if (!axis.range) {
    print_row(table, axis.name, "in no track: it stays where it is", "", "", "", "");
    return;
  }
  const auto print_end = [&](std::string_view name, std::string_view quantity, const Peak& end,
                             double limit) {
    const bool outside = end.value < axis.limit_min || end.value > axis.limit_max;
    print_row(table, name, quantity, fmt::format("{:.6g} {}", end.value, axis.unit),
              fmt::format("{:.2f}", end.frame), fmt::format("{:g} {}", limit, axis.unit),
              outside ? "outside" : "");
  };
  print_end(axis.name, "lowest", axis.range->lowest, axis.limit_min);
  print_end("", "highest", axis.range->highest, axis.limit_max);
}

std::string share_of(const CheckedPeak& peak) {
  if (!peak.limit) return "";
  if (!std::isfinite(peak.value)) return "exceeded";
  // The share is rounded up, so that a value just above its limit does not read as 100 %.
  const double percent = 100 * peak.share();
  return fmt::format("{:.0f} %", peak.is_exceeded() ? std::max(101.0, std::ceil(percent)) : percent);
}

template <class Axis>
void print_peaks(const Axis& axis, const Table& table) {
  for (const auto& [name, per, peak] : peaks_of(axis)) {
    const std::string value = std::isfinite(peak.value)
                                  ? fmt::format("{:.6g} {}{}", peak.value, axis.unit, per)
                                  : std::string("no bound");
    print_row(table, "", name, value, fmt::format("{:.2f}", peak.frame),
              peak.limit ? fmt::format("{:g} {}{}", *peak.limit, axis.unit, per) : "none", share_of(peak));
  }
}

void print_axis(const CheckedAxis& axis, const Table& table) {
  print_range(axis, table);
  if (axis.range) print_peaks(axis, table);
}

void print_motor(const CheckReport& report, const CheckedMotor& motor, const Table& table) {
  print_row(table, report.axes[motor.axis].name, "of its motor", "", "", "", "");
  print_peaks(motor, table);
}

void print_steps(const CheckReport& report, const Table& table) {
  std::FILE* out = table.out;
  if (report.steps.empty()) {
    fmt::print(out, "  no step of velocity or acceleration, neither at a key nor at an end\n");
    return;
  }
  fmt::print(out, "  steps:\n");
  fmt::print(out, "  {:<{}}  {:>6}{:>12}{:>24}{:>24}\n", "axis", table.names, "key", "frame", "velocity",
             "acceleration");
  for (std::size_t i = 0; i < std::min(report.steps.size(), max_steps_shown); ++i) {
    const CheckedStep& step = report.steps[i];
    const CheckedAxis& axis = report.axes[step.axis];
    const auto amount = [&](double size, const char* per) {
      return size > 0 ? fmt::format("{:.6g} {}{}", size, axis.unit, per) : std::string("-");
    };
    const std::string key = step.key ? fmt::format("{}", *step.key) : "-";
    fmt::print(out, "  {:<{}}  {:>6}{:>12.2f}{:>24}{:>24}\n", axis.name, table.names, key, step.frame,
               amount(step.velocity, "/s"), amount(step.acceleration, "/s^2"));
  }
  if (report.steps.size() > max_steps_shown) {
    fmt::print(out, "  and {} more, which --json lists\n", report.steps.size() - max_steps_shown);
  }
}

void print_stops(const CheckReport& report, std::FILE* out) {
  if (!report.stops) return;
  const LongestStop& longest = report.stops->longest;
  if (!std::isfinite(report.highest_rate)) return;  // nothing moves
  double share = 0;
  for (const CheckedStopAxis& axis : report.stops->axes) {
    share = std::max({share, axis.acceleration.share(), axis.jerk.share()});
  }
  fmt::print(
      out,
      "  a controlled stop takes {:.2f} s and {:.1f} frames at most (from frame {:.2f}, {}), and at most "
      "{:.0f} % of a stop limit\n",
      longest.length.seconds, longest.length.frames, longest.from_frame,
      longest.forward ? "forward" : "backward", std::ceil(100 * share));
  if (report.highest_rate > 0) {
    fmt::print(out, "  every limit holds up to {:.3g} times the drawn speed\n",
               std::floor(1000 * report.highest_rate) / 1000);
  }
}

void print_verdict(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest,
                   std::FILE* out) {
  const std::int32_t frames = plan.move().frames;
  if (!plan.is_whole()) {
    fmt::print(out, "{} in {}\n", report.fits() ? "fits" : "does not fit",
               frames_in_words(plan.part(), frames));
    return;
  }
  const std::int32_t known = report.fits() ? frames : max_frames;
  const bool is_fewer = smallest.with_other_curve &&
                        *smallest.with_other_curve < std::min(known, smallest.frames.value_or(known));
  const std::string other =
      is_fewer ? fmt::format("{} with another speed curve{}", counted(*smallest.with_other_curve, "frame"),
                             smallest.may_be_refined ? "" : " of as many control values")
               : "";
  if (report.fits()) {
    fmt::print(out, "fits in {}", counted(frames, "frame"));
    const bool would_do = smallest.frames && *smallest.frames < frames;
    if (would_do) fmt::print(out, "; {} would do", counted(*smallest.frames, "frame"));
    fmt::print(out, "{}{}{}\n", other.empty() ? "" : (would_do ? ", " : "; "), other,
               would_do || is_fewer ? in_proportion(plan.move()) : "");
    return;
  }
  fmt::print(out, "does not fit in {}; ", counted(frames, "frame"));
  if (smallest.frames) {
    fmt::print(out, "{} would do{}{}{}\n", counted(*smallest.frames, "frame"), other.empty() ? "" : ", ",
               other, in_proportion(plan.move()));
  } else {
    fmt::print(out, "{}{}{}{}{}\n",
               smallest.was_ended ? "" : "no number of frames would do: ", smallest.reason,
               other.empty() ? "" : "; ", other, other.empty() ? "" : in_proportion(plan.move()));
  }
}

// --- JSON

void write_peak(JsonWriter& json, const char* name, const CheckedPeak& peak) {
  json.line();
  json.object(name, [&] {
    json.member("peak", peak.value);
    json.member("frame", peak.frame);
    json.member("limit", peak.limit);
  });
}

void write_axis(JsonWriter& json, const CheckedAxis& axis) {
  json.member("name", axis.name);
  json.object("position", [&] {
    json.member("min", axis.range ? std::optional(axis.range->lowest.value) : std::nullopt);
    json.member("max", axis.range ? std::optional(axis.range->highest.value) : std::nullopt);
    json.member("limit_min", axis.limit_min);
    json.member("limit_max", axis.limit_max);
  });
  for (const auto& [name, per, peak] : peaks_of(axis)) write_peak(json, name, peak);
}

/// Stops stay on the path, so that their positions are those of the motion.
void write_stops(JsonWriter& json, const CheckReport& report) {
  json.line();
  if (!report.stops) return json.member("stop", std::optional<double>());
  const LongestStop& longest = report.stops->longest;
  json.object("stop", [&] {
    json.member("longest_s", longest.length.seconds);
    json.member("longest_frames", longest.length.frames);
    json.member("from_frame", longest.from_frame);
    json.member("forward", longest.forward);
    std::vector<CheckedAxis> stopped = report.axes;
    for (std::size_t a = 0; a < stopped.size(); ++a) {
      stopped[a].velocity = report.stops->axes[a].velocity;
      stopped[a].acceleration = report.stops->axes[a].acceleration;
      stopped[a].jerk = report.stops->axes[a].jerk;
    }
    json.objects("axes", stopped, [&](const CheckedAxis& axis) { write_axis(json, axis); });
  });
}

void write_smallest(JsonWriter& json, const SmallestFrames& smallest) {
  json.member("smallest_frames", smallest.frames);
  json.member("smallest_frames_other_curve", smallest.with_other_curve);
  json.member("reason", smallest.frames ? std::nullopt : std::optional(smallest.reason));
}

}  // namespace

void print_check(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest,
                 std::FILE* out) {
  const MoveFile& move = plan.move();
  fmt::print(out, "{} on {}: {} at {} fps, {:.3f} s\n", move.name, plan.rig()->name,
             frames_in_words(plan.part(), move.frames), move.fps.as_written, plan.duration_s());
  print_rolls(plan, out);
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    print_followed(plan, t, "  ", out);
    print_passed(plan, t, "  ", out);
  }
  const Table table = table_of(report, out);
  print_row(table, "axis", "quantity", "peak", "frame", "limit", "share");
  for (const CheckedAxis& axis : report.axes) print_axis(axis, table);
  for (const CheckedMotor& motor : report.motors) print_motor(report, motor, table);
  print_steps(report, table);
  if (report.speed_error > 0) {
    fmt::print(out, "  the drives follow this motion within {:g} of its speed\n", report.speed_error);
  }
  print_stops(report, out);
  print_verdict(plan, report, smallest, out);
}

void write_check(JsonWriter& json, const Plan& plan, const CheckReport& report,
                 const SmallestFrames& smallest) {
  json.member("format", 1);
  if (plan.names_frames()) {
    json.member("first", plan.part().first);
    json.member("last", plan.part().last);
  }
  json.member("fits", report.fits());
  write_smallest(json, smallest);
  json.line();
  json.objects("axes", report.axes, [&](const CheckedAxis& axis) { write_axis(json, axis); });
  json.line();
  if (!report.motors.empty()) {
    json.objects("motors", report.motors, [&](const CheckedMotor& motor) {
      json.member("axis", report.axes[motor.axis].name);
      json.member("unit", motor.unit);
      for (const auto& [name, per, peak] : peaks_of(motor)) write_peak(json, name, peak);
    });
    json.line();
  }
  json.objects("steps", report.steps, [&](const CheckedStep& step) {
    json.member("key", step.key);
    json.member("frame", step.frame);
    json.member("axis", report.axes[step.axis].name);
    json.member("velocity_step", step.velocity);
    json.member("acceleration_step", step.acceleration);
  });
  write_stops(json, report);
  json.line();
  json.member("highest_rate", report.highest_rate);
}

}  // namespace inbetween
