// The trajectory of a move on a rig as a table for somebody else's program: what plays, cut into polynomials,
// and stops that are proven.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

/// A motor in the units of its drive: (position + offset) * scale + zero. A drive that counts whole numbers
/// is sent the nearest: floor(... + 0.5).
struct TableMotor {
  std::string name;          ///< of its axis; of another motor of an axis "NAME.2"
  std::string unit;          ///< of its position
  std::string drive_unit;    ///< "counts", "steps" or "turns"
  std::size_t position = 0;  ///< of TrajectoryTable's positions: motors of one axis share one
  double offset = 0;
  double scale = 1;
  double zero = 0;
};

/// A piece of the motion of a group: with u = (time - begin) * per_frame, 0 to 1, each of its positions is
/// c[0] + c[1] u + ... + c[degree] u^degree, c being its coefficients.
struct TablePiece {
  FrameTime begin;
  double per_frame = 0;   ///< 1 / length in frames
  std::size_t first = 0;  ///< in TableGroup::coefficients: degree + 1 of its first position, then of the next
  int degree = 0;
};

/// Positions that have their pieces together.
struct TableGroup {
  std::vector<std::size_t> positions;  ///< their numbers
  std::vector<TablePiece> pieces;
  std::vector<double> coefficients;
  std::vector<double> end;  ///< where they are from the last frame on
};

/// A stop from the drawn speed. In `jerk_s` seconds the deceleration of time grows from 0 to
/// 1 / (jerk_s + steady_s) a second, stays for `steady_s` and falls to 0 in `jerk_s`. It takes
/// 2 jerk_s + steady_s, and on the time line half of that.
struct TableStop {
  double jerk_s = 0;
  double steady_s = 0;

  [[nodiscard]] double seconds() const { return 2 * jerk_s + steady_s; }
};

struct TrajectoryTable {
  std::string name;
  std::string rig;
  std::string hash;  ///< of what decides the motion, as in `plan --json`
  FrameRate fps;
  std::int32_t rate_hz = 0;  ///< of the rig
  std::int32_t first_frame = 0;
  std::int32_t last_frame = 0;
  std::size_t position_count = 0;
  std::vector<TableMotor> motors;  ///< in the order of the rig
  std::vector<TableGroup> groups;
  /// Each equal part of the time line, from its first frame to its last, has a stop that begins there.
  /// Playing forward at the drawn speed it keeps every axis inside its stop limits, and on its path.
  std::vector<TableStop> stops;
};

/// This makes a table of what the plan plays, rolls included. `report` is of check(plan), and the plan fits.
/// Throws InputError where a table cannot say what the rig needs: an axis whose backlash is taken up, since
/// that depends on where it came from. Cost: two coefficients a number of the trajectory; that of check() for
/// the stops.
TrajectoryTable trajectory_table(const Plan& plan, const CheckReport& report);

/// The longest of its stops, which is how long a button has to be waited for.
double longest_stop_s(const TrajectoryTable& table);
std::size_t piece_count(const TrajectoryTable& table);

/// Version 1 of the format.
void write_table_json(const TrajectoryTable& table, std::FILE* file);

/// Version 1 of the header: C99 and C++, that stands alone. What it defines begins with `name`, which is a
/// name of C (table_name_of). Numbers read back exactly.
void write_table_header(const TrajectoryTable& table, std::string_view name, std::FILE* file);

/// The beginning of the names that the header in a file defines: the file's name without folder and ending,
/// with '_' for what a name of C cannot have, and in front of a digit. The table is NAME_table, since NAME
/// alone may be a word of C.
std::string table_name_of(const std::string& file);

}  // namespace inbetween
