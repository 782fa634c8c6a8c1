// Where axes rest is kept through a power cut at any moment: what is read afterwards is the old position, the
// new one, or none; never a wrong one.
#include "host_tools/reference/position_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "host_tools/text/text_file.hpp"
#include "tests/support/property.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/simulated_disk.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace position_file_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const std::string slider = rig_text(
    {axis_text(
         "slide", "mm", {0, 800}, {.velocity = 100, .acceleration = 200},
         R"(home = { chip = "head", line = 23, direction = "negative", fast = 20, slow = 2, back_off = 5, at = 3 })",
         R"(type = "step-dir", chip = "head", step = 17, dir = 27, steps_per_unit = 80)"),
     axis_text("track", "mm", {0, 1500}, {.velocity = 400, .acceleration = 800}, R"(reference = "drive")",
               cia402_text(1)),
     axis_text("head pan", "deg", {-90, 90}, {.velocity = 60, .acceleration = 120}, "",
               R"(type = "pipe", path = "/dev/ttyACM0", counts_per_unit = 10)")},
    {.name = "slider", .rate_hz = 250, .more = bus_can0});
constexpr std::size_t slide = 0;
constexpr std::size_t track = 1;
constexpr std::size_t pan = 2;

const std::string path = "/state/slider.positions";

const RigFile& rig() {
  static const RigFile read = parse_rig(slider, "slider.toml");
  return read;
}

RigFile changed_rig(std::string_view from, std::string_view to) {
  return parse_rig(with(slider, from, to), "slider.toml");
}

using Positions = std::vector<std::optional<double>>;

Positions positions_of(const PositionFile& file) {
  Positions positions;
  for (const KnownAxis& axis : file.axes()) positions.push_back(axis.position);
  return positions;
}

/// The text of a file in which slide rests at 5600 and pan at -20.5.
std::string kept_text() {
  SimulatedDisk disk;
  PositionFile file(path, rig(), disk.layer());
  file.at_rest(std::vector<PositionFile::Rest>{{slide, 5600.0}, {pan, -20.5}});
  return disk.content().at(path);
}

PositionFile opened(const std::string& text, const RigFile& of_rig = rig()) {
  SimulatedDisk disk(DiskContent{{path, text}});
  return PositionFile(path, of_rig, disk.layer());
}

std::string why_unreferenced(const PositionFile& file) {
  for (const KnownAxis& axis : file.axes()) {
    EXPECT_FALSE(axis.position.has_value());
    EXPECT_EQ(axis.why, file.axes().front().why);
  }
  return file.axes().front().why;
}

/// `body` with the check sum that belongs to it (FNV-1a, 64 bits, worked out here once more).
std::string with_sum(const std::string& body) {
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (const char c : body) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return fmt::format("{}sum {:016x}\n", body, sum);
}

// ---- what is kept

TEST(PositionFile, KeepsTheAxesWhosePositionNoDriveKnows) {
  EXPECT_THAT(kept_axes(rig()), ElementsAre(slide, pan));
  EXPECT_THAT(
      kept_axes(parse_rig(slider + "[[axis]]\nname = \"lift\"\nunit = \"mm\"\nmin = 0\nmax = 1\n"
                                   "max_velocity = 1\nmax_acceleration = 1\nreference = \"operator\"\n"
                                   "drive = { type = \"cia402\", bus = \"can0\", node = 2, "
                                   "counts_per_unit = 1 }\n",
                          "r")),
      ElementsAre(slide, pan, 3));
}

TEST(PositionFile, WhatWasKeptIsReadAgain) {
  const PositionFile file = opened(kept_text());
  EXPECT_THAT(positions_of(file), ElementsAre(5600.0, -20.5));
  EXPECT_EQ(file.axes().at(1).axis, pan);
  EXPECT_EQ(file.axes().at(1).why, "");
}

