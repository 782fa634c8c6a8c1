// Errors of a run from the text of its record (tick,seconds,state,frame, and two columns for each axis), by a
// reader of its own and plain loops.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace inbetween {

struct OracleRow {
  long tick = 0;
  std::string state;
  std::optional<double> frame;
  std::vector<std::optional<double>> told;
  std::vector<double> actual;
};

/// Names in the text have no commas.
std::vector<OracleRow> rows_of_record(const std::string& text);

/// A row, and the row before, whose setpoint it answers: indexes of rows that follow each other.
struct OracleAnswer {
  std::size_t setpoint = 0;
  std::size_t answer = 0;
};
std::vector<OracleAnswer> answers_in(const std::vector<OracleRow>& rows);

struct OracleFigures {
  long count = 0;
  double worst = 0;  ///< of the largest magnitude
  double frame = 0;
  double mean = 0;
  double rms = 0;
};
/// Of all errors on frames from `first` to before `last`.
OracleFigures figures_of_errors(const std::vector<double>& errors, const std::vector<double>& frames,
                                double first = -1e9, double last = 1e9);

/// Accuracy and repeatability of ISO 9283 of points that should be at `command`.
std::array<double, 2> accuracy_and_repeatability(const std::array<double, 3>& command,
                                                 const std::vector<std::array<double, 3>>& points);

}  // namespace inbetween
