// Which format a file has, and its reader and writer by name.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

enum class ExchangeFormat : std::uint8_t {
  csv,
  raw_move,
  arc_move,
  arc_scene,
  kuper,
  flair,
  maya_mov,
  nuke_chan,
  servo_json,
  record,
};
/// In the order of ExchangeFormat.
inline constexpr std::array<std::string_view, 10> exchange_format_words = {
    "csv", "raw-move", "arcm", "arcx", "kuper", "flair", "maya-mov", "nuke-chan", "servo-json", "record"};
std::string_view to_string(ExchangeFormat format);
std::optional<ExchangeFormat> exchange_format_of_word(std::string_view word);

/// A file may be of several formats, and somebody has to say which it has.
class UnclearFormat : public InputError {
 public:
  UnclearFormat(const std::string& file, const std::string& message, std::vector<ExchangeFormat> formats)
      : InputError({file}, message), formats_(std::move(formats)) {}
  [[nodiscard]] const std::vector<ExchangeFormat>& formats() const { return formats_; }

 private:
  std::vector<ExchangeFormat> formats_;
};

/// The format of a file by what it contains and by its extension, which must agree. Throws UnclearFormat
/// where nobody can be sure, with those that it may be: bare rows of numbers are three formats, and only
/// .txt, .mov and .chan tell them apart. Throws InputError at the file where it has none.
ExchangeFormat exchange_format_of(const std::string& file, std::string_view text);

/// The format of a file that is to be written, by its extension. Throws InputError where several formats have
/// it, or none.
ExchangeFormat exchange_format_to_write(const std::string& file);

/// Reads with the options of each reader as they are when nobody says anything. Throws InputError.
BakedTable read_baked_table(ExchangeFormat format, std::string_view text, const std::string& file);

/// Writes with the decimals of the format, or with `decimals`. Throws InputError; a scene without motion and
/// a record are not written.
std::string write_baked_table(ExchangeFormat format, const BakedTable& table,
                              std::optional<std::int32_t> decimals = {});

}  // namespace inbetween
