// Whole sessions with a DFMoco device, from a scripted host that shares nothing with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dfmoco_device.hpp"
#include "tests/support/oracle_dfmoco_host.hpp"
#include "tests/support/pretend_rig.hpp"

namespace inbetween {
namespace dfmoco_session_test {

using namespace dragonframe;
using Lines = std::vector<std::string>;

struct Session {
  explicit Session(std::uint8_t motors = 4)
      : device(motors, [this](const RigOrder& order) { return rig.take(order); }) {
    device.connect(0);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() = default;

  /// What the device says to a line; what it has said before is read.
  Lines ask(const std::string& line) {
    read();
    device.hear(oracle::dfmoco_bytes(line), now_ns);
    host.hear(device.take_text());
    return host.take_lines();
  }
  void read() {
    host.hear(device.take_text());
    for (const std::string& line : host.take_lines()) told.push_back(line);
  }
  void run_for(double seconds) {
    const std::int64_t until_ns = now_ns + static_cast<std::int64_t>(seconds * 1e9);
    while (now_ns < until_ns) {
      now_ns += PretendRig::tick_ns;
      const std::vector<RigEvent> events = rig.tick();
      device.observe(rig.state(), now_ns);
      for (const RigEvent& event : events) device.tell(event, now_ns);
      read();
    }
  }
  /// The host polls until nothing moves.
  void run_until_still() {
    for (int i = 0; i < 3000; ++i) {
      run_for(0.02);
      if (ask("ms").at(0).find('1') == std::string::npos) return;
    }
    throw std::runtime_error("the rig does not come to rest");
  }

  PretendRig rig;
  DfmocoDevice device;
  oracle::DfmocoHost host;
  std::int64_t now_ns = 0;
  Lines told;
};

TEST(DfmocoSession, IsThatOfTheDescription) {
  Session session;
  session.read();
  EXPECT_EQ(session.told, (Lines{"hi 2 4 2.0.0"})) << "it greets by itself";
  EXPECT_EQ(session.ask("hi"), (Lines{"hi 2 4 2.0.0"}));
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask("pr 1 2000"), (Lines{"pr 1 2000"}));
  EXPECT_EQ(session.ask("mm 1 2500"), (Lines{"mm 1 2500"}));
  EXPECT_EQ(session.ask("ms"), (Lines{"ms 1000"}));
  session.told.clear();
  session.run_for(1.02);
  EXPECT_EQ(session.told, (Lines{"mp 1 2000"})) << "once a second, what moves";
  session.run_for(2);
  EXPECT_EQ(session.told, (Lines{"mp 1 2000", "mp 1 2500"})) << "and once, where it rests";
  EXPECT_EQ(session.ask("ms"), (Lines{"ms 0000"}));
  EXPECT_EQ(session.ask("mm 1 2500"), (Lines{"mp 1 2500"})) << "it is there already";
  EXPECT_EQ(session.ask("np 2 500"), (Lines{"mp 2 500"})) << "as the sketch, not as the document";
  EXPECT_EQ(session.ask("jm 2 1000000 5000"), (Lines{"jm 2"}));
  session.run_for(0.3);
  const Lines stopped = session.ask("sm 2");
  ASSERT_EQ(stopped.size(), 2U);
  EXPECT_EQ(stopped[0], "sm 2");
  EXPECT_EQ(stopped[1], "mp 2 " + std::to_string(session.rig.state().positions[1]));
  session.run_until_still();
  EXPECT_EQ(session.ask("zm 2"), (Lines{"mp 2 0"}));
  session.told.clear();
  session.run_for(1);
  EXPECT_NE(std::find(session.told.begin(), session.told.end(), "mp 2 0"), session.told.end())
      << "and once more";
  EXPECT_EQ(session.ask("mm 9 1"), (Lines{"parse error"}));
}

TEST(DfmocoSession, ABlurredFrameBeginsASecondBehindGo) {
  Session session;
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask("go"), (Lines{"parse error"}));
  EXPECT_EQ(session.ask("bf 500 500 1 0 100 200"), (Lines{"bf 1000"}));
  EXPECT_EQ(session.ask("ms"), (Lines{"ms 1000"})) << "on the way to its start";
  EXPECT_EQ(session.ask("go"), (Lines{"parse error"}));
  session.run_until_still();
  EXPECT_EQ(session.rig.state().positions[0], -50);
  EXPECT_EQ(session.ask("go"), (Lines{"go"}));
  EXPECT_EQ(session.ask("mm 1 0"), (Lines{"parse error"}));
  EXPECT_EQ(session.ask("bf 500 500 1 0 100 200"), (Lines{"parse error"}));
  session.run_for(1);
  EXPECT_EQ(session.rig.state().positions[0], 50) << "the shutter opens";
  session.run_for(0.26);
  EXPECT_NEAR(session.rig.state().positions[0], 100, 3) << "this frame, in the middle of the exposure";
  session.run_for(0.24);
  EXPECT_EQ(session.rig.state().positions[0], 150) << "it closes";
  session.run_for(1.1);
  EXPECT_EQ(session.rig.state().positions[0], 250);
  EXPECT_EQ(session.ask("go"), (Lines{"parse error"})) << "the motor is no longer at the start";
}

TEST(DfmocoSession, ABlurThatCannotBeIsToldSo) {
  Session session;
  EXPECT_EQ(session.ask("bf 500 500 1 0 100 200"), (Lines{"parse error"})) << "nobody has agreed";
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask("bf 10 1000 1 0 1000 2000"), (Lines{"bf -1"})) << "200 000 steps/s";
  EXPECT_EQ(session.ask("go"), (Lines{"parse error"}));
  session.rig.judge = [](const RigOrder&) { return RigAnswer::soft_upper; };
  EXPECT_EQ(session.ask("bf 500 500 1 0 100 200"), (Lines{"bf -1"})) << "a limit of the rig";
  session.rig.judge = {};
  for (const char* line : {"bf", "bf 500", "bf 500 500", "bf 500 500 1 0 100", "bf 500 500 1 0 100 200 2",
                           "bf 500 500 5 0 100 200", "bf 500 500 0 0 100 200", "bf 0 500 1 0 100 200",
                           "bf 500 1001 1 0 100 200", "bf 500 -1 1 0 100 200",
                           "bf 500 500 1 0 100 200 1 0 100 200", "bf 500 500 1 0 100 200 5 0 100 200"}) {
    EXPECT_EQ(session.ask(line), (Lines{"parse error"})) << line;
  }
  EXPECT_TRUE(session.rig.taken<PrepareShot>().size() == 1U) << "the one that the rig refused";
  EXPECT_EQ(session.ask("bf 70000 500 1 0 100 200 2 0 0 0"), (Lines{"bf 1000"})) << "more than 16 bits of ms";
  session.run_until_still();
  EXPECT_EQ(session.ask("mm 2 5"), (Lines{"mm 2 5"}));
  session.run_until_still();
  EXPECT_EQ(session.ask("go"), (Lines{"parse error"})) << "a motor has left its start";
}

