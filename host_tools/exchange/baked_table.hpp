// A baked motion: what another program has written of it, row by row, and what it has not written.
//
// Other programs know no keys and no speed curve; they write where every axis is on every frame. Most of
// their formats leave out how many frames a second there are, in what unit a column counts, which way is up,
// or where in the exposure a row is. That is asked (questions_of) and never guessed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/rig_model/move_unit.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

/// Readers refuse what has more. A move has 1 000 000 frames at most, and one row more.
inline constexpr std::size_t max_table_rows = 1'000'001;
inline constexpr std::size_t max_table_columns = 256;
/// Of a file of rows; all of its numbers then take 256 MiB at most.
inline constexpr std::size_t max_baked_bytes = std::size_t{64} << 20U;
/// The frame numbers of a file, in either direction from 0.
inline constexpr std::int64_t max_table_frame = 100'000'000;

/// Which coordinate of a position in space points up.
enum class UpAxis : std::uint8_t { y, z };

/// Where in the exposure of its frame a row is.
enum class ShutterPhase : std::uint8_t {
  frame_boundary,   ///< half a frame before the middle of the exposure: the shutter is closed
  exposure_centre,  ///< the middle of the exposure: the shutter is open
};

/// One coordinate, on every row.
struct BakedColumn {
  std::string name;                           // of the file; "column 3" where it names none
  std::optional<MoveUnit> unit = {};          // where the file says it
  bool is_in_counts = false;                  // pulses of a servo: what a count is, is not in the file
  std::optional<std::int32_t> channel = {};   // the number of the servo or motor, where the file says it
  std::optional<std::int32_t> decimals = {};  // most digits behind a point; nothing where an exponent stands
  std::vector<double> values = {};
};

/// All columns have a value on each row, and rows follow each other at one rate.
struct BakedTable {
  std::string file;
  std::optional<FrameRate> fps = {};             // rows a second
  std::optional<double> about_fps = {};          // as a decimal in the file, which is not exact: 29.97
  std::optional<std::int64_t> first_frame = {};  // the number of row 0
  std::vector<std::uint32_t> lines = {};         // on which a row begins; empty where rows have no lines
  std::vector<double> seconds = {};              // of each row, where the file says it
  double seconds_rounding = 0;                   // how far each may be off by its printed digits
  std::vector<BakedColumn> columns = {};
  bool has_names = true;     // otherwise they are "column 1" and so on
  bool is_in_space = false;  // positions and angles of a camera in the world, not axes of a rig
  std::optional<UpAxis> up = {};
  bool has_euler_angles = false;    // in an order that the file does not say
  std::string rotation_order = {};  // "zxy", once somebody has said it
  bool has_exposures = true;        // a row is of a frame; otherwise it is of a moment
  std::optional<ShutterPhase> phase = {};
  std::vector<Warning> warnings = {};  // what the file has and the table has not

  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : columns.front().values.size(); }
  /// Of a row, or the file.
  [[nodiscard]] Place place_of(std::size_t row) const;
};

enum class TableAsks : std::uint8_t { fps, names, unit, count, up_axis, rotation_order, phase };

/// Something that has to be known of a table, and that its file does not say.
struct TableQuestion {
  TableAsks asks = TableAsks::fps;
  std::optional<std::size_t> column = {};  // of which
  std::string words;                       // a question that ends with a question mark
};

/// In the order of TableAsks, and of the columns.
std::vector<TableQuestion> questions_of(const BakedTable& table);

/// Refuses a table whose columns are of unequal lengths, which has fewer than two rows or no column, a name
/// twice, or seconds that are not even (mixed rates). Every reader ends with it. Throws InputError.
void check_table(const BakedTable& table);

/// Refuses the first row whose seconds are not those of a rate, with its line.
void check_seconds(const BakedTable& table, const FrameRate& fps);

/// Throws InputError where there is none: `missing`, and the name that was probably meant, or all names.
const BakedColumn& named_column(const BakedTable& table, const std::string& name, const std::string& missing);

/// "24", "24000/1001".
std::string to_string(const FrameRate& fps);

/// Whether a rate that was written as a decimal number may be meant to be this one: it differs by no more
/// than 0.005, which 23.98 differs from 24000/1001.
bool is_about(double decimal, const FrameRate& fps);

/// A whole number of frames a second, 1..1000, or the decimal that is not exact goes into `table`. Throws
/// InputError at `place` where it is neither.
void take_rate(double rate, const Place& place, BakedTable& table);

}  // namespace inbetween
