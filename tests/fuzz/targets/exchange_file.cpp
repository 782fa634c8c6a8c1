// Any text is a baked motion that keeps every promise of host_tools/exchange/baked_table.hpp, or is refused
// in one line, or in one for each row that is wrong. The first byte says as what it is read.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host_tools/exchange/arc_scene.hpp"
#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/table_csv.hpp"
#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/text/toml_value.hpp"
#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

const std::string any_file = "any.file";

void require_table(const BakedTable& table) {
  fuzz_require(table.rows() >= 2 && table.rows() <= max_table_rows,
               "a motion has rows, and no more than may be");
  fuzz_require(table.columns.size() <= max_table_columns, "columns fit");
  fuzz_require(table.lines.empty() || table.lines.size() == table.rows(), "every row has a line, or none");
  fuzz_require(table.seconds.empty() || table.seconds.size() == table.rows(),
               "every row has a time, or none");
  fuzz_require(!(table.fps && table.about_fps), "a rate is exact or is not");
  for (const BakedColumn& column : table.columns) {
    fuzz_require(!column.name.empty(), "a column has a name");
    fuzz_require(column.values.size() == table.rows(), "columns are as long as each other");
    for (const double value : column.values)
      fuzz_require(std::fabs(value) <= max_magnitude, "a position is one");
  }
  for (const TableQuestion& question : questions_of(table)) {
    fuzz_require(question.words.ends_with('?'), "a question asks");
  }
}

/// What can be written in the format that it was read from comes back with as many rows and columns.
void require_round_trip(ExchangeFormat format, const BakedTable& table) {
  std::string text;
  try {
    text = write_baked_table(format, table, 3);
  } catch (const InputError&) {
    return;  // a name or a unit that the format does not have
  }
  const BakedTable back = read_baked_table(format, text, any_file);
  fuzz_require(back.rows() == table.rows(), "rows come back");
  const bool has_all = format == ExchangeFormat::flair || back.columns.size() == table.columns.size();
  fuzz_require(has_all, "columns come back");
}

/// A scene that is written back is the same scene from then on.
void require_scene(std::string_view text) {
  const std::string once = write_arc_scene(read_arc_scene(text, any_file));
  fuzz_require(write_arc_scene(read_arc_scene(once, any_file)) == once, "a scene comes back");
}

void require_lines(const WrongRowsError& error) {
  std::string_view lines = error.what();
  for (std::size_t end = lines.find('\n'); end != lines.npos; end = lines.find('\n')) {
    require_one_line(lines.substr(0, end), any_file);
    lines.remove_prefix(end + 1);
  }
  require_one_line(lines, any_file);
}

void read(std::uint8_t kind, std::string_view text) {
  const std::size_t formats = exchange_format_words.size();
  const std::size_t which = kind % (formats + 2);
  if (which == formats) {
    require_table(read_table_csv(text, any_file, {.has_decimal_commas = true, .fills_gaps = true}));
    return;
  }
  const auto format =
      which < formats ? static_cast<ExchangeFormat>(which) : exchange_format_of(any_file, text);
  if (format == ExchangeFormat::arc_scene) {
    require_scene(text);
    return;
  }
  const BakedTable table = read_baked_table(format, text, any_file);
  require_table(table);
  if (format != ExchangeFormat::record) require_round_trip(format, table);
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const auto judge = [&](std::string_view text, const char*) {
    try {
      inbetween::read(bytes[0], text);
    } catch (const inbetween::WrongRowsError& error) {
      inbetween::require_lines(error);
    }
  };
  return inbetween::fuzz_text(bytes + 1, size - 1, inbetween::any_file.c_str(), judge);
}
