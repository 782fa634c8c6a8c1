#include "host_tools/exchange/table_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

const BakedColumn& answered_column(const BakedTable& table, const std::string& name) {
  return named_column(table, name, fmt::format("there is no column {}", in_quotes(name)));
}

void answer_rate(const std::optional<FrameRate>& said, BakedTable& table) {
  if (!said) return;
  if (table.fps && !(*table.fps == *said)) {
    throw InputError({table.file},
                     fmt::format("the file has {} rows a second, and {} were given; leave one of the "
                                 "two out, or correct it",
                                 to_string(*table.fps), to_string(*said)));
  }
  if (table.about_fps && !is_about(*table.about_fps, *said)) {
    throw InputError({table.file},
                     fmt::format("the file says about {} frames a second, and {} are not; give the "
                                 "exact rate of the file",
                                 *table.about_fps, to_string(*said)));
  }
  check_seconds(table, *said);
  table.fps = *said;
}

/// Positions in place of counts, and the unit that was said.
BakedColumn answered(const BakedColumn& column, const ColumnAnswer& answer, const std::string& file) {
  BakedColumn result = column;
  result.name = answer.axis;
  if (column.unit && answer.unit && column.unit != answer.unit) {
    throw InputError({file},
                     fmt::format("{} counts in {}, and {} was given; leave one of the two out",
                                 in_quotes(column.name), to_string(*column.unit), to_string(*answer.unit)));
  }
  if (answer.unit) result.unit = answer.unit;
  if (answer.is_reversed) {
    if (column.is_in_counts) {
      throw InputError({file},
                       fmt::format("{} has counts; where they run backwards, say how far a count is with a "
                                   "minus",
                                   in_quotes(column.name)));
    }
    for (double& value : result.values) value = 0 - value;  // and 0 stays 0
  }
  if (!column.is_in_counts) {
    if (!answer.count) return result;
    throw InputError({file}, fmt::format("{} has positions and no counts; leave out what a count is",
                                         in_quotes(column.name)));
  }
  if (!answer.count || !answer.unit) return result;
  for (double& value : result.values) value = (value - answer.zero) * *answer.count;
  result.is_in_counts = false;
  result.decimals.reset();
  return result;
}

void answer_columns(const std::vector<ColumnAnswer>& answers, BakedTable& table) {
  std::vector<BakedColumn> columns;
  std::set<std::string_view> axes;
  std::set<std::string_view> taken;
  for (const ColumnAnswer& answer : answers) {
    if (!axes.insert(answer.axis).second || !taken.insert(answer.column).second) {
      throw InputError({table.file}, fmt::format("column {} or axis {} is named twice; name each once",
                                                 in_quotes(answer.column), in_quotes(answer.axis)));
    }
    columns.push_back(answered(answered_column(table, answer.column), answer, table.file));
  }
  if (columns.empty()) {
    throw InputError({table.file}, "no column was named; say which axis each column is");
  }
  for (const BakedColumn& column : table.columns) {
    if (taken.contains(column.name)) continue;
    table.warnings.push_back(
        {{table.file}, fmt::format("column {} is of no axis and is left out", in_quotes(column.name))});
  }
  table.columns = std::move(columns);
  table.has_names = true;
}

template <class Answer>
void answer_once(const std::optional<Answer>& said, std::string_view what, bool may_be_asked,
                 std::optional<Answer>& place, const std::string& file) {
  if (!said) return;
  if (!may_be_asked) {
    throw InputError({file}, fmt::format("{} has no meaning for this file; leave it out", what));
  }
  if (place && *place != *said) {
    throw InputError({file}, fmt::format("the file says {} otherwise; leave it out", what));
  }
  place = said;
}

}  // namespace

bool is_rotation_order(std::string_view order) {
  std::string letters = lower_case(order);
  std::ranges::sort(letters);
  return letters == "xyz";
}

BakedTable answered_table(BakedTable table, const TableAnswers& answers) {
  answer_rate(answers.fps, table);
  answer_columns(answers.columns, table);
  answer_once(answers.up, "which coordinate is up", table.is_in_space, table.up, table.file);
  answer_once(answers.phase, "where in the exposure a row is", table.has_exposures, table.phase, table.file);
  if (answers.rotation_order) {
    if (!table.has_euler_angles || !is_rotation_order(*answers.rotation_order)) {
      throw InputError(
          {table.file},
          fmt::format("{} is no order of rotations of this file; write one such as ZXY for a file "
                      "with three angles",
                      in_quotes(*answers.rotation_order)));
    }
    table.has_euler_angles = false;
    table.rotation_order = lower_case(*answers.rotation_order);
  }
  std::string open;
  for (const TableQuestion& question : questions_of(table))
    open += (open.empty() ? "" : " ") + question.words;
  if (!open.empty()) throw InputError({table.file}, "the file does not say; please do: " + open);
  return table;
}

}  // namespace inbetween
