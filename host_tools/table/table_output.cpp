#include "host_tools/table/table_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "host_tools/files/json_writer.hpp"

namespace inbetween {
namespace {

constexpr int table_version = 1;

/// A number of C that is a double and reads back to the same one.
std::string number_of(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// What C and C++ take for a comment's end, for a quotation mark and for the end of a line is none of it.
std::string in_comment(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    const bool is_plain =
        static_cast<unsigned char>(c) >= ' ' && c != '*' && c != '\\' && c != '"' && c != '?';
    safe += is_plain ? c : '_';
  }
  return safe;
}

/// The list of an array: numbers, so many a line.
void write_list(std::span<const std::string> items, std::size_t per_line, std::FILE* file) {
  for (std::size_t i = 0; i < items.size(); i += per_line) {
    const std::span<const std::string> line = items.subspan(i, std::min(per_line, items.size() - i));
    fmt::print(file, "  {},\n", fmt::join(line, ", "));
  }
}

constexpr std::string_view types = R"(#ifndef INBETWEEN_TRAJECTORY
/* The version of these types. A program asks for it: #if INBETWEEN_TRAJECTORY != 1 */
#define INBETWEEN_TRAJECTORY 1

/* A stretch of time of a group of positions. With
     u = ((frame - piece.frame) + (fraction - piece.fraction)) * piece.per_frame,
   0 to 1, position i of the group is at c[0] + c[1] u + ... + c[degree] u^degree, where c is
   &coefficients[piece.first + i * (piece.degree + 1)]. A piece lasts until the next one begins. */
typedef struct inbetween_piece {
  int32_t frame;      /* where it begins: a whole frame */
  int32_t degree;     /* 0 to 7 */
  double fraction;    /* ... and a part of a frame, 0 to below 1 */
  double per_frame;   /* 1 / its length in frames */
  uint32_t first;     /* of its coefficients */
} inbetween_piece;

/* Positions that have their pieces together. */
typedef struct inbetween_group {
  const inbetween_piece* pieces;
  const double* coefficients;
  const double* end;  /* where they are from last_frame on */
  const uint16_t* positions;  /* their numbers, position_count of them */
  uint32_t piece_count;
  uint32_t position_count;
} inbetween_group;

/* What a motor is sent: (position + offset) * scale + zero, in units of its drive. A drive that counts
   whole numbers is sent floor(... + 0.5). */
typedef struct inbetween_motor {
  const char* name;
  const char* unit;        /* of its position and its offset */
  const char* drive_unit;  /* "counts", "steps" or "turns" */
  uint32_t position;       /* its number; motors of one axis share one */
  double offset;
  double scale;
  double zero;
} inbetween_motor;

/* A stop from the drawn speed, playing forward. For jerk_s seconds the rate falls ever faster, for steady_s
   evenly, and for jerk_s ever slower to 0. */
typedef struct inbetween_stop {
  double jerk_s;
  double steady_s;
} inbetween_stop;

typedef struct inbetween_trajectory {
  const char* name;
  const char* hash;         /* of what decides the motion */
  int32_t fps_numerator;    /* frames a second: numerator / denominator */
  int32_t fps_denominator;
  int32_t rate_hz;          /* ticks a second of the rig for which it was made */
  int32_t first_frame;      /* negative on a pre-roll */
  int32_t last_frame;
  uint32_t position_count;
  uint32_t motor_count;
  uint32_t group_count;
  uint32_t stop_count;
  const inbetween_motor* motors;
  const inbetween_group* groups;
  const inbetween_stop* stops;  /* of equal parts of the time line, first_frame to last_frame */
} inbetween_trajectory;
#endif
)";

void write_group(const TableGroup& group, std::string_view name, std::size_t number, std::FILE* file) {
  const auto head = [&](std::string_view type, std::string_view what) {
    fmt::print(file, "\nstatic const {} {}_{}_{}[] = {{\n", type, name, what, number);
  };
  std::vector<std::string> items;
  for (const TablePiece& piece : group.pieces) {
    items.push_back(fmt::format("{{{}, {}, {}, {}, {}u}}", piece.begin.frame, piece.degree,
                                number_of(piece.begin.fraction), number_of(piece.per_frame), piece.first));
  }
  head("inbetween_piece", "pieces");
  write_list(items, 1, file);
  fmt::print(file, "}};\n");
  head("double", "coefficients");
  for (const TablePiece& piece : group.pieces) {
    for (std::size_t i = 0; i < group.positions.size(); ++i) {
      const auto size = static_cast<std::size_t>(piece.degree) + 1;
      items.clear();
      for (std::size_t power = 0; power < size; ++power)
        items.push_back(number_of(group.coefficients[piece.first + i * size + power]));
      write_list(items, items.size(), file);
    }
  }
  fmt::print(file, "}};\n");
  items.clear();
  for (const double end : group.end) items.push_back(number_of(end));
  head("double", "end");
  write_list(items, 4, file);
  fmt::print(file, "}};\n");
  items.clear();
  for (const std::size_t position : group.positions) items.push_back(fmt::format("{}", position));
  head("uint16_t", "positions");
  write_list(items, 16, file);
  fmt::print(file, "}};\n");
}

void write_groups(const TrajectoryTable& table, std::string_view name, std::FILE* file) {
  for (std::size_t i = 0; i < table.groups.size(); ++i) write_group(table.groups[i], name, i, file);
  fmt::print(file, "\nstatic const inbetween_group {}_groups[] = {{\n", name);
  for (std::size_t i = 0; i < table.groups.size(); ++i) {
    fmt::print(file,
               "  {{{0}_pieces_{1}, {0}_coefficients_{1}, {0}_end_{1}, {0}_positions_{1}, {2}u, {3}u}},\n",
               name, i, table.groups[i].pieces.size(), table.groups[i].positions.size());
  }
  fmt::print(file, "}};\n");
}

}  // namespace