TEST(PositionFile, IsATextThatAPersonCanRead) {
  const std::string body =
      fmt::format("inbetween positions 2\nrig {:016x} slider\nat 5600 slide\nat -20.5 head pan\n",
                  position_identity(rig()));
  EXPECT_EQ(kept_text(), with_sum(body));
}

TEST(PositionFile, AMovingAxisHasNoNumber) {
  SimulatedDisk disk(DiskContent{{path, kept_text()}});
  PositionFile file(path, rig(), disk.layer());
  file.about_to_move(std::vector<std::size_t>{slide, track});
  EXPECT_THAT(disk.content().at(path), HasSubstr("\nmoving slide\nat -20.5 head pan\n"));
  EXPECT_THAT(positions_of(file), ElementsAre(std::nullopt, -20.5));
  const PositionFile after = opened(disk.content().at(path));
  EXPECT_THAT(positions_of(after), ElementsAre(std::nullopt, -20.5));
  EXPECT_EQ(after.axes().at(0).why, "it was moving when the power was cut or the program ended");
}

TEST(PositionFile, HowTheDrivesOfAnAxisCountStandsBelowIt) {
  SimulatedDisk disk;
  PositionFile file(path, rig(), disk.layer());
  file.at_rest(std::vector<PositionFile::Rest>{{slide, 7.0, {-1200, 0.1}}, {pan, 2.0, {}}});
  EXPECT_THAT(disk.content().at(path), HasSubstr("\nat 7 slide\nzero -1200 0.1\nat 2 head pan\n"));
  const PositionFile after = opened(disk.content().at(path));
  EXPECT_THAT(after.axes().at(0).zeros, ElementsAre(-1200, 0.1));
  EXPECT_THAT(after.axes().at(1).zeros, IsEmpty());
  file.about_to_move(std::vector<std::size_t>{slide});
  EXPECT_THAT(disk.content().at(path), HasSubstr("\nmoving slide\nat 2 head pan\n"));
  file.at_rest(std::vector<PositionFile::Rest>{{slide, std::nullopt, {3}}});
  EXPECT_THAT(file.axes().at(0).zeros, IsEmpty()) << "nobody knows from where it counts";
}

TEST(PositionFile, AnAxisCanBecomeUnreferenced) {
  SimulatedDisk disk(DiskContent{{path, kept_text()}});
  PositionFile file(path, rig(), disk.layer());
  file.at_rest(std::vector<PositionFile::Rest>{{slide, std::nullopt}});
  EXPECT_THAT(disk.content().at(path), HasSubstr("\nunreferenced slide\nat -20.5 head pan\n"));
  const PositionFile after = opened(disk.content().at(path));
  EXPECT_THAT(positions_of(after), ElementsAre(std::nullopt, -20.5));
  EXPECT_EQ(after.axes().at(0).why, "nobody has said where it is");
}

TEST(PositionFile, AMotionOfDrivesThatKnowTouchesNoFile) {
  SimulatedDisk disk;
  PositionFile file(path, rig(), disk.layer());
  file.about_to_move(std::vector<std::size_t>{track});
  EXPECT_EQ(disk.operations(), 0U);
}

TEST(PositionFile, OnlyAKeptAxisRestsAtANumber) {
  SimulatedDisk disk;
  PositionFile file(path, rig(), disk.layer());
  EXPECT_THROW(file.at_rest(std::vector<PositionFile::Rest>{{track, 1.0}}), std::logic_error);
  for (const double position : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(file.at_rest(std::vector<PositionFile::Rest>{{slide, position}}), std::logic_error);
  }
  EXPECT_EQ(disk.operations(), 0U);
}

// ---- what is not believed

TEST(PositionFile, AMissingFileLeavesEveryAxisUnreferenced) {
  SimulatedDisk disk;
  const PositionFile file(path, rig(), disk.layer());
  EXPECT_EQ(why_unreferenced(file), "no position has been kept for it in /state/slider.positions");
  EXPECT_EQ(disk.operations(), 0U) << "reading writes nothing";
}

