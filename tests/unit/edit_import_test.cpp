// A file that is dropped on the page: asked about, written beside the move, and never over anything.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/edit/edit_session.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/places.hpp"
#include "tests/support/simulated_disk.hpp"

namespace inbetween {
namespace edit_import_test {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const std::string move_text = "name = \"slide\"\n";
const std::string rows = "0\n10\n20.5\n";
// "0\n10\n20.5\n"
const std::string rows_in_base64 = "MAoxMAoyMC41Cg==";

json request(const json& answers = json::object(), bool writes = false) {
  return {{"file", "in.txt"}, {"bytes", rows_in_base64}, {"answers", answers}, {"writes", writes}};
}
const json all_answers = {
    {"fps", "24"}, {"axis 1", "pan"}, {"unit 1", "deg"}, {"phase", "boundary"}, {"name", "pan"}};

struct Opened {
  explicit Opened(SimulatedDisk& disk,
                  std::optional<std::string> rig = in_checkout("examples/camera_rig.toml"))
      : Opened(disk.layer(), std::move(rig)) {}
  explicit Opened(FileLayer files, std::optional<std::string> rig = in_checkout("examples/camera_rig.toml"))
      : session(std::move(files), "m.toml", std::move(rig), "this") {}

  json ask(const json& of) {
    const EditAnswer answer = session.import_motion(parse_import_request(of.dump()));
    EXPECT_EQ(answer.status, 200) << answer.json;
    return json::parse(answer.json);
  }
  EditSession session;
};

json question_of(const json& document, const std::string& id) {
  for (const json& question : document.at("questions"))
    if (question.at("id") == id) return question;
  return json::object();
}

TEST(EditImport, TellsEveryOpenQuestionAndTheSuggestedName) {
  SimulatedDisk disk({{"m.toml", move_text}});
  const json document = Opened(disk).ask(request());
  std::vector<std::string> ids;
  for (const json& question : document.at("questions")) ids.push_back(question.at("id"));
  EXPECT_THAT(ids, ElementsAre("fps", "axis 1", "phase", "name"));
  EXPECT_EQ(question_of(document, "fps").at("words"), "how many rows does a second have?");
  EXPECT_EQ(question_of(document, "name").at("suggestion"), "in");
  EXPECT_EQ(document.at("written"), nullptr);
  EXPECT_EQ(document.at("summary"), nullptr);
}

TEST(EditImport, IsWrittenBesideTheMoveAndOpened) {
  SimulatedDisk disk({{"m.toml", move_text}});
  Opened opened(disk);
  std::string asked;
  opened.session.open_imports_with(
      [&](const std::string& move) { return "http://there/#" + (asked = move); });
  const json seen = opened.ask(request(all_answers));
  EXPECT_EQ(seen.at("summary"), "2 frames of pan at 24 fps, 0.083 s");
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", move_text}})) << "it was only looked at";
  const json document = opened.ask(request(all_answers, true));
  EXPECT_EQ(asked, "pan.toml");
  EXPECT_EQ(document.at("written"), (json{{"move", "pan.toml"},
                                          {"rows", "pan.csv"},
                                          {"address", "http://there/#pan.toml"},
                                          {"why_not", nullptr}}));
  DiskContent content = disk.content();
  EXPECT_EQ(content.at("pan.csv"), "frame,pan\n0,0\n1,10\n2,20.5\n");
  EXPECT_THAT(content.at("pan.toml"),
              AllOf(HasSubstr("Imported from in.txt"), HasSubstr("name = \"pan\"\nfps = 24\nframes = 2\n"),
                    HasSubstr("table = \"pan.csv\"")));
  EXPECT_EQ(content.at("m.toml"), move_text);
  EXPECT_EQ(content.size(), 3U) << "nothing else is left there";
}

TEST(EditImport, WithAQuestionOpenNothingIsWritten) {
  for (const auto& [id, answer] : all_answers.items()) {
    SimulatedDisk disk({{"m.toml", move_text}});
    json answers = all_answers;
    answers.erase(id);
    const json document = Opened(disk).ask(request(answers, true));
    EXPECT_EQ(document.at("written"), nullptr) << id;
    EXPECT_EQ(disk.content().size(), 1U) << id;
  }
}

TEST(EditImport, ANameThatIsTakenIsAskedAgainAndKeepsItsFile) {
  for (const std::string taken : {"pan.toml", "pan.csv"}) {
    SimulatedDisk disk({{"m.toml", move_text}, {taken, "mine"}});
    Opened opened(disk);
    const json document = opened.ask(request(all_answers, true));
    EXPECT_EQ(document.at("written"), nullptr);
    EXPECT_THAT(question_of(document, "name").at("mistake").get<std::string>(),
                HasSubstr("is there already; write another name"));
    EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", move_text}, {taken, "mine"}}));
  }
  SimulatedDisk disk({{"m.toml", move_text}, {"in.csv", "mine"}});
  EXPECT_EQ(question_of(Opened(disk).ask(request()), "name").at("suggestion"), "in-2");
}

TEST(EditImport, ANameThatIsTakenInTheVeryMomentKeepsItsFileToo) {
  for (const std::string taken : {"pan.toml", "pan.csv"}) {
    SimulatedDisk disk({{"m.toml", move_text}});
    FileLayer files = disk.layer();
    files.create = [&, create = files.create](const std::string& name, int& descriptor) {
      if (name == part_of(taken) && !disk.content().contains(taken)) {
        EXPECT_FALSE(replace_durably(disk.layer(), taken, "mine"));
      }
      return create(name, descriptor);
    };
    Opened opened(files);
    const json document = opened.ask(request(all_answers, true));
    EXPECT_EQ(document.at("written"), nullptr) << taken;
    EXPECT_EQ(question_of(document, "name").at("mistake"), taken + " is there already; write another name");
    EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", move_text}, {taken, "mine"}}));
  }
}

TEST(EditImport, NoNameLeadsOutOfTheFolder) {
  for (const char* name : {"../pan", "/tmp/pan", ".pan", "a/b", "a\\b", "a\nb", "..", ".toml"}) {
    SimulatedDisk disk({{"m.toml", move_text}});
    json answers = all_answers;
    answers["name"] = name;
    const json document = Opened(disk).ask(request(answers, true));
    EXPECT_THAT(question_of(document, "name").at("mistake").get<std::string>(), HasSubstr("is no name"))
        << name;
    EXPECT_EQ(disk.content().size(), 1U) << name;
  }
}

TEST(EditImport, AFullDiskLeavesNoHalfOfIt) {
  SimulatedDisk whole({{"m.toml", move_text}});
  Opened(whole).ask(request(all_answers, true));
  const std::size_t operations = whole.operations();
  for (std::size_t at = 1; at <= operations; ++at) {
    SimulatedDisk disk({{"m.toml", move_text}});
    disk.fail_at(at, ENOSPC, false);
    Opened opened(disk);
    const EditAnswer answer =
        opened.session.import_motion(parse_import_request(request(all_answers, true).dump()));
    const DiskContent content = disk.content();
    if (content.contains("pan.toml")) {
      EXPECT_TRUE(content.contains("pan.csv")) << at << ": a move that names rows has them";
    }
    EXPECT_TRUE(answer.status != 200 || content.contains("pan.toml")) << at;
    EXPECT_EQ(content.at("m.toml"), move_text);
  }
}

TEST(EditImport, EveryWrongLineIsTold) {
  SimulatedDisk disk({{"m.toml", move_text}});
  json of = request();
  of["bytes"] = "MAp4CjIwCg==";  // "0\nx\n20\n"
  const json document = Opened(disk).ask(of);
  EXPECT_THAT(document.at("refused").at(0).get<std::string>(), StartsWith("in.txt:2:1: error: "));
}

TEST(EditImport, BytesThatAreNoTextAreAnsweredInText) {
  SimulatedDisk disk({{"m.toml", move_text}});
  json of = request();
  of["bytes"] = "//79/AAB/w==";  // ff fe fd fc 00 01 ff
  EXPECT_FALSE(Opened(disk).ask(of).at("refused").empty());
  of["file"] = "x.csv";
  of["bytes"] = "ZnJhbWUsSPZoZQoxLDAKMiwxCg==";  // "frame,H\xf6he\n1,0\n2,1\n"
  EXPECT_THAT(question_of(Opened(disk).ask(of), "axis 1").at("words").get<std::string>(), HasSubstr("he"));
}

TEST(EditImport, AMoveThatCannotBeOpenedIsWrittenAndSaysWhy) {
  SimulatedDisk disk({{"m.toml", move_text}});
  Opened opened(disk);
  opened.session.open_imports_with(
      [](const std::string&) -> std::string { throw std::runtime_error("another program edits it"); });
  const json written = opened.ask(request(all_answers, true)).at("written");
  EXPECT_EQ(written.at("address"), nullptr);
  EXPECT_EQ(written.at("why_not"), "another program edits it");
  EXPECT_TRUE(disk.content().contains("pan.toml"));
}

TEST(EditImport, AMoveThatThePageDoesNotShowIsWrittenAndSaysWhy) {
  SimulatedDisk disk({{"m.toml", move_text}});
  Opened opened(disk);
  opened.session.open_imports_with([](const std::string&) -> std::string {
    ADD_FAILURE() << "it would be opened in vain";
    return "";
  });
  json of = request(all_answers, true);
  std::string base64;
  for (int i = 0; i < 1400; ++i) base64 += "MAowCjAK";  // "0\n0\n0\n"
  of["bytes"] = base64;
  const json written = opened.ask(of).at("written");
  EXPECT_EQ(written.at("address"), nullptr);
  EXPECT_THAT(written.at("why_not").get<std::string>(),
              HasSubstr("the table has 4200 rows on 4199 frames, and the page does not show one of more"));
  EXPECT_TRUE(disk.content().contains("pan.toml"));
}

TEST(EditImport, ARigIsNeededAndThePageOfThisMove) {
  SimulatedDisk disk({{"m.toml", move_text}});
  Opened without(disk, std::nullopt);
  EXPECT_EQ(without.session.import_motion(parse_import_request(request().dump())).status, 422);
  json of = request();
  of["id"] = "another";
  EXPECT_EQ(Opened(disk).session.import_motion(parse_import_request(of.dump())).status, 403);
}

TEST(EditImport, ARequestThatIsNoneIsRefusedByItsMember) {
  const auto refusal = [](const char* member, const json& value) {
    json of = request();
    of[member] = value;
    try {
      static_cast<void>(parse_import_request(of.dump()));
    } catch (const RequestError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refusal("writes", false), "taken");
  EXPECT_THAT(refusal("bytes", "MAo"), HasSubstr("no Base64"));
  EXPECT_THAT(refusal("bytes", "MA=o"), HasSubstr("no Base64"));
  EXPECT_THAT(refusal("bytes", "====").substr(0, 12), "import.bytes");
  EXPECT_THAT(refusal("bytes", 3), HasSubstr("import.bytes"));
  EXPECT_THAT(refusal("file", "a/b.txt"), HasSubstr("import.file"));
  EXPECT_THAT(refusal("file", ""), HasSubstr("import.file"));
  EXPECT_THAT(refusal("answers", json::array()), HasSubstr("import.answers"));
  EXPECT_THAT(refusal("answers", json{{"fps", 24}}), HasSubstr("import.answers"));
  EXPECT_THAT(refusal("writes", "yes"), HasSubstr("import.writes"));
  EXPECT_THAT(refusal("more", 1), HasSubstr("not known"));
  EXPECT_EQ(parse_import_request(request().dump()).bytes, rows);
}

}  // namespace edit_import_test
}  // namespace inbetween