TEST(DfmocoSession, AJogStopsWithItsHost) {
  Session session;
  ASSERT_TRUE(session.device.arm());
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(session.ask("jm 1 1000000"), (Lines{"jm 1"}));
    session.run_for(0.2);
  }
  EXPECT_TRUE(session.rig.taken<StopMotor>().empty());
  session.run_for(2);
  EXPECT_EQ(session.rig.taken<StopMotor>(), (std::vector<StopMotor>{{.motor = 1}}));
  EXPECT_EQ(session.ask("jm 1 -1000000 0"), (Lines{"jm 1"}));
  EXPECT_EQ(session.rig.taken<JogMotor>().back().speed, 4) << "no slower";
  session.run_for(0.1);
  EXPECT_EQ(session.ask("jm 1 1000000"), (Lines{"jm 1"}));
  EXPECT_EQ(session.rig.taken<StopMotor>().size(), 2U) << "the other way round it first stops";
  session.run_until_still();
  const auto here = session.rig.state().positions[0];
  EXPECT_EQ(session.ask("im 1 " + std::to_string(here + 1000)), (Lines{"im 1"}));
  session.run_until_still();
  EXPECT_EQ(session.rig.state().positions[0], here + 2);
  EXPECT_EQ(session.ask("im 1 " + std::to_string(here + 3)), (Lines{"im 1"}));
  session.run_until_still();
  EXPECT_EQ(session.rig.state().positions[0], here + 3) << "not beyond";
  EXPECT_EQ(session.ask("jm 1"), (Lines{"parse error"}));
  EXPECT_EQ(session.ask("jm 1 5 10001"), (Lines{"parse error"}));
}

