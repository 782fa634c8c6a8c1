// What a page is told of a file that it imports, and the name that the move gets.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host_tools/exchange/import_form.hpp"
#include "host_tools/text/file_layer.hpp"

namespace inbetween {

/// "pan.toml" and the rows beside it, "pan.csv".
struct ImportedNames {
  std::string move, rows;
};

/// The question how the move is called, `answer` being what was said. Its mistake says why that is no name of
/// a file, or that `files` have one already; without an answer the name of the imported file is suggested, or
/// the first with a number behind it that is free.
FormQuestion name_question(const FileLayer& files, const std::string& file, std::string_view answer);

/// Of an answer without a mistake.
ImportedNames imported_names(const FormQuestion& name);

/// A move that was written, and where a page has it; `why_not` where it cannot be opened.
struct WrittenImport {
  std::string move, rows;
  std::optional<std::string> address = {};
  std::optional<std::string> why_not = {};
};

/// {"questions": [{"id", "words", "choices", "suggestion", "answer", "mistake", "may_stay_open"}], "refused":
/// lines, "warnings": lines, "summary": of the move once no question is open, "written": what was written};
/// null where there is none.
std::string import_document(const ImportForm& form, const std::optional<WrittenImport>& written);

}  // namespace inbetween
