#include "host_tools/exchange/record_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "host_tools/exchange/table_text.hpp"
#include "host_tools/text/csv_table.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 4> record_columns = {"tick", "seconds", "state", "frame"};
constexpr double record_rounding_s = 0.5e-6;  // seconds have six decimals
constexpr std::int64_t max_record_ticks = 1'000'000'000;
constexpr double max_record_seconds = 1e9;
constexpr double max_record_rate = 1e6;  // any rig is slower

/// The whole numbers of ticks a second with which all seconds agree.
class RecordRate {
 public:
  /// Throws InputError at `place` where none is left.
  void take(std::int64_t tick, double seconds, const Place& place) {
    if (tick == 0) return;
    const double ticks = static_cast<double>(tick);
    if (seconds > record_rounding_s)
      high_ = std::min(high_, std::floor(ticks / (seconds - record_rounding_s)));
    low_ = std::max(low_, std::ceil(ticks / (seconds + record_rounding_s)));
    if (low_ <= high_) return;
    throw InputError(place,
                     fmt::format("tick {} at {} s is at no rate that the rows before are at; name a record "
                                 "as it was written",
                                 tick, seconds));
  }
  [[nodiscard]] std::optional<FrameRate> rate() const {
    if (low_ != high_) return std::nullopt;
    return FrameRate{static_cast<std::int32_t>(low_), 1};
  }

 private:
  double low_ = 1, high_ = max_record_rate;
};

class RecordReader {
 public:
  RecordReader(std::string_view text, const std::string& file, RecordedPositions positions)
      : rows_(text, file), positions_(positions), table_{.file = file} {}

  BakedTable read() {
    const std::optional<CsvRow> head = next();
    if (!head) throw InputError({table_.file}, "the file is empty; name a record of inbetween run");
    take_head(*head);
    while (const std::optional<CsvRow> row = next()) take(*row);
    if (table_.lines.empty()) {
      throw InputError({table_.file}, "no move was played while this was recorded; name another record");
    }
    table_.fps = rate_.rate();
    table_.has_exposures = false;
    table_.seconds_rounding = record_rounding_s;
    check_table(table_);
    return std::move(table_);
  }

 private:
  std::optional<CsvRow> next() {
    CsvRow row;
    if (!rows_.next(row, record_columns.size() + 2 * max_table_columns)) return std::nullopt;
    return row;
  }
  [[nodiscard]] Place place_of(const CsvRow& row, std::size_t field) const {
    return {table_.file, row.line, row.columns[field]};
  }

  void take_head(const CsvRow& head) {
    const std::size_t first = record_columns.size();
    const bool begins = head.fields.size() >= first + 2 && (head.fields.size() - first) % 2 == 0 &&
                        std::equal(record_columns.begin(), record_columns.end(), head.fields.begin());
    for (std::size_t c = first; begins && c < head.fields.size(); c += 2) {
      if (head.fields[c + 1] != head.fields[c] + " actual") refuse_head(head);
      table_.columns.push_back({.name = head.fields[c]});
    }
    if (!begins) refuse_head(head);
    fields_ = head.fields.size();
  }
  [[noreturn]] void refuse_head(const CsvRow& head) const {
    throw InputError({table_.file, head.line, 0},
                     "this is no record of inbetween run with frames; name one that --record has written");
  }

  void take(const CsvRow& row) {
    if (row.fields.size() != fields_) {
      throw InputError(
          {table_.file, row.line, 0},
          fmt::format(
              "the row has {}, and the first row has {}; record it again, or leave the rows from here out",
              counted(std::ssize(row.fields), "field"), fields_));
    }
    const std::int64_t tick = table_whole_number(row.fields[0], place_of(row, 0), 0, max_record_ticks);
    const double seconds = table_number(row.fields[1], place_of(row, 1));
    if (!(seconds >= 0 && seconds <= max_record_seconds)) {
      throw InputError(
          place_of(row, 1),
          fmt::format("{} s are no time of a record; name one as it was written", row.fields[1]));
    }
    rate_.take(tick, seconds, {table_.file, row.line, 0});
    const bool is_played = !row.fields[3].empty();
    if (!is_played) {
      has_ended_ = has_ended_ || !table_.lines.empty();
      return;
    }
    table_number(row.fields[3], place_of(row, 3));
    check_next(tick, row);
    take_positions(row);
    table_.seconds.push_back(seconds);
    table_.lines.push_back(row.line);
    last_tick_ = tick;
  }

  void check_next(std::int64_t tick, const CsvRow& row) const {
    const Place place{table_.file, row.line, 0};
    if (table_.lines.empty()) return;
    if (has_ended_) {
      throw InputError(place, "a second motion begins here; leave the rows of one of them out");
    }
    if (tick != last_tick_ + 1) {
      throw InputError(
          place, fmt::format("tick {} follows tick {}, and those between were lost; record it again", tick,
                             last_tick_));
    }
    if (table_.rows() == max_table_rows) {
      throw InputError(
          place, fmt::format("the record has more than {} ticks; record a part of the move", max_table_rows));
    }
  }

  void take_positions(const CsvRow& row) {
    const std::size_t offset = positions_ == RecordedPositions::actual ? 1 : 0;
    for (std::size_t i = 0; i < table_.columns.size(); ++i) {
      const std::size_t field = record_columns.size() + 2 * i + offset;
      if (row.fields[field].empty()) {
        throw InputError(
            place_of(row, field),
            fmt::format("{} has no setpoint while the move is played, as after a stop; leave the rows "
                        "from here out",
                        in_quotes(table_.columns[i].name)));
      }
      table_.columns[i].values.push_back(table_number(row.fields[field], place_of(row, field)));
    }
  }

  CsvReader rows_;
  RecordedPositions positions_;
  BakedTable table_;
  RecordRate rate_;
  std::size_t fields_ = 0;
  std::int64_t last_tick_ = 0;
  bool has_ended_ = false;
};

}  // namespace

BakedTable read_record_table(std::string_view text, const std::string& file, RecordedPositions positions) {
  const TextLines checked(text, file);  // how long it is, and what is no text
  return RecordReader(text, file, positions).read();
}

}  // namespace inbetween
