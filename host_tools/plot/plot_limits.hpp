// The picture of a move against the limits of its rig, as `inbetween check --plot` writes it. It takes plain
// data and knows nothing of the solver.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

/// One quantity of one axis over the frames of the move.
struct LimitsRow {
  std::string axis;
  std::string quantity;        // "velocity"
  std::string unit;            // "mm/s"
  std::vector<Point> samples;  // x: frame, ascending; y: value, finite
  double peak = 0;             // largest magnitude, proven; infinity where there is no bound
  double peak_frame = 0;
  bool peak_is_below = false;   // the peak is that of a negative value
  std::optional<double> limit;  // of the magnitude, > 0
  std::vector<double> steps;    // frames at which the value steps and may not
  bool exceeded = false;        // the peak is beyond the limit
};

/// The speed curve of a track as it was drawn and as it was fitted.
struct FittedCurve {
  std::string axes;
  std::vector<Point> before, after;  // x: frame of the picture, y: phi, both ascending in x
};

struct LimitsPlot {
  std::string name;
  std::string frame_rate;        // as written
  double frames_per_second = 0;  // > 0
  std::int32_t frames = 0;       // N >= 1
  WholeFrames part = {};         // that are played: 0..N, or some of them
  std::int32_t first_frame = 0;  // part.first, or below it with a pre-roll
  std::int32_t last_frame = 0;   // part.last, or above it with a post-roll
  std::vector<LimitsRow> rows;
  std::vector<FittedCurve> curves = {};  // drawn below the rows
};

/// Draws one page, 1400 pixels wide, and writes it as SVG, PNG or PDF by the ending of the file's name: a row
/// for each quantity with its limits as dashed lines and its peak as a dot, both orange where the peak is
/// beyond the limit, and an orange line where the value steps and may not. A curve far beyond its limit is
/// cut off at the edge of the row, and the label says so.
///
/// Throws std::invalid_argument where a row has no two samples or one that is not finite (a mistake of the
/// caller), std::runtime_error, one line that starts with the file's name, where no picture can be written.
void draw_limits_plot(const LimitsPlot& plot, const std::filesystem::path& file,
                      PictureStyle style = PictureStyle::light);

}  // namespace inbetween
