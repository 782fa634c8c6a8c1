#include "host_tools/exchange/import_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "host_tools/exchange/table_answers.hpp"
#include "host_tools/text/ini_sections.hpp"
#include "host_tools/text/spelling.hpp"

namespace inbetween {
namespace {

constexpr std::string_view unnamed = "column ";
constexpr std::array<std::string_view, 3> angle_names = {"rx", "ry", "rz"};

/// "3" is "column 3" of a file without names.
std::string named_column(const BakedTable& table, const std::string& name) {
  const bool is_number = !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
  return is_number && !table.has_names ? std::string(unnamed) + name : name;
}

ImportSaid with_named_columns(const BakedTable& table, ImportSaid said) {
  for (AxisWord& word : said.axes) word.column = named_column(table, word.column);
  for (UnitWord& word : said.units) {
    if (word.column) word.column = named_column(table, *word.column);
  }
  for (CountWord& word : said.counts) word.column = named_column(table, word.column);
  return said;
}

template <class Names>
std::string wrong_name(std::string_view what, std::string_view name, const Names& names) {
  const std::vector<std::string_view> views(names.begin(), names.end());
  const auto meant = probably_meant(name, views);
  return meant ? fmt::format("there is no {} {}; did you mean {}?", what, in_quotes(name), in_quotes(*meant))
               : fmt::format("there is no {} {}; name one of {}", what, in_quotes(name),
                             comma_separated(views));
}

std::vector<std::string> axis_names(const RigFile& rig) {
  std::vector<std::string> names;
  for (const RigAxis& axis : rig.axes) names.push_back(axis.name);
  return names;
}

const RigAxis* axis_of_rig(const RigFile& rig, std::string_view name) {
  const auto found = std::ranges::find(rig.axes, name, &RigAxis::name);
  return found == rig.axes.end() ? nullptr : &*found;
}

/// A column, and what is known of where it goes.
struct MappedColumn {
  const BakedColumn* column = nullptr;
  const RigAxis* axis = nullptr;
  bool is_reversed = false;
  bool is_left_out = false;
};

void check_columns_named(const BakedTable& table, const ImportSaid& said) {
  std::vector<std::string> names;
  for (const BakedColumn& column : table.columns) names.push_back(column.name);
  const auto check = [&](const std::string& name) {
    if (std::ranges::find(names, name) != names.end()) return;
    throw InputError({table.file}, wrong_name("column", name, names));
  };
  for (const AxisWord& word : said.axes) check(word.column);
  for (const UnitWord& word : said.units) {
    if (word.column) check(*word.column);
  }
  for (const CountWord& word : said.counts) check(word.column);
}

std::vector<MappedColumn> mapped_columns(const BakedTable& table, const RigFile& rig,
                                         const ImportSaid& said) {
  check_columns_named(table, said);
  std::vector<MappedColumn> mapped;
  for (const BakedColumn& column : table.columns) {
    MappedColumn& one = mapped.emplace_back(MappedColumn{&column});
    const auto word = std::ranges::find(said.axes, column.name, &AxisWord::column);
    if (word != said.axes.end()) {
      one.is_left_out = word->is_left_out;
      one.is_reversed = word->is_reversed;
      if (word->is_left_out) continue;
      one.axis = axis_of_rig(rig, word->axis);
      if (one.axis == nullptr)
        throw InputError({table.file}, wrong_name("axis", word->axis, axis_names(rig)));
      continue;
    }
    const bool is_taken = std::ranges::find(said.axes, column.name, &AxisWord::axis) != said.axes.end();
    if (table.has_names && !is_taken) one.axis = axis_of_rig(rig, column.name);
    one.is_left_out = one.axis == nullptr && said.leaves_others_out;
  }
  return mapped;
}

bool fits(MoveUnit unit, const RigAxis& axis) {
  return converted(1, unit, axis.unit).has_value();
}

/// Nothing where nobody has said it.
std::optional<MoveUnit> unit_of(const MappedColumn& mapped, const std::string& file, const ImportSaid& said) {
  const BakedColumn& column = *mapped.column;
  if (column.unit) return column.unit;
  std::optional<MoveUnit> plain;
  for (const UnitWord& word : said.units) {
    if (word.column && *word.column == column.name) return word.unit;
    if (word.column || mapped.axis == nullptr || !fits(word.unit, *mapped.axis)) continue;
    if (plain && *plain != word.unit) {
      throw InputError({file}, fmt::format("two units are given that {} may count in; say COLUMN=UNIT for it",
                                           in_quotes(column.name)));
    }
    plain = word.unit;
  }
  return plain;
}

const CountWord* count_of_column(const BakedColumn& column, const ImportSaid& said) {
  const auto found = std::ranges::find(said.counts, column.name, &CountWord::column);
  return found == said.counts.end() ? nullptr : &*found;
}

/// Of one angle alone no order is asked.
bool has_order_of_angles(const std::vector<MappedColumn>& mapped) {
  const auto is_angle = [](const MappedColumn& one) {
    return !one.is_left_out && std::ranges::find(angle_names, one.column->name) != angle_names.end();
  };
  return std::ranges::count_if(mapped, is_angle) > 1;
}

std::string suggested_axis(const BakedTable& table, std::size_t column, const RigFile& rig) {
  if (!table.has_names)
    return table.columns.size() == rig.axes.size() ? rig.axes[column].name : std::string();
  const std::string& name = table.columns[column].name;
  std::vector<std::string_view> names;
  std::string same;
  for (const RigAxis& axis : rig.axes) {
    names.push_back(axis.name);
    if (lower_case(axis.name) == lower_case(name)) same = axis.name;
  }
  if (!same.empty()) return same;
  return std::string(probably_meant(name, names).value_or(""));
}

std::string suggested_rate(const BakedTable& table) {
  if (!table.about_fps) return "";
  constexpr std::array<FrameRate, 3> usual = {{{24000, 1001}, {30000, 1001}, {60000, 1001}}};
  for (const FrameRate& rate : usual) {
    if (is_about(*table.about_fps, rate)) return to_string(rate);
  }
  return "";
}

void ask_about_columns(const BakedTable& table, const RigFile& rig, const ImportSaid& said,
                       const std::vector<MappedColumn>& mapped, std::vector<OpenQuestion>& open) {
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    const std::string& name = mapped[i].column->name;
    if (mapped[i].axis != nullptr || mapped[i].is_left_out) continue;
    open.push_back({.asks = TableAsks::names,
                    .column = name,
                    .words = fmt::format("which axis is {}?", in_quotes(name)),
                    .option = fmt::format("--axis \"{}=AXIS\"", name),
                    .suggestion = suggested_axis(table, i, rig)});
  }
  for (const MappedColumn& one : mapped) {
    const BakedColumn& column = *one.column;
    if (one.axis == nullptr || column.is_in_counts || unit_of(one, table.file, said)) continue;
    open.push_back(
        {.asks = TableAsks::unit,
         .column = column.name,
         .axis = one.axis->name,
         .words = fmt::format("in what unit does {} count, for axis {}?", in_quotes(column.name),
                              in_quotes(one.axis->name)),
         .option = fmt::format("--unit \"{}=UNIT\"", column.name),
         .suggestion = std::string(one.axis->unit == AxisUnit::unit ? "rig" : to_string(one.axis->unit))});
  }
  for (const MappedColumn& one : mapped) {
    if (one.is_left_out || !one.column->is_in_counts || count_of_column(*one.column, said) != nullptr)
      continue;
    open.push_back(
        {.asks = TableAsks::count,
         .column = one.column->name,
         .words = fmt::format("which count of {} is the 0 of its axis, and how far is it to the next?",
                              in_quotes(one.column->name)),
         .option = fmt::format("--count \"{}=1500,0.1deg\"", one.column->name)});
  }
}

/// Those that are of the whole file, as questions_of has them.
void ask_about_file(const BakedTable& table, const ImportSaid& said, bool has_order,
                    std::vector<OpenQuestion>& open) {
  for (const TableQuestion& question : questions_of(table)) {
    OpenQuestion asked{.asks = question.asks, .words = question.words};
    switch (question.asks) {
      case TableAsks::fps:
        if (said.fps) continue;
        asked.option = "--fps RATE";
        asked.suggestion = suggested_rate(table);
        break;
      case TableAsks::up_axis:
        if (said.up) continue;
        asked.option = "--up y or --up z";
        break;
      case TableAsks::rotation_order:
        if (said.rotation_order || !has_order) continue;
        asked.option = "--rotation-order ZXY";
        break;
      case TableAsks::phase:
        if (said.phase) continue;
        asked.option = "--phase centre or --phase boundary";
        break;
      default:
        continue;  // of columns
    }
    open.push_back(std::move(asked));
  }
}

std::string wrong_answer(std::string_view answer, std::string_view remedy) {
  return fmt::format("{} is no answer; {}", in_quotes(answer), remedy);
}

}  // namespace

