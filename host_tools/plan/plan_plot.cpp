#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/plan/axes_in_space.hpp"
#include "host_tools/plan/key_frames.hpp"
#include "host_tools/plan/link_rows.hpp"
#include "host_tools/plan/passed_keys.hpp"
#include "host_tools/plan/plan_output.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "host_tools/plan/space_track.hpp"
#include "inbetween/base/bisection.hpp"

namespace inbetween {
namespace {

/// A cubic through so many points looks smooth across a whole picture.
constexpr std::size_t samples_per_segment = 64;
/// As a segment; a span of a speed curve is narrower.
constexpr std::size_t samples_per_span = 32;
/// An axis over time has about so many samples, and looks smooth; a frame has at least one.
constexpr int smooth_samples = 1200;
/// A move of few frames has no more than this: it looks smooth with them.
constexpr int max_samples_per_frame = 32;

void sample_path(const Track& track, PlotTrack& plot) {
  const Path& path = track.path();
  const auto axes = static_cast<std::size_t>(path.axis_count());
  plot.path.resize(axes);
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    for (std::size_t sample = 0; sample < samples_per_segment; ++sample) {
      const double t = static_cast<double>(sample) / samples_per_segment;
      for (std::size_t d = 0; d < axes; ++d) plot.path[d].push_back(path.segment(i)[d].value(t));
    }
  }
  for (std::size_t d = 0; d < axes; ++d) plot.path[d].push_back(path.segment(path.segment_count())[d].c0);
}

void sample_curve(const SpeedProfile& profile, PlotTrack& plot) {
  const std::size_t count = samples_per_span * static_cast<std::size_t>(profile.span_count());
  for (std::size_t i = 0; i <= count; ++i) {
    plot.curve.push_back(profile.value(static_cast<double>(i) / samples_per_span));
  }
}

/// How many samples between two frames look smooth where so many frames are shown.
int samples_per_frame(std::int32_t frames) {
  return std::clamp(smooth_samples / frames, 1, max_samples_per_frame);
}

void sample_speed(const Track& track, PlotTrack& plot) {
  const int samples = samples_per_frame(track.frames());
  for (std::int32_t frame = 0; frame < track.frames(); ++frame) {
    for (int i = 0; i < samples; ++i) {
      plot.speed_line.push_back(track.along({frame, static_cast<double>(i) / samples}).speed);
    }
  }
  plot.speed_line.push_back(track.along({track.frames(), 0}).speed);
}

void take_holds(const KeyTiming& timing, PlotTrack& plot) {
  plot.key_holds.assign(plot.key_frames.size(), 0);
  for (const KeyLock& lock : timing.locks) {
    if (lock.key < 0) continue;  // a turn of the path, which is no key
    plot.key_holds[static_cast<std::size_t>(lock.key)] = lock.hold;
  }
}

/// The data of a track, without the indexes of its axes in the plot.
PlotTrack plot_of_track(const Plan& plan, std::size_t index) {
  const MoveTrack& written = plan.move().tracks[index];
  const SolvedTrack& solved = plan.tracks()[index];
  const Track& track = solved.track();
  const auto axes = static_cast<std::size_t>(track.path().axis_count());
  PlotTrack plot;
  sample_path(track, plot);
  if (track.has_profile()) {
    sample_curve(track.profile(), plot);
    plot.control_values = solved.control_values();
  } else {
    sample_speed(track, plot);
  }
  plot.tangents.resize(axes);
  for (std::int32_t frame = 0; frame <= track.frames(); ++frame) {
    const PathPoint& point = solved.table().point(frame);
    const auto cubics = track.path().segment(point.segment);
    for (std::size_t d = 0; d < axes; ++d) plot.tangents[d].push_back(cubics[d].derivative(point.t));
    plot.speed.push_back(frame_row(track, solved.table(), frame).speed);
  }
  plot.keys.resize(axes);
  for (std::int32_t i = 0; i <= track.path().segment_count(); ++i) {
    if (!track.path().key_at(i)) continue;
    if (plot.keys.front().size() == written.keys.size()) continue;  // the return to key 0
    for (std::size_t d = 0; d < axes; ++d) plot.keys[d].push_back(track.path().segment(i)[d].c0);
  }
  if (!passed_keys(plan, index).empty()) {
    plot.passed = plot.keys;
    for (std::size_t k = 0; k < written.keys.size(); ++k) {
      for (std::size_t d = 0; d < axes; ++d) plot.keys[d][k] = written.keys[k].at[d];
    }
  }
  plot.key_frames = key_frames_of(plan, index);
  if (solved.key_timing()) take_holds(*solved.key_timing(), plot);
  const std::string unit = plan.length_unit(index);
  plot.speed_unit = unit.empty() ? "" : unit + "/s";
  return plot;
}

PlotPlace place_in_plot(const Vector3& position) {
  return {position.x, position.y, position.z};
}

/// The frames at which keys of any track are met.
std::set<double> frames_of_keys(const PlotMove& plot) {
  std::set<double> frames;
  for (const PlotTrack& track : plot.tracks) frames.insert(track.key_frames.begin(), track.key_frames.end());
  return frames;
}

/// The point at which a tip is to look on a frame: that of a key of its track which is met then, or the link.
std::optional<PlotPlace> aim_at(const Plan& plan, const PlotMove& plot, const Tip& tip, double frame,
                                const std::vector<Pose>& poses) {
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const MoveTrack& track = plan.move().tracks[t];
    const bool has_direction = track.space && !is_row_of_points(track);
    if (!has_direction || track.space->tips.front() != tip.name) continue;
    if (track.space->aim_node) {
      const std::int32_t link = link_of(*track.space, *plan.kinematics());
      return place_in_plot(poses[static_cast<std::size_t>(link)].position);
    }
    const SpaceRows rows(*track.space);
    const std::vector<double>& met = plot.tracks[t].key_frames;
    const auto at = std::ranges::find(met, frame);
    if (rows.aim.empty() || at == met.end()) return std::nullopt;
    const auto key = static_cast<std::size_t>(at - met.begin()) % track.keys.size();
    const std::vector<double> row = space_row(*track.space, track.keys[key]);
    return PlotPlace{row[rows.aim[0]], row[rows.aim[1]], row[rows.aim[2]]};
  }
  return std::nullopt;
}

