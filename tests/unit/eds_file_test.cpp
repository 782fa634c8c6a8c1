// Data sheets of drives (EDS, DCF): what is read of them, where they are wrong, and what a rig's drive lacks
// by its own. The texts have the shapes that makers use, and none is a maker's.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/rig/cia402_kind.hpp"
#include "host_tools/rig/eds_drive.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/eds_text.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace eds_file_test {

using testing::HasSubstr;

EdsFile read(std::string_view text, int node = 5) {
  return parse_eds(text, "drive.eds", node);
}

std::string refusal_of(std::string_view text) {
  try {
    read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

constexpr std::string_view some = R"([FileInfo]
FileName=some.eds
; a comment
[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x00020192 ; with a comment behind it
)";

TEST(EdsFile, AnObjectIsReadWithItsLine) {
  const EdsFile eds = read(some);
  ASSERT_EQ(eds.objects.size(), 1U);
  const EdsObject& object = *eds.find(0x1000, 0);
  EXPECT_EQ(object.value, 0x00020192U);
  EXPECT_EQ(object.size, 4);
  EXPECT_EQ(object.line, 4U);
  EXPECT_TRUE(object.can_be_read);
  EXPECT_FALSE(object.can_be_written);
  EXPECT_EQ(eds.find(0x1000, 1), nullptr);
}

TEST(EdsFile, CapitalsSpacesCrlfAByteOrderMarkAndAMissingEndAreAllTheSame) {
  const EdsFile eds = read(
      "\xEF\xBB\xBF[60c2SUB1]\r\n  parametername = T\xFCr\r\ndatatype= 0x5 \r\nACCESSTYPE "
      "=RWW\r\nDefaultValue=4");
  const EdsObject& object = *eds.find(0x60C2, 1);
  EXPECT_EQ(object.value, 4U);
  EXPECT_EQ(object.size, 1);
  EXPECT_TRUE(object.can_be_written);
}

std::string variable(std::string_view type, std::string_view value) {
  return "[2000]\nDataType=" + std::string(type) + "\nAccessType=rw\nDefaultValue=" + std::string(value) +
         "\n";
}

TEST(EdsFile, NumbersAreDecimalHexadecimalOctalNegativeOrASumWithTheNode) {
  const auto value = [](std::string_view type, std::string_view text) {
    return read(variable(type, text), 5).find(0x2000, 0)->value;
  };
  EXPECT_EQ(value("0x7", "12"), 12U);
  EXPECT_EQ(value("7", "0x1F"), 31U);
  EXPECT_EQ(value("0x0007", "017"), 15U);
  EXPECT_EQ(value("0x7", "$NODEID+0x180"), 0x185U);
  EXPECT_EQ(value("0x7", "0x40000180 + $NodeId"), 0x40000185U);
  EXPECT_EQ(value("0x7", ""), 0U);
  EXPECT_EQ(value("0x4", "-1"), 0xFFFFFFFFU);
  EXPECT_EQ(value("0x3", "-3"), 0xFFFDU);
  EXPECT_EQ(value("0x2", "0xFD"), 0xFDU);
  EXPECT_EQ(value("0x2", "0xFFFFFFFD"), 0xFDU) << "extended to 32 bits";
  EXPECT_EQ(value("0x8", "1.0"), 0x3F800000U);
}

TEST(EdsFile, WhatIsNoNumberOfFourBytesIsBytes) {
  const auto bytes = [](std::string_view type, std::string_view text) {
    return read(variable(type, text)).find(0x2000, 0)->bytes;
  };
  EXPECT_EQ(bytes("0x9", "ab;c"), (std::vector<std::uint8_t>{'a', 'b', ';', 'c'}));
  EXPECT_EQ(bytes("0x1B", "0x0102030405060708"), (std::vector<std::uint8_t>{8, 7, 6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(bytes("0xF", "").size(), 0U);
  EXPECT_EQ(read(variable("0x40", "")).find(0x2000, 0)->size, 0) << "a type of the maker's own";
}

TEST(EdsFile, CompactPartsAreAllThereAndASectionHasTheValuesOfSome) {
  const EdsFile eds = read(
      "[1003]\nObjectType=8\nDataType=7\nAccessType=ro\nCompactSubObj=3\nDefaultValue=9\n"
      "[1003Value]\nNrOfEntries=1\n2=0x22\n");
  ASSERT_EQ(eds.objects.size(), 4U);
  EXPECT_EQ(eds.find(0x1003, 0)->value, 3U);
  EXPECT_EQ(eds.find(0x1003, 0)->size, 1);
  EXPECT_EQ(eds.find(0x1003, 1)->value, 9U);
  EXPECT_EQ(eds.find(0x1003, 2)->value, 0x22U);
}

TEST(EdsFile, ADcfHasTheValuesOfADevice) {
  const EdsFile eds = read(variable("0x7", "1") + "ParameterValue=2\n");
  EXPECT_EQ(eds.find(0x2000, 0)->value, 2U);
}

TEST(EdsFile, ListsAndCountsOfObjectsMayBeWrong) {
  const EdsFile eds = read(
      "[OptionalObjects]\nSupportedObjects=7\n1=0x1234\n[1018]\nObjectType=9\nSubNumber=9\n"
      "[1018sub1]\nDataType=7\nAccessType=ro\n");
  EXPECT_EQ(eds.objects.size(), 1U);
}

TEST(EdsFile, WhatIsWrongIsNamedWithItsLine) {
  EXPECT_EQ(
      refusal_of(variable("0x5", "256")),
      "drive.eds:4: error: DefaultValue is \"256\", which has no room in 1 byte; correct it or its DataType");
  EXPECT_THAT(refusal_of(variable("0x5", "-1")), HasSubstr("drive.eds:4: error: DefaultValue is \"-1\""));
  EXPECT_THAT(refusal_of(variable("0x2", "-129")), HasSubstr("drive.eds:4:"));
  EXPECT_THAT(refusal_of(variable("0x7", "08")),
              HasSubstr("drive.eds:4: error: DefaultValue is \"08\"; write"));
  EXPECT_THAT(refusal_of(variable("0x7", "$NODE+1")), HasSubstr("$NODEID+0x200"));
  EXPECT_THAT(refusal_of(variable("0x7", "1+")), HasSubstr("drive.eds:4:"));
  EXPECT_THAT(refusal_of(variable("seven", "1")), HasSubstr("drive.eds:2: error: DataType is \"seven\""));
  EXPECT_THAT(refusal_of("[2000]\nDataType=7\nAccessType=often\n"),
              HasSubstr("drive.eds:3: error: AccessType"));
  EXPECT_THAT(refusal_of("[2000]\nAccessType=rw\n"),
              HasSubstr("drive.eds:1: error: section \"2000\" lacks a line; "
                        "add DataType="));
  EXPECT_THAT(refusal_of("[2000]\nDataType=7\n"), HasSubstr("add AccessType=rw"));
  EXPECT_THAT(refusal_of("[2000\n"), HasSubstr("drive.eds:1:"));
  EXPECT_THAT(refusal_of("DataType=7\n"), HasSubstr("drive.eds:1:"));
  EXPECT_THAT(refusal_of(std::string(some) + "words\n"), HasSubstr("drive.eds:10: error: \"words\" is no"));
  EXPECT_THAT(refusal_of(std::string(some) + "AccessType=rw\n"),
              HasSubstr("drive.eds:10: error: \"AccessType\""));
  EXPECT_THAT(refusal_of(std::string(some) + "[1000]\n"),
              HasSubstr("drive.eds:10: error: section \"1000\" is in "
                        "line 4 already"));
  EXPECT_THAT(refusal_of(std::string(some) + "[1000sub0]\nDataType=7\nAccessType=ro\n"),
              HasSubstr("drive.eds:10: error: object 1000h:0 is in line 4 already"));
  EXPECT_THAT(refusal_of("[2000]\nDataType=7\nAccessType=ro\nCompactSubObj=255\n"),
              HasSubstr("drive.eds:4:"));
  EXPECT_THAT(refusal_of("; nothing\n"), HasSubstr("drive.eds: error: the file has no object"));
}

// --- the drive of a rig

/// A rig beside its data sheet.
struct Sheet {
  explicit Sheet(const std::string& eds, const std::string& drive = "") {
    std::ofstream(folder.path() / "drive.eds") << eds;
    std::ofstream(folder.path() / "rig.toml")
        << rig_text({{.name = "slide",
                      .max_velocity = 200,
                      .max_acceleration = 800,
                      .more = "unpowered = \"holds\"\nreference = \"drive\"",
                      .drive = cia402_text(5) + R"(, eds = "drive.eds")" + drive}},
                    {.rate_hz = 250, .more = bus_can0});
  }
  [[nodiscard]] std::string rig() const { return (folder.path() / "rig.toml").string(); }
  /// "" or why a drive of the rig cannot be used.
  [[nodiscard]] std::string refusal() const {
    try {
      refuse_unfit_drives(read_rig_file(rig()));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder;
};

TEST(EdsDrive, ADriveThatHasWhatItNeedsIsPlayedWithItsDictionary) {
  const Sheet sheet(eds_text({}));
  EXPECT_EQ(sheet.refusal(), "");
  const RigFile rig = read_rig_file(sheet.rig());
  const SimulatedCia402Drive drive(simulated_settings_of(rig.axes[0], 0), 0);
  EXPECT_EQ(drive.objects().value(0x1400, 1), 0x205U);
  EXPECT_EQ(drive.objects().value(0x1018, 1), 0x1234U);
  EXPECT_EQ(drive.objects().find({.index = 0x6085}), nullptr);
  const std::string name = "Tür";
  EXPECT_EQ(drive.objects().read({.index = 0x1008}), (std::vector<std::uint8_t>{name.begin(), name.end()}));
}

TEST(EdsDrive, ASimulatedRunHasTheDriveOfTheDataSheet) {
  const Sheet sheet(eds_text({}));
  const ProgramRun run = run_program({"goto", "--rig", sheet.rig(), "--sim", "--fast", "--yes", "slide=20"});
  EXPECT_EQ(run.status, 0) << run.err << run.out;
  EXPECT_THAT(run.err,
              HasSubstr("note: axis \"slide\": the drive has no soft limits (no 607D); only this program"));
  EXPECT_THAT(run.err, HasSubstr("(no 6085)"));
  EXPECT_THAT(run.err, Not(HasSubstr("6502")));
}

TEST(EdsDrive, WhatItLacksIsToldBeforeAnythingIsConnectedWithTheLine) {
  EXPECT_THAT(Sheet(eds_text({.modes = "0x21"})).refusal(),
              testing::ContainsRegex(
                  "drive.eds:[1-9][0-9]*: error: axis \"slide\": the drive does not offer the mode of "
                  "operation that the rig says \\(object 6502h:0 is 33"));
  EXPECT_THAT(Sheet(eds_text({.without = {"1016", "1400sub5"}})).refusal(),
              HasSubstr("drive.eds: error: axis \"slide\": the drive would run on if this program died"));
  EXPECT_EQ(
      Sheet(eds_text({.without = {"1016", "1017", "1400sub5"}}), ", watchdog = \"life-guarding\"").refusal(),
      "");
  EXPECT_THAT(Sheet(eds_text({.without = {"1600sub2"}})).refusal(), HasSubstr("1600h:2"));
  EXPECT_THAT(Sheet(eds_text({.without = {"6064"}})).refusal(),
              HasSubstr("(object 1A00h:2 for 6064h:0; 0602 0000h: the device has no such object)"));
  EXPECT_THAT(Sheet(eds_text({.period_access = "ro"})).refusal(),
              testing::ContainsRegex("drive.eds:[1-9][0-9]*: .*60C2h:1 is 1 \\(1h\\), not 4"));
  EXPECT_THAT(Sheet(eds_text({.without = {"6007"}})).refusal(), HasSubstr("on_host_lost"));
  EXPECT_EQ(Sheet(eds_text({.without = {"6502"}})).refusal(), "");
}

TEST(EdsDrive, AnObjectThatMayNotBeMappedIsToldWithItsOwnLine) {
  const std::string sheet = eds_text({.not_mapped = {"607A"}});
  const auto line =
      std::count(sheet.begin(), sheet.begin() + static_cast<std::ptrdiff_t>(sheet.find("[607A]")), '\n') + 1;
  EXPECT_THAT(Sheet(sheet).refusal(),
              testing::AllOf(HasSubstr(fmt::format("drive.eds:{}: error: axis \"slide\": ", line)),
                             HasSubstr("object 1600h:2"), HasSubstr("(607A0020h)"),
                             HasSubstr("0604 0041h: the object cannot be mapped into a PDO")));
  std::string unsaid = sheet;
  for (std::size_t at = 0; (at = unsaid.find("PDOMapping=0\n")) != unsaid.npos;) unsaid.erase(at, 13);
  EXPECT_EQ(Sheet(unsaid).refusal(), "") << "what the file does not say may be";
  EXPECT_THAT(
      Sheet(std::string(eds_text({})) + "[2000]\nDataType=7\nAccessType=rw\nPDOMapping=2\n").refusal(),
      HasSubstr("PDOMapping is 2; write 0 or 1"));
}

// Jog needs a terminal, and reads the rig as goto does.
TEST(EdsDrive, EveryCommandThatReadsARigLooksAtTheDataSheetsBeforeAnythingIsConnected) {
  const Sheet sheet(eds_text({.modes = "0x21"}));
  const std::string move = in_checkout("examples/reveal.toml");
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"plan", move},
                                             {"check", move},
                                             {"run", move},
                                             {"goto", "--yes", "slide=20"},
                                             {"home"},
                                             {"sim-drives"}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--rig", sheet.rig()});
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, 1) << command.front() << run.out;
    EXPECT_THAT(run.err,
                testing::ContainsRegex("drive.eds:[1-9][0-9]*: error: axis \"slide\": the drive does "
                                       "not offer the mode of operation"))
        << command.front();
  }
}

TEST(EdsDrive, WhatSomebodyMaySetInTheDriveIsNotJudgedBeforeItIsConnected) {
  EXPECT_EQ(Sheet(eds_text({.window = "0xFFFFFFFF"})).refusal(), "");
}

TEST(EdsDrive, AMissingDataSheetAndOneThatIsWrongAreErrorsOfOneLine) {
  const Sheet empty("");
  EXPECT_THAT(empty.refusal(), HasSubstr("drive.eds: error: the file has no object"));
  std::filesystem::remove(empty.folder.path() / "drive.eds");
  EXPECT_THAT(empty.refusal(), HasSubstr("drive.eds: error: "));
  const Sheet wrong(eds_text({.modes = "none"}));
  const ProgramRun run = run_program({"goto", "--rig", wrong.rig(), "--sim", "--fast", "--yes", "slide=20"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, testing::ContainsRegex("drive.eds:[1-9][0-9]*: error: DefaultValue is \"none\""));
}

}  // namespace eds_file_test
}  // namespace inbetween
