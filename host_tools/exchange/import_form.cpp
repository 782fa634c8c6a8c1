#include "host_tools/exchange/import_form.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "host_tools/exchange/arc_scene.hpp"
#include "host_tools/exchange/import_answers.hpp"
#include "host_tools/exchange/motion_reading.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

constexpr std::string_view format_id = "format";
constexpr std::string_view separator_id = "separator";
constexpr std::string_view comma_id = "decimal commas";
constexpr std::string_view gaps_id = "gaps";
constexpr std::string_view positions_id = "positions";

std::string_view answer_to(std::string_view id, const FormAnswers& answers) {
  const auto found = answers.find(id);
  return found == answers.end() ? std::string_view() : trimmed(found->second);
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

// --- how the file is read

/// Asked only where nobody can be sure, and then as long as the form is open.
ExchangeFormat format_of(const std::string& file, std::string_view text, const FormAnswers& answers,
                         ImportForm& form) {
  try {
    return exchange_format_of(file, text);
  } catch (const UnclearFormat& unclear) {
    FormQuestion question{.id = std::string(format_id), .words = unclear.message()};
    for (const ExchangeFormat format : unclear.formats()) question.choices.emplace_back(to_string(format));
    question.answer = answer_to(format_id, answers);
    const bool is_one = std::ranges::find(question.choices, question.answer) != question.choices.end();
    if (!question.answer.empty() && !is_one) question.mistake = "choose one of the formats that it may have";
    form.questions.push_back(question);
    if (!is_one) throw;
    return *exchange_format_of_word(question.answer);
  }
}

/// A command line has options for it.
void offer(std::string_view id, std::string_view words, std::vector<std::string> choices,
           const FormAnswers& answers, ImportForm& form) {
  form.questions.push_back({.id = std::string(id),
                            .words = std::string(words),
                            .choices = std::move(choices),
                            .answer = std::string(answer_to(id, answers)),
                            .may_stay_open = true});
}

void offer_csv(const FormAnswers& answers, ImportForm& form) {
  offer(separator_id, "what separates columns?", {"comma", "semicolon", "tab"}, answers, form);
  offer(comma_id, "do decimals have a comma, 12,5?", {"no", "yes"}, answers, form);
  offer(gaps_id, "shall frames that are missing lie on a line between their neighbours?", {"no", "yes"},
        answers, form);
}

BakedTable table_of(const std::string& file, std::string_view text, const FormAnswers& answers,
                    ImportForm& form) {
  switch (imported_file_of(file, text)) {
    case ImportedFile::takes:
      throw InputError({file}, "this is a file of takes; take one of them with inbetween import --take N");
    case ImportedFile::robot:
      throw InputError({file}, "this is a robot, which becomes a rig; make it with inbetween import");
    case ImportedFile::motion:
      break;
  }
  const ExchangeFormat format = format_of(file, text, answers, form);
  const bool is_scene = format == ExchangeFormat::arc_scene && !read_arc_scene(text, file).has_motion();
  if (is_scene)
    throw InputError({file},
                     "this is a scene without motion, which becomes a rig; make it with inbetween "
                     "import");
  MotionReading reading{.csv = {.separator = separator_of_word(answer_to(separator_id, answers)),
                                .has_decimal_commas = answer_to(comma_id, answers) == "yes",
                                .fills_gaps = answer_to(gaps_id, answers) == "yes"}};
  if (answer_to(positions_id, answers) == "measured") reading.positions = RecordedPositions::actual;
  if (format == ExchangeFormat::record) {
    offer(positions_id, "where the axes were told to be (told), or where they were (measured)?",
          {"told", "measured"}, answers, form);
  }
  const bool was_said =
      std::ranges::any_of(std::array{separator_id, comma_id, gaps_id},
                          [&](std::string_view id) { return !answer_to(id, answers).empty(); });
  if (format == ExchangeFormat::csv && was_said) offer_csv(answers, form);
  try {
    return read_motion(format, text, file, reading);
  } catch (const InputError&) {
    if (format == ExchangeFormat::csv && !was_said) offer_csv(answers, form);
    throw;
  }
}

// --- what it means

/// A question, and in which order it stands: by kind, and then by column.
struct Placed {
  TableAsks asks;
  std::size_t column;
  FormQuestion question;
};

/// "fps", "unit 2" of the second column: a name may have bytes that no page gives back.
std::string id_of(const OpenQuestion& question, std::size_t column) {
  constexpr std::array<std::string_view, 7> words = {"fps", "axis",           "unit", "count",
                                                     "up",  "rotation order", "phase"};
  const std::string_view word = words.at(static_cast<std::size_t>(question.asks));
  return question.column.empty() ? std::string(word) : fmt::format("{} {}", word, column + 1);
}

/// A form that is filled in, one answer after the other as at a terminal: what is asked next depends on it.
class Filling {
 public:
  Filling(const BakedTable& table, const RigFile& rig, const FormAnswers& answers)
      : table_(table), rig_(rig), answers_(answers) {}

  /// Returns whether every question has an answer that was taken.
  bool fill(ImportSaid& said, ImportForm& form) {
    std::vector<Placed> all;
    std::map<std::string, std::string> mistakes;
    std::vector<Placed> left = ask(said);
    for (std::size_t next = 0; next < left.size();) {
      Placed& one = left[next];
      const std::string& id = one.question.id;
      if (one.question.answer.empty() || mistakes.contains(id)) {
        ++next;
        continue;
      }
      if (const auto mistake = take_answer(open_[next], one.question.answer, rig_, said)) {
        mistakes[id] = *mistake;
      } else {
        all.push_back(std::move(one));
      }
      left = ask(said);
      next = 0;
    }
    for (Placed& one : left) {
      one.question.mistake = mistakes[one.question.id];
      all.push_back(std::move(one));
    }
    std::ranges::stable_sort(all, {}, [](const Placed& one) { return std::pair(one.asks, one.column); });
    for (Placed& one : all) form.questions.push_back(std::move(one.question));
    return left.empty();
  }

 private:
  std::vector<Placed> ask(const ImportSaid& said) {
    open_ = open_questions(table_, rig_, said);
    std::vector<Placed> asked;
    for (const OpenQuestion& open : open_) {
      const auto found = std::ranges::find(table_.columns, open.column, &BakedColumn::name);
      const auto column = static_cast<std::size_t>(found - table_.columns.begin());
      const std::string id = id_of(open, column);
      asked.push_back({.asks = open.asks,
                       .column = column,
                       .question = {.id = id,
                                    .words = open.words,
                                    .choices = choices_of(open, rig_),
                                    .suggestion = open.suggestion,
                                    .answer = std::string(answer_to(id, answers_))}});
    }
    return asked;
  }

  const BakedTable& table_;
  const RigFile& rig_;
  const FormAnswers& answers_;
  std::vector<OpenQuestion> open_;
};

}  // namespace

ImportForm import_form(const std::string& file, std::string_view text, const RigFile& rig,
                       const FormAnswers& answers, const std::string& name) {
  ImportForm form;
  try {
    BakedTable table = table_of(file, text, answers, form);
    ImportSaid said;
    if (!Filling(table, rig, answers).fill(said, form)) return form;
    table = imported_table(std::move(table), rig, said);
    RowsMove move = rows_move_of(table, rig, name);
    for (const Warning& warning : table.warnings) form.warnings.push_back(to_string(warning));
    for (const std::string& warning : move.warnings)
      form.warnings.push_back(to_string(Warning{{file}, warning}));
    form.move = std::move(move);
  } catch (const UnclearFormat&) {
    // Its question is in the form.
  } catch (const InputError& error) {
    form.refused = lines_of(error.what());
  }
  return form;
}

}  // namespace inbetween
