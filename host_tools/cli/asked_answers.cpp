#include "host_tools/cli/asked_answers.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <iostream>
#include <vector>

#include "drivers/linux/key_terminal.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

[[noreturn]] void refuse_open(const std::string& file, const std::vector<OpenQuestion>& open) {
  throw InputError({file}, "the file does not say, and nobody did; say " + in_one_line(open));
}

}  // namespace

LineReader lines_of_terminal() {
  if (!KeyTerminal::is_there()) return {};
  return []() -> std::optional<std::string> {
    std::string line;
    if (!std::getline(std::cin, line)) return std::nullopt;
    return line;
  };
}

void ask_one(const std::string& file, const OpenQuestion& question, const LineReader& read,
             const std::function<std::optional<std::string>(const std::string&)>& take) {
  if (!read) refuse_open(file, {question});
  for (;;) {
    fmt::print(stderr, "{}{} ", question.words,
               question.suggestion.empty() ? "" : fmt::format(" Enter: {}.", question.suggestion));
    std::fflush(stderr);
    std::optional<std::string> line = read();
    if (!line) {
      fmt::print(stderr, "\n");
      refuse_open(file, {question});
    }
    const std::string answer(trimmed(*line));
    if (answer.empty() && question.suggestion.empty()) continue;
    const std::optional<std::string> mistake = take(answer.empty() ? question.suggestion : answer);
    if (!mistake) return;
    fmt::print(stderr, "{}\n", *mistake);
  }
}

bool ask_open_questions(const BakedTable& table, const RigFile& rig, const LineReader& read,
                        ImportSaid& said) {
  std::vector<OpenQuestion> open = open_questions(table, rig, said);
  if (open.empty()) return false;
  if (!read) refuse_open(table.file, open);
  while (!open.empty()) {
    const OpenQuestion question = open.front();
    ask_one(table.file, question, read,
            [&](const std::string& answer) { return take_answer(question, answer, rig, said); });
    open = open_questions(table, rig, said);
  }
  return true;
}

}  // namespace inbetween
