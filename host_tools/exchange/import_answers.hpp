// What must be known of a baked motion before a rig can play it: what is still open, and the motion with all
// of it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/exchange/table_words.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// What was said so far. A column without a name may be called by its number.
struct ImportSaid {
  std::optional<FrameRate> fps = {};
  std::vector<AxisWord> axes = {};
  bool leaves_others_out = false;  // columns without an axis of their name
  std::vector<UnitWord> units = {};
  std::vector<CountWord> counts = {};
  std::optional<UpAxis> up = {};
  std::optional<std::string> rotation_order = {};
  std::optional<ShutterPhase> phase = {};
};

struct OpenQuestion {
  TableAsks asks = TableAsks::fps;
  std::string column = {};      // of which; empty where the whole file is meant
  std::string axis = {};        // of the column, where that matters
  std::string words = {};       // a question that ends with a question mark
  std::string option = {};      // by which it is answered beforehand: --fps 24
  std::string suggestion = {};  // what somebody probably answers, to be agreed to; empty where nobody knows
};

/// What nobody has said: a column goes by itself to the axis of exactly its name. Of a column without an axis
/// the unit is not asked yet. Throws
/// InputError at the file where an axis or a column that was named is not there, or a plain unit is given
/// twice for what it fits.
std::vector<OpenQuestion> open_questions(const BakedTable& table, const RigFile& rig, const ImportSaid& said);

/// Every answer that take_answer takes, where they are few; nothing where it is to be written.
std::vector<std::string> choices_of(const OpenQuestion& question, const RigFile& rig);

/// All of them in one line, each with the option that answers it.
std::string in_one_line(const std::vector<OpenQuestion>& questions);

/// Takes an answer in words. Returns what is wrong with it, or nothing where it was taken.
std::optional<std::string> take_answer(const OpenQuestion& question, std::string_view answer,
                                       const RigFile& rig, ImportSaid& said);

/// The table with the axes of the rig in place of columns, in their units. Throws InputError as
/// answered_table does, and where a column counts a length and its axis an angle. No question is open.
BakedTable imported_table(BakedTable table, const RigFile& rig, const ImportSaid& said);

/// The options that say what was said, so that somebody can import the next file without questions.
std::string as_options(const ImportSaid& said);

}  // namespace inbetween
