// The moves that frame tables are measured with, here and beside other libraries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "host_tools/plan/ode_frame_table.hpp"
#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// A move of the size that the benchmark's name says, with all memory that any solver needs.
class Subject {
 public:
  Subject(std::size_t keys, std::size_t control_values, std::size_t axes, std::int32_t frames)
      : axes_(axes), frames_(frames) {
    std::mt19937 random(1989);
    std::uniform_real_distribution<double> coordinate(0.0, 100.0);
    std::uniform_real_distribution<double> height(1.0, 20.0);
    keys_.resize(keys * axes);
    for (double& value : keys_) value = coordinate(random);
    control_values_.resize(control_values);
    for (double& value : control_values_) value = height(random);
    cubics_.resize((keys + 1) * axes);
    weights_.resize(axes);
    pieces_.resize(96 * keys);  // a plane curve is often near a cusp
    begins_.resize(pieces_.size());
    buckets_.resize(2 * pieces_.size());
    first_pieces_.resize(keys + 1);
    segment_begins_.resize(keys + 1);
    spans_.resize(control_values);
    integrals_.resize(control_values + 1);
    span_distances_.resize(control_values + 1);
    points_.resize(static_cast<std::size_t>(frames) + 1);
  }

  [[nodiscard]] Track make_track() {
    const Path path =
        *Path::make({.spline = Spline::tcb, .axis_count = static_cast<std::int32_t>(axes_), .keys = keys_},
                    {cubics_, weights_});
    const ArcLength arc_length =
        *ArcLength::make(path, {}, {pieces_, begins_, buckets_, first_pieces_, segment_begins_});
    const SpeedProfile profile = *SpeedProfile::make(control_values_, {spans_, integrals_});
    return *Track::make(path, arc_length, profile, frames_, {24, 1}, {span_distances_});
  }
  [[nodiscard]] FrameTable closed_form_of(const Track& track) { return *closed_form_table(track, points_); }
  [[nodiscard]] FrameTable closed_form() { return closed_form_of(make_track()); }
  [[nodiscard]] OdeTable runge_kutta() { return *runge_kutta_table(make_track(), {}, points_); }
  [[nodiscard]] std::size_t axes() const { return axes_; }
  [[nodiscard]] std::int32_t frames() const { return frames_; }

 private:
  std::size_t axes_;
  std::int32_t frames_;
  std::vector<double> keys_, control_values_, weights_, begins_;
  std::vector<Cubic> cubics_;
  std::vector<ArcPiece> pieces_;
  std::vector<std::int32_t> buckets_, first_pieces_;
  std::vector<TwoSum> segment_begins_, integrals_;
  std::vector<SpanDistance> span_distances_;
  std::vector<SpeedSpan> spans_;
  std::vector<PathPoint> points_;
};

/// A short move as an animator makes it: 8 keys, 7 control values. A long one: 100 keys, 64.
inline Subject subject_of(std::int32_t frames, std::size_t axes = 3) {
  return frames <= 1000 ? Subject(8, 7, axes, frames) : Subject(100, 64, axes, frames);
}

}  // namespace inbetween