TEST(PositionFile, AFileThatCannotBeReadLeavesEveryAxisUnreferenced) {
  SimulatedDisk disk;
  FileLayer files = disk.layer();
  files.read = [](const std::string&, std::size_t, std::string&) { return EACCES; };
  EXPECT_EQ(why_unreferenced(PositionFile(path, rig(), files)), path + " cannot be read: Permission denied");
  const std::string huge = kept_text() + std::string(max_position_bytes, ' ');
  EXPECT_EQ(why_unreferenced(opened(huge)), path + " cannot be read: File too large");
}

TEST(PositionFile, AnotherRigsFileIsNotBelieved) {
  EXPECT_EQ(why_unreferenced(opened(kept_text(), changed_rig("\"slider\"", "\"crane\""))),
            path + " is of another rig, \"slider\"");
}

TEST(PositionFile, AFileOfOtherAxesIsNotBelieved) {
  EXPECT_EQ(why_unreferenced(opened(kept_text(), changed_rig("\"slide\"", "\"dolly\""))),
            "the rig had other axes when " + path + " was written");
}

TEST(PositionFile, ARigThatHasChangedIsUnreferenced) {
  const std::vector<std::pair<const char*, const char*>> changes = {
      {"steps_per_unit = 80", "steps_per_unit = -80"},
      {"steps_per_unit = 80", "steps_per_unit = 80.5"},
      {"step = 17", "step = 18"},
      {"dir = 27", "dir = \"DIR\""},
      {"chip = \"head\", step", "chip = \"foot\", step"},
      {"line = 23", "line = 24"},
      {"at = 3", "at = 4"},
      {"\"negative\"", "\"positive\""},
      {"unit = \"deg\"", "unit = \"turn\""},
      {"/dev/ttyACM0", "/dev/ttyACM1"},
      {"counts_per_unit = 10 ", "counts_per_unit = 11 "},
      {"type = \"pipe\", path = \"/dev/ttyACM0\", counts_per_unit = 10",
       "type = \"step-dir\", chip = \"head\", step = 1, dir = 2, steps_per_unit = 10"}};
  for (const auto& [from, to] : changes) {
    EXPECT_EQ(why_unreferenced(opened(kept_text(), changed_rig(from, to))),
              "a unit, a drive or a home of the rig has changed since " + path + " was written")
        << from << " -> " << to;
  }
}

TEST(PositionFile, LimitsOfTheRigAndItsOtherAxesMayChange) {
  for (const auto& [from, to] :
       std::vector<std::pair<const char*, const char*>>{{"max = 800", "max = 700"},
                                                        {"max_velocity = 60", "max_velocity = 50"},
                                                        {"node = 1", "node = 2"},
                                                        {"rate_hz = 250", "rate_hz = 500"},
                                                        {"\"track\"", "\"rail\""},
                                                        {"fast = 20", "fast = 10"}}) {
    EXPECT_THAT(positions_of(opened(kept_text(), changed_rig(from, to))), ElementsAre(5600.0, -20.5)) << to;
  }
}

TEST(PositionFile, AnotherVersionIsNotBelieved) {
  const std::string text = kept_text();
  const std::string body = text.substr(0, text.rfind("sum "));
  EXPECT_EQ(why_unreferenced(opened(with_sum(with(body, "positions 2", "positions 1")))),
            path + " is of another version of this program");
}