std::vector<OpenQuestion> open_questions(const BakedTable& table, const RigFile& rig,
                                         const ImportSaid& said) {
  const ImportSaid named = with_named_columns(table, said);
  const std::vector<MappedColumn> mapped = mapped_columns(table, rig, named);
  std::vector<OpenQuestion> open;
  ask_about_columns(table, rig, named, mapped, open);
  ask_about_file(table, named, has_order_of_angles(mapped), open);
  std::ranges::stable_sort(open, {}, [](const OpenQuestion& question) { return question.asks; });
  return open;
}

std::vector<std::string> choices_of(const OpenQuestion& question, const RigFile& rig) {
  switch (question.asks) {
    case TableAsks::names: {
      std::vector<std::string> choices = {"-"};
      for (const RigAxis& axis : rig.axes) choices.insert(choices.end(), {axis.name, "-" + axis.name});
      return choices;
    }
    case TableAsks::unit: {
      const RigAxis* const axis = axis_of_rig(rig, question.axis);
      std::vector<std::string> choices;
      for (const std::string_view word : move_unit_words) {
        const auto unit = move_unit_of_word(word);
        if (unit && (axis == nullptr || fits(*unit, *axis))) choices.emplace_back(word);
      }
      choices.emplace_back("rig");
      return choices;
    }
    case TableAsks::up_axis:
      return {"y", "z"};
    case TableAsks::rotation_order:
      return {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"};
    case TableAsks::phase:
      return {"centre", "boundary"};
    case TableAsks::fps:
    case TableAsks::count:
      break;
  }
  return {};
}

std::string in_one_line(const std::vector<OpenQuestion>& questions) {
  constexpr std::size_t max_columns = 8;
  std::string line;
  std::size_t same = 0;
  for (std::size_t i = 0; i < questions.size(); ++i) {
    same = i > 0 && questions[i].asks == questions[i - 1].asks ? same + 1 : 0;
    if (same >= max_columns) {
      if (same == max_columns) line += " and so on for the other columns,";
      continue;
    }
    line += fmt::format(" {} ({}),", questions[i].words, questions[i].option);
  }
  if (!line.empty()) line.pop_back();
  return line.empty() ? line : line.substr(1);
}

std::optional<std::string> take_answer(const OpenQuestion& question, std::string_view answer,
                                       const RigFile& rig, ImportSaid& said) {
  const std::string text(trimmed(answer));
  switch (question.asks) {
    case TableAsks::fps:
      said.fps = frame_rate_of_word(text);
      if (!said.fps) return wrong_answer(text, "write a rate such as 24 or 24000/1001");
      return std::nullopt;
    case TableAsks::names: {
      const auto word = axis_word_of(question.column + "=" + text);
      if (!word) return wrong_answer(text, "name an axis, or - where the column is of none");
      if (!word->is_left_out && axis_of_rig(rig, word->axis) == nullptr)
        return wrong_name("axis", word->axis, axis_names(rig));
      said.axes.push_back(*word);
      return std::nullopt;
    }
    case TableAsks::unit: {
      const auto unit = move_unit_of_word(text);
      if (!unit)
        return wrong_answer(text, fmt::format("write one of {}, or rig", comma_separated(move_unit_words)));
      const RigAxis* const axis = axis_of_rig(rig, question.axis);
      if (axis != nullptr && !fits(*unit, *axis))
        return wrong_answer(text, fmt::format("the axis counts in {}", to_string(axis->unit)));
      said.units.push_back({question.column, *unit});
      return std::nullopt;
    }
    case TableAsks::count: {
      const auto word = count_word_of(question.column + "=" + text);
      if (!word) return wrong_answer(text, "write ZERO,DISTANCE UNIT, such as 1500,0.1deg");
      said.counts.push_back(*word);
      return std::nullopt;
    }
    case TableAsks::up_axis:
      said.up = up_axis_of_word(text);
      if (!said.up) return wrong_answer(text, "write y or z");
      return std::nullopt;
    case TableAsks::rotation_order:
      if (!is_rotation_order(text)) return wrong_answer(text, "write the three axes in order, such as ZXY");
      said.rotation_order = text;
      return std::nullopt;
    case TableAsks::phase:
      said.phase = phase_of_word(text);
      if (!said.phase) return wrong_answer(text, "write centre or boundary");
      return std::nullopt;
  }
  return std::nullopt;
}

BakedTable imported_table(BakedTable table, const RigFile& rig, const ImportSaid& said) {
  const ImportSaid named = with_named_columns(table, said);
  const std::vector<MappedColumn> mapped = mapped_columns(table, rig, named);
  table.has_euler_angles = table.has_euler_angles && has_order_of_angles(mapped);
  TableAnswers answers{
      .fps = named.fps, .up = named.up, .rotation_order = named.rotation_order, .phase = named.phase};
  for (const MappedColumn& one : mapped) {
    if (one.axis == nullptr || one.is_left_out) continue;
    ColumnAnswer answer{.column = one.column->name, .axis = one.axis->name, .is_reversed = one.is_reversed};
    if (const CountWord* const count = count_of_column(*one.column, named)) {
      answer.unit = count->unit;
      answer.count = count->count;
      answer.zero = count->zero;
    } else if (!one.column->is_in_counts) {
      answer.unit = unit_of(one, table.file, named);
    }
    answers.columns.push_back(std::move(answer));
  }
  BakedTable result = answered_table(std::move(table), answers);
  for (BakedColumn& column : result.columns) {
    const RigAxis& axis = *axis_of_rig(rig, column.name);
    const MoveUnit unit = column.unit.value_or(MoveUnit::of_rig);
    if (!fits(unit, axis)) {
      throw InputError(
          {result.file},
          fmt::format("the column of axis {} counts in {}, and the axis in {}; correct the unit, "
                      "or which axis the column is",
                      in_quotes(axis.name), to_string(unit), to_string(axis.unit)));
    }
    for (double& value : column.values) value = converted(value, unit, axis.unit).value_or(value);
    column.unit = as_move_unit(axis.unit);
  }
  return result;
}

std::string as_options(const ImportSaid& said) {
  std::string options;
  if (said.fps) options += " --fps " + to_string(*said.fps);
  for (const AxisWord& word : said.axes) {
    options += fmt::format(" --axis \"{}={}{}\"", word.column,
                           word.is_reversed || word.is_left_out ? "-" : "", word.axis);
  }
  for (const UnitWord& word : said.units) {
    const std::string unit(word.unit == MoveUnit::of_rig ? "rig" : to_string(word.unit));
    options += word.column ? fmt::format(" --unit \"{}={}\"", *word.column, unit) : " --unit " + unit;
  }
  for (const CountWord& word : said.counts) {
    options += fmt::format(" --count \"{}={},{}{}\"", word.column, word.zero, word.count,
                           word.unit == MoveUnit::of_rig ? "rig" : to_string(word.unit));
  }
  if (said.up) options += *said.up == UpAxis::y ? " --up y" : " --up z";
  if (said.rotation_order) options += " --rotation-order " + *said.rotation_order;
  if (said.phase) options += fmt::format(" --phase {}", to_string(*said.phase));
  return options;
}

}  // namespace inbetween
