// An edited move is saved whole or not at all, and never over somebody else's change.
#include "host_tools/edit/edit_session.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/edit/folder_files.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/simulated_disk.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace edit_session_test {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string old_text = R"(name = "slide"
fps = 24
frames = 96
[[track]]
axes = ["x", "y"]
keys = [{ at = [0, 0] }, { at = [40, 30] }, { at = [80, 20] }] # three
speed = [0, 0, 10, 0, 0]
)";
const std::string new_text = R"(name = "slide"
fps = 24
frames = 72
[[track]]
axes = ["x", "y"]
keys = [{ at = [0, 0] }, { at = [45, 30] }, { at = [80, 20] }] # three
speed = [0, 0, 10, 0, 0]
)";

/// The edits that make the new text of the old one, as the page sends them; `second_x` is where the second
/// key goes.
json edits(const std::string& base = old_text, double second_x = 45) {
  const auto key = [](int from, double x, double y) {
    return json{{"from", from},     {"at", {x, y}},    {"tension", 0},   {"continuity", 0}, {"bias", 0},
                {"frame", nullptr}, {"hold", nullptr}, {"break", false}, {"ease", false}};
  };
  return {{"base", base},
          {"frames", 72},
          {"fps", "24"},
          {"tracks",
           {{{"keys", {key(0, 0, 0), key(1, second_x, 30), key(2, 80, 20)}},
             {"speed", nullptr},
             {"spline", "smooth"},
             {"closed", false}}}}};
}

EditRequest request(const json& of) {
  return parse_edit_request(of.dump());
}

struct Opened {
  explicit Opened(SimulatedDisk& disk) : Opened(disk.layer()) {}
  explicit Opened(FileLayer files) : session(std::move(files), "m.toml", std::nullopt) {}

  /// A save by a page that knows the file as `known`.
  EditAnswer save(const std::string& known, bool own, json of = edits()) {
    of["expects"] = revision_of(known);
    of["own"] = own;
    return session.save(request(of));
  }
  EditSession session;
};

json kept(const EditAnswer& answer) {
  EXPECT_EQ(answer.status, 200) << answer.json;
  return json::parse(answer.json).value("kept", json("nothing said"));
}

TEST(EditSession, SavesWhatWasEditedAndNothingElse) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  const EditAnswer saved = opened.session.save(request(edits()));
  EXPECT_EQ(kept(saved), nullptr);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", new_text}}));
  EXPECT_EQ(json::parse(saved.json).at("revision"), revision_of(new_text));
  EXPECT_EQ(json::parse(opened.session.revision().json).at("revision"), revision_of(new_text));
}

TEST(EditSession, ThePageGetsTheTextByteForByteAndItIsEnoughForAnySession) {
  const std::string text = "\xef\xbb\xbf# \"\xc3\xa4\\\t\"\r\n" + old_text;
  SimulatedDisk disk({{"m.toml", text}});
  const json document = json::parse(Opened(disk).session.open().json);
  EXPECT_EQ(document.at("text"), text);
  Opened again(disk);
  EXPECT_EQ(kept(again.session.save(request(edits(document.at("text"))))), nullptr);
  EXPECT_THAT(disk.content().at("m.toml"), StartsWith("\xef\xbb\xbf# \"\xc3\xa4\\\t\"\r\n"));
  const json of_base = json::parse(again.session.document_of_base(text).json);
  EXPECT_EQ(of_base.at("tracks"), document.at("tracks"));
  EXPECT_FALSE(of_base.contains("text"));
}

TEST(EditSession, TheThousandthSaveOfAPageIsAsGoodAsTheFirst) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  std::string known = old_text;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(kept(opened.save(known, true, edits(old_text, 41 + i))), nullptr) << i;
    known = disk.content().at("m.toml");
    ASSERT_THAT(known, HasSubstr(fmt::format("[{}, 30]", 41 + i)));
  }
  EXPECT_EQ(disk.content().size(), 1U);
}

