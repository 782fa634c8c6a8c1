#include "host_tools/exchange/exchange_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "host_tools/exchange/arc_move.hpp"
#include "host_tools/exchange/flair_carts.hpp"
#include "host_tools/exchange/kuper_ascii.hpp"
#include "host_tools/exchange/maya_mov.hpp"
#include "host_tools/exchange/nuke_chan.hpp"
#include "host_tools/exchange/raw_move.hpp"
#include "host_tools/exchange/record_table.hpp"
#include "host_tools/exchange/servo_json.hpp"
#include "host_tools/exchange/table_csv.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

using Formats = std::vector<ExchangeFormat>;

/// Those that files of an extension have.
Formats formats_of_extension(const std::string& file) {
  using enum ExchangeFormat;
  const std::size_t dot = file.rfind('.');
  const std::string extension =
      dot == std::string::npos ? "" : lower_case(std::string_view(file).substr(dot + 1));
  if (extension == "csv" || extension == "tsv") return {csv, record};
  if (extension == "txt") return {raw_move, csv, kuper, flair};
  if (extension == "arcm") return {arc_move};
  if (extension == "arcx") return {arc_scene};
  if (extension == "mov") return {maya_mov};
  if (extension == "chan") return {nuke_chan};
  if (extension == "json") return {servo_json};
  return {};
}

/// The first lines that say something, as far as they tell formats apart.
struct Beginning {
  bool has_comments = false;
  std::vector<TextLine> lines = {};  // two at most
};
Beginning beginning_of(std::string_view text, const std::string& file) {
  Beginning beginning;
  TextLines lines(text, file);
  while (beginning.lines.size() < 2) {
    const std::optional<TextLine> line = lines.next();
    if (!line) break;
    const std::string_view words = trimmed(line->text);
    if (words.starts_with('#')) {
      beginning.has_comments = true;
    } else if (!words.empty()) {
      beginning.lines.push_back(*line);
    }
  }
  return beginning;
}

bool is_bare_row(const TextLine& line) {
  const auto words = words_of(line.text, max_table_columns);
  return words && std::ranges::all_of(*words, [](const TextWord& word) { return is_number_word(word.text); });
}

/// A whole number that ascends by one, and six or seven numbers behind it.
bool may_be_chan(const Beginning& beginning) {
  std::vector<double> frames;
  for (const TextLine& line : beginning.lines) {
    const auto words = words_of(line.text, max_table_columns);
    if (!words || (words->size() != 7 && words->size() != 8)) return false;
    const std::string_view word = words->front().text;
    constexpr std::size_t max_digits = 9;  // of a frame
    const bool is_whole = word.size() <= max_digits && word.find_first_not_of("+-0123456789") == word.npos;
    if (!is_whole || !is_number_word(word)) return false;
    frames.push_back(table_number(word, {}));
  }
  return frames.size() == 2 && frames[1] == frames[0] + 1;
}

Formats formats_of_rows(const Beginning& beginning) {
  using enum ExchangeFormat;
  const TextLine& first = beginning.lines.front();
  if (!is_bare_row(first)) return {csv};
  Formats formats = {maya_mov};
  if (!beginning.has_comments) formats.push_back(raw_move);
  if (may_be_chan(beginning)) formats.push_back(nuke_chan);
  if (first.text.find('\t') != first.text.npos && !beginning.has_comments) formats.push_back(csv);
  return formats;
}

/// Those that what stands in the file may be.
Formats formats_of_content(std::string_view text, const std::string& file) {
  using enum ExchangeFormat;
  if (is_quicktime(text)) {
    throw InputError({file}, "this is a film (QuickTime); name a file with a motion");
  }
  const Beginning beginning = beginning_of(text, file);
  if (beginning.lines.empty()) throw InputError({file}, "the file is empty; name one with a motion");
  const std::string first = lower_case(trimmed(beginning.lines.front().text));
  if (first.starts_with('<')) {
    const bool is_scene = text.find(arc_namespace) != text.npos;
    const bool has_curves = text.find("controlPoints") != text.npos;
    if (is_scene) return {has_curves ? arc_move : arc_scene};
    throw InputError({file},
                     fmt::format("this is XML, and no scene of Dragonframe's Arc workspace; name one of {}",
                                 comma_separated(exchange_format_words)));
  }
  if (first.starts_with('{')) return {servo_json};
  if (first.starts_with(record_head)) return {record};
  if (first.starts_with("axes") && trimmed(std::string_view(first).substr(4)).starts_with('='))
    return {kuper};
  if (first.starts_with("data_type")) return {flair};
  return formats_of_rows(beginning);
}

