// Holds docs/formats.md against the readers. What a reader accepts is asked of the reader itself: an unknown
// field is refused with the list of all fields.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig/fault_script.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace formats_document_test {

using Fields = std::vector<std::string>;

std::vector<std::string> lines_of_document() {
  std::ifstream file(in_checkout("docs/formats.md"));
  EXPECT_TRUE(file.is_open());
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

/// The fields in the first column of the table under each heading.
std::map<std::string, Fields> documented_fields() {
  std::map<std::string, Fields> fields;
  std::string heading;
  for (const std::string& line : lines_of_document()) {
    if (line.starts_with("#")) heading = line.substr(line.find_first_not_of("# "));
    if (line.starts_with("| `")) fields[heading].push_back(line.substr(3, line.find('`', 3) - 3));
  }
  return fields;
}

/// The fenced TOML examples, in order.
std::vector<std::string> documented_examples() {
  std::vector<std::string> examples;
  bool inside = false;
  for (const std::string& line : lines_of_document()) {
    if (line == "```toml") examples.emplace_back();
    if (line.starts_with("```")) {
      inside = line == "```toml";
    } else if (inside) {
      examples.back() += line + "\n";
    }
  }
  return examples;
}

/// The document's move with the rows of its table.
MoveFile parse_example(std::string_view text, const std::string& file) {
  const auto rows = [](const std::filesystem::path&, std::size_t) {
    return std::string("frame,tail\n0,0\n240,30\n");
  };
  return parse_move_beside(rows, text, file);
}

/// The document's script of faults is for the document's rig.
FaultScript parse_faults(std::string_view text, const std::string& file) {
  return parse_fault_script(text, file, parse_rig(documented_examples().at(1), "rig.toml"));
}

/// The fields that `parse` lists when it refuses `text`, which has an unknown field.
template <typename Parse>
Fields accepted_fields(Parse parse, const std::string& text) {
  try {
    parse(text, "file.toml");
    ADD_FAILURE() << "accepted:\n" << text;
  } catch (const InputError& error) {
    const std::string lead = "its fields are ";
    const std::size_t list = error.message().find(lead);
    if (list == std::string::npos) {
      ADD_FAILURE() << error.what();
      return {};
    }
    std::string words = error.message().substr(list + lead.size());
    Fields fields;
    for (std::size_t comma = 0; (comma = words.find(", ")) != std::string::npos; words.erase(0, comma + 2)) {
      fields.push_back(words.substr(0, comma));
    }
    fields.push_back(words);
    return fields;
  }
  return {};
}

/// Accepted fields by the heading under which the document must have them. "Which reader" is in the sample.
std::map<std::string, Fields> reader_fields() {
  const std::string move = "name = \"m\"\nfps = 24\nframes = 2\n[[track]]\naxes = [\"x\"]\nspeed = [1]\n";
  const std::string rig =
      "name = \"r\"\nrate_hz = 100\n[bus.can0]\nbitrate = 500000\n[[axis]]\nname = \"x\"\nunit = \"mm\"\nmin "
      "= 0\n"
      "max = 1\nmax_velocity = 1\nmax_acceleration = 1\n";
  std::map<std::string, Fields> fields;
  fields["Move"] = accepted_fields(parse_move, "unknown_field = 1");
  fields["`[[track]]`"] = accepted_fields(parse_move, move + "unknown_field = 1");
  fields["`keys`"] = accepted_fields(parse_move, move + "keys = [ { at = [1], unknown_field = 1 } ]");
  const std::string cue = "keys = [ { at = [1] } ]\n[[cue]]\nunknown_field = 1";
  fields["`[[cue]]`"] = accepted_fields(parse_move, move + cue);
  fields["`clapper`"] =
      accepted_fields(parse_move, "clapper = { unknown_field = 1 }\n" + move + "keys = [ { at = [1] } ]");
  fields["Rig"] = accepted_fields(parse_rig, "unknown_field = 1");
  fields["`[bus.NAME]`"] = accepted_fields(parse_rig, with(rig, "bitrate = 500000", "unknown_field = 1"));
  fields["`[[axis]]`"] = accepted_fields(parse_rig, rig + "unknown_field = 1");
  const std::string pipe = "drive = { type = \"pipe\", path = \"p\", counts_per_unit = 1 }\n";
  fields["`home`"] = accepted_fields(parse_rig, rig + pipe + "home = { unknown_field = 1 }");
  const std::string cia402 = "drive = { type = \"cia402\", bus = \"can0\", node = 1, counts_per_unit = 1 }\n";
  fields["`home` by a drive"] =
      accepted_fields(parse_rig, rig + cia402 + "home = { by = \"drive\", unknown_field = 1 }");
  for (const char* table : {"calibration", "backlash"}) {
    fields[fmt::format("`{}`", table)] =
        accepted_fields(parse_rig, fmt::format("{}{}{} = {{ unknown_field = 1 }}", rig, pipe, table));
  }
  fields["`ganged`"] = accepted_fields(parse_rig, rig + pipe + "ganged = [{ unknown_field = 1 }]");
  fields["`limit_min` and `limit_max`"] =
      accepted_fields(parse_rig, rig + pipe + "limit_min = { unknown_field = 1 }");
  for (const char* section :
       {"emergency_stop", "start_trigger", "camera", "output.NAME", "kinematics", "lens", "dragonframe"}) {
    fields[fmt::format("`[{}]`", section)] =
        accepted_fields(parse_rig, fmt::format("{}{}[{}]\nunknown_field = 1", rig, pipe, section));
  }
  fields["`asks`"] = accepted_fields(
      parse_rig, rig + pipe + "[camera]\nchip = \"c\"\nline = 1\nasks = { unknown_field = 1 }");
  for (const char* type : {"cia402", "odrive", "moteus", "rmd", "cubemars", "step-dir", "pipe"}) {
    const std::string drive = fmt::format("drive = {{ type = \"{}\", unknown_field = 1 }}", type);
    fields[fmt::format("`drive = {{ type = \"{}\" }}`", type)] = accepted_fields(parse_rig, rig + drive);
  }
  fields["Faults"] = accepted_fields(parse_faults, "unknown_field = 1");
  fields["`[[fault]]`"] = accepted_fields(parse_faults, "[[fault]]\nunknown_field = 1");
  return fields;
}

TEST(FormatsDocument, HasEveryFieldThatTheReadersAcceptAndNoOther) {
  const std::map<std::string, Fields> documented = documented_fields();
  const std::map<std::string, Fields> accepted = reader_fields();
  for (const auto& [heading, fields] : accepted) {
    ASSERT_TRUE(documented.contains(heading)) << "docs/formats.md has no table under " << heading;
    EXPECT_THAT(documented.at(heading), testing::UnorderedElementsAreArray(fields)) << heading;
  }
  for (const auto& [heading, fields] : documented) EXPECT_TRUE(accepted.contains(heading)) << heading;
}

TEST(FormatsDocument, ItsExamplesAreAccepted) {
  const std::vector<std::string> examples = documented_examples();
  ASSERT_EQ(examples.size(), 3U);
  EXPECT_EQ(parse_example(examples[0], "docs/formats.md").tracks.size(), 10U);
  EXPECT_EQ(parse_rig(examples[1], "docs/formats.md").axes.size(), 8U);
  EXPECT_EQ(parse_faults(examples[2], "docs/formats.md").faults.size(), 9U);
}

TEST(FormatsDocument, ItsExamplesHaveEveryField) {
  const std::vector<std::string> examples = documented_examples();
  ASSERT_EQ(examples.size(), 3U);
  for (const auto& [heading, fields] : documented_fields()) {
    const bool of_move = heading == "Move" || heading == "`[[track]]`" || heading == "`keys`" ||
                         heading == "`[[cue]]`" || heading == "`clapper`";
    const bool of_faults = heading == "Faults" || heading == "`[[fault]]`";
    for (const std::string& field : fields) {
      EXPECT_THAT(examples[of_move     ? 0
                           : of_faults ? 2
                                       : 1],
                  testing::ContainsRegex("(^|[^a-z_])" + field + "( |\\]|\\.)"))
          << heading << " " << field;
    }
  }
}

/// The rows of the table that says what each fault is begin with the word in quotes.
TEST(FormatsDocument, HasEveryFaultThatThereIs) {
  std::set<std::string> documented;
  for (const std::string& line : lines_of_document()) {
    if (line.starts_with("| \"")) documented.insert(line.substr(2, line.find('"', 3) - 1));
  }
  std::set<std::string> accepted;
  try {
    parse_faults("[[fault]]\naxis = \"track\"\nwhat = \"?\"", "file.toml");
  } catch (const InputError& error) {
    std::istringstream words(error.message().substr(error.message().find("; write ") + 8));
    for (std::string word; words >> word;) {
      if (word.back() == ',') word.pop_back();
      if (word != "or") accepted.insert(word);
    }
  }
  EXPECT_GE(accepted.size(), 15U);
  EXPECT_EQ(documented, accepted);
}

/// Units of a move and of a rig are different lists. Whatever else has a unit refers to them.
TEST(FormatsDocument, ListsTheUnitsOnceForAMoveAndOnceForARig) {
  const std::vector<std::string> lines = lines_of_document();
  EXPECT_EQ(std::ranges::count_if(lines,
                                  [](const std::string& line) {
                                    return line.find("`\"rad\"`") != std::string::npos ||
                                           line.find("`deg`, `rad`") != std::string::npos;
                                  }),
            2);
}

/// Words in quotes in the type column of a field are the words that the reader names when it refuses another.
TEST(FormatsDocument, HasEveryWordThatAFieldMayBe) {
  // "direction" is the first of that name, "[[fault]] direction" that under this heading.
  const auto row_of = [](std::string_view name) {
    const std::size_t blank = name.rfind(' ');
    const std::string_view field = name.substr(blank == std::string_view::npos ? 0 : blank + 1);
    bool is_under = blank == std::string_view::npos;
    for (const std::string& line : lines_of_document()) {
      is_under = is_under || line == fmt::format("### `{}`", name.substr(0, blank));
      if (!is_under) continue;
      // `bias` is a number in a key and a word in an input.
      if (line.starts_with(fmt::format("| `{}` | `\"", field))) return line;
    }
    return std::string();
  };
  const std::string move = documented_examples().at(0);
  const std::string rig = documented_examples().at(1);
  const std::string faults = documented_examples().at(2);
  const auto words_after = [](auto parse, const std::string& text) {
    std::set<std::string> words;
    try {
      parse(text, "file.toml");
    } catch (const InputError& error) {
      std::istringstream list(error.message().substr(error.message().find("; write ") + 8));
      for (std::string word; list >> word;) {
        if (word.back() == ',') word.pop_back();
        if (word != "or") words.insert(word);
      }
    }
    return words;
  };
  const std::map<std::string, std::set<std::string>> words = {
      {"spline", words_after(parse_example, with(move, "\"tcb\"", "\"?\""))},
      {"timing", words_after(parse_example, with(move, "\"speed\"", "\"?\""))},
      {"kinetic", words_after(parse_example, with(move, "kinetic = \"curves\"", "kinetic = \"?\""))},
      {"rest", words_after(parse_example, with(move, "rest    = \"both\"", "rest = \"?\""))},
      {"corners", words_after(parse_example, with(move, "corners = \"pass\"", "corners = \"?\""))},
      {"start", words_after(parse_example, with(move, "\"trigger\"", "\"?\""))},
      {"unit", words_after(parse_example, with(move, "unit = \"mm\"", "unit = \"?\""))},
      {"way", words_after(parse_example, with(move, "\"long\"", "\"?\""))},
      {"mode", words_after(parse_rig, with(rig, "mode = \"cyclic\"", "mode = \"?\""))},
      {"drive = { type = \"cubemars\" } mode",
       words_after(parse_rig, with(rig, "mode = \"servo\"", "mode = \"?\""))},
      {"[[axis]] unit", words_after(parse_rig, with(rig, "\"unit\"", "\"?\""))},
      {"reference", words_after(parse_rig, with(rig, "reference = \"drive\"", "reference = \"?\""))},
      {"unpowered", words_after(parse_rig, with(rig, "unpowered = \"falls\"", "unpowered = \"?\""))},
      {"direction", words_after(parse_rig, with(rig, "\"negative\"", "\"?\""))},
      {"stops_at", words_after(parse_rig, with(rig, "stops_at = \"high\"", "stops_at = \"?\""))},
      {"enable_active",
       words_after(parse_rig, with(rig, "enable_active = \"low\"", "enable_active = \"?\""))},
      {"bias", words_after(parse_rig, with(rig, "stops_at = \"high\"\nbias = \"pull-up\"",
                                           "stops_at = \"high\"\nbias = \"?\""))},
      {"[[fault]] direction", words_after(parse_faults, with(faults, "\"from-drive\"", "\"?\""))},
  };
  for (const auto& [field, accepted] : words) {
    ASSERT_GE(accepted.size(), 2U) << field;
    const std::string row = row_of(field);
    const std::string type =
        row.substr(row.find("| ", 2), row.find(" | ", row.find("| ", 2)) - row.find("| ", 2));
    std::set<std::string> documented;
    for (std::size_t at = 0; (at = type.find("`\"", at)) != std::string::npos;) {
      const std::size_t end = type.find("\"`", at);
      documented.insert(type.substr(at + 1, end - at));
      at = end + 2;
    }
    EXPECT_EQ(documented, accepted) << field;
  }
}

/// As GitHub names a heading in links: lower case, spaces as hyphens, and no other signs than _ and -.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (c == ' ') anchor += '-';
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-')
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return anchor;
}

