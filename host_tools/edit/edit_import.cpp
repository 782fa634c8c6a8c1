#include "host_tools/edit/edit_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

ImportedNames names_of(const std::string& stem) {
  return {.move = stem + ".toml", .rows = stem + ".csv"};
}

/// Whatever cannot be said not to be there is there.
bool is_free(const FileLayer& files, const std::string& stem) {
  const ImportedNames names = names_of(stem);
  return std::ranges::all_of(std::array{names.move, names.rows}, [&](const std::string& name) {
    std::string bytes;
    return files.read(name, 0, bytes) == ENOENT;
  });
}

std::string without_extension(const std::string& file) {
  const std::size_t dot = file.rfind('.');
  return dot == std::string::npos || dot == 0 ? file : file.substr(0, dot);
}

std::string suggested_name(const FileLayer& files, const std::string& file) {
  constexpr int max_tried = 1000;
  std::string stem = without_extension(file);
  if (is_free(files, stem)) return stem;
  for (int number = 2; number < max_tried; ++number) {
    std::string name = fmt::format("{}-{}", stem, number);
    if (is_free(files, name)) return name;
  }
  return "";
}

std::string mistake_in(const FileLayer& files, const std::string& stem) {
  constexpr std::size_t max_bytes = 100;
  const bool has_control = std::ranges::any_of(
      stem, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f || c == '/' || c == '\\'; });
  if (stem.empty() || stem.starts_with('.') || has_control || stem.size() > max_bytes) {
    return fmt::format("{} is no name for a file in the folder of the move; write a name such as pan",
                       in_quotes(stem));
  }
  if (is_free(files, stem)) return "";
  const ImportedNames names = names_of(stem);
  return fmt::format("{} or {} is there already; write another name", names.move, names.rows);
}

}  // namespace

FormQuestion name_question(const FileLayer& files, const std::string& file, std::string_view answer) {
  FormQuestion question{.id = "name",
                        .words = "what shall the move be called?",
                        .suggestion = suggested_name(files, file),
                        .answer = std::string(trimmed(answer))};
  if (question.answer.ends_with(".toml")) question.answer = without_extension(question.answer);
  if (!question.answer.empty()) question.mistake = mistake_in(files, question.answer);
  return question;
}

ImportedNames imported_names(const FormQuestion& name) {
  return names_of(name.answer);
}

std::string import_document(const ImportForm& form, const std::optional<WrittenImport>& written) {
  using nlohmann::json;
  const auto or_null = [](const std::optional<std::string>& text) { return text ? json(*text) : json(); };
  json questions = json::array();
  for (const FormQuestion& question : form.questions) {
    questions.push_back({{"id", question.id},
                         {"words", question.words},
                         {"choices", question.choices},
                         {"suggestion", question.suggestion},
                         {"answer", question.answer},
                         {"mistake", question.mistake},
                         {"may_stay_open", question.may_stay_open}});
  }
  json document{{"questions", questions},
                {"refused", form.refused},
                {"warnings", form.warnings},
                {"summary", form.move ? json(summary_of(*form.move)) : json()},
                {"written", nullptr}};
  if (written) {
    document["written"] = {{"move", written->move},
                           {"rows", written->rows},
                           {"address", or_null(written->address)},
                           {"why_not", or_null(written->why_not)}};
  }
  // A file may have bytes that are no UTF-8.
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace inbetween