TEST(PositionFile, OnlyItsOwnTextIsBelieved) {
  const std::string text = kept_text();
  const std::string body = text.substr(0, text.rfind("sum "));
  ASSERT_THAT(positions_of(opened(with_sum(body))), ElementsAre(5600.0, -20.5));
  for (const char* number :
       {"05600", "+5600", "5.6e3", "5600.0", "0x15e0", "inf", "nan", "", " 5600", "1e999", "-"}) {
    EXPECT_THAT(why_unreferenced(opened(with_sum(with(body, "at 5600 ", fmt::format("at {} ", number))))),
                StartsWith(path + " is damaged"))
        << number;
  }
  for (const std::string& bad :
       {with(body, "at 5600", "At 5600"), with(body, "at 5600", "at"), with(body, "at 5600", "moving 5600"),
        with(body, "rig ", "rig  "), with(body, "rig ", "rig F"), body + "\n", body + "moving",
        body + "moving x", with(body, "2\nrig", "2\n\nrig"), with(body, "positions 2", "positions 2 "),
        std::string("inbetween positions 2\n")}) {
    why_unreferenced(opened(with_sum(bad)));
  }
  EXPECT_EQ(why_unreferenced(opened(with(text, "5600", "5601"))),
            path + " is damaged: its check sum is not that of its text");
  EXPECT_EQ(why_unreferenced(opened("")), path + " is empty");
  EXPECT_EQ(why_unreferenced(opened("0\n")), path + " is no position file");
}

TEST(PositionFile, AChangeOfAnyByteIsNoticed) {
  const std::string text = kept_text();
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      why_unreferenced(opened(damaged));
    }
    why_unreferenced(opened(text.substr(0, i)));
    why_unreferenced(opened(text.substr(i + 1)));
    why_unreferenced(opened(text.substr(0, i) + '\0' + text.substr(i)));
  }
}

TEST(PositionFileProperty, GarbageIsUnreferenced) {
  check_property(2000, [] {
    const std::string text = kept_text();
    std::string garbage = *rc::gen::arbitrary<std::string>();
    if (*rc::gen::arbitrary<bool>()) {  // a piece of a good file with garbage in it
      const auto from = *rc::gen::inRange<std::size_t>(0, text.size());
      const auto to = *rc::gen::inRange<std::size_t>(from, text.size() + 1);
      garbage = text.substr(0, from) + garbage + text.substr(to);
    }
    RC_PRE(garbage != text);
    RC_ASSERT(positions_of(opened(garbage)) == (Positions{std::nullopt, std::nullopt}));
  });
}

TEST(PositionFileProperty, GarbageWithAGoodCheckSumIsReadOnlyAsItIsWritten) {
  check_property(2000, [] {
    const auto lines = *rc::gen::container<std::vector<std::string>>(rc::gen::element<std::string>(
        "at 1 slide", "at -0 slide", "at 1e5 slide", "at 100000 slide", "moving slide", "moving",
        "unreferenced x", "", "rig 00 x", "rig 0000000000000000 x", "at 1  y", "zero 1", "zero 1 -2.5",
        "zero", "zero 01", "zero nan"));
    std::string body = "inbetween positions 2\nrig 00000000000000ff slider\n";
    for (const std::string& line : lines) body += line + '\n';
    const auto parsed = parse_positions(with_sum(body));
    if (const auto* kept = std::get_if<KeptPositions>(&parsed)) RC_ASSERT(to_text(*kept) == with_sum(body));
  });
}

TEST(PositionFileProperty, EveryPositionComesBackToTheLastBit) {
  check_property(2000, [] {
    const auto bits = *rc::gen::arbitrary<std::int64_t>();
    const double position =
        *rc::gen::arbitrary<bool>() ? std::bit_cast<double>(bits) : static_cast<double>(bits >> 11);
    RC_PRE(std::isfinite(position));
    SimulatedDisk disk;
    PositionFile file(path, rig(), disk.layer());
    file.at_rest(std::vector<PositionFile::Rest>{{slide, position}});
    const Positions read = positions_of(PositionFile(path, rig(), disk.layer()));
    RC_ASSERT(std::bit_cast<std::int64_t>(read.at(0).value()) == std::bit_cast<std::int64_t>(position));
    RC_ASSERT(!read.at(1).has_value());
  });
}

// ---- the power is cut

using Allowed = std::set<std::optional<double>>;

/// What may be read of slide and of pan if the power is cut at this moment.
struct Truth {
  Allowed of_slide;
  Allowed of_pan;
};

