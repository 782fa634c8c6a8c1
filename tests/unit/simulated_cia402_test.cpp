// The simulated CiA 402 drive held to the standards, without the host's side.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "inbetween/can/nmt.hpp"
#include "inbetween/can/sdo.hpp"
#include "sim/can_bus.hpp"
#include "sim/cia402_drive.hpp"
#include "sim/simulated_motor.hpp"

namespace inbetween {
namespace simulated_cia402_test {

using can::Cia402State;
using can::Frame;
using can::NmtState;

constexpr std::int64_t ms = 1'000'000;

can::NodeId node(int number) {
  return can::NodeId::make(number).value();
}

class SimulatedDrive : public testing::Test {
 protected:
  SimulatedCia402Drive drive{{.node = node(5), .position = 1000, .keeps_record = true}, 0};
  std::int64_t now = 0;

  std::vector<Frame> pass(std::int64_t ns) {
    now += ns;
    drive.advance(now);
    return drive.take_frames();
  }
  std::vector<Frame> hear(const Frame& frame) {
    drive.receive(frame);
    return drive.take_frames();
  }
  void boot() { pass(60 * ms); }
  void obey(can::NmtCommand command) { hear(can::nmt_frame({.command = command, .node = 5})); }
  can::SdoMessage ask(const can::SdoMessage& request) {
    const std::vector<Frame> answers = hear(can::sdo_frame(0x605, request));
    EXPECT_EQ(answers.size(), 1U);
    return answers.empty() ? can::SdoMessage{} : can::read_sdo_answer(answers[0]).value();
  }
  /// 0 or the reason of the abort.
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
    const can::SdoMessage answer = ask({.kind = can::SdoKind::download,
                                        .object = {.index = index, .sub = sub},
                                        .size = size,
                                        .value = value});
    return answer.kind == can::SdoKind::abort ? answer.value : 0;
  }
  std::uint32_t read(std::uint16_t index, std::uint8_t sub = 0) {
    return ask({.kind = can::SdoKind::upload, .object = {.index = index, .sub = sub}}).value;
  }
  void map() {
    EXPECT_EQ(write(0x1400, 1, 4, 0x80000205), 0U);
    EXPECT_EQ(write(0x1600, 0, 1, 0), 0U);
    EXPECT_EQ(write(0x1600, 1, 4, 0x60400010), 0U);
    EXPECT_EQ(write(0x1600, 2, 4, 0x607A0020), 0U);
    EXPECT_EQ(write(0x1600, 0, 1, 2), 0U);
    EXPECT_EQ(write(0x1400, 2, 1, 1), 0U);
    EXPECT_EQ(write(0x1400, 1, 4, 0x205), 0U);
  }
  /// One tick: the command, SYNC 4 ms later.
  std::vector<Frame> command(std::uint16_t word, std::int32_t target = 1000) {
    std::vector<Frame> heard = hear(can::command_frame(node(5), {.controlword = word, .target = target}));
    const std::vector<Frame> passed = pass(4 * ms);
    heard.insert(heard.end(), passed.begin(), passed.end());
    const std::vector<Frame> synced = hear({.id = 0x080});
    heard.insert(heard.end(), synced.begin(), synced.end());
    return heard;
  }
  void bring_to_operation() {
    boot();
    map();
    write(0x60C2, 1, 1, 4);
    EXPECT_EQ(write(0x6060, 0, 1, 8), 0U);
    obey(can::NmtCommand::start);
    for (const std::uint16_t word : std::array<std::uint16_t, 3>{0x0006, 0x0007, 0x000F}) command(word);
    for (int i = 0; i < 30; ++i) command(0x000F);
    ASSERT_EQ(drive.state(), Cia402State::operation_enabled);
  }
  static std::vector<std::uint16_t> emergencies(const std::vector<Frame>& frames) {
    std::vector<std::uint16_t> codes;
    for (const Frame& frame : frames) {
      if (const auto emergency = can::read_emergency(frame, node(5))) codes.push_back(emergency->code);
    }
    return codes;
  }
};

TEST_F(SimulatedDrive, AnswersWhetherItLivesWithAnotherToggleBitEachTime) {
  boot();
  const Frame question{.id = 0x705, .is_remote = true, .length = 1};
  for (const unsigned state : {0x7FU, 0xFFU, 0x7FU}) {
    EXPECT_EQ(hear(question),
              (std::vector{Frame{.id = 0x705, .length = 1, .data = {static_cast<std::uint8_t>(state)}}}));
  }
  EXPECT_EQ(write(0x1017, 0, 2, 50), 0U);
  pass(1 * ms);
  EXPECT_TRUE(hear(question).empty()) << "it has heartbeats";
}

TEST_F(SimulatedDrive, LeavesOperationalWhenNobodyHasAskedForItsLifeTime) {
  boot();
  EXPECT_EQ(write(0x100C, 0, 2, 30), 0U);
  EXPECT_EQ(write(0x100D, 0, 1, 4), 0U);
  EXPECT_EQ(write(0x1029, 1, 1, 0), 0U);
  obey(can::NmtCommand::start);
  EXPECT_TRUE(pass(500 * ms).empty()) << "watched from the first question on";
  hear(can::guard_request_frame(node(5)));
  EXPECT_TRUE(pass(119 * ms).empty());
  const std::vector<Frame> told = pass(2 * ms);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(can::read_emergency(told[0], node(5)).value().code, 0x8130);
  EXPECT_EQ(drive.nmt(), NmtState::pre_operational);
}

TEST_F(SimulatedDrive, TellsOnceThatItHasBootedAndIsPreOperational) {
  EXPECT_TRUE(pass(49 * ms).empty());
  const std::vector<Frame> frames = pass(ms);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(can::read_heartbeat(frames[0], node(5)), NmtState::boot_up);
  EXPECT_EQ(drive.nmt(), NmtState::pre_operational);
  EXPECT_TRUE(pass(1000 * ms).empty()) << "no heartbeats from the factory";
  EXPECT_EQ(write(0x1017, 0, 2, 50), 0U);
  EXPECT_EQ(pass(1000 * ms).size(), 20U);
}

TEST_F(SimulatedDrive, HearsNothingBeforeItHasBooted) {
  EXPECT_TRUE(
      hear(can::sdo_frame(0x605, {.kind = can::SdoKind::upload, .object = {.index = 0x1000}})).empty());
}

TEST_F(SimulatedDrive, RefusesWithTheReasonsOfTheStandard) {
  boot();
  EXPECT_EQ(read(0x1000), 0x00020192U);
  EXPECT_EQ(read(0x6064), 1000U);
  EXPECT_EQ(write(0x6041, 0, 2, 1), can::abort_read_only);
  EXPECT_EQ(write(0x2000, 0, 2, 1), can::abort_no_object);
  EXPECT_EQ(write(0x607D, 3, 4, 1), can::abort_no_sub_index);
  EXPECT_EQ(write(0x6060, 0, 2, 8), can::abort_wrong_length);
  EXPECT_EQ(write(0x6060, 0, 1, 2), can::abort_bad_value);
  EXPECT_EQ(write(0x6007, 0, 2, 4), can::abort_too_high);
  EXPECT_EQ(write(0x60C2, 1, 1, 0), can::abort_too_low);
  EXPECT_EQ(write(0x1019, 0, 1, 1), can::abort_bad_value);
  EXPECT_EQ(write(0x1006, 0, 4, 4000), 0U);
  EXPECT_EQ(write(0x1019, 0, 1, 10), can::abort_device_state);
  EXPECT_EQ(ask({.kind = can::SdoKind::announce_download, .object = {.index = 0x6060}, .value = 9}).value,
            can::abort_wrong_length);
}

TEST_F(SimulatedDrive, TakesAMappingInTheOrderOfTheStandardOnly) {
  boot();
  EXPECT_EQ(write(0x1600, 0, 1, 0), can::abort_unsupported_access) << "the PDO is valid";
  EXPECT_EQ(write(0x1400, 1, 4, 0x206), can::abort_bad_value) << "nor can it be moved";
  EXPECT_EQ(write(0x1800, 3, 2, 10), can::abort_unsupported_access);
  EXPECT_EQ(write(0x1400, 1, 4, 0x80000205), 0U);
  EXPECT_EQ(write(0x1600, 1, 4, 0x607A0020), can::abort_unsupported_access) << "there are objects in it";
  EXPECT_EQ(write(0x1600, 0, 1, 0), 0U);
  EXPECT_EQ(write(0x1400, 1, 4, 0x205), can::abort_bad_value) << "it is empty";
  EXPECT_EQ(write(0x1600, 1, 4, 0x10000020), can::abort_not_mappable);
  EXPECT_EQ(write(0x1600, 1, 4, 0x607A0020), 0U);
  EXPECT_EQ(write(0x1600, 2, 4, 0x607A0020), 0U);
  EXPECT_EQ(write(0x1600, 3, 4, 0x60400010), 0U);
  EXPECT_EQ(write(0x1600, 0, 1, 3), can::abort_pdo_too_long);
  EXPECT_EQ(write(0x1600, 0, 1, 9), can::abort_pdo_too_long);
  EXPECT_EQ(write(0x1600, 0, 1, 2), 0U);
  EXPECT_EQ(write(0x1400, 2, 1, 250), can::abort_bad_value);
  EXPECT_EQ(write(0x1400, 1, 4, 0x180), can::abort_bad_value) << "a restricted identifier";
  EXPECT_EQ(write(0x1400, 1, 4, 0x205), 0U);
}

TEST_F(SimulatedDrive, AFaultIsResetByARisingEdge) {
  bring_to_operation();
  drive.add_trouble(
      {.kind = DriveTrouble::Kind::emergency, .at_ns = now, .for_ns = 100 * ms, .value = 0x2310});
  EXPECT_EQ(emergencies(command(0x000F)), (std::vector<std::uint16_t>{0x2310}));
  command(0x0080);
  EXPECT_EQ(drive.state(), Cia402State::fault);
  pass(200 * ms);
  command(0x0080);
  EXPECT_EQ(drive.state(), Cia402State::fault) << "no edge";
  command(0x0000);
  EXPECT_EQ(emergencies(command(0x0080)), (std::vector<std::uint16_t>{0}));
  EXPECT_EQ(drive.state(), Cia402State::switch_on_disabled);
}

TEST_F(SimulatedDrive, TakesItsTimeToBeEnabled) {
  boot();
  map();
  obey(can::NmtCommand::start);
  command(0x0006);
  EXPECT_EQ(drive.state(), Cia402State::ready_to_switch_on);
  command(0x0007);
  EXPECT_EQ(drive.state(), Cia402State::switched_on);
  for (int i = 0; i < 25; ++i) command(0x000F);
  EXPECT_EQ(drive.state(), Cia402State::switched_on);
  command(0x000F);
  EXPECT_EQ(drive.state(), Cia402State::operation_enabled);
}

TEST_F(SimulatedDrive, SupervisesTheHostFromItsFirstHeartbeatOn) {
  bring_to_operation();
  EXPECT_EQ(write(0x6007, 0, 2, 3), 0U);
  EXPECT_EQ(write(0x1016, 1, 4, 0x007F0064), 0U);
  hear({.id = 0x77F, .length = 1, .data = {0x00}});
  EXPECT_TRUE(emergencies(pass(500 * ms)).empty()) << "a boot-up message is none";
  hear({.id = 0x77F, .length = 1, .data = {0x05}});
  EXPECT_TRUE(emergencies(pass(99 * ms)).empty());
  EXPECT_EQ(emergencies(pass(2 * ms)), (std::vector<std::uint16_t>{0x8130}));
  EXPECT_NE(drive.state(), Cia402State::operation_enabled);
  EXPECT_TRUE(emergencies(pass(500 * ms)).empty()) << "told once";
}

TEST_F(SimulatedDrive, MissesSetpointsFromTheFirstOn) {
  bring_to_operation();
  EXPECT_EQ(write(0x1400, 5, 2, 50), 0U);
  EXPECT_TRUE(emergencies(pass(500 * ms)).empty());
  command(0x000F);
  EXPECT_EQ(emergencies(pass(60 * ms)), (std::vector<std::uint16_t>{0x8250}));
}

TEST_F(SimulatedDrive, MissesSyncAfterOneAndAHalfPeriods) {
  bring_to_operation();
  EXPECT_EQ(write(0x1006, 0, 4, 4000), 0U);
  command(0x000F);
  EXPECT_TRUE(emergencies(pass(5 * ms)).empty());
  EXPECT_EQ(emergencies(pass(2 * ms)), (std::vector<std::uint16_t>{0x8100}));
}

TEST_F(SimulatedDrive, ReactsToLostCommunicationAsItIsTold) {
  struct Row {
    std::uint32_t option;
    Cia402State state;
  };
  for (const Row& row : {Row{0, Cia402State::operation_enabled}, Row{1, Cia402State::fault},
                         Row{2, Cia402State::switch_on_disabled}, Row{3, Cia402State::quick_stop_active}}) {
    drive = SimulatedCia402Drive({.node = node(5), .position = 1000, .keeps_record = true}, now);
    bring_to_operation();
    EXPECT_EQ(write(0x6007, 0, 2, row.option), 0U);
    EXPECT_EQ(write(0x605A, 0, 2, 6), 0U);
    obey(can::NmtCommand::enter_pre_operational);
    pass(100 * ms);
    EXPECT_EQ(drive.state(), row.state) << row.option;
  }
}

TEST_F(SimulatedDrive, AQuickStopEndsWithoutPowerUnlessItIsToldToStay) {
  bring_to_operation();
  command(0x0002);
  EXPECT_EQ(drive.state(), Cia402State::quick_stop_active);
  command(0x0002);
  EXPECT_EQ(drive.state(), Cia402State::switch_on_disabled) << "605A is 2 from the factory";
}

TEST_F(SimulatedDrive, APdoOfAnotherLengthIsReported) {
  bring_to_operation();
  EXPECT_EQ(emergencies(hear({.id = 0x205, .length = 5})), (std::vector<std::uint16_t>{0x8210}));
  EXPECT_EQ(emergencies(hear({.id = 0x205, .length = 7, .data = {0x0F}})),
            (std::vector<std::uint16_t>{0x8220}));
  EXPECT_EQ(emergencies(hear({.id = 0x080, .length = 1, .data = {1}})), (std::vector<std::uint16_t>{0x8240}));
}

TEST_F(SimulatedDrive, AppliesATargetWithTheNextSync) {
  bring_to_operation();
  const std::size_t before = drive.record().applied.size();
  hear(can::command_frame(node(5), {.controlword = 0x000F, .target = 1234}));
  EXPECT_EQ(drive.record().applied.size(), before);
  EXPECT_NE(drive.objects().value(0x607A), 1234U);
  pass(4 * ms);
  hear({.id = 0x080});
  ASSERT_EQ(drive.record().applied.size(), before + 1);
  EXPECT_EQ(drive.record().applied.back().target, 1234);
  EXPECT_EQ(drive.record().applied.back().at_ns, now);
}

TEST_F(SimulatedDrive, ForgetsTargetsThatWaitWhenItLeavesOperational) {
  bring_to_operation();
  EXPECT_EQ(write(0x6007, 0, 2, 0), 0U);
  hear(can::command_frame(node(5), {.controlword = 0x000F, .target = 1234}));
  obey(can::NmtCommand::enter_pre_operational);
  obey(can::NmtCommand::start);
  hear({.id = 0x080});
  EXPECT_EQ(drive.record().applied.back().target, 1000);
}

TEST_F(SimulatedDrive, ANewHeartbeatPeriodBeginsAtOnce) {
  boot();
  write(0x1017, 0, 2, 1000);
  EXPECT_EQ(pass(10 * ms).size(), 1U);
  write(0x1017, 0, 2, 50);
  EXPECT_EQ(pass(60 * ms).size(), 2U);
}

TEST_F(SimulatedDrive, TellsItsPositionAtEverySecondSyncIfItIsToldTo) {
  boot();
  map();
  EXPECT_EQ(write(0x1800, 2, 1, 2), 0U);
  obey(can::NmtCommand::start);
  int told = 0;
  for (int i = 0; i < 10; ++i) {
    for (const Frame& frame : hear({.id = 0x080})) told += frame.id == 0x185 ? 1 : 0;
  }
  EXPECT_EQ(told, 5);
}

TEST_F(SimulatedDrive, AFollowingErrorMustLastAsLongAsItIsTold) {
  bring_to_operation();
  EXPECT_EQ(write(0x6065, 0, 4, 100), 0U);
  EXPECT_EQ(write(0x6066, 0, 2, 200), 0U);
  drive.add_trouble({.kind = DriveTrouble::Kind::stick, .at_ns = now});
  EXPECT_TRUE(emergencies(command(0x000F, 1500)).empty());
  std::vector<std::uint16_t> codes;
  for (int i = 0; i < 45; ++i) EXPECT_TRUE(emergencies(command(0x000F, 1500)).empty()) << i;
  for (int i = 0; i < 10; ++i) {
    for (const std::uint16_t code : emergencies(command(0x000F, 1500))) codes.push_back(code);
  }
  EXPECT_EQ(codes, (std::vector<std::uint16_t>{0x8611}));
}

TEST_F(SimulatedDrive, KeepsItsSoftLimitsAndSaysSo) {
  bring_to_operation();
  EXPECT_EQ(write(0x607D, 1, 4, 900), 0U);
  EXPECT_EQ(write(0x607D, 2, 4, 1100), 0U);
  for (int i = 0; i < 100; ++i) command(0x000F, std::min(1000 + 10 * i, 1500));
  EXPECT_NEAR(drive.position(), 1100, 1);
  EXPECT_NE(read(0x6041) & can::status_internal_limit, 0U);
}

TEST_F(SimulatedDrive, ADriveThatIsStoppedHearsNothingButNmt) {
  boot();
  obey(can::NmtCommand::stop);
  EXPECT_TRUE(
      hear(can::sdo_frame(0x605, {.kind = can::SdoKind::upload, .object = {.index = 0x1000}})).empty());
  obey(can::NmtCommand::reset_communication);
  EXPECT_EQ(pass(60 * ms).size(), 1U);
}

TEST_F(SimulatedDrive, AResetOfItsCommunicationForgetsWhatBelongsToItOnly) {
  boot();
  write(0x1017, 0, 2, 50);
  write(0x6065, 0, 4, 77);
  obey(can::NmtCommand::reset_communication);
  boot();
  EXPECT_EQ(read(0x1017), 0U);
  EXPECT_EQ(read(0x6065), 77U);
  obey(can::NmtCommand::reset_node);
  boot();
  EXPECT_EQ(read(0x6065), 2000U);
}

TEST(SimulatedMotor, SettlesWhereItIsWantedInSpiteOfFriction) {
  SimulatedMotor motor({}, 0);
  for (int i = 0; i < 4000; ++i) motor.follow({.position = 100}, 250e-6);
  EXPECT_NEAR(motor.position(), 100, 0.2);
  EXPECT_NEAR(motor.velocity(), 0, 0.1);
}

TEST(SimulatedMotor, ItsAccelerationIsLimitedByItsCurrent) {
  SimulatedMotor motor({.max_acceleration = 1000, .friction = 0, .viscous_friction = 0}, 0);
  for (int i = 0; i < 400; ++i) motor.follow({.position = 1e6}, 250e-6);
  EXPECT_NEAR(motor.velocity(), 100, 1e-6);
}

TEST(SimulatedMotor, RollsToAStandWithoutCurrentAndStaysThere) {
  SimulatedMotor motor({}, 0);
  for (int i = 0; i < 400; ++i) motor.follow({.position = 1e4, .velocity = 1e4}, 250e-6);
  for (int i = 0; i < 4000; ++i) motor.coast(250e-6);
  EXPECT_EQ(motor.velocity(), 0);
  const double rest = motor.position();
  motor.coast(1);
  EXPECT_EQ(motor.position(), rest);
  motor.hold(true);
  motor.follow({.position = 0}, 250e-6);
  EXPECT_EQ(motor.position(), rest);
}

TEST(SimulatedCanBus, TheLowestIdentifierIsHeardFirstAndNobodyHearsHimself) {
  SimulatedCanBus bus;
  std::vector<std::uint32_t> order;
  bus.set_fate([&](const Frame& frame, std::int64_t) {
    order.push_back(frame.id.number());
    return FrameFate{.copies = frame.id == 0x123 ? 2 : 1, .delay_ns = frame.id == 0x080 ? 5 : 0};
  });
  bus.send({.id = 0x77F, .length = 1, .data = {5}});
  bus.inject({.id = 0x7FF});
  bus.inject({.id = 0x123});
  bus.inject({.id = 0x080});
  std::vector<std::uint32_t> heard;
  for (const Frame& frame : bus.run(0)) heard.push_back(frame.id.number());
  EXPECT_EQ(heard, (std::vector<std::uint32_t>{0x123, 0x123, 0x7FF}));
  EXPECT_EQ(order.size(), 4U);
  EXPECT_TRUE(bus.run(4).empty());
  EXPECT_EQ(bus.run(5).size(), 1U);
}

}  // namespace simulated_cia402_test
}  // namespace inbetween
