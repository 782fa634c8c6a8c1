#include "host_tools/exchange/raw_move.hpp"

#include <fmt/format.h>

namespace inbetween {

BakedTable read_raw_move(std::string_view text, const std::string& file) {
  BakedTable table{.file = file};
  TextLines lines(text, file);
  take_bare_rows(lines, "", table);
  check_table(table);
  return table;
}

std::string write_raw_move(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  std::string text;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (const BakedColumn& column : table.columns) {
      text += fmt::format("{:<12}    ", fixed_number(column.values[row], writing.decimals));
    }
    text += '\n';
  }
  return text;
}

}  // namespace inbetween