/// Reads what a disk may have, each text once.
class AfterPowerCut {
 public:
  void expect(const SimulatedDisk& disk, const Truth& truth, const std::string& when) {
    for (const std::optional<std::string>& text : disk.after_power_cut(path)) {
      const Positions& read = positions(text);
      ++checked_;
      if (truth.of_slide.contains(read.at(0)) && truth.of_pan.contains(read.at(1))) continue;
      ADD_FAILURE() << when << ": slide at " << read.at(0).value_or(NAN) << ", pan at "
                    << read.at(1).value_or(NAN) << " is read from\n"
                    << text.value_or("no file");
      return;
    }
  }
  [[nodiscard]] std::size_t checked() const { return checked_; }

 private:
  const Positions& positions(const std::optional<std::string>& text) {
    const auto [found, is_new] = read_.try_emplace(text);
    if (is_new) {
      SimulatedDisk disk(text ? DiskContent{{path, *text}} : DiskContent{});
      const PositionFile file(path, rig(), disk.layer());
      found->second = positions_of(file);
      for (const KnownAxis& axis : file.axes()) EXPECT_EQ(axis.why.empty(), axis.position.has_value());
    }
    return found->second;
  }

  std::map<std::optional<std::string>, Positions> read_;
  std::size_t checked_ = 0;
};

