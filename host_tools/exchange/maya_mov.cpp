#include "host_tools/exchange/maya_mov.hpp"

#include <algorithm>

namespace inbetween {
namespace {

/// A name in a comment stays on its line.
std::string in_comment(const std::string& name) {
  std::string shown = name;
  std::ranges::replace_if(
      shown, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  return shown;
}

}  // namespace

bool is_quicktime(std::string_view bytes) {
  if (bytes.size() < 8) return false;
  const std::string_view kind = bytes.substr(4, 4);
  return kind == "ftyp" || kind == "moov" || kind == "mdat" || kind == "wide";
}

BakedTable read_maya_mov(std::string_view text, const std::string& file) {
  if (is_quicktime(text)) {
    throw InputError({file}, "this is a film (QuickTime); name a channel move of Maya, which is a text");
  }
  BakedTable table{.file = file};
  TextLines lines(text, file);
  take_bare_rows(lines, "#", table);
  check_table(table);
  return table;
}

std::string write_maya_mov(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  std::string text;
  for (const BakedColumn& column : table.columns) text += "# " + in_comment(column.name) + "\n";
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const char* between = "";
    for (const BakedColumn& column : table.columns) {
      text += between + fixed_number(column.values[row], writing.decimals);
      between = " ";
    }
    text += '\n';
  }
  return text;
}

}  // namespace inbetween
