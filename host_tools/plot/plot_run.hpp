// The picture of a run: where every axis was told to be, and where it was, as `inbetween run --plot` writes
// it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

/// An axis of a run over its seconds; x ascends, and the values are finite.
struct RunPlotAxis {
  std::string name;
  std::string unit;
  std::vector<Point> commanded = {};  // none where it was told nothing
  std::vector<Point> actual = {};
  std::vector<Point> following_error = {};  // of it, none where it was told nothing
};

/// What the picture calls what it shows.
struct RunPlotWords {
  std::string error = "following error";
  std::string heading = "Positions over seconds";
  std::string legend = "dashed: commanded; line: actual";
  std::string description = "positions as commanded and as they were";
};

struct RunPlot {
  std::string name;
  std::string summary;
  std::vector<RunPlotAxis> axes;
  RunPlotWords words = {};
};

/// Draws one page, 1400 pixels wide, and writes it as SVG, PNG or PDF by the ending of the file's name: for
/// each axis its positions, dashed as commanded and whole as they were, and below them its following error.
///
/// Throws std::runtime_error, one line that starts with the file's name, where no picture can be written.
void draw_run_plot(const RunPlot& plot, const std::filesystem::path& file,
                   PictureStyle style = PictureStyle::light);

}  // namespace inbetween
