#include "host_tools/exchange/motion_reading.hpp"

#include <filesystem>

#include "host_tools/exchange/arc_scene.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {

ImportedFile imported_file_of(const std::string& file, std::string_view text) {
  if (text.starts_with("SQLite format 3")) return ImportedFile::takes;
  const bool is_robot = lower_case(std::filesystem::path(file).extension().string()) == ".urdf" ||
                        (trimmed(text).starts_with('<') && text.find("<robot") != std::string_view::npos &&
                         text.find(arc_namespace) == std::string_view::npos);
  return is_robot ? ImportedFile::robot : ImportedFile::motion;
}

BakedTable read_motion(ExchangeFormat format, std::string_view text, const std::string& file,
                       const MotionReading& reading) {
  if (format == ExchangeFormat::record) return read_record_table(text, file, reading.positions);
  if (format == ExchangeFormat::csv) return read_table_csv(text, file, reading.csv);
  return read_baked_table(format, text, file);
}

std::optional<char> separator_of_word(std::string_view word) {
  if (word == "comma") return ',';
  if (word == "semicolon") return ';';
  if (word == "tab") return '\t';
  return std::nullopt;
}

}  // namespace inbetween
