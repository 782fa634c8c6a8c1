#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "host_tools/check/check_output.hpp"
#include "host_tools/check/checked_peaks.hpp"

namespace inbetween {
namespace {

constexpr std::int32_t even_samples = 6000;
constexpr std::int32_t samples_near_peak = 64;

/// The frames at which a motion is sampled: evenly over the move with its rolls, and closer within a few of
/// those steps of each peak.
std::vector<double> sample_frames(const LimitsPlot& plot, const CheckedAxis& axis) {
  std::vector<double> at;
  const double first = plot.first_frame;
  const double last = plot.last_frame;
  const double even = (last - first) / even_samples;
  for (std::int32_t i = 0; i <= even_samples; ++i) at.push_back(first + i * even);
  for (const auto& [name, per, peak] : peaks_of(axis)) {
    for (std::int32_t i = -samples_near_peak; i <= samples_near_peak; ++i) {
      at.push_back(peak.frame + 2 * even * i / samples_near_peak);
    }
  }
  // A peak at an end has half of its samples outside the move.
  std::erase_if(at, [&](double frame) { return !(frame >= first && frame <= last); });
  std::ranges::sort(at);
  return at;
}

void add_rows(const Plan& plan, const CheckReport& report, std::size_t index, LimitsPlot& plot) {
  const CheckedAxis& axis = report.axes[index];
  const PlanAxis& planned = plan.axes()[index];
  std::vector<AxisMotion> motion(plan.played().axis_count());
  const auto motion_at = [&](double frame) {
    const auto whole = static_cast<std::int32_t>(std::floor(frame));
    plan.motion().motion({whole, frame - whole}, motion);
    const AxisMotion& now = motion[planned.move_axis];
    return std::array<double, 3>{now.velocity, now.acceleration, now.jerk};
  };
  // The jerk jumps at the joint with a roll, so the peak may be on one side only.
  const auto is_below = [&](double frame, std::size_t quantity) {
    double largest = 0;
    for (const double side : {frame - 1e-6, frame, frame + 1e-6}) {
      const double value = motion_at(side)[quantity];
      if (std::fabs(value) > std::fabs(largest)) largest = value;
    }
    return largest < 0;
  };
  std::array<std::vector<Point>, 3> samples;
  for (const double frame : sample_frames(plot, axis)) {
    const std::array<double, 3> values = motion_at(frame);
    for (std::size_t i = 0; i < values.size(); ++i) samples[i].push_back({frame, values[i]});
  }
  const std::array<NamedPeak, 3> peaks = peaks_of(axis);
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    const CheckedPeak& peak = peaks[i].peak;
    if (!peak.limit) continue;
    std::vector<double> steps;
    for (const CheckedStep& step : report.steps) {
      const bool is_refused =
          i == 0 ? step.velocity > 0 : i == 1 && breaks_jerk_limit(step, plan.rig()->axes[index]);
      if (step.axis == index && is_refused) steps.push_back(step.frame);
    }
    plot.rows.push_back({.axis = axis.name,
                         .quantity = peaks[i].name,
                         .unit = axis.unit + peaks[i].per,
                         .samples = std::move(samples[i]),
                         .peak = peak.value,
                         .peak_frame = peak.frame,
                         .peak_is_below = is_below(peak.frame, i),
                         .limit = peak.limit,
                         .steps = std::move(steps),
                         .exceeded = peak.is_exceeded()});
  }
}

}  // namespace

LimitsPlot limits_plot_of(const Plan& plan, const CheckReport& report) {
  LimitsPlot plot{.name = plan.move().name,
                  .frame_rate = plan.move().fps.as_written,
                  .frames_per_second = plan.move().fps.rate.frames_per_second(),
                  .frames = plan.move().frames,
                  .part = plan.part(),
                  .first_frame = plan.played().first_frame(),
                  .last_frame = plan.played().last_frame(),
                  .rows = {}};
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    if (report.axes[a].range) add_rows(plan, report, a, plot);
  }
  return plot;
}

}  // namespace inbetween