TEST(EditSession, NoFileThatCanBeReadIsTooLargeToBeEdited) {
  // Every character of the comment takes two in JSON.
  std::string large = old_text + "# ";
  large.append(max_file_bytes - large.size() - 1, '"') += '\n';
  SimulatedDisk disk({{"m.toml", large}});
  Opened opened(disk);
  const std::string sent = edits(json::parse(opened.session.open().json).at("text")).dump();
  EXPECT_LE(sent.size(), max_request_bytes);
  EXPECT_EQ(kept(opened.session.save(parse_edit_request(sent))), nullptr);
  EXPECT_THAT(disk.content().at("m.toml"), StartsWith(new_text));
}

TEST(EditSession, WritesNothingOverAnOutsideChange) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  const std::string outside = "# mine\n" + old_text;
  replace_durably(disk.layer(), "m.toml", outside);
  const EditAnswer refused = opened.session.save(request(edits()));
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(json::parse(refused.json).at("revision"), revision_of(outside));
  EXPECT_EQ(opened.save("older still", false).status, 409);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", outside}}));

  EXPECT_EQ(kept(opened.session.keep(request(edits()))), "m.mine-1.toml");
  EXPECT_EQ(disk.content().at("m.mine-1.toml"), new_text);

  EXPECT_EQ(kept(opened.save(outside, false)), "m.outside-1.toml");
  EXPECT_EQ(disk.content().at("m.outside-1.toml"), outside);
  EXPECT_EQ(disk.content().at("m.toml"), new_text);
  EXPECT_EQ(kept(opened.session.keep(request(edits()))), nullptr) << "the file has it";
}

TEST(EditSession, WhatAnotherTabHasSavedIsKeptBeforeItIsReplaced) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  EXPECT_EQ(kept(opened.save(old_text, true, edits(old_text, 50))), nullptr);
  const std::string of_the_first_tab = disk.content().at("m.toml");
  EXPECT_EQ(opened.save(old_text, true).status, 409);
  EXPECT_EQ(kept(opened.save(of_the_first_tab, false)), "m.outside-1.toml");
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", new_text}, {"m.outside-1.toml", of_the_first_tab}}));
}

TEST(EditSession, AnOutsideVersionThatIsNoMoveIsKeptToo) {
  const std::string broken = "frames = = 7\n\xff";
  SimulatedDisk disk({{"m.toml", broken}});
  Opened opened(disk);
  EXPECT_EQ(opened.session.open().status, 422) << "somebody chose to load it first";
  EXPECT_EQ(kept(opened.save(broken, false)), "m.outside-1.toml");
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", new_text}, {"m.outside-1.toml", broken}}));
}

/// As another program does it: a file of its own, and then the name.
void write_as_another(SimulatedDisk& disk, const std::string& text) {
  const FileLayer theirs = disk.layer();
  int descriptor = -1;
  std::size_t written = 0;
  theirs.create("theirs", descriptor);
  theirs.write(descriptor, text, written);
  theirs.rename("theirs", "m.toml");
}

TEST(EditSession, WhatIsWrittenInTheMomentOfTheSaveStaysAndTheSaveIsRefused) {
  SimulatedDisk disk({{"m.toml", old_text}});
  FileLayer files = disk.layer();
  const std::string outside = "# in that moment\n" + old_text;
  bool has_come = false;
  files.swap = [&, swap = files.swap](const std::string& one, const std::string& other) {
    if (!std::exchange(has_come, true)) write_as_another(disk, outside);
    return swap(one, other);
  };
  Opened opened(files);
  EXPECT_EQ(opened.save(old_text, true).status, 409);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", outside}}));
  EXPECT_EQ(kept(opened.save(outside, false)), "m.outside-1.toml");
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", new_text}, {"m.outside-1.toml", outside}}));
}

