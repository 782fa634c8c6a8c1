// Asks at a terminal what nobody has said of a file that is imported.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host_tools/exchange/import_answers.hpp"

namespace inbetween {

/// A line that somebody types; nothing once they have left. Empty: nobody is there.
using LineReader = std::function<std::optional<std::string>()>;
/// They come from standard input if that is a terminal.
LineReader lines_of_terminal();

/// Asks one line each until no question is open; Enter alone agrees to what is suggested. Where `read` has
/// nobody to ask, throws InputError at the file with every open question and the option that answers it.
/// Returns whether anything was asked.
bool ask_open_questions(const BakedTable& table, const RigFile& rig, const LineReader& read,
                        ImportSaid& said);

/// Asks `question` until `take` returns no mistake. Throws InputError at `file`, with the option, where
/// nobody answers.
void ask_one(const std::string& file, const OpenQuestion& question, const LineReader& read,
             const std::function<std::optional<std::string>(const std::string&)>& take);

}  // namespace inbetween