/// A day of a rig: both axes move and rest, then pan alone, then slide, which loses its place. `truth` is
/// kept up with what really is; `between` is called while nothing is being written.
template <typename Between>
void live_a_day(SimulatedDisk& disk, Truth& truth, Between between) {
  const auto one_of = [](const Allowed& before, std::optional<double> after) {
    Allowed both = before;
    both.insert(after);
    return both;
  };
  PositionFile file(path, rig(), disk.layer());
  const auto move = [&](bool slides, bool pans) {
    std::vector<std::size_t> axes;
    if (slides) axes.push_back(slide);
    if (pans) axes.push_back(pan);
    const Truth before = truth;
    if (slides) truth.of_slide = one_of(before.of_slide, std::nullopt);
    if (pans) truth.of_pan = one_of(before.of_pan, std::nullopt);
    try {
      file.about_to_move(axes);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), StartsWith(path + ": error: "));
      between();
      return false;  // and so nothing has moved
    }
    if (slides) truth.of_slide = {std::nullopt};
    if (pans) truth.of_pan = {std::nullopt};
    between();
    return true;
  };
  const auto rest = [&](const std::vector<PositionFile::Rest>& rests) {
    for (const PositionFile::Rest& axis : rests) {
      Allowed& allowed = axis.axis == slide ? truth.of_slide : truth.of_pan;
      allowed = one_of(allowed, axis.position);
    }
    try {
      file.at_rest(rests);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), StartsWith(path + ": error: "));
      between();
      return;
    }
    for (const PositionFile::Rest& axis : rests) {
      (axis.axis == slide ? truth.of_slide : truth.of_pan) = {axis.position};
    }
    between();
  };
  between();
  if (move(true, true)) rest({{slide, 64'000}, {pan, 300}});
  if (move(false, true)) rest({{pan, -450}});
  if (move(true, false)) rest({{slide, std::nullopt}});
}

struct Morning {
  const char* what;
  DiskContent disk;
  Truth truth;
};

std::vector<Morning> mornings() {
  const Truth unknown = {{std::nullopt}, {std::nullopt}};
  const Truth known = {{5600}, {-20.5}};
  const std::string longer = kept_text() + kept_text();
  return {{"no file", {}, unknown},
          {"a file", {{path, kept_text()}}, known},
          {"a file, and a good one half written", {{path, kept_text()}, {part_of(path), longer}}, known},
          {"a half written one alone", {{part_of(path), kept_text()}}, unknown},
          {"a damaged file", {{path, kept_text().substr(9)}}, unknown}};
}

TEST(PositionFilePowerCut, AtEveryByteLeavesTheOldPositionTheNewOneOrNone) {
  AfterPowerCut after;
  for (const Morning& morning : mornings()) {
    SimulatedDisk whole_day(morning.disk);
    Truth truth = morning.truth;
    live_a_day(whole_day, truth, [&] { after.expect(whole_day, truth, morning.what); });
    ASSERT_GT(whole_day.operations(), 600U);

    for (std::size_t operation = 0; operation < whole_day.operations(); ++operation) {
      SimulatedDisk disk(morning.disk);
      disk.cut_power_at(operation);
      truth = morning.truth;
      EXPECT_THROW(live_a_day(disk, truth, [] {}), PowerCut);
      after.expect(disk, truth, fmt::format("{}, cut at operation {}", morning.what, operation));
      if (testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(after.checked(), 3'000U);
}

TEST(PositionFilePowerCut, AfterAnOperationThatFailedLeavesTheOldPositionTheNewOneOrNone) {
  AfterPowerCut after;
  for (const Morning& morning : mornings()) {
    SimulatedDisk whole_day(morning.disk);
    Truth truth = morning.truth;
    live_a_day(whole_day, truth, [] {});
    for (const bool for_good : {false, true}) {
      for (std::size_t operation = 0; operation < whole_day.operations(); ++operation) {
        SimulatedDisk disk(morning.disk);
        disk.fail_at(operation, ENOSPC, for_good);
        truth = morning.truth;
        live_a_day(disk, truth, [&] {
          after.expect(disk, truth, fmt::format("{}, failed at operation {}", morning.what, operation));
        });
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

// ---- the disk refuses

TEST(PositionFile, NothingMayMoveWhereTheMotionCannotBeWrittenDown) {
  for (const auto& [error, words] : std::map<int, std::pair<const char*, const char*>>{
           {ENOSPC, {"No space left on device", "make room on the disk"}},
           {EROFS, {"Read-only file system", "make the folder one that you may write to"}}}) {
    SimulatedDisk disk(DiskContent{{path, kept_text()}});
    PositionFile file(path, rig(), disk.layer());
    disk.fail_at(0, error, true);
    try {
      file.about_to_move(std::vector<std::size_t>{slide});
      ADD_FAILURE() << "it may move";
    } catch (const std::runtime_error& refusal) {
      const std::string line = refusal.what();
      EXPECT_THAT(line, StartsWith(path + ": error: the positions of the axes cannot be kept, "));
      EXPECT_THAT(line, HasSubstr(words.first));
      EXPECT_THAT(line, HasSubstr(words.second));
      EXPECT_EQ(line.find('\n'), std::string::npos);
    }
    EXPECT_THAT(positions_of(file), ElementsAre(5600.0, -20.5)) << "it has not moved";
  }
}

TEST(PositionFile, AnyOperationThatFailsIsTold) {
  const auto is_told = [](std::size_t operation, bool for_good) {
    SimulatedDisk disk;
    PositionFile file(path, rig(), disk.layer());
    disk.fail_at(operation, EIO, for_good);
    try {
      file.about_to_move(std::vector<std::size_t>{slide});
    } catch (const std::runtime_error&) {
      return true;
    }
    return false;
  };
  SimulatedDisk good;
  PositionFile(path, rig(), good.layer()).about_to_move(std::vector<std::size_t>{slide});
  std::size_t passed_over = 0;
  for (std::size_t operation = 0; operation < good.operations(); ++operation) {
    EXPECT_TRUE(is_told(operation, true)) << operation;
    if (!is_told(operation, false)) ++passed_over;
  }
  // A write that stops in the midst is gone on with.
  EXPECT_EQ(passed_over, good.content().at(path).size() - 1);
}

TEST(PositionFile, AFolderThatIsReadOnlyOrNoFolderIsRefused) {
  const TemporaryFile no_folder("state", "");
  PositionFile file((no_folder.path() / "inbetween" / "x.positions").string(), rig());
  EXPECT_THAT(why_unreferenced(file), HasSubstr("cannot be read: Not a directory"));
  EXPECT_THROW(file.about_to_move(std::vector<std::size_t>{slide}), std::runtime_error);

  const TemporaryFolder folder;
  std::filesystem::permissions(folder.path(),
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  if (::access(folder.path().c_str(), W_OK) != 0) {  // root may write everywhere
    PositionFile refused((folder.path() / "x.positions").string(), rig());
    EXPECT_THROW(refused.about_to_move(std::vector<std::size_t>{slide}), std::runtime_error);
  }
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
}

TEST(PositionFile, AFullDeviceIsRefused) {
  FileLayer files = system_files();
  files.create = [](const std::string&, int& descriptor) {
    descriptor = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
    return descriptor < 0 ? errno : 0;
  };
  const TemporaryFolder folder;
  PositionFile file((folder.path() / "x.positions").string(), rig(), files);
  try {
    file.about_to_move(std::vector<std::size_t>{slide});
    ADD_FAILURE() << "it may move";
  } catch (const std::runtime_error& refusal) {
    EXPECT_THAT(refusal.what(), HasSubstr("No space left on device; make room on the disk"));
  }
}

// ---- on a real disk

TEST(PositionFile, IsWrittenToTheDiskInAFolderThatItMakes) {
  const TemporaryFolder folder;
  const std::string real = (folder.path() / "a" / "b" / "slider.positions").string();
  PositionFile file(real, rig());
  file.about_to_move(std::vector<std::size_t>{slide, pan});
  file.at_rest(std::vector<PositionFile::Rest>{{slide, 5600}, {pan, -20.5}});
  EXPECT_EQ(read_text_file(real), kept_text());
  EXPECT_FALSE(std::filesystem::exists(part_of(real)));
  EXPECT_THAT(positions_of(PositionFile(real, rig())), ElementsAre(5600.0, -20.5));
}

TEST(PositionFile, APipeOfItsNameIsNotWaitedFor) {
  const TemporaryFolder folder;
  const std::string pipe = (folder.path() / "slider.positions").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(why_unreferenced(PositionFile(pipe, rig())), HasSubstr("cannot be read: Invalid argument"));
  EXPECT_THAT(why_unreferenced(PositionFile(folder.path().string(), rig())), HasSubstr("Is a directory"));
}

// ---- where it is

TEST(PositionFile, LiesInTheFolderForTheStateOfPrograms) {
  const std::string in_state = position_file_path("my slider/2", "/var/state", "/of/somebody");
  EXPECT_THAT(in_state, testing::MatchesRegex("/var/state/inbetween/my_slider_2-[0-9a-f]{16}\\.positions"));
  const std::string name = std::filesystem::path(in_state).filename().string();
  EXPECT_EQ(position_file_path("my slider/2", nullptr, "/of/somebody"),
            "/of/somebody/.local/state/inbetween/" + name);
  EXPECT_EQ(position_file_path("my slider/2", "", "/of/somebody"),
            "/of/somebody/.local/state/inbetween/" + name);
  EXPECT_EQ(position_file_path("my slider/2", "relative", "/of/somebody"),
            "/of/somebody/.local/state/inbetween/" + name);
  EXPECT_THROW(position_file_path("x", nullptr, nullptr), std::runtime_error);
  EXPECT_THROW(position_file_path("x", "a", "b"), std::runtime_error);
}

TEST(PositionFile, RigsOfDifferentNamesHaveDifferentFiles) {
  const auto file_of = [](const std::string& name) { return position_file_path(name, "/s", nullptr); };
  EXPECT_NE(file_of("a b"), file_of("a_b"));
  EXPECT_NE(file_of(std::string(255, 'x')), file_of(std::string(254, 'x')));
  EXPECT_LT(std::filesystem::path(file_of(std::string(255, 'x'))).filename().string().size(), 100U);
}

}  // namespace position_file_test
}  // namespace inbetween