TEST(DfmocoSession, RatesAreAnsweredAsTheyAreTaken) {
  Session session;
  EXPECT_EQ(session.ask("pr 1 70000"), (Lines{"pr 1 20000"})) << "not its low 16 bits";
  EXPECT_EQ(session.ask("pr 1 1"), (Lines{"pr 1 100"}));
  EXPECT_EQ(session.rig.taken<SetMotor>().front().settings.max_acceleration, 10'000U);
  session.rig.judge = [](const RigOrder&) { return RigAnswer::range; };
  EXPECT_EQ(session.ask("pr 1 5000"), (Lines{"parse error"})) << "the rig is slower";
}

TEST(DfmocoSession, NothingMovesWithoutConsentAndAStopTakesItAway) {
  Session session;
  for (const char* line : {"mm 1 100", "jm 1 100", "im 1 100"}) {
    EXPECT_EQ(session.ask(line), (Lines{"parse error"})) << line;
  }
  EXPECT_FALSE(session.rig.was_moved());
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask("sa"), (Lines{"sa"}));
  EXPECT_TRUE(session.device.is_armed()) << "nothing was stopped";
  EXPECT_EQ(session.ask("mm 1 100000"), (Lines{"mm 1 100000"}));
  session.run_for(0.1);
  EXPECT_EQ(session.ask("np 1 0"), (Lines{"parse error"})) << "not while it moves";
  EXPECT_EQ(session.ask("sa"), (Lines{"sa"}));
  EXPECT_FALSE(session.device.is_armed());
  EXPECT_EQ(session.ask("mm 1 0"), (Lines{"parse error"}));
}

TEST(DfmocoSession, WhoIsUnpluggedLeavesARigAtRest) {
  Session session;
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask("mm 1 100000"), (Lines{"mm 1 100000"}));
  session.run_for(0.1);
  EXPECT_FALSE(session.device.connect(session.now_ns)) << "a second host does not get in";
  const std::string half = "mm 1 25";
  session.device.hear({reinterpret_cast<const std::uint8_t*>(half.data()), half.size()}, session.now_ns);
  session.device.disconnect(session.now_ns);
  EXPECT_EQ(session.rig.taken<StopAll>().size(), 1U);
  ASSERT_TRUE(session.device.connect(session.now_ns));
  session.read();
  EXPECT_EQ(session.ask(""), Lines{}) << "the half line went with its host";
  EXPECT_FALSE(session.device.is_armed());
}

TEST(DfmocoSession, HalfALineIsDroppedAfterASilence) {
  Session session;
  ASSERT_TRUE(session.device.arm());
  const std::string half = "mm 1 25";
  session.device.hear({reinterpret_cast<const std::uint8_t*>(half.data()), half.size()}, session.now_ns);
  session.run_for(2.1);
  EXPECT_EQ(session.ask("ms"), (Lines{"ms 0000"})) << "not mm 1 25ms";
  const auto notices = session.device.take_notices();
  EXPECT_EQ(notices.back().kind, PortNotice::Kind::half_dropped);
  EXPECT_FALSE(text_of(notices.back()).empty());
  EXPECT_EQ(session.ask("move 1"), Lines{}) << "nobody answers what is no command";
  EXPECT_EQ(session.device.take_notices().back().kind, PortNotice::Kind::unknown_line);
}

}  // namespace dfmoco_session_test
}  // namespace inbetween
