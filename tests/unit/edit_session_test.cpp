// An edited move is saved whole or not at all, and never over somebody else's change.
#include "host_tools/edit/edit_session.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host_tools/edit/folder_files.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/simulated_disk.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace edit_session_test {

using nlohmann::json;
using testing::HasSubstr;

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

/// The edits that make the new text of the old one, as the page sends them.
json edits(const std::string& revision) {
  const auto key = [](int from, double x, double y) {
    return json{{"from", from},     {"at", {x, y}},    {"tension", 0},   {"continuity", 0}, {"bias", 0},
                {"frame", nullptr}, {"hold", nullptr}, {"break", false}, {"ease", false}};
  };
  return {{"revision", revision},
          {"frames", 72},
          {"fps", "24"},
          {"tracks",
           {{{"keys", {key(0, 0, 0), key(1, 45, 30), key(2, 80, 20)}},
             {"speed", nullptr},
             {"spline", "smooth"},
             {"closed", false}}}}};
}

EditRequest request(const json& of) {
  return parse_edit_request(of.dump());
}

struct Opened {
  explicit Opened(SimulatedDisk& disk) : session(disk.layer(), "m.toml", std::nullopt, nullptr) {
    revision = json::parse(session.open().json).at("revision").get<std::string>();
  }
  EditSession session;
  std::string revision;
};

TEST(EditSession, SavesWhatWasEditedAndNothingElse) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  const EditAnswer saved = opened.session.save(request(edits(opened.revision)));
  EXPECT_EQ(saved.status, 200) << saved.json;
  EXPECT_EQ(disk.content().at("m.toml"), new_text);
  EXPECT_EQ(json::parse(saved.json).at("revision"), revision_of(new_text));
  EXPECT_EQ(json::parse(opened.session.revision().json).at("revision"), revision_of(new_text));
}

TEST(EditSession, WritesNothingOverAnOutsideChange) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  const std::string outside = "# mine\n" + old_text;
  replace_durably(disk.layer(), "m.toml", outside);
  const EditAnswer refused = opened.session.save(request(edits(opened.revision)));
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(json::parse(refused.json).at("revision"), revision_of(outside));
  EXPECT_EQ(disk.content().at("m.toml"), outside);

  json forced = edits(opened.revision);
  forced["expects"] = "a revision that is older still";
  EXPECT_EQ(opened.session.save(request(forced)).status, 409);
  EXPECT_EQ(disk.content().at("m.toml"), outside);

  EXPECT_EQ(json::parse(opened.session.keep(request(edits(opened.revision))).json).at("kept"),
            "m.mine-1.toml");
  EXPECT_EQ(disk.content().at("m.mine-1.toml"), new_text);

  forced["expects"] = revision_of(outside);
  const EditAnswer saved = opened.session.save(request(forced));
  EXPECT_EQ(saved.status, 200) << saved.json;
  EXPECT_EQ(json::parse(saved.json).at("kept"), "m.outside-1.toml");
  EXPECT_EQ(disk.content().at("m.outside-1.toml"), outside);
  EXPECT_EQ(disk.content().at("m.toml"), new_text);
}

TEST(EditSession, APowerCutAtEveryOperationOfASaveLeavesTheOldFileOrTheNewOne) {
  std::size_t operations = 0;
  {
    SimulatedDisk disk({{"m.toml", old_text}});
    Opened opened(disk);
    const std::size_t before = disk.operations();
    EXPECT_EQ(opened.session.save(request(edits(opened.revision))).status, 200);
    operations = disk.operations() - before;
    EXPECT_EQ(disk.after_power_cut("m.toml"), (std::set<std::optional<std::string>>{new_text}));
  }
  ASSERT_GT(operations, new_text.size());
  for (std::size_t operation = 0; operation < operations; ++operation) {
    SimulatedDisk disk({{"m.toml", old_text}});
    Opened opened(disk);
    disk.cut_power_at(disk.operations() + operation);
    EXPECT_THROW(opened.session.save(request(edits(opened.revision))), PowerCut);
    for (const std::optional<std::string>& there : disk.after_power_cut("m.toml")) {
      EXPECT_TRUE(there == old_text || there == new_text) << operation << ": " << there.value_or("no file");
    }
  }
}

TEST(EditSession, AFullDiskIsToldAndTheOldFileStays) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  disk.fail_at(disk.operations() + 20, ENOSPC, true);
  const EditAnswer refused = opened.session.save(request(edits(opened.revision)));
  EXPECT_EQ(refused.status, 500);
  EXPECT_THAT(refused.json, HasSubstr("No space left on device"));
}

TEST(EditSession, RefusesWhatItDoesNotKnow) {
  SimulatedDisk disk({{"m.toml", old_text}});
  Opened opened(disk);
  EXPECT_EQ(opened.session.save(request(edits("another"))).status, 410);
  json wrong = edits(opened.revision);
  wrong["tracks"][0]["keys"][0]["from"] = 7;
  EXPECT_EQ(opened.session.save(request(wrong)).status, 400);
  EXPECT_EQ(opened.session.fit(request(edits(opened.revision))).status, 422) << "there is no rig";
  EXPECT_EQ(disk.content(), (DiskContent{{"m.toml", old_text}}));

  for (const char* text : {"", "{", "[]", "7", "null", R"({"revision":7})",
                           R"({"revision":"x","frames":1e99,"fps":"24","tracks":[]})",
                           R"({"revision":"x","frames":10,"fps":"24\"\nname=\"y","tracks":[]})",
                           R"({"revision":"x","frames":10,"fps":"24","tracks":[],"path":"/etc/passwd"})",
                           R"({"revision":"x","frames":10,"fps":"24","tracks":[[[[[[[[[[[[1]]]]]]]]]]]]})"}) {
    EXPECT_THROW(parse_edit_request(text), RequestError) << text;
  }
}

TEST(EditSession, TheSolvedDocumentHasTheFitAndTheFewestFrames) {
  TemporaryFolder folder;
  const std::string whip =
      "name = \"whip\"\nfps = 24\nframes = 60\n[[track]]\naxes = [\"pan\"]\n"
      "keys = [{ at = [-60] }, { at = [60] }]\nspeed = [0, 0, 10, 4, 2, 0, 0]\n";
  SimulatedDisk disk({{"m.toml", whip}});
  EditSession session(disk.layer(), "m.toml", read_rig_file(in_checkout("examples/camera_rig.toml")),
                      nullptr);
  const json document = json::parse(session.open().json);
  EXPECT_EQ(document.at("axes").at(0).at("unit"), "deg");
  EXPECT_EQ(document.at("tracks").at(0).at("live"), true);
  const json asked{{"revision", document.at("revision")},
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

TEST(FolderFiles, ASavedFileKeepsThePermissionsOfTheOldOne) {
  TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "move.toml";
  const FileLayer files = files_beneath(folder.path().string());
  ASSERT_FALSE(replace_durably(files, "move.toml", "new"));
  for (const auto mode :
       {std::filesystem::perms{0600}, std::filesystem::perms{0664}, std::filesystem::perms{0444}}) {
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