std::string words_of_formats(const Formats& formats) {
  std::vector<std::string> words;
  for (const ExchangeFormat format : formats) words.emplace_back(to_string(format));
  return listed_with_and(words);
}

}  // namespace

std::string_view to_string(ExchangeFormat format) {
  return exchange_format_words.at(static_cast<std::size_t>(format));
}

std::optional<ExchangeFormat> exchange_format_of_word(std::string_view word) {
  const auto found = std::ranges::find(exchange_format_words, word);
  if (found == exchange_format_words.end()) return std::nullopt;
  return static_cast<ExchangeFormat>(found - exchange_format_words.begin());
}

ExchangeFormat exchange_format_of(const std::string& file, std::string_view text) {
  using enum ExchangeFormat;
  const Formats content = formats_of_content(text, file);
  const Formats extension = formats_of_extension(file);
  Formats both;
  for (const ExchangeFormat format : content) {
    const bool is_usual = std::ranges::find(extension, format) != extension.end();
    if (extension.empty() || is_usual) both.push_back(format);
  }
  // A .chan file that was renamed would play its frame numbers as an axis.
  const bool is_chan_as_text =
      both == Formats{raw_move} && std::ranges::find(content, nuke_chan) != content.end();
  if (both.size() == 1 && !is_chan_as_text) return both.front();
  if (both.empty()) {
    throw UnclearFormat(file,
                        fmt::format("by its extension it is {}, and what stands in it is {}; say which "
                                    "format it has",
                                    words_of_formats(extension), words_of_formats(content)),
                        content);
  }
  const Formats& open = is_chan_as_text ? content : both;
  throw UnclearFormat(
      file, fmt::format("what stands in it may be {}; say which format it has", words_of_formats(open)),
      open);
}

ExchangeFormat exchange_format_to_write(const std::string& file) {
  using enum ExchangeFormat;
  Formats formats = formats_of_extension(file);
  std::erase(formats, record);
  if (formats.size() == 1) return formats.front();
  throw InputError({file}, fmt::format("its extension does not tell its format; say one of {}",
                                       formats.empty() ? comma_separated(exchange_format_words)
                                                       : words_of_formats(formats)));
}

BakedTable read_baked_table(ExchangeFormat format, std::string_view text, const std::string& file) {
  using enum ExchangeFormat;
  switch (format) {
    case csv:
      return read_table_csv(text, file);
    case raw_move:
      return read_raw_move(text, file);
    case arc_move:
    case arc_scene:
      return read_arc_move(text, file);
    case kuper:
      return read_kuper_ascii(text, file);
    case flair:
      return read_flair_carts(text, file);
    case maya_mov:
      return read_maya_mov(text, file);
    case nuke_chan:
      return read_nuke_chan(text, file);
    case servo_json:
      return read_servo_json(text, file);
    case record:
      return read_record_table(text, file);
  }
  throw InputError({file}, "its format is none that is read");
}

std::string write_baked_table(ExchangeFormat format, const BakedTable& table,
                              std::optional<std::int32_t> decimals) {
  using enum ExchangeFormat;
  const TableWriting writing{decimals.value_or(TableWriting{}.decimals)};
  switch (format) {
    case csv:
      return write_table_csv(table, writing);
    case raw_move:
      return write_raw_move(table, writing);
    case arc_move:
      return write_arc_move(table, writing);
    case kuper:
      return write_kuper_ascii(table, {decimals.value_or(kuper_decimals)});
    case flair:
      return write_flair_carts(table, {decimals.value_or(flair_decimals)});
    case maya_mov:
      return write_maya_mov(table, writing);
    case nuke_chan:
      return write_nuke_chan(table, writing);
    case servo_json:
      return write_servo_json(table);
    case arc_scene:
    case record:
      break;
  }
  throw InputError({table.file},
                   fmt::format("{} is not written: it is what another program sets up, or what was "
                               "recorded; write arcm or csv",
                               to_string(format)));
}

}  // namespace inbetween