std::string table_name_of(const std::string& file) {
  const std::size_t folder = file.find_last_of('/');
  std::string name = folder == std::string::npos ? file : file.substr(folder + 1);
  const std::size_t ending = name.find_last_of('.');
  if (ending != std::string::npos && ending > 0) name.resize(ending);
  for (char& c : name) {
    const bool is_in_name =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    if (!is_in_name) c = '_';
  }
  return name.empty() || (name.front() >= '0' && name.front() <= '9') ? "_" + name : name;
}

void write_table_header(const TrajectoryTable& table, std::string_view name, std::FILE* file) {
  std::string guard(name);
  std::ranges::transform(guard, guard.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  fmt::print(file,
             "/* The move {} on the rig {}, solved by inbetween: make it anew rather than change it. It is "
             "described under\n"
             "   \"Trajectory tables\" in docs/formats.md of inbetween. */\n"
             "#ifndef INBETWEEN_TABLE_{}\n#define INBETWEEN_TABLE_{}\n\n#include <stdint.h>\n\n{}",
             in_comment(table.name), in_comment(table.rig), guard, guard, types);
  write_groups(table, name, file);
  fmt::print(file, "\nstatic const inbetween_motor {}_motors[] = {{\n", name);
  for (const TableMotor& motor : table.motors) {
    fmt::print(file, "  {{\"{}\", \"{}\", \"{}\", {}u, {}, {}, {}}},\n", in_comment(motor.name), motor.unit,
               motor.drive_unit, motor.position, number_of(motor.offset), number_of(motor.scale),
               number_of(motor.zero));
  }
  fmt::print(file, "}};\n\nstatic const inbetween_stop {}_stops[] = {{\n", name);
  std::vector<std::string> stops;
  for (const TableStop& stop : table.stops)
    stops.push_back(fmt::format("{{{}, {}}}", number_of(stop.jerk_s), number_of(stop.steady_s)));
  write_list(stops, 2, file);
  fmt::print(file,
             "}};\n\nstatic const inbetween_trajectory {0}_table = {{\n"
             "  \"{1}\", \"{2}\", {3}, {4}, {5}, {6}, {7},\n"
             "  {8}u, {9}u, {10}u, {11}u, {0}_motors, {0}_groups, {0}_stops,\n}};\n"
             "\n/* Whoever includes this may leave {0}_table unused without a warning. */\n"
             "static inline const inbetween_trajectory* {0}_trajectory(void) {{\n  return "
             "&{0}_table;\n}}\n\n#endif\n",
             name, in_comment(table.name), table.hash, table.fps.numerator, table.fps.denominator,
             table.rate_hz, table.first_frame, table.last_frame, table.position_count, table.motors.size(),
             table.groups.size(), table.stops.size());
}

void write_table_json(const TrajectoryTable& table, std::FILE* file) {
  JsonWriter json(file);
  json.begin_object();
  json.member("format", table_version);
  json.member("name", table.name);
  json.member("rig", table.rig);
  json.member("hash", table.hash);
  json.member("fps", std::array{table.fps.numerator, table.fps.denominator});
  json.member("rate_hz", table.rate_hz);
  json.member("first", table.first_frame);
  json.member("last", table.last_frame);
  json.line();
  json.objects("motors", table.motors, [&](const TableMotor& motor) {
    json.member("name", motor.name);
    json.member("unit", motor.unit);
    json.member("position", motor.position);
    json.member("offset", motor.offset);
    json.member("scale", motor.scale);
    json.member("zero", motor.zero);
    json.member("drive_unit", motor.drive_unit);
  });
  json.line();
  json.objects("groups", table.groups, [&](const TableGroup& group) {
    json.member("positions", group.positions);
    json.member("end", group.end);
    json.line();
    json.objects("pieces", group.pieces, [&](const TablePiece& piece) {
      json.member("frame", piece.begin.frame);
      json.member("fraction", piece.begin.fraction);
      json.member("per_frame", piece.per_frame);
      json.array("coefficients", [&] {
        const auto size = static_cast<std::size_t>(piece.degree) + 1;
        for (std::size_t i = 0; i < group.positions.size(); ++i)
          json.value(std::span(group.coefficients).subspan(piece.first + i * size, size));
      });
    });
  });
  json.line();
  json.objects("stops", table.stops, [&](const TableStop& stop) {
    json.member("jerk_s", stop.jerk_s);
    json.member("steady_s", stop.steady_s);
  });
  json.end_object();
  json.finish();
}

}  // namespace inbetween