TEST(EditSession, ASecondChangeWhileTheFirstIsPutBackIsKeptToo) {
  SimulatedDisk disk({{"m.toml", old_text}});
  FileLayer files = disk.layer();
  int writes = 0;
  files.swap = [&, swap = files.swap](const std::string& one, const std::string& other) {
    write_as_another(disk, fmt::format("# change {}\n{}", ++writes, old_text));
    return swap(one, other);
  };
  Opened opened(files);
  EXPECT_EQ(opened.save(old_text, true).status, 409);
  EXPECT_EQ(writes, 2);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", "# change 1\n" + old_text},
                                         {part_of("m.toml"), "# change 2\n" + old_text}}));
}

TEST(EditSession, AFileThatComesInTheMomentInWhichItIsSavedAnewStays) {
  SimulatedDisk disk;
  FileLayer files = disk.layer();
  files.rename_new = [&, rename = files.rename_new](const std::string& from, const std::string& to) {
    write_as_another(disk, "# theirs\n");
    return rename(from, to);
  };
  Opened opened(files);
  json asked = edits();
  asked["expects"] = "gone";
  EXPECT_EQ(opened.session.save(request(asked)).status, 409);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", "# theirs\n"}}));
}

TEST(EditSession, WhereNamesCannotBeSwappedAChangeBeforeTheSaveIsStillSeen) {
  SimulatedDisk disk({{"m.toml", old_text}});
  FileLayer files = disk.layer();
  std::string outside;
  files.swap = [&](const std::string&, const std::string&) {
    if (!outside.empty()) replace_durably(disk.layer(), "m.toml", outside);
    return EINVAL;
  };
  Opened opened(files);
  EXPECT_EQ(kept(opened.save(old_text, true)), nullptr);
  EXPECT_EQ(disk.content().at("m.toml"), new_text);
  outside = "# in that moment\n" + old_text;
  EXPECT_EQ(opened.save(new_text, true, edits(old_text, 60)).status, 409);
  EXPECT_EQ(disk.content().at("m.toml"), outside);
}

TEST(EditSession, AFileThatIsGoneIsToldAndSavedAnewOnlyIfThatIsAsked) {
  SimulatedDisk disk;
  Opened opened(disk);
  EXPECT_EQ(opened.session.open().status, 404);
  EXPECT_EQ(json::parse(opened.session.revision().json).at("revision"), "gone");
  const EditAnswer refused = opened.save(old_text, true);
  EXPECT_EQ(refused.status, 409);
  json asked = edits();
  asked["expects"] = json::parse(refused.json).at("revision");
  EXPECT_EQ(kept(opened.session.save(request(asked))), nullptr);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", new_text}}));
}

TEST(EditSession, ASaveWhoseAnswerWasLostIsDoneWhenItIsAskedForAgain) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  EXPECT_EQ(kept(opened.save(old_text, true)), nullptr);
  const EditAnswer again = opened.save(old_text, true);
  EXPECT_EQ(kept(again), nullptr);
  EXPECT_EQ(json::parse(again.json).at("revision"), revision_of(new_text));
}

TEST(EditSession, WhatCannotBeSolvedIsNotSavedAndComesAsText) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  json unsolvable = edits();
  unsolvable["tracks"][0]["keys"][0]["frame"] = 40;
  unsolvable["tracks"][0]["keys"][1]["frame"] = 20;
  const EditAnswer refused = opened.session.save(request(unsolvable));
  EXPECT_EQ(refused.status, 422);
  EXPECT_THAT(json::parse(refused.json).at("error").get<std::string>(),
              AllOf(HasSubstr("frame"), Not(HasSubstr("\n"))));
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", old_text}}));
  const EditAnswer text = opened.session.text(request(unsolvable));
  EXPECT_EQ(text.status, 200) << text.json;
  EXPECT_THAT(json::parse(text.json).at("text").get<std::string>(),
              AllOf(HasSubstr("frame = 40"), HasSubstr("# three")));
}

