// The words of CiA 402, and what is written into a drive before it may be switched on.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "inbetween/can/cia402.hpp"
#include "inbetween/can/cia402_setup.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/sdo.hpp"
#include "tests/support/drive_objects.hpp"

namespace inbetween::can {
namespace can_cia402_test {

constexpr std::int64_t ms = 1'000'000;

NodeId node(int number) {
  return NodeId::make(number).value();
}

/// Written from the bits of the profile instead of its masks: b0 ready, b1 switched on, b2 enabled, b3
/// fault, b5 no quick stop, b6 disabled.
Cia402State told_by_bits(unsigned word) {
  const auto bit = [word](unsigned number) { return ((word >> number) & 1) != 0; };
  const bool ready = bit(0);
  const bool on = bit(1);
  const bool enabled = bit(2);
  const bool faulty = bit(3);
  const bool no_quick_stop = bit(5);
  const bool disabled = bit(6);
  if (!ready && !on && !enabled && !faulty) {
    return disabled ? Cia402State::switch_on_disabled : Cia402State::not_ready;
  }
  if (disabled) return Cia402State::unknown;
  if (faulty) {
    if (ready && on && enabled) return Cia402State::fault_reaction_active;
    return !ready && !on && !enabled ? Cia402State::fault : Cia402State::unknown;
  }
  if (ready && on && enabled) {
    return no_quick_stop ? Cia402State::operation_enabled : Cia402State::quick_stop_active;
  }
  if (!no_quick_stop || !ready || enabled) return Cia402State::unknown;
  return on ? Cia402State::switched_on : Cia402State::ready_to_switch_on;
}

TEST(Cia402, EveryStatuswordIsTheStateThatItsBitsTell) {
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    ASSERT_EQ(state_of(static_cast<std::uint16_t>(word)), told_by_bits(word)) << std::hex << word;
  }
}

TEST(Cia402, EveryGoalTimesEveryStateHasItsControlword) {
  const std::array<std::array<int, cia402_states>, cia402_goals> expected{{
      // not ready, disabled, ready, switched on, enabled, quick stop, fault reaction, fault, unknown
      {0x00, 0x00, 0x00, 0x06, 0x07, 0x00, 0x00, 0x00, 0x00},
      {0x00, 0x00, 0x00, 0x06, 0x07, 0x00, 0x00, 0x80, 0x00},
      {0x06, 0x06, 0x07, 0x0F, 0x0F, 0x00, 0x06, 0x06, 0x06},
      {0x02, 0x02, 0x02, 0x02, 0x02, 0x02, 0x02, 0x02, 0x02},
  }};
  for (std::size_t g = 0; g < cia402_goals; ++g) {
    for (std::size_t s = 0; s < cia402_states; ++s) {
      EXPECT_EQ(controlword_for(static_cast<Cia402Goal>(g), static_cast<Cia402State>(s)),
                expected.at(g).at(s))
          << "goal " << g << ", " << name_of(static_cast<Cia402State>(s));
    }
  }
}

TEST(Cia402, ThePeriodIsExactInTheDriveOrRefused) {
  struct Row {
    int rate_hz, value, index;
  };
  for (const Row& row : {Row{1000, 1, -3}, Row{500, 2, -3}, Row{250, 4, -3}, Row{2000, 5, -4},
                         Row{400, 25, -4}, Row{100, 10, -3}, Row{4, 250, -3}, Row{8000, 125, -6}}) {
    const Result<InterpolationPeriod> period = interpolation_period(row.rate_hz);
    ASSERT_TRUE(period) << row.rate_hz;
    EXPECT_EQ(period->value, row.value);
    EXPECT_EQ(period->index, row.index);
    EXPECT_EQ(period->microseconds * row.rate_hz, 1'000'000);
  }
  for (const int rate_hz : {240, 300, 320, 60, 24, 3}) {
    ASSERT_FALSE(interpolation_period(rate_hz)) << rate_hz;
    EXPECT_EQ(interpolation_period(rate_hz).error().code, ErrorCode::accuracy);
  }
  EXPECT_EQ(interpolation_period(0).error().code, ErrorCode::out_of_range);
}

TEST(Cia402, EveryFindingHasWords) {
  for (std::size_t i = 0; i < drive_findings; ++i) {
    const DriveFindingWords words = words_of(static_cast<DriveFinding>(i));
    EXPECT_STRNE(words.what, "") << i;
    EXPECT_STRNE(words.remedy, "") << i;
  }
  EXPECT_EQ(words_of(DriveFinding::following_error).reaction, DriveReaction::own_stop);
  EXPECT_EQ(words_of(DriveFinding::watchdog_unset).reaction, DriveReaction::refuse);
  EXPECT_TRUE(words_of(DriveFinding::unexpected_boot).loses_reference);
}

class SetupOfNode5 : public testing::Test {
 protected:
  Cia402Setup setup{.node = node(5), .host = node(127)};
  DriveObjects objects;
  SetupRunner runner{node(5), 500 * ms};