/// The headings below the title, and behind the table of contents, as links of that table.
std::vector<std::string> headings_as_links() {
  std::vector<std::string> links;
  bool inside = false;
  for (const std::string& line : lines_of_document()) {
    if (line.starts_with("```")) inside = !inside;
    if (inside || !line.starts_with("##") || line == "## Contents") continue;
    const std::string heading = line.substr(line.find_first_not_of("# "));
    links.push_back(fmt::format("[{}](#{})", heading, anchor_of(heading)));
  }
  return links;
}

TEST(FormatsDocument, ItsContentsAreItsHeadingsInTheirOrder) {
  std::vector<std::string> contents;
  bool inside = false;
  for (const std::string& line : lines_of_document()) {
    if (line.starts_with("## ")) inside = line == "## Contents";
    for (std::size_t end = line.find("(#"); inside && end != std::string::npos;
         end = line.find("(#", end + 1)) {
      // A heading such as `[[track]]` has brackets of its own.
      const std::size_t close = line.find(')', end);
      std::size_t begin = line.rfind("), ", end);
      if (begin == std::string::npos) begin = line.rfind("): ", end);
      begin = begin == std::string::npos ? line.find('[') : begin + 3;
      contents.push_back(line.substr(begin, close + 1 - begin));
    }
  }
  EXPECT_EQ(contents, headings_as_links());
}