TEST(EditSession, APowerCutAtEveryOperationOfASaveLeavesTheOldFileOrTheNewOne) {
  std::size_t operations = 0;
  {
    SimulatedDisk disk({{"m.toml", old_text}});
    Opened opened(disk);
    const std::size_t before = disk.operations();
    EXPECT_EQ(opened.session.save(request(edits())).status, 200);
    operations = disk.operations() - before;
    EXPECT_EQ(disk.after_power_cut("m.toml"), (std::set<std::optional<std::string>>{new_text}));
  }
  ASSERT_GT(operations, new_text.size());
  for (std::size_t operation = 0; operation < operations; ++operation) {
    SimulatedDisk disk({{"m.toml", old_text}});
    Opened opened(disk);
    disk.cut_power_at(disk.operations() + operation);
    EXPECT_THROW(opened.session.save(request(edits())), PowerCut);
    for (const std::optional<std::string>& there : disk.after_power_cut("m.toml")) {
      EXPECT_TRUE(there == old_text || there == new_text) << operation << ": " << there.value_or("no file");
    }
  }
}

/// Whether a text is somewhere on the disk, as programs see it.
bool has(const SimulatedDisk& disk, const std::string& text) {
  const DiskContent content = disk.content();
  return std::ranges::any_of(content, [&](const auto& file) { return file.second == text; });
}

TEST(EditSession, AFullDiskIsToldAndTheOldFileStaysAtEveryOperation) {
  const std::string outside = "# from elsewhere\n" + old_text;
  std::size_t failed = 0;
  for (std::size_t operation = 0;; operation += 7) {
    SimulatedDisk disk({{"m.toml", outside}});
    Opened opened(disk);
    disk.fail_at(disk.operations() + operation, ENOSPC, true);
    const EditAnswer answer = opened.save(outside, false);
    EXPECT_TRUE(has(disk, outside)) << operation;
    if (answer.status == 200) {
      EXPECT_EQ(disk.content().at("m.toml"), new_text);
      break;
    }
    ++failed;
    EXPECT_EQ(answer.status, 500) << operation;
    EXPECT_THAT(answer.json, HasSubstr("No space left on device"));
    const std::string there = disk.content().at("m.toml");
    EXPECT_TRUE(there == outside || there == new_text) << operation;
  }
  EXPECT_GT(failed, 20U);
}

TEST(EditSession, WhatAnInterruptedSaveHasLeftIsKeptByTheNext) {
  SimulatedDisk disk({{"m.toml", new_text}, {part_of("m.toml"), "# only here\n"}});
  Opened opened(disk);
  EXPECT_EQ(opened.save(new_text, true, edits(old_text, 60)).status, 200);
  EXPECT_TRUE(has(disk, "# only here\n"));
  EXPECT_FALSE(disk.content().contains(part_of("m.toml")));
}

TEST(EditSession, AFileOfAnotherProgramBesideItIsLeftAlone) {
  SimulatedDisk disk({{"m.toml", old_text}, {"m.toml.part", "# a download of somebody else\n"}});
  Opened opened(disk);
  EXPECT_EQ(kept(opened.save(old_text, true)), nullptr);
  EXPECT_EQ(disk.content(),
            (DiskContent{{"m.toml", new_text}, {"m.toml.part", "# a download of somebody else\n"}}));
}

TEST(EditSession, ADiskThatWasFullForATimeLeavesNothingBehind) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  disk.fail_at(disk.operations() + 2, ENOSPC, false);
  EXPECT_EQ(opened.session.save(request(edits())).status, 500);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", old_text}}));
  EXPECT_EQ(kept(opened.session.save(request(edits()))), nullptr);
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", new_text}}));
}

