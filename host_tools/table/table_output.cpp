#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <span>

#include "host_tools/table/trajectory_table.hpp"
#include "host_tools/text/json_writer.hpp"

namespace inbetween {
namespace {

constexpr int table_version = 1;

/// A number of C that is a double and reads back to the same one.
std::string number_of(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// No name of a move may end a comment, a text or a line of C: the characters that could are replaced.
std::string in_comment(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    const bool is_plain =
        static_cast<unsigned char>(c) >= ' ' && c != '*' && c != '\\' && c != '"' && c != '?';
    safe += is_plain ? c : '_';
  }
  return safe;
}

/// Writes the items of an array, so many a line.
void write_items(std::span<const std::string> items, std::size_t per_line, std::FILE* file) {
  for (std::size_t i = 0; i < items.size(); i += per_line) {
    const std::span<const std::string> line = items.subspan(i, std::min(per_line, items.size() - i));
    fmt::print(file, "  {},\n", fmt::join(line, ", "));
  }
}

/// Writes an array of that type and name, `text_of` each of `values`.
template <class Values, class TextOf>
void write_array(std::string_view type, const std::string& name, const Values& values, std::size_t per_line,
                 const TextOf& text_of, std::FILE* file) {
  std::vector<std::string> items(values.size());
  std::ranges::transform(values, items.begin(), text_of);
  fmt::print(file, "\nstatic const {} {}[] = {{\n", type, name);
  write_items(items, per_line, file);
  fmt::print(file, "}};\n");
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

/// Writes the coefficients of a group, those of a position on a piece a line.
void write_coefficients(const TableGroup& group, const std::string& name, std::FILE* file) {
  fmt::print(file, "\nstatic const double {}[] = {{\n", name);
  for (const TablePiece& piece : group.pieces) {
    std::vector<std::string> items(static_cast<std::size_t>(piece.degree) + 1);
    for (std::size_t i = 0; i < group.positions.size(); ++i) {
      const auto own = std::span(group.coefficients).subspan(piece.first + i * items.size(), items.size());
      std::ranges::transform(own, items.begin(), number_of);
      write_items(items, items.size(), file);
    }
  }
  fmt::print(file, "}};\n");
}

void write_group(const TableGroup& group, std::string_view name, std::size_t number, std::FILE* file) {
  const auto named = [&](std::string_view what) { return fmt::format("{}_{}_{}", name, what, number); };
  const auto piece_text = [](const TablePiece& piece) {
    return fmt::format("{{{}, {}, {}, {}, {}u}}", piece.begin.frame, piece.degree,
                       number_of(piece.begin.fraction), number_of(piece.per_frame), piece.first);
  };
  write_array("inbetween_piece", named("pieces"), group.pieces, 1, piece_text, file);
  write_coefficients(group, named("coefficients"), file);
  write_array("double", named("end"), group.end, 4, number_of, file);
  const auto position_text = [](std::size_t position) { return fmt::format("{}", position); };
  write_array("uint16_t", named("positions"), group.positions, 16, position_text, file);
}

void write_groups(const TrajectoryTable& table, std::string_view name, std::FILE* file) {
  for (std::size_t i = 0; i < table.groups.size(); ++i) write_group(table.groups[i], name, i, file);
  const auto group_text = [&](const TableGroup& group) {
    return fmt::format("{{{0}_pieces_{1}, {0}_coefficients_{1}, {0}_end_{1}, {0}_positions_{1}, {2}u, {3}u}}",
                       name, &group - table.groups.data(), group.pieces.size(), group.positions.size());
  };
  write_array("inbetween_group", fmt::format("{}_groups", name), table.groups, 1, group_text, file);
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
  const auto motor_text = [](const TableMotor& motor) {
    return fmt::format("{{\"{}\", \"{}\", \"{}\", {}u, {}, {}, {}}}", in_comment(motor.name), motor.unit,
                       motor.drive_unit, motor.position, number_of(motor.offset), number_of(motor.scale),
                       number_of(motor.zero));
  };
  write_array("inbetween_motor", fmt::format("{}_motors", name), table.motors, 1, motor_text, file);
  const auto stop_text = [](const TableStop& stop) {
    return fmt::format("{{{}, {}}}", number_of(stop.jerk_s), number_of(stop.steady_s));
  };
  write_array("inbetween_stop", fmt::format("{}_stops", name), table.stops, 2, stop_text, file);
  fmt::print(file,
             "\nstatic const inbetween_trajectory {0}_table = {{\n"
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
