// The picture of many takes: what wear and drift look like, as `inbetween takes plot --trend` writes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"

namespace inbetween {

/// A quantity of an axis, a value for each take; nothing where a take has none. Values are finite.
struct TrendPlotRow {
  std::string quantity;  ///< "following error, peak"
  std::string unit;
  std::vector<std::optional<double>> values;
};

struct TrendPlotAxis {
  std::string name;
  std::vector<TrendPlotRow> rows;  ///< of every axis as many
};

struct TrendPlot {
  std::string name;
  std::string summary;
  std::vector<std::int64_t> takes;  ///< their numbers, in the order in which they are drawn
  std::vector<TrendPlotAxis> axes;
};

/// Draws one page, 1400 pixels wide, and writes it as SVG, PNG or PDF by the ending of the file's name: a
/// line of panels for each axis, one for each quantity, with a point for each take from the left to the right
/// at even distances. Lines join the takes that have a value, and end where one has none.
///
/// Throws std::runtime_error, one line that starts with the file's name, where no picture can be written;
/// std::invalid_argument where the data contradict each other (a mistake of the caller).
void draw_trend_plot(const TrendPlot& plot, const std::filesystem::path& file,
                     PictureStyle style = PictureStyle::light);

}  // namespace inbetween