  void work() { objects.work_off(runner, script_of(setup)); }
  void expect_refused(DriveFinding finding, int index) {
    work();
    ASSERT_EQ(runner.state(), SetupState::refused);
    EXPECT_EQ(runner.refusal().finding, finding) << words_of(runner.refusal().finding).what;
    EXPECT_EQ(runner.refusal().object.index, index) << std::hex << runner.refusal().object.index;
  }
};

TEST(SetupRunner, EveryStateTimesEveryEvent) {
  using enum SetupState;
  const std::array<std::array<SetupState, setup_events>, setup_states> expected{{
      // begin_reading, begin_writing, written, finished, differs
      {reading, writing, idle, done, idle},
      {reading, writing, reading, done, refused},
      {reading, writing, verifying, done, refused},
      {reading, writing, verifying, done, refused},
      {reading, writing, done, done, done},
      {reading, writing, refused, refused, refused},
  }};
  for (std::size_t s = 0; s < setup_states; ++s) {
    for (std::size_t e = 0; e < setup_events; ++e) {
      EXPECT_EQ(next_state(static_cast<SetupState>(s), static_cast<SetupEvent>(e)), expected.at(s).at(e))
          << "state " << s << ", event " << e;
    }
  }
}

TEST_F(SetupOfNode5, WritesWhatTheDriveNeedsAndReadsItBack) {
  setup.following_error_window = 1500;
  setup.following_error_timeout_ms = 10;
  setup.position_limits = CountRange{.min = -100, .max = 200000};
  setup.quick_stop_option = 6;
  setup.vendor = 0x1234;
  setup.product = 0x5678;
  setup.sync_overflow = 10;
  work();
  ASSERT_EQ(runner.state(), SetupState::done);
  EXPECT_EQ(objects.value(0x1600, 0), 2U);
  EXPECT_EQ(objects.value(0x1600, 1), 0x60400010U);
  EXPECT_EQ(objects.value(0x1600, 2), 0x607A0020U);
  EXPECT_EQ(objects.value(0x1A00, 0), 3U);
  EXPECT_EQ(objects.value(0x1A00, 1), 0x60410010U);
  EXPECT_EQ(objects.value(0x1A00, 2), 0x60640020U);
  EXPECT_EQ(objects.value(0x1A00, 3), 0x60610008U);
  EXPECT_EQ(objects.value(0x1400, 1), 0x205U);
  EXPECT_EQ(objects.value(0x1800, 1), 0x40000185U) << "bit 30 stays as it was";
  for (int n = 1; n < 4; ++n) {
    EXPECT_NE(objects.value(0x1400 + n, 1) & 0x80000000, 0U);
    EXPECT_NE(objects.value(0x1800 + n, 1) & 0x80000000, 0U);
  }
  EXPECT_EQ(objects.value(0x1400, 2), 1U);
  EXPECT_EQ(objects.value(0x1800, 2), 1U);
  EXPECT_EQ(objects.value(0x1800, 3), 0U);
  EXPECT_EQ(objects.value(0x1400, 5), 50U);
  EXPECT_EQ(objects.value(0x1006, 0), 0U) << "it watches the host's heartbeat";
  EXPECT_EQ(objects.value(0x1019, 0), 10U);
  EXPECT_EQ(objects.value(0x60C2, 1), 4U);
  EXPECT_EQ(objects.value(0x60C2, 2), 0xFDU);
  EXPECT_EQ(objects.value(0x6065, 0), 1500U);
  EXPECT_EQ(objects.value(0x6066, 0), 10U);
  EXPECT_EQ(objects.value(0x607D, 1), 0xFFFFFF9CU);
  EXPECT_EQ(objects.value(0x607D, 2), 200000U);
  EXPECT_EQ(objects.value(0x605A, 0), 6U);
  EXPECT_EQ(objects.value(0x1029, 1), 0U);
  EXPECT_EQ(objects.value(0x6007, 0), 3U);
  EXPECT_EQ(objects.value(0x1016, 1), 0x007F0064U);
  EXPECT_EQ(objects.value(0x1017, 0), 50U);
  EXPECT_EQ(objects.value(0x6060, 0), 8U);
  EXPECT_EQ(runner.host_timeout_ms(), 100);
  EXPECT_EQ(runner.setpoint_timeout_ms(), 50);
}

TEST_F(SetupOfNode5, MapsInTheOrderOfTheStandard) {
  work();
  using Key = DriveObjects::Key;
  std::vector<std::pair<Key, std::uint32_t>> rpdo;
  for (const auto& [key, value] : objects.written) {
    if (key.first == 0x1400 || key.first == 0x1600) rpdo.emplace_back(key, value);
  }
  const std::vector<std::pair<Key, std::uint32_t>> expected{
      {{0x1400, 1}, 0x80000205}, {{0x1600, 0}, 0}, {{0x1600, 1}, 0x60400010}, {{0x1600, 2}, 0x607A0020},
      {{0x1600, 0}, 2},          {{0x1400, 2}, 1}, {{0x1400, 5}, 50},         {{0x1400, 1}, 0x205}};
  EXPECT_EQ(rpdo, expected);
  std::vector<Key> tpdo;
  for (const auto& [key, value] : objects.written) {
    if (key.first == 0x1800 || key.first == 0x1A00) tpdo.push_back(key);
  }
  const std::vector<Key> order{{0x1800, 1}, {0x1A00, 0}, {0x1A00, 1}, {0x1A00, 2}, {0x1A00, 3},
                               {0x1A00, 0}, {0x1800, 2}, {0x1800, 3}, {0x1800, 5}, {0x1800, 1}};
  EXPECT_EQ(tpdo, order);
}

TEST_F(SetupOfNode5, RefusesAnotherDevice) {
  objects.set(0x1000, 0, 4, 0x00020191);
  expect_refused(DriveFinding::wrong_device, 0x1000);
}
TEST_F(SetupOfNode5, RefusesAnotherProduct) {
  setup.product = 0x9999;
  expect_refused(DriveFinding::wrong_device, 0x1018);
}
TEST_F(SetupOfNode5, RefusesADriveWithoutCyclicPosition) {
  objects.set(0x6502, 0, 4, 0x25);
  expect_refused(DriveFinding::mode_not_offered, 0x6502);
}
TEST_F(SetupOfNode5, RefusesADriveThatProducesSync) {
  objects.set(0x1005, 0, 4, 0x40000080);
  expect_refused(DriveFinding::sync_of_another, 0x1005);
}
TEST_F(SetupOfNode5, RefusesADisabledFollowingErrorWindow) {  // docs/faults.md 25
  objects.set(0x6065, 0, 4, 0xFFFFFFFF);
  expect_refused(DriveFinding::window_disabled, 0x6065);
}
TEST_F(SetupOfNode5, RefusesADriveThatCountsItsPositionsRound) {
  for (const auto& [begin, end] : {std::pair{0U, 360'000U}, std::pair{0xFFFE7960U, 0x7FFFFFFFU},
                                   std::pair{0U, 0x7FFFFFFFU}, std::pair{0x80000000U, 0U}}) {
    objects.set(0x607B, 1, 4, begin);
    objects.set(0x607B, 2, 4, end);
    expect_refused(DriveFinding::counts_round, 0x607B);
  }
}
TEST_F(SetupOfNode5, TakesADriveWhoseRangeIsOffOrThatHasNone) {
  objects.set(0x607B, 1, 4, 0);
  objects.set(0x607B, 2, 4, 0);
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
  objects.remove(0x607B, 1);
  objects.remove(0x607B, 2);
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
}
TEST_F(SetupOfNode5, RefusesAPeriodThatIsNotTaken) {
  objects.freeze(0x60C2, 1);
  expect_refused(DriveFinding::read_back_differs, 0x60C2);
  EXPECT_EQ(runner.refusal().expected, 4U);
  EXPECT_EQ(runner.refusal().found, 20U);
}
TEST_F(SetupOfNode5, RefusesASyncPeriodThatIsNotTaken) {
  objects.set(0x1006, 0, 4, 1000);
  objects.freeze(0x1006, 0);
  expect_refused(DriveFinding::read_back_differs, 0x1006);
}
TEST_F(SetupOfNode5, RefusesAMappingThatIsNotTaken) {
  objects.freeze(0x1A00, 2);
  expect_refused(DriveFinding::read_back_differs, 0x1A00);
}
TEST_F(SetupOfNode5, LeavesAPdoThatNobodyNeedsAndThatIsFixed) {
  for (const int fixed : {0x1402, 0x1803}) {
    objects = {};
    objects.set(fixed, 1, 4, 0x123);
    objects.freeze(fixed, 1);
    work();
    EXPECT_EQ(runner.state(), SetupState::done);
    for (const int pdo : {0x1401, 0x1402, 0x1403, 0x1801, 0x1802, 0x1803}) {
      EXPECT_EQ(runner.has_kept(static_cast<std::uint16_t>(pdo)), pdo == fixed) << std::hex << pdo;
    }
  }
}

TEST_F(SetupOfNode5, RefusesAnRpdoThatItNeedsAndThatIsFixedOtherwise) {
  objects.freeze(0x1400, 1);
  expect_refused(DriveFinding::read_back_differs, 0x1400);
}

TEST_F(SetupOfNode5, NotesTheErrorThatItHas) {
  objects.set(0x603F, 0, 2, 0x7305);
  objects.set(0x1003, 1, 4, 0x8611);
  work();
  EXPECT_EQ(runner.error_code(), 0x7305);
  objects.set(0x603F, 0, 2, 0);
  work();
  EXPECT_EQ(runner.error_code(), 0x8611);
  objects.remove(0x603F, 0);
  objects.remove(0x1003, 1);
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
  EXPECT_EQ(runner.error_code(), 0);
}

TEST_F(SetupOfNode5, RefusesAnotherSerialNumber) {
  objects.set(0x1018, 4, 4, 77);
  setup.serial = 77;
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
  setup.serial = 78;
  expect_refused(DriveFinding::wrong_device, 0x1018);
}

TEST_F(SetupOfNode5, UsesTheRpdoThatItIsToldTo) {
  setup.rpdo = 3;
  work();
  ASSERT_EQ(runner.state(), SetupState::done);
  EXPECT_EQ(objects.value(0x1402, 1), 0x405U);
  EXPECT_EQ(objects.value(0x1602, 2), 0x607A0020U);
  EXPECT_NE(objects.value(0x1400, 1) & 0x80000000, 0U);
  EXPECT_EQ(objects.value(0x1402, 5), 50U);
}

TEST_F(SetupOfNode5, ReportsTheObjectAndTheReasonOfTheDrive) {
  objects.remove(0x6060, 0);
  expect_refused(DriveFinding::sdo_failed, 0x6060);
  EXPECT_EQ(runner.refusal().abort_code, abort_no_object);
}

TEST_F(SetupOfNode5, DoesWithoutObjectsThatADriveNeedNotHave) {
  for (const int index : {0x1401, 0x1402, 0x1403, 0x1801, 0x1802, 0x1803, 0x1029}) objects.remove(index, 1);
  objects.remove(0x1006, 0);
  objects.remove(0x1019, 0);
  objects.remove(0x1800, 3);
  objects.remove(0x1800, 5);
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
}

TEST_F(SetupOfNode5, DoesNotDoWithoutThemForAnotherReason) {
  objects.refuse(0x1029, 1, abort_device_state);
  expect_refused(DriveFinding::sdo_failed, 0x1029);
  EXPECT_EQ(runner.refusal().abort_code, abort_device_state);
}

TEST_F(SetupOfNode5, DoesNotDoWithoutTheCounterThatTheHostSends) {
  setup.sync_overflow = 10;
  objects.remove(0x1019, 0);
  expect_refused(DriveFinding::sdo_failed, 0x1019);
}

TEST_F(SetupOfNode5, ChangesTheCounterWhileSyncHasNoPeriodOnly) {
  setup.sync_overflow = 10;
  objects.set(0x1006, 0, 4, 1000);
  objects.remove(0x1016, 1);
  work();
  using Key = DriveObjects::Key;
  std::vector<std::pair<Key, std::uint32_t>> sync;
  for (const auto& [key, value] : objects.written) {
    if (key.first == 0x1006 || key.first == 0x1019) sync.emplace_back(key, value);
  }
  const std::vector<std::pair<Key, std::uint32_t>> expected{
      {{0x1006, 0}, 0}, {{0x1019, 0}, 10}, {{0x1006, 0}, 4000}};
  EXPECT_EQ(sync, expected);
}

TEST_F(SetupOfNode5, AWatchdogThatIsNotAnsweredForIsNotTakenForAbsent) {
  objects.silence(0x1016, 1);
  expect_refused(DriveFinding::sdo_silent, 0x1016);
}

TEST_F(SetupOfNode5, OneWatchdogOfTheDriveIsEnough) {  // docs/faults.md 29
  objects.remove(0x1016, 1);
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
  EXPECT_EQ(runner.host_timeout_ms(), 0);
  EXPECT_EQ(runner.setpoint_timeout_ms(), 50);
  objects = DriveObjects();
  objects.freeze(0x1400, 5);
  work();
  EXPECT_EQ(runner.state(), SetupState::done);
  EXPECT_EQ(runner.host_timeout_ms(), 100);
  EXPECT_EQ(runner.setpoint_timeout_ms(), 0);
}

TEST_F(SetupOfNode5, WithoutAFiniteWatchdogTheDriveIsRefused) {  // docs/faults.md 29
  objects.remove(0x1016, 1);
  objects.freeze(0x1400, 5);
  work();
  EXPECT_EQ(runner.refusal().finding, DriveFinding::watchdog_unset);

  objects = DriveObjects();
  objects.remove(0x1400, 5);
  objects.set(0x1016, 1, 4, 0x007F0000);
  objects.freeze(0x1016, 1);
  work();
  EXPECT_EQ(runner.refusal().finding, DriveFinding::watchdog_unset) << "0 ms";

  objects.set(0x1016, 1, 4, 0x007F0000 | 201);
  work();
  EXPECT_EQ(runner.refusal().finding, DriveFinding::watchdog_unset) << "more than twice what was asked";

  objects.set(0x1016, 1, 4, 0x007E0000 | 100);
  work();
  EXPECT_EQ(runner.refusal().finding, DriveFinding::watchdog_unset) << "another node";

  objects.set(0x1016, 1, 4, 0x007F0000 | 120);
  work();
  EXPECT_EQ(runner.state(), SetupState::done) << "rounded up";
  EXPECT_EQ(runner.host_timeout_ms(), 120);
}

TEST_F(SetupOfNode5, ASilentDriveIsRefusedAtItsFirstObject) {
  const SetupScript script = script_of(setup);
  runner.begin(script);
  std::vector<Frame> sent;
  for (std::int64_t now = 0; now <= 600 * ms; now += 4 * ms) {
    if (const std::optional<Frame> frame = runner.poll(script, now)) sent.push_back(*frame);
  }
  ASSERT_EQ(sent.size(), 2U) << "the request and its abort";
  EXPECT_EQ(runner.state(), SetupState::refused);
  EXPECT_EQ(runner.refusal().abort_code, abort_timeout);
}

TEST_F(SetupOfNode5, SettingsThatLeaveADriveUnwatchedAreRefused) {
  const Cia402Setup good = setup;
  const auto refuses = [&](auto change) {
    Cia402Setup bad = good;
    change(bad);
    SetupScript script;
    return !write_setup_script(bad, script);
  };
  EXPECT_FALSE(refuses([](Cia402Setup&) {}));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.host = bad.node; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.host_timeout_ms = 0; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.setpoint_timeout_ms = 0; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.drive_heartbeat_ms = 0; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.quick_stop_option = 0; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.quick_stop_option = 9; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.quick_stop_deceleration = 0; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.sync_overflow = 1; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.following_error_window = 0xFFFFFFFF; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.position_limits = CountRange{.min = 1, .max = 1}; }));
  EXPECT_TRUE(refuses([](Cia402Setup& bad) { bad.rate_hz = 240; }));
}

}  // namespace can_cia402_test
}  // namespace inbetween::can
