// Data sheets of drives (EDS, DCF): what is read of them, where they are wrong, and what a rig's drive lacks
// by its own. The texts have the shapes that makers use, and none is a maker's.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/rig/cia402_kind.hpp"
#include "host_tools/rig/eds_drive.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/eds_text.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace eds_file_test {

using testing::HasSubstr;
using testing::Not;

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

/// The one warning that a text brings; "" for none.
std::string warning_of(std::string_view text) {
  const std::vector<std::string> warnings = read(text).warnings;
  EXPECT_LE(warnings.size(), 1U);
  return warnings.empty() ? "" : warnings.front();
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
  EXPECT_EQ(value("0x7", ""), std::nullopt) << "unknown until the drive is connected, and never 0";
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

TEST(EdsFile, AnEmptyValueOfADeviceLeavesThatOfItsKind) {
  const EdsFile eds = read(variable("0x7", "1") + "ParameterValue=\n");
  EXPECT_EQ(eds.find(0x2000, 0)->value, 1U);
}

TEST(EdsFile, WhatMakersGetWrongIsAWarningWithItsLineAndMakesThatObjectUnknown) {
  struct Row {
    std::string text;
    const char* words;
  };
  const std::string unknown = "; it is unknown until the drive is connected";
  for (const Row& row :
       {Row{variable("0x5", "256"),
            "drive.eds:4: warning: DefaultValue is \"256\", which has no room in 1 byte"},
        Row{variable("0x5", "-1"), "drive.eds:4: warning: DefaultValue is \"-1\""},
        Row{variable("0x2", "-129"), "drive.eds:4:"},
        Row{variable("0x7", "08"), "drive.eds:4: warning: DefaultValue"},
        Row{variable("0x7", "1.5"), "is \"1.5\", and no number such as 12"},
        Row{variable("0x7", "0x80 (rw)"), "is \"0x80 (rw)\""},
        Row{variable("0x7", "$NODE+1"), "$NODEID+0x200"}, Row{variable("0x7", "1+"), "drive.eds:4:"},
        Row{variable("seven", "1"), "drive.eds:2: warning: DataType is \"seven\""},
        Row{"[2000]\nAccessType=rw\n", "drive.eds:1: warning: section \"2000\" has no DataType"},
        Row{variable("7", "1") + "DefaultValue=2\n",
            "drive.eds:5: warning: \"DefaultValue\" is in section \"2000\""},
        Row{variable("7", "1") + "written by hand\n",
            "drive.eds:5: warning: \"written by hand\" is no [SECTION]"},
        Row{variable("7", "1") + "[2000]\nDataType=7\n", "section \"2000\" is in line 1 already"},
        Row{variable("7", "1") + "[2000sub0]\nDataType=7\n",
            "drive.eds:5: warning: object 2000h:0 is in line 1"}}) {
    SCOPED_TRACE(row.text);
    const EdsFile eds = read(row.text);
    ASSERT_FALSE(eds.warnings.empty());
    EXPECT_THAT(eds.warnings.front(), testing::AllOf(HasSubstr(row.words), testing::EndsWith(unknown)));
    ASSERT_EQ(eds.objects.size(), 1U);
    EXPECT_EQ(eds.objects.front().value, std::nullopt);
  }
}

TEST(EdsFile, WhatIsWrongBesideAnObjectsValueIsAWarningToo) {
  const auto with_line = [](const char* line) { return variable("0x6", "7") + line + "\n"; };
  EXPECT_EQ(
      warning_of(with_line("HighLimit=65536")),
      "drive.eds:5: warning: HighLimit is \"65536\", which has no room in 2 bytes; it is unknown until the "
      "drive is connected");
  EXPECT_THAT(warning_of(with_line("LowLimit=9\nHighLimit=8")),
              HasSubstr("drive.eds:5: warning: LowLimit is 9, above HighLimit = 8; neither is believed"));
  EXPECT_THAT(warning_of(with_line("PDOMapping=2")), HasSubstr("whether it can be mapped is unknown"));
  EXPECT_THAT(warning_of(with_line("CompactSubObj=255")), HasSubstr("at most 254 parts"));
  EXPECT_THAT(warning_of("[2000]\nDataType=7\nAccessType=often\n"),
              HasSubstr("drive.eds:3: warning: AccessType"));
  EXPECT_THAT(warning_of(variable("7", "1") + "[0005]\nDataType=7\n"), HasSubstr("is no object of a device"));
  EXPECT_THAT(warning_of("[2001\nDataType=9\n" + variable("7", "1")),
              HasSubstr("drive.eds:1: warning: section"));
  EXPECT_THAT(warning_of("DataType=7\n" + variable("7", "1")), HasSubstr("it is passed over"));
  for (const char* const line :
       {"AccessType=rw", "# a comment", "; another", "\x1A", "", "ParameterName=T\xFCr"}) {
    const EdsFile eds = read(with_line(line));
    EXPECT_THAT(eds.warnings, testing::IsEmpty()) << line;
    EXPECT_EQ(eds.find(0x2000, 0)->value, 7U) << line;
  }
  EXPECT_EQ(read("[2000]\nDataType=7\n").find(0x2000, 0)->can_be_written, true) << "nothing else is said";
}

TEST(EdsFile, WithoutAnyObjectItIsNoDataSheet) {
  EXPECT_THAT(refusal_of("; nothing\n"), HasSubstr("drive.eds: error: the file has no object"));
  EXPECT_THAT(refusal_of("words\n"), HasSubstr("drive.eds: error: the file has no object"));
}

// --- the drive of a rig

/// A rig beside its data sheet.
struct Sheet {
  explicit Sheet(const std::string& eds, const std::string& drive = "") {
    std::ofstream(folder.path() / "drive.eds") << eds;
    std::ofstream(folder.path() / "rig.toml")
        << rig_text({axis_text("slide", "mm", {-100, 200}, {.velocity = 200, .acceleration = 800},
                               "unpowered = \"holds\"\nreference = \"drive\"",
                               cia402_text(5) + R"(, eds = "drive.eds")" + drive)},
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
  EXPECT_THAT(Sheet(eds_text({.without = {"1600sub2", "1601sub2"}})).refusal(), HasSubstr("1600h:2"));
  EXPECT_THAT(Sheet(eds_text({.without = {"6064"}})).refusal(),
              HasSubstr("(object 1A00h:2 for 6064h:0; 0602 0000h: the device has no such object)"));
  EXPECT_THAT(
      Sheet(eds_text({.period_access = "ro"})).refusal(),
      testing::ContainsRegex("drive.eds:[1-9][0-9]*: .*60C2h:1 is 1 \\(1h\\), not 4.*write rate_hz = 1000"));
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
}

/// A part of a sheet in other words.
std::string changed(std::string_view from, std::string_view to) {
  return with(eds_text({}), from, to);
}
std::string in_section(const std::string& section, std::string_view from, std::string_view to) {
  std::string text = eds_text({});
  return text.replace(text.find(from, text.find("[" + section + "]")), from.size(), to);
}
std::string without_values(const std::vector<std::string>& sections) {
  std::string text = eds_text({});
  for (const std::string& section : sections) {
    const std::size_t begin = text.find("DefaultValue=", text.find("[" + section + "]"));
    text.erase(begin, text.find('\n', begin) + 1 - begin);
  }
  return text;
}

// Each in the form in which a maker's file has it.
TEST(EdsDrive, SheetsAsMakersWriteThemPlay) {
  struct Row {
    const char* what;
    std::string sheet;
    std::vector<std::string> said;  ///< in warnings and notes
  };
  std::string crlf;
  for (const char c : "\xEF\xBB\xBF" + eds_text({}) + "\x1A") crlf += c == '\n' ? "\r\n" : std::string(1, c);
  for (const Row& row : {
           Row{"no device type, as maxon and Schunk have it", without_values({"1000"}), {}},
           Row{"no modes, as Elmo has it", without_values({"6502"}), {}},
           Row{"no value of anything that can only be read",
               without_values({"1000", "1001", "1018sub0", "1018sub1", "6041", "6061", "6064", "6502"}),
               {}},
           Row{"no following error window", without_values({"6065", "6066"}), {}},
           Row{"a device type that is empty", changed("DefaultValue=0x00020192", "DefaultValue="), {}},
           Row{"a DCF with empty values",
               changed("DefaultValue=0x00020192", "DefaultValue=0x20192\nParameterValue="),
               {}},
           Row{"a limit one too high, as Eyou has it",
               eds_text({}) + "[2023]\nDataType=6\nAccessType=rw\nHighLimit=65536\n",
               {"warning: HighLimit is \"65536\"", "drive.eds:"}},
           Row{"an unused RPDO that is fixed, as Faulhaber has it",
               in_section("1401sub1", "AccessType=rw", "AccessType=ro"),
               {"keeps its RPDO 2 (object 1401h:1 is fixed)"}},
           Row{"room in the second RPDO only, as iPOS has it",
               eds_text({.without = {"1600sub2", "1600sub3", "1600sub4"}}),
               {"its controlword and target go in RPDO 2 (1601h)"}},
           Row{"CRLF, a byte order mark and the end of a DOS file", crlf, {}},
           Row{"a window with a decimal", eds_text({.window = "2000.0"}), {"DefaultValue is \"2000.0\""}},
           Row{"modes with words behind them",
               eds_text({.modes = "0xA1 = csp"}),
               {"DefaultValue is \"0xA1 = csp\""}},
           Row{"a statusword without a type",
               changed("[6041]\nParameterName=p\nObjectType=0x7\nDataType=0x0006\n",
                       "[6041]\nParameterName=p\n"),
               {"section \"6041\" has no DataType"}},
           Row{"objects of the dummy kind",
               "[0005]\nDataType=5\n" + eds_text({}),
               {"section \"0005\" is no object"}},
           Row{"a part in small letters", changed("[607A]", "[607a]"), {}},
           Row{"access in capitals, and none", in_section("6040", "AccessType=rww", "AccessType=RWW"), {}},
           Row{"a heartbeat twice",
               eds_text({}) + "[1017]\nDataType=6\nAccessType=rw\nDefaultValue=1\n",
               {"section \"1017\" is in line"}},
           Row{"a line of text", eds_text({}) + "end of file\n", {"\"end of file\" is no [SECTION]"}},
       }) {
    SCOPED_TRACE(row.what);
    const Sheet sheet(row.sheet);
    const ProgramRun run =
        run_program({"goto", "--rig", sheet.rig(), "--sim", "--fast", "--yes", "slide=20"});
    EXPECT_EQ(run.status, 0) << run.err << run.out;
    for (const std::string& words : row.said) EXPECT_THAT(run.err, HasSubstr(words));
    if (row.said.empty()) {
      EXPECT_THAT(run.err, Not(HasSubstr("warning")));
    }
  }
}

TEST(EdsDrive, APeriodThatIsFixedNamesTheRateAndTheLimitOfTheFile) {
  const std::string fixed = with(eds_text({}), "[60C2sub1]\n", "[60C2sub1]\nLowLimit=1\nHighLimit=1\n");
  EXPECT_THAT(Sheet(fixed).refusal(),
              testing::AllOf(HasSubstr("the data sheet has LowLimit = 1 and HighLimit = 1"),
                             HasSubstr("write rate_hz = 1000 in the rig")));
}

// docs/faults.md 51
TEST(EdsDrive, ADriveOfAnotherMakeThanItsSheetIsRefused) {
  const Sheet sheet(eds_text({}));
  const RigFile rig = read_rig_file(sheet.rig());
  RigFile without = rig;
  std::get<Cia402Drive>(without.axes[0].drive).eds.clear();
  SimulatedHardware hardware(without, {0});  // of vendor 5101h
  RigDrives drives(rig, hardware);
  drives.enable();
  std::vector<DriveState> states(1);
  for (std::int64_t now_ns = 4'000'000; now_ns < 10'000'000'000 && drives.trouble().empty();
       now_ns += 4'000'000) {
    drives.read(states, now_ns);
    drives.write({}, now_ns);
  }
  EXPECT_FALSE(states[0].is_on);
  EXPECT_THAT(drives.trouble(), HasSubstr("(object 1018h:1 is 20737 (5101h), not 4660 (1234h))"));
}

TEST(EdsDrive, AWarningIsToldOnceHoweverManyDrivesHaveTheSheet) {
  const Sheet sheet(eds_text({}) + "[2023]\nDataType=6\nAccessType=rw\nHighLimit=65536\n");
  EXPECT_EQ(refuse_unfit_drives(read_rig_file(sheet.rig())).size(), 1U);
}

}  // namespace eds_file_test
}  // namespace inbetween
