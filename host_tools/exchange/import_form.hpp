// An import as a form: somebody sees all questions at once, and answers them in any order.
//
// The questions, their words and what counts as an answer are those of `inbetween import` at a terminal
// (import_answers.hpp). The form keeps nothing: who fills it in comes with the file and with all answers.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/exchange/rows_move.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// By the id of their question. An empty one is none.
using FormAnswers = std::map<std::string, std::string, std::less<>>;

struct FormQuestion {
  std::string id;
  std::string words;
  std::vector<std::string> choices = {};  // every answer, where they are few; otherwise it is written
  std::string suggestion = {};            // what somebody probably answers; it counts for nothing
  std::string answer = {};                // as it was given
  std::string mistake = {};               // what is wrong with the answer; empty where it was taken
  bool may_stay_open = false;             // how a file is read, which its format has a usual way for
};

struct ImportForm {
  std::vector<FormQuestion> questions = {};  // also those that are answered
  std::vector<std::string> refused = {};     // lines with place, mistake and remedy: the file as it is
  std::vector<std::string> warnings = {};    // lines
  std::optional<RowsMove> move = {};         // once no question is open and nothing is refused
};

/// Reads `text`, the bytes of the file that is called `file`, with the answers so far. `name` is that of the
/// move. A unit is asked once it is known which axis a column is. Throws nothing that the file could cause.
ImportForm import_form(const std::string& file, std::string_view text, const RigFile& rig,
                       const FormAnswers& answers, const std::string& name);

}  // namespace inbetween
