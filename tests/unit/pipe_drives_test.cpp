// Lines of text to a FIFO and to a serial port: what is in them, what is refused, and a reader that stalls.
#include "host_tools/rig/pipe_drives.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <string>
#include <vector>

#include "drivers/linux/line_pipe.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace pipe_drives_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;

std::string axis(const std::string& name, const std::string& path, const std::string& more = "",
                 const std::string& accepted = ", no_watchdog = \"accepted\"") {
  return fmt::format(
      "[[axis]]\nname = \"{}\"\nunit = \"deg\"\nmin = -90\nmax = 90\nmax_velocity = 100\nmax_acceleration = "
      "500\n"
      "unpowered = \"holds\"\ndrive = {{ type = \"pipe\", path = \"{}\", counts_per_unit = 10, count_at_zero "
      "= "
      "1500{}{} }}\n",
      name, path, more, accepted);
}
RigFile rig_of(const std::string& axes, int rate_hz = 250) {
  return parse_rig(fmt::format("name = \"puppet\"\nrate_hz = {}\n", rate_hz) + axes, "rig.toml");
}

/// The reading end of something.
struct Reader {
  explicit Reader(int descriptor) : file(descriptor) {}
  ~Reader() { leave(); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  void leave() {
    if (file >= 0) ::close(file);
    file = -1;
  }
  /// What has come since the last call.
  [[nodiscard]] std::string read() const {
    std::string all;
    std::array<char, 65536> part{};
    for (ssize_t count = 0; (count = ::read(file, part.data(), part.size())) > 0;) {
      all.append(part.data(), static_cast<std::size_t>(count));
    }
    return all;
  }
  int file;
};

struct Fifo {
  Fifo() { EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0); }
  [[nodiscard]] int opened() const { return ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC); }
  TemporaryFolder folder;
  std::string path = (folder.path() / "servos").string();
};

/// The port of two axes, tick by tick at 250 Hz.
class TwoServos : public testing::Test {
 protected:
  Fifo fifo;
  RigFile rig = rig_of(axis("jaw", fifo.path) + axis("lid", fifo.path));
  Reader reader{fifo.opened()};
  PipeDrives drives{rig, std::vector<std::size_t>{0, 1}};
  std::vector<DriveState> states = std::vector<DriveState>(2);
  std::int64_t now_ns = 1'000'000'000;

  void tick(const std::vector<double>& positions) {
    now_ns += 4'000'000;
    drives.read(states, now_ns);
    std::vector<Setpoint> setpoints;
    for (const double position : positions) setpoints.push_back({.position = position});
    drives.write(setpoints, now_ns);
  }
};

TEST_F(TwoServos, EveryTickIsALineWithItsNumberItsTimeAndTheCountOfEachAxis) {
  drives.place(0, 5);
  drives.enable();
  tick({});
  EXPECT_TRUE(states[0].is_on);
  EXPECT_EQ(states[0].actual, 5);
  EXPECT_EQ(reader.read(), "") << "without a setpoint nothing is sent";
  tick({5, 0});
  tick({5.06, -0.06});
  tick({-90, 90});
  EXPECT_EQ(reader.read(), "0 0 jaw=1550 lid=1500\n1 4 jaw=1551 lid=1499\n2 8 jaw=600 lid=2400\n");
  EXPECT_EQ(states[1].actual, -0.06) << "where it was told to be";
  drives.disable();
  EXPECT_EQ(reader.read(), "off\n");
  tick({1, 1});
  EXPECT_EQ(reader.read(), "");
  EXPECT_FALSE(states[0].is_on);
  EXPECT_EQ(drives.trouble(), "");
}

TEST_F(TwoServos, AQuickStopIsSilenceForWhatWatchesTheLines) {
  drives.enable();
  tick({0, 0});
  drives.quick_stop();
  tick({1, 1});
  drives.disable();
  EXPECT_EQ(reader.read(), "0 0 jaw=1500 lid=1500\n");
}

TEST_F(TwoServos, AReaderThatStallsIsAFaultThatLastsAndTheLoopGoesOn) {
  drives.enable();
  int lines = 0;
  while (states[0].condition == DriveCondition::fine && lines < 10'000) {
    tick({10, 0});
    ++lines;
  }
  tick({20, 0});
  EXPECT_EQ(states[0].condition, DriveCondition::cannot_follow);
  EXPECT_EQ(states[1].condition, DriveCondition::cannot_follow) << "it is in the same lines";
  EXPECT_NEAR(lines, 28, 2) << "a tenth of a second, and the tick in which it shows";
  EXPECT_TRUE(drives.has_lost_position(0));
  EXPECT_THAT(drives.trouble(), AllOf(HasSubstr("is not read any more"), HasSubstr("axis \"jaw\"")));
  static_cast<void>(reader.read());
  for (int i = 0; i < 5; ++i) tick({30, 0});
  drives.enable();
  tick({30, 0});
  EXPECT_EQ(reader.read(), "") << "nothing moves because somebody reads again";
  EXPECT_EQ(states[0].condition, DriveCondition::cannot_follow);
  Counters counts;
  drives.count(counts);
  EXPECT_THAT(trouble_of(counts), HasSubstr("jaw: unread 1; lid: unread 1"));
}

TEST_F(TwoServos, AReaderThatLeavesIsAFaultAndNoSignal) {
  drives.enable();
  tick({0, 0});
  reader.leave();
  tick({0, 0});
  tick({0, 0});
  EXPECT_EQ(states[0].condition, DriveCondition::cannot_follow);
}