TEST(FormatsDocument, ItsLinksLeadToItsHeadings) {
  std::set<std::string> anchors;
  for (const std::string& link : headings_as_links()) {
    EXPECT_TRUE(anchors.insert(link.substr(link.rfind("(#"))).second) << link << " is there twice";
  }
  const std::string here = "](#", elsewhere = "formats.md#";
  for (const auto& [document, mark] : {std::pair("docs/formats.md", here),
                                       {"docs/camera.md", elsewhere},
                                       {"docs/puppet.md", elsewhere},
                                       {"README.md", elsewhere}}) {
    const std::string text = file_contents(in_checkout(document));
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) {
      const std::size_t sign = at + mark.size() - 1;
      const std::string link = "(" + text.substr(sign, text.find(')', sign) + 1 - sign);
      EXPECT_TRUE(anchors.contains(link)) << document << " links to " << link;
    }
  }
}

TEST(FormatsDocument, TheFirstPagesForACameraAndAPuppetAreATenthOfItAtMost) {
  const std::string formats = file_contents(in_checkout("docs/formats.md"));
  for (const char* page : {"docs/camera.md", "docs/puppet.md"}) {
    EXPECT_LE(10 * file_contents(in_checkout(page)).size(), formats.size()) << page;
    EXPECT_THAT(file_contents(in_checkout("README.md")), testing::HasSubstr(fmt::format("]({})", page)));
  }
}

}  // namespace formats_document_test
}  // namespace inbetween