/// Pages of several tabs, other programs, disks that fail: every text that was in the file and that no page
/// holds is found somewhere.
TEST(EditSession, NothingThatWasInTheFileIsLostInAThousandRandomSequences) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    std::mt19937 random(seed);
    const auto below = [&](unsigned end) { return random() % end; };
    SimulatedDisk disk({{"m.toml", old_text}});
    FileLayer files = disk.layer();
    std::vector<std::string> was_there;
    unsigned writes = 0;
    const auto write_outside = [&] {
      const std::string text = fmt::format("# {}\n{}", ++writes, below(3) == 0 ? "= broken" : old_text);
      std::erase(was_there, disk.content().at("m.toml"));  // whoever replaces it has to answer for it
      was_there.push_back(text);
      write_as_another(disk, text);
    };
    bool writes_in_between = false;
    bool fails = false;
    std::size_t failing = 0;
    files.swap = [&, swap = files.swap](const std::string& one, const std::string& other) {
      if (std::exchange(writes_in_between, false)) write_outside();
      return swap(one, other);
    };
    files.write = [&, write = files.write](int descriptor, std::string_view bytes, std::size_t& written) {
      if (fails && failing-- == 0) return failing = 0, ENOSPC;
      return write(descriptor, bytes.substr(0, 40), written);
    };
    std::optional<Opened> opened(files);
    struct Page {
      std::set<std::string> texts = {old_text};
      std::string known = old_text;
    };
    std::array<Page, 2> pages;
    for (int step = 0; step < 12; ++step) {
      Page& page = pages.at(below(2));
      switch (below(6)) {
        case 0:
          write_outside();
          break;
        case 1:
          fails = !fails;
          failing = below(8);
          break;
        case 2:
          opened.emplace(files);
          break;  // a program started anew
        case 3:
          writes_in_between = true;
          break;
        default: {
          const std::string there = disk.content().at("m.toml");
          const json of = edits(old_text, 41 + static_cast<int>(seed % 7) + step);
          const bool mine = page.known == there;
          if (!mine && below(2) == 0) {
            EXPECT_EQ(opened->save(page.known, true, of).status, 409);
            break;
          }
          const EditAnswer answer = opened->save(there, mine, of);
          ASSERT_THAT(answer.status, testing::AnyOf(200, 409, 500)) << answer.json;
          const std::string text = json::parse(opened->session.text(request(of)).json).at("text");
          page.texts.insert(text);  // whether it is saved or not, the page has it
          if (disk.content().at("m.toml") == text) page.known = text;
        }
      }
      for (const std::string& text : was_there) ASSERT_TRUE(has(disk, text)) << step << ": " << text;
      const std::string there = disk.content().at("m.toml");
      ASSERT_TRUE(there == old_text || std::ranges::count(was_there, there) > 0 ||
                  pages[0].texts.contains(there) || pages[1].texts.contains(there))
          << "the file is whole";
      if (std::ranges::none_of(pages, [&](const Page& one) { return one.texts.contains(there); }))
        was_there.push_back(there);
    }
  }
}

TEST(EditSession, RefusesWhatItDoesNotKnow) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  EXPECT_EQ(opened.session.save(request(edits("no move"))).status, 422);
  json wrong = edits();
  wrong["tracks"][0]["keys"][0]["from"] = 7;
  EXPECT_EQ(opened.session.save(request(wrong)).status, 400);
  EXPECT_EQ(opened.session.fit(request(edits())).status, 422) << "there is no rig";
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", old_text}}));

  for (const char* text :
       {"", "{", "[]", "7", "null", R"({"base":7})", R"({"base":"x","frames":1e99,"fps":"24","tracks":[]})",
        R"({"base":"x","frames":10,"fps":"24\"\nname=\"y","tracks":[]})",
        R"({"base":"x","frames":10,"fps":"24","tracks":[],"own":"yes"})",
        R"({"base":"x","frames":10,"fps":"24","tracks":[],"path":"/etc/passwd"})",
        R"({"base":"x","frames":10,"fps":"24","tracks":[[[[[[[[[[[[1]]]]]]]]]]]]})"}) {
    EXPECT_THROW(parse_edit_request(text), RequestError) << text;
  }
  for (const char* text : {"", "{}", R"({"base":7})", R"({"base":"x","frames":1})"})
    EXPECT_THROW(parse_base(text), RequestError) << text;
}

