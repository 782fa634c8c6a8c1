// The picture of a planned move, as `inbetween plan --plot` writes it. It takes plain data and knows nothing
// of the solver.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

struct PlotAxis {
  std::string name;
  std::string unit;               // "" when unknown
  std::vector<double> positions;  // on the frames first_frame..last_frame, axis units
  std::optional<double> minimum;  // limits, drawn when given
  std::optional<double> maximum;
  /// The positions with even steps between the frames; empty: straight from frame to frame.
  std::vector<double> line = {};
};

struct PlotTrack {
  std::vector<std::size_t> axes;          // indexes into PlotMove::axes, at least one
  std::vector<std::vector<double>> path;  // [axis of the track][sample], dense along the path
  std::vector<std::vector<double>>
      tangents;                           // [axis of the track][frame], direction of the path, of any length
  std::vector<std::vector<double>> keys;  // [axis of the track][key], at least one key
  /// Where the path passes the keys, in the same shape; empty where it meets all of them.
  std::vector<std::vector<double>> passed = {};
  std::vector<double> key_frames;      // where each key is met; one more than keys on a closed path
  std::vector<double> key_holds;       // frames that each rests from there on; empty if none rests
  std::vector<double> control_values;  // v_0..v_f over a = 0..f; empty for a track without a speed curve
  std::vector<double> curve;           // phi sampled evenly over a in [0, f]; empty with control_values
  std::string speed_unit;              // "mm/s"; "" when unknown
  std::vector<double> speed;           // N + 1, unit/s along the path
  /// The speed of a track without a curve, with even steps between the frames; empty: straight from frame to
  /// frame.
  std::vector<double> speed_line = {};
};

/// x, y and z in the world, m.
using PlotPlace = std::array<double, 3>;

/// The links of an articulated rig at a moment, each as a line from the link that holds it.
struct PlotPosture {
  double frame = 0;
  PlotPlace tip{};
  PlotPlace view{};                   // the direction in which it looks, of length 1
  std::optional<PlotPlace> aim = {};  // the point at which it is to look
  std::vector<std::pair<PlotPlace, PlotPlace>> bones;
};

/// The path of a link of the rig.
struct PlotTip {
  std::string name;
  std::vector<PlotPlace> places;      // on the frames that are played
  std::vector<PlotPosture> postures;  // where keys are met
};

struct PlotMove {
  std::string name;
  std::string frame_rate;        // as written: "24" or "24000/1001"
  double frames_per_second = 0;  // > 0
  std::int32_t frames = 0;       // N >= 1
  WholeFrames part = {};         // that are played: 0..N, or some of them
  std::int32_t first_frame = 0;  // part.first, or below it with a pre-roll
  std::int32_t last_frame = 0;   // part.last, or above it with a post-roll
  std::vector<PlotAxis> axes;
  std::vector<PlotTrack> tracks;
  std::vector<PlotTip> tips = {};
};

/// More than 3 axes are timed by frames, without a speed curve.
[[nodiscard]] bool is_puppet(const PlotMove& move);

/// Draws one page, 1400 pixels wide and as tall as the move asks for, and writes it as SVG, PNG or PDF by the
/// ending of the file's name. Per track: the path with a tick across it at every frame (Bartels and Hardtke
/// 1989, Figures 4 to 6: crowded ticks are slow, sparse ones fast), the speed curve over its control values,
/// and the time bar, a stripe per frame as wide as the distance travelled in it; then every axis over time,
/// rolls included. Of a part of a move path and speed curve are drawn whole, the rest on its frames. Per tip
/// of an articulated rig: its path in plan, elevation and perspective (plot_tips.hpp). Where frames are too
/// many for ticks or stripes to be told apart, the page shows every k-th and says so.
///
/// A track of one axis is a ruler; of three or more axes, two planes through its first three. Both axes of a
/// plane have the same scale when they have the same unit and one is not more than 12 times as long as the
/// other. Keys are numbered from 0, as in P_0..P_n.
///
/// Throws std::invalid_argument where the data contradict each other or are not finite (a mistake of the
/// caller), std::runtime_error, one line that starts with the file's name, where no picture can be written.
/// Cost: O(all samples). The size of the picture depends on its axes, keys and tracks, not on the number of
/// frames: an SVG has about 100 kB a track and 20 kB an axis, and less than 1.5 MB with three axes of pure
/// noise.
///
/// A puppet's move, more than 3 axes timed by frames (is_puppet), is another page, as high as a sheet of
/// paper that wide (A4) or less: it begins with every axis over time, shows path, speed curve and time bar
/// only of the tracks that have a speed curve, and of every tip the perspective alone.
void draw_plot(const PlotMove& move, const std::filesystem::path& file,
               PictureStyle style = PictureStyle::light);

}  // namespace inbetween
