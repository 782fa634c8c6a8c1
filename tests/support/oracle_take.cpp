#include "tests/support/oracle_take.hpp"

#include <cmath>
#include <sstream>

namespace inbetween {

std::vector<OracleRow> rows_of_record(const std::string& text) {
  std::vector<OracleRow> rows;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);  // the names
  while (std::getline(lines, line)) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == ',') {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    OracleRow row;
    row.tick = std::stol(cells[0]);
    row.state = cells[2];
    if (!cells[3].empty()) row.frame = std::stod(cells[3]);
    for (std::size_t c = 4; c + 1 < cells.size(); c += 2) {
      row.told.push_back(cells[c].empty() ? std::nullopt : std::optional(std::stod(cells[c])));
      row.actual.push_back(std::stod(cells[c + 1]));
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<OracleAnswer> answers_in(const std::vector<OracleRow>& rows) {
  std::vector<OracleAnswer> answers;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].tick == rows[i - 1].tick + 1 && rows[i - 1].frame && rows[i - 1].told[0] && rows[i].told[0]) {
      answers.push_back({i - 1, i});
    }
  }
  return answers;
}

OracleFigures figures_of_errors(const std::vector<double>& errors, const std::vector<double>& frames,
                                double first, double last) {
  OracleFigures figures;
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (frames[i] < first || frames[i] >= last) continue;
    if (figures.count == 0 || std::fabs(errors[i]) > std::fabs(figures.worst)) {
      figures.worst = errors[i];
      figures.frame = frames[i];
    }
    ++figures.count;
    sum += errors[i];
    squares += errors[i] * errors[i];
  }
  if (figures.count == 0) return figures;
  figures.mean = sum / static_cast<double>(figures.count);
  figures.rms = std::sqrt(squares / static_cast<double>(figures.count));
  return figures;
}

std::array<double, 2> accuracy_and_repeatability(const std::array<double, 3>& command,
                                                 const std::vector<std::array<double, 3>>& points) {
  const auto n = static_cast<double>(points.size());
  std::array<double, 3> bary{};
  for (std::size_t d = 0; d < 3; ++d) {
    for (const auto& point : points) bary.at(d) += point.at(d) / n;
  }
  const auto away = [&](const std::array<double, 3>& point) {
    double squares = 0;
    for (std::size_t d = 0; d < 3; ++d) squares += (point.at(d) - bary.at(d)) * (point.at(d) - bary.at(d));
    return std::sqrt(squares);
  };
  double mean = 0, deviation = 0;
  for (const auto& point : points) mean += away(point) / n;
  for (const auto& point : points) deviation += (away(point) - mean) * (away(point) - mean) / (n - 1);
  return {away(command), mean + 3 * std::sqrt(deviation)};
}

}  // namespace inbetween