TEST(EditSession, TheSolvedDocumentHasTheFitAndTheFewestFrames) {
  TemporaryFolder folder;
  const std::string whip =
      "name = \"whip\"\nfps = 24\nframes = 60\n[[track]]\naxes = [\"pan\"]\n"
      "keys = [{ at = [-60] }, { at = [60] }]\nspeed = [0, 0, 10, 4, 2, 0, 0]\n";
  SimulatedDisk disk({{"m.toml", whip}});
  EditSession session(disk.layer(), "m.toml", in_checkout("examples/camera_rig.toml"));
  const json document = json::parse(session.open().json);
  EXPECT_EQ(document.at("axes").at(0).at("unit"), "deg");
  EXPECT_EQ(document.at("tracks").at(0).at("live"), true);
  const json asked{{"base", document.at("text")},
                   {"frames", 60},
                   {"fps", "24"},
                   {"tracks",
                    {{{"keys", document.at("tracks").at(0).at("keys")},
                      {"speed", nullptr},
                      {"spline", "smooth"},
                      {"closed", false}}}}};
  const EditAnswer fitted = session.fit(request(asked));
  ASSERT_EQ(fitted.status, 200) << fitted.json;
  EXPECT_NE(json::parse(fitted.json).at("tracks").at(0).at("speed"), document.at("tracks").at(0).at("speed"));
  EXPECT_EQ(json::parse(session.fewest(request(asked)).json).at("frames"), 90) << "as README.md says of it";
}

// The page sees new limits as it sees a changed move: by their revision.
TEST(EditSession, TheLimitsAreThoseThatTheRigsFileHasNow) {
  const TemporaryFile rig("rig.toml", file_contents(in_checkout("examples/camera_rig.toml")));
  const std::string turn =
      "name = \"turn\"\nfps = 24\nframes = 60\n[[track]]\naxes = [\"pan\"]\n"
      "keys = [{ at = [-60] }, { at = [60] }]\nspeed = [0, 0, 10, 0, 0]\n";
  SimulatedDisk disk({{"m.toml", turn}});
  EditSession session(disk.layer(), "m.toml", rig.path().string());
  const auto revision = [&] { return json::parse(session.revision().json); };
  const auto limit = [&] {
    return json::parse(session.document_of_base(turn).json)["axes"][0]["limits"]["max_velocity"];
  };
  const std::string rig_text = file_contents(rig.path().string());
  const auto write_rig = [&](const std::string& text) { std::ofstream(rig.path()) << text; };
  EXPECT_EQ(limit(), 90);
  const json first = revision();
  EXPECT_EQ(json::parse(session.open().json)["rig"]["revision"], first["rig"]);
  EXPECT_EQ(first["rig_error"], nullptr);

  std::string slower = rig_text;
  slower.replace(slower.find("max_velocity = 90.0"), 19, "max_velocity = 45.0");
  write_rig(slower);
  EXPECT_NE(revision()["rig"], first["rig"]);
  EXPECT_EQ(limit(), 45);

  write_rig("[[axis]]\n");
  EXPECT_THAT(revision()["rig_error"].get<std::string>(), HasSubstr("rig.toml:1"));
  EXPECT_EQ(limit(), 45) << "until the file can be read again";
  std::filesystem::remove(rig.path());
  EXPECT_THAT(revision()["rig_error"].get<std::string>(), HasSubstr("rig.toml"));
  write_rig(rig_text);
  EXPECT_EQ(revision(), first);
  EXPECT_EQ(limit(), 90);
}