TEST_F(TwoServos, AReaderThatKeepsUpMissesNoLineOfAnHour) {
  drives.enable();
  constexpr int ticks = 250 * 3600 / 100;  // every hundredth of them is enough
  for (int i = 0; i < ticks; ++i) {
    tick({i % 90 * 1.0, 0});
    ASSERT_EQ(reader.read(), fmt::format("{} {} jaw={} lid=1500\n", i, 4 * i, 1500 + i % 90 * 10));
  }
  EXPECT_EQ(drives.trouble(), "");
}

/// The refusal of the port of a rig; "" for none.
std::string refusal_of(const std::string& axes, int rate_hz = 250) {
  const RigFile rig = rig_of(axes, rate_hz);
  std::vector<std::size_t> all;
  for (std::size_t a = 0; a < rig.axes.size(); ++a) all.push_back(a);
  try {
    const PipeDrives drives(rig, all);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PipeDrives, ALineThatHasNoRoomClosesThePipe) {
  const Fifo fifo;
  const Reader reader(fifo.opened());
  LinePipe pipe;
  ASSERT_FALSE(pipe.open(fifo.path, 115'200));
  const std::string line = "0 0 jaw=1500 lid=1500\n";
  std::size_t sent = 0;
  while (pipe.send(line)) sent += line.size();
  EXPECT_FALSE(pipe.is_open());
  EXPECT_FALSE(pipe.send("off\n")) << "it could be the middle of a line";
  EXPECT_EQ(reader.read().size(), sent);
}

TEST(PipeDrives, WhatCannotBeUsedIsRefusedAtItsAxisBeforeAnythingIsSent) {
  const Fifo fifo;
  EXPECT_THAT(refusal_of(axis("jaw", fifo.path)),
              AllOf(StartsWith("rig.toml:3:"), HasSubstr("nobody reads ")));
  const Reader reader{fifo.opened()};
  EXPECT_EQ(refusal_of(axis("jaw", fifo.path)), "");
  // docs/faults.md 29
  EXPECT_THAT(refusal_of(axis("jaw", fifo.path, "", "")),
              HasSubstr("cannot see whether what reads \"" + fifo.path + "\" stops by itself"));
  EXPECT_THAT(refusal_of(axis("left lid", fifo.path)), HasSubstr("write it without spaces"));
  EXPECT_THAT(refusal_of(axis("jaw", fifo.path + "s")), HasSubstr("there is no "));
  EXPECT_THAT(refusal_of(axis("jaw", fifo.path) + axis("lid", fifo.path, ", baud = 9600")),
              HasSubstr("has another baud"));
  const std::string file = (fifo.folder.path() / "file").string();
  std::ofstream(file) << "x";
  EXPECT_THAT(refusal_of(axis("jaw", file)), HasSubstr("is neither a FIFO nor a serial port"));
  EXPECT_EQ(reader.read(), "");
}

/// A pseudo-terminal is to this program what a serial port is.
struct Terminal {
  Terminal() {
    EXPECT_EQ(::grantpt(board.file), 0);
    EXPECT_EQ(::unlockpt(board.file), 0);
  }
  Reader board{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)};
  std::string path = ::ptsname(board.file);
};

TEST(PipeDrives, ABoardOnASerialPortHasTwoSecondsToStart) {
  const Terminal terminal;
  const RigFile rig = rig_of(axis("jaw", terminal.path));
  PipeDrives drives(rig, std::vector<std::size_t>{0});
  drives.enable();
  std::vector<DriveState> states(1);
  drives.read(states, 1'000'000'000);
  EXPECT_FALSE(states[0].is_on);
  drives.read(states, 2'999'000'000);
  EXPECT_FALSE(states[0].is_on);
  drives.read(states, 3'000'000'000);
  EXPECT_TRUE(states[0].is_on);
  const Setpoint setpoint{.position = 1};
  drives.write({&setpoint, 1}, 3'000'000'000);
  EXPECT_EQ(terminal.board.read(), "0 0 jaw=1510\n") << "as it is, no line end is changed";
}

TEST(PipeDrives, LinesThatASerialPortIsTooSlowForAreRefused) {
  const Terminal terminal;
  EXPECT_EQ(refusal_of(axis("jaw", terminal.path, ", baud = 230400")), "");
  EXPECT_THAT(refusal_of(axis("jaw", terminal.path, ", baud = 9600")),
              HasSubstr("bit/s of the 9600 of \"" + terminal.path + "\"; raise baud or lower rate_hz"));
}

TEST(PipeDrives, TheCountsOfAServoAreHeldAgainstItsRange) {
  EXPECT_NO_THROW(rig_of(axis("jaw", "p", ", min_count = 600, max_count = 2400")));
  EXPECT_THAT([] { rig_of(axis("jaw", "p", ", min_count = 601")); },
              ThrowsMessage<InputError>(HasSubstr("min_count is 601, and -90 deg is count 600; correct")));
  EXPECT_THAT([] { rig_of(axis("jaw", "p", ", max_count = 2399")); },
              ThrowsMessage<InputError>(HasSubstr("max_count is 2399, and 90 deg is count 2400; correct")));
  EXPECT_THAT([] { rig_of(axis("jaw", "p", ", baud = 12345")); },
              ThrowsMessage<InputError>(HasSubstr("baud is 12345; write one that serial ports have")));
}

TEST(PipeDrives, TheMachineOpensThem) {
  const Fifo fifo;
  const Reader reader{fifo.opened()};
  const RigFile rig = rig_of(axis("jaw", fifo.path));
  MachineHardware hardware(rig, false);
  RigDrives drives(rig, hardware);
  std::vector<DriveState> states(1);
  drives.place(0, 7);
  drives.enable();
  drives.read(states, 4'000'000);
  const Setpoint setpoint{.position = 7};
  drives.write({&setpoint, 1}, 4'000'000);
  EXPECT_EQ(reader.read(), "0 0 jaw=1570\n");
}

}  // namespace pipe_drives_test
}  // namespace inbetween