PlotPosture posture_at(const Plan& plan, const PlotMove& plot, const Tip& tip, double frame) {
  const auto whole = static_cast<std::int32_t>(frame);
  const std::vector<Pose> poses = link_poses(plan, {whole, frame - whole});
  const Pose& pose = poses[static_cast<std::size_t>(tip.link)];
  PlotPosture posture{.frame = frame,
                      .tip = place_in_plot(pose.position),
                      .view = place_in_plot(pose.rotation.x),
                      .aim = aim_at(plan, plot, tip, frame, poses),
                      .bones = {}};
  const auto joints = plan.kinematics()->tree().joints();
  // Along the branch of the tip: axes of other branches may be in no track.
  for (std::int32_t link = tip.link; joints[static_cast<std::size_t>(link)].parent >= 0;) {
    const std::int32_t parent = joints[static_cast<std::size_t>(link)].parent;
    const auto& from = poses[static_cast<std::size_t>(parent)].position;
    const auto& to = poses[static_cast<std::size_t>(link)].position;
    if (from != to) posture.bones.emplace_back(place_in_plot(from), place_in_plot(to));
    link = parent;
  }
  return posture;
}

void sample_tips(const Plan& plan, PlotMove& plot) {
  if (plan.tips().empty()) return;
  LinkRows links(plan, PlanRows::frame);
  for (const Tip& tip : plan.tips()) {
    PlotTip drawn{.name = tip.name, .places = {}, .postures = {}};
    for (std::int32_t frame = plan.part().first; frame <= plan.part().last; ++frame) {
      drawn.places.push_back(
          place_in_plot(links.at(frame)[static_cast<std::size_t>(tip.link)].pose.position));
    }
    for (const double frame : frames_of_keys(plot)) {
      if (frame < plan.part().first || frame > plan.part().last) continue;
      drawn.postures.push_back(posture_at(plan, plot, tip, frame));
    }
    plot.tips.push_back(std::move(drawn));
  }
}

}  // namespace

PlotMove plot_of(const Plan& plan) {
  PlotMove plot;
  plot.name = plan.move().name;
  plot.frame_rate = plan.move().fps.as_written;
  plot.frames_per_second = plan.move().fps.rate.frames_per_second();
  plot.frames = plan.move().frames;
  plot.part = plan.part();
  plot.first_frame = plan.played().first_frame();
  plot.last_frame = plan.played().last_frame();
  const int samples = samples_per_frame(plot.last_frame - plot.first_frame);
  std::vector<std::vector<std::size_t>> axes_of_tracks;
  for (const MoveTrack& track : plan.move().tracks) axes_of_tracks.emplace_back(track.axes.size());
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    if (!axis.track) continue;
    axes_of_tracks[*axis.track][axis.track_axis] = plot.axes.size();
    PlotAxis drawn{.name = axis.name, .unit = unit_of(axis), .positions = {}, .minimum = {}, .maximum = {}};
    const AxisColumn column(plan, axis, PlanRows::frame);
    for (std::int64_t frame = column.line().first(); frame <= column.line().last(); ++frame) {
      const FrameTime when = column.line().at(frame);
      for (int i = 0; i < (frame < column.line().last() ? samples : 1); ++i) {
        drawn.line.push_back(column.position({when.frame, static_cast<double>(i) / samples}));
        if (i == 0) drawn.positions.push_back(drawn.line.back());
      }
    }
    if (plan.rig()) {
      drawn.minimum = plan.rig()->axes[a].min;
      drawn.maximum = plan.rig()->axes[a].max;
    }
    plot.axes.push_back(std::move(drawn));
  }
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    plot.tracks.push_back(plot_of_track(plan, t));
    plot.tracks.back().axes = std::move(axes_of_tracks[t]);
  }
  sample_tips(plan, plot);
  return plot;
}

}  // namespace inbetween