TEST(FolderFiles, NothingOutsideTheFolderIsReachedByAnyName) {
  TemporaryFolder outside;
  TemporaryFolder folder;
  const auto write = [](const std::filesystem::path& path) { std::ofstream(path) << "x"; };
  write(outside.path() / "secret");
  write(folder.path() / "own");
  std::filesystem::create_directory(folder.path() / "below");
  std::filesystem::create_symlink(outside.path() / "secret", folder.path() / "link");
  std::filesystem::create_symlink(outside.path(), folder.path() / "way_out");
  const FileLayer files = files_beneath(folder.path().string());
  std::string bytes;
  EXPECT_EQ(files.read("own", 10, bytes), 0);
  int descriptor = -1;
  const std::string secret = (outside.path() / "secret").string();
  const std::string relative = "../" + outside.path().filename().string() + "/secret";
  for (const std::string& name : {secret, relative, "below/../" + relative, std::string("link"),
                                  std::string("way_out/secret"), std::string("/proc/self/root") + secret}) {
    EXPECT_NE(files.read(name, 10, bytes), 0) << name;
    EXPECT_NE(files.create(name, descriptor), 0) << name;
    EXPECT_NE(files.rename("own", name == "link" ? "./link" : name), 0) << name;
  }
  EXPECT_EQ(file_contents(secret), "x");
}

/// A folder of a real disk with a move in it, saved by a page.
struct RealFile {
  TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "m.toml";
  Opened opened{files_beneath(folder.path().string())};
  RealFile() { write(old_text); }
  void write(const std::string& text) const { std::ofstream(path) << text; }
  [[nodiscard]] std::string text() const { return file_contents(path.string()); }
  [[nodiscard]] std::ptrdiff_t files() const {
    return std::distance(std::filesystem::directory_iterator(folder.path()),
                         std::filesystem::directory_iterator());
  }
};

TEST(EditSession, AWriteProtectedFileIsNotReplaced) {
  RealFile file;
  std::filesystem::permissions(file.path, std::filesystem::perms{0444});
  const EditAnswer refused = file.opened.save(old_text, true);
  EXPECT_EQ(refused.status, 500);
  EXPECT_THAT(refused.json, HasSubstr("m.toml is write-protected (chmod u+w lets it be written)"));
  EXPECT_EQ(file.text(), old_text);
  std::filesystem::permissions(file.path, std::filesystem::perms{0644});
  EXPECT_EQ(kept(file.opened.save(old_text, true)), nullptr);
  EXPECT_EQ(file.text(), new_text);
  EXPECT_EQ(file.files(), 1);
}

TEST(EditSession, AFileThatAnotherProgramIsStillWritingIsNotReplaced) {
  RealFile file;
  {
    std::ofstream theirs(file.path, std::ios::in | std::ios::out);  // opened, and nothing written yet
    const EditAnswer refused = file.opened.save(old_text, true);
    EXPECT_EQ(refused.status, 500);
    EXPECT_THAT(refused.json, HasSubstr("m.toml is being written by another program"));
    theirs << "# theirs";
  }
  EXPECT_EQ(file.text(), "# theirs" + old_text.substr(8));
  EXPECT_EQ(file.opened.save(old_text, true).status, 409);
  EXPECT_EQ(file.files(), 1);
}

TEST(FolderFiles, ASavedFileKeepsThePermissionsOfTheOldOne) {
  TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "move.toml";
  const FileLayer files = files_beneath(folder.path().string());
  ASSERT_FALSE(replace_durably(files, "move.toml", "new"));
  for (const auto mode : {std::filesystem::perms{0600}, std::filesystem::perms{0664}}) {
    std::filesystem::permissions(path, mode);
    ASSERT_FALSE(replace_durably(files, "move.toml", "saved"));
    EXPECT_EQ(std::filesystem::status(path).permissions(), mode);
    EXPECT_EQ(file_contents(path.string()), "saved");
  }
  if (::geteuid() != 0) return;  // whoever else it belongs to
  ASSERT_EQ(::chown(path.c_str(), 12, 34), 0);
  ASSERT_FALSE(replace_durably(files, "move.toml", "saved"));
  struct stat status = {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 12U);
  EXPECT_EQ(status.st_gid, 34U);
}

}  // namespace edit_session_test
}  // namespace inbetween
