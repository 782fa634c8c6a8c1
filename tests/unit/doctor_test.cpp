// What the doctor finds on machines, buses and drives with prepared mistakes, and what it says to do.
#include "host_tools/doctor/doctor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if_arp.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/can/can_link.hpp"
#include "drivers/linux/machine_facts.hpp"
#include "host_tools/rig/fault_script.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace doctor_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// The findings that are not fine, "verdict of: what; remedy" a line.
std::string trouble_in(const Findings& findings) {
  std::string text;
  for (const Finding& finding : findings) {
    EXPECT_NE(finding.what, "") << finding.of;
    if (finding.verdict == Verdict::fine) continue;
    EXPECT_NE(finding.remedy, "") << finding.of;
    text += std::string(word_of(finding.verdict)) + " " + finding.of + ": " + finding.what + "; " +
            finding.remedy + "\n";
  }
  return text;
}

// --- the machine

/// A folder with the files in which a kernel tells about itself.
struct Root {
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder.path() / name).parent_path());
    std::ofstream(folder.path() / name) << text << '\n';
  }
  [[nodiscard]] MachineFacts facts() const { return read_machine_facts(folder.path()); }
  TemporaryFolder folder;
};

TEST(Doctor, WhereTheMachineTellsNothingThereIsNothingWrongButItsKernel) {
  const Root root;
  const MachineFacts facts = root.facts();
  EXPECT_EQ(facts.kernel, "");
  EXPECT_THAT(facts.can_interfaces, IsEmpty());
  EXPECT_THAT(trouble_in(check_machine(facts)), HasSubstr("note kernel: it does not tell its version"));
}

TEST(Doctor, ARealTimeKernelOnAPunctualMachineIsFine) {
  const Root root;
  root.write("proc/version",
             "Linux version 6.1.0-18-rt-amd64 (a@b (c) d) (gcc (Debian) 12, ld) #1 SMP PREEMPT_RT x");
  root.write("sys/kernel/realtime", "1");
  root.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
  root.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance");
  root.write("sys/class/net/can0/type", "280");
  root.write("sys/class/net/eth0/type", "1");
  const MachineFacts facts = root.facts();
  EXPECT_EQ(facts.kernel, "6.1.0-18-rt-amd64 #1 SMP PREEMPT_RT x");
  EXPECT_THAT(facts.can_interfaces, ElementsAre("can0"));
  EXPECT_EQ(trouble_in(check_machine(facts)), "");
}

TEST(Doctor, EveryMistakeOfAMachineIsNamedWithItsRemedy) {
  const Root root;
  root.write("proc/version", "Linux version 6.1.0 (who) #1 SMP PREEMPT_DYNAMIC");
  root.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  root.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave");
  root.write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance");
  fs::create_directories(root.folder.path() / "sys/class/net/wlan0/wireless");
  EXPECT_THAT(trouble_in(check_machine(root.facts())),
              AllOf(HasSubstr("note kernel: 6.1.0 #1 SMP PREEMPT_DYNAMIC, which is no real-time kernel"),
                    HasSubstr("note clock: hpet, which takes microseconds"),
                    HasSubstr("changes with the load (cpu0 powersave); as root: echo performance"),
                    HasSubstr("note network: wlan0 is wireless")));
}

TEST(Doctor, ARightThatIsNeededAndRefusedIsAProblem) {
  const std::vector<RealTimeRight> rights{
      {.name = "SCHED_FIFO priority", .refusal = Refusal{.what = "it cannot", .remedy = "run as root"}},
      {.name = "no deep sleep of processors", .is_needed = false, .refusal = Refusal{"no", "nothing"}},
      {.name = "locked memory"}};
  EXPECT_EQ(
      trouble_in(check_rights(rights)),
      "problem SCHED_FIFO priority: it cannot; run as root\nnote no deep sleep of processors: no; nothing\n");
}

TEST(Doctor, AWakeUpMoreThanAQuarterOfATickLateIsANote) {
  WakeLatency latency;
  latency.max_us = 1000;
  EXPECT_EQ(judge(latency, 250).verdict, Verdict::fine);
  latency.max_us = 1001;
  EXPECT_THAT(
      trouble_in({judge(latency, 250)}),
      HasSubstr(
          "note wake-up: at 250 Hz half within 0 us, 99.9 % within 0 us, the worst 1001 us, more than a "
          "quarter of a tick (1000 us)"));
}

// --- a bus

/// An answer of the kernel about a CAN interface.
class LinkAnswer {
 public:
  LinkAnswer(unsigned short type, unsigned flags) {
    nlmsghdr header{};
    header.nlmsg_type = RTM_NEWLINK;
    ifinfomsg interface {};
    interface.ifi_type = type;
    interface.ifi_flags = flags;
    append(header);
    append(interface);
  }
  template <class Value>
  void append(const Value& value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  template <class Value>
  void attribute(unsigned short type, const Value& value) {
    append(rtattr{.rta_len = sizeof(rtattr) + sizeof value, .rta_type = type});
    append(value);
  }
  /// An attribute around what is appended next, `bytes` of it.
  void nest(unsigned short type, std::size_t bytes) {
    append(rtattr{.rta_len = static_cast<unsigned short>(sizeof(rtattr) + bytes), .rta_type = type});
  }
  [[nodiscard]] std::vector<std::byte> bytes() const {
    std::vector<std::byte> bytes = bytes_;
    const auto length = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(bytes.data(), &length, sizeof length);
    return bytes;
  }

 private:
  std::vector<std::byte> bytes_;
};

std::vector<std::byte> answer_of_controller() {
  LinkAnswer answer(ARPHRD_CAN, 1);
  answer.attribute(IFLA_TXQLEN, std::uint32_t{10});
  constexpr std::size_t state = sizeof(rtattr) + 4, timing = sizeof(rtattr) + sizeof(can_bittiming);
  answer.nest(IFLA_LINKINFO, sizeof(rtattr) + state + timing);
  answer.nest(IFLA_INFO_DATA, state + timing);
  answer.attribute(IFLA_CAN_STATE, std::uint32_t{CAN_STATE_ERROR_PASSIVE});
  can_bittiming bits{};
  bits.bitrate = 500'000;
  bits.sample_point = 875;
  answer.attribute(IFLA_CAN_BITTIMING, bits);
  return answer.bytes();
}

TEST(CanLink, TheKernelTellsBitrateSamplePointStateAndQueue) {
  const auto link = can::parse_can_link(answer_of_controller());
  ASSERT_TRUE(link);
  EXPECT_TRUE(link->is_up);
  EXPECT_EQ(link->queue_frames, 10U);
  EXPECT_EQ(link->bitrate, 500'000U);
  EXPECT_EQ(link->sample_point_permille, 875U);
  EXPECT_EQ(link->controller, can::ControllerState::passive);
}

TEST(CanLink, TheKernelTellsWhetherItCarriesCanFdAndHowFast) {
  LinkAnswer answer(ARPHRD_CAN, 1);
  answer.attribute(IFLA_MTU, std::uint32_t{CANFD_MTU});
  constexpr std::size_t timing = sizeof(rtattr) + sizeof(can_bittiming);
  answer.nest(IFLA_LINKINFO, sizeof(rtattr) + timing);
  answer.nest(IFLA_INFO_DATA, timing);
  can_bittiming bits{};
  bits.bitrate = 5'000'000;
  answer.attribute(IFLA_CAN_DATA_BITTIMING, bits);
  const auto link = can::parse_can_link(answer.bytes());
  ASSERT_TRUE(link);
  EXPECT_TRUE(link->carries_fd);
  EXPECT_EQ(link->data_bitrate, 5'000'000U);
  EXPECT_FALSE(can::parse_can_link(answer_of_controller())->carries_fd);
}

TEST(CanLink, AVirtualInterfaceHasNoBitrateAndAnotherKindIsNone) {
  const auto link = can::parse_can_link(LinkAnswer(ARPHRD_CAN, 0).bytes());
  ASSERT_TRUE(link);
  EXPECT_FALSE(link->is_up);
  EXPECT_EQ(link->bitrate, std::nullopt);
  EXPECT_EQ(link->controller, std::nullopt);
  EXPECT_FALSE(can::parse_can_link(LinkAnswer(ARPHRD_ETHER, 1).bytes()));
  EXPECT_FALSE(can::read_can_link("nocan"));
  EXPECT_FALSE(can::read_can_link("lo"));
}

TEST(CanLink, AnAnswerThatIsCutOffOrHasWrongLengthsIsReadNoFurther) {
  const std::vector<std::byte> whole = answer_of_controller();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::vector<std::byte> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_FALSE(can::parse_can_link(part)) << length;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const unsigned byte : {0U, 1U, 3U, 0xFFU}) {
      std::vector<std::byte> wrong = whole;
      wrong[at] = std::byte(byte);
      static_cast<void>(can::parse_can_link(wrong));  // the sanitizers watch
    }
  }
}

constexpr BusNeeds needs{.bitrate = 1'000'000, .frames_per_tick = 7};
const can::CanLink right{.is_up = true,
                         .queue_frames = 10,
                         .bitrate = 1'000'000,
                         .sample_point_permille = 750,
                         .controller = can::ControllerState::active};

TEST(Doctor, ABusAsTheRigNeedsItIsFine) {
  EXPECT_EQ(trouble_in(check_bus("can0", right, needs)), "");
  EXPECT_EQ(trouble_in(check_bus("can0", can::CanLink{.is_up = true}, needs)), "") << "a virtual one";
  EXPECT_EQ(trouble_in(check_bus("can0", right, std::nullopt)), "");
}

TEST(Doctor, EveryMistakeOfABusIsNamedWithItsRemedy) {
  const auto trouble = [](auto change) {
    can::CanLink link = right;
    change(link);
    return trouble_in(check_bus("can0", link, needs));
  };
  EXPECT_THAT(trouble_in(check_bus("can0", std::nullopt, needs)),
              HasSubstr("problem bus can0: there is no such CAN interface; "));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.is_up = false; }),
              HasSubstr("problem bus can0: is down; as root: ip link set can0 up type can bitrate 1000000"));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.bitrate = 500'000; }),
              HasSubstr("problem bus can0: runs at 500000 bit/s, and the rig says 1000000; "));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.sample_point_permille = 500; }),
              HasSubstr("note bus can0: 1000000 bit/s, sampled at 50.0 % of a bit, where CANopen"));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.controller = can::ControllerState::warning; }),
              HasSubstr("note bus can0: has seen many errors"));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.controller = can::ControllerState::passive; }),
              HasSubstr("problem bus can0: is error-passive: nobody acknowledges"));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.controller = can::ControllerState::bus_off; }),
              HasSubstr("problem bus can0: is bus-off; "));
  EXPECT_THAT(
      trouble([](can::CanLink& link) { link.queue_frames = 6; }),
      HasSubstr("problem bus can0: holds 6 frames to be sent, and a tick has 7; as root: ip link set can0 "
                "txqueuelen 14"));
  EXPECT_THAT(trouble([](can::CanLink& link) { link.queue_frames = 1000; }),
              HasSubstr("note bus can0: holds 1000"));
}

TEST(Doctor, WhatABusHasIsFineUpToEachBound) {
  const auto trouble = [](auto change) {
    can::CanLink link = right;
    change(link);
    return trouble_in(check_bus("can0", link, needs));
  };
  for (const std::uint32_t permille : {700U, 900U}) {
    EXPECT_EQ(trouble([&](can::CanLink& link) { link.sample_point_permille = permille; }), "") << permille;
  }
  for (const std::uint32_t permille : {699U, 901U}) {
    EXPECT_THAT(trouble([&](can::CanLink& link) { link.sample_point_permille = permille; }),
                HasSubstr("where CANopen recommends 87.5 %"))
        << permille;
  }
  for (const std::uint32_t frames : {7U, 128U}) {
    EXPECT_EQ(trouble([&](can::CanLink& link) { link.queue_frames = frames; }), "") << frames;
  }
  EXPECT_THAT(trouble([](can::CanLink& link) { link.queue_frames = 129; }),
              HasSubstr("note bus can0: holds 129 frames to be sent: after a fault of the cable"));
}

TEST(Doctor, AnInterfaceThatIsDownIsOneMistakeAndItsControllerIsNoOther) {
  can::CanLink link = right;
  link.is_up = false;
  link.controller = can::ControllerState::bus_off;
  EXPECT_EQ(trouble_in(check_bus("can0", link, std::nullopt)),
            "problem bus can0: is down; as root: ip link set can0 up\n");
}

TEST(Doctor, ABusOfCanFdIsAsTheRigSays) {
  constexpr BusNeeds fd{.bitrate = 1'000'000, .data_bitrate = 5'000'000, .frames_per_tick = 7};
  can::CanLink link = right;
  EXPECT_THAT(
      trouble_in(check_bus("can0", link, fd)),
      HasSubstr("problem bus can0: does not carry CAN FD frames, which its drives speak; as root: ip "
                "link set can0 down; ip link set can0 up type can bitrate 1000000 dbitrate 5000000 fd on"));
  link.carries_fd = true;
  link.data_bitrate = 2'000'000;
  EXPECT_THAT(trouble_in(check_bus("can0", link, fd)),
              HasSubstr("problem bus can0: sends data with 2000000 bit/s, and the rig says 5000000; "));
  link.data_bitrate = 5'000'000;
  link.sample_point_permille = 666;
  EXPECT_EQ(trouble_in(check_bus("can0", link, fd)), "");
  const can::CanLink virtual_one{.is_up = true};
  EXPECT_THAT(trouble_in(check_bus("can0", virtual_one, fd)), HasSubstr("ip link set can0 mtu 72 up"));
}

// --- drives

const std::string two_axes = pan_and_tilt_text();

/// The drives of that rig with the faults of a script, on a clock that takes no time.
Findings visit(const std::string& faults = "") {
  const RigFile rig = parse_rig(two_axes, "rig.toml");
  SimulatedHardware hardware(rig, {0, 0},
                             faults.empty() ? FaultScript{} : parse_fault_script(faults, "faults.toml", rig));
  std::int64_t now_ns = 10'000'000'000;  // the machine has been on for longer than a drive may take to boot
  return check_drives(rig, hardware, [&] { return now_ns += 4'000'000; });
}
std::string fault(const std::string& lines) {
  return "[[fault]]\naxis = \"tilt\"\n" + lines + "\n";
}

TEST(Doctor, DrivesAreSetUpWithoutPowerAndWhatTheyHaveIsTold) {
  const Findings findings = visit();
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(trouble_in(findings), "");
  EXPECT_EQ(findings[1].of, "axis \"tilt\"");
  EXPECT_EQ(findings[1].what, "node 2 has mode 8, the period of 250 Hz and a watchdog of 20 ms");
}

TEST(Doctor, EveryMistakeOfADriveIsNamedWithItsRemedyAndTheOthersAreLookedAt) {
  struct Mistake {
    std::string lines, words;
  };
  for (const auto& [lines, words] : {
           Mistake{"what = \"lose-frames\"\nat = 0\ndirection = \"from-drive\"",
                   "no boot-up message came from the drive; look at"},
           Mistake{"what = \"no-watchdog\"", "the drive would run on if this program died (object 1016h:1"},
           Mistake{"what = \"no-window\"", "the drive does not watch its following error (object 6065h:0 is"},
           Mistake{"what = \"fixed-object\"\nobject = 0x60C2\nsub = 1\nvalue = 2",
                   "60C2h:1 is 2 (2h), not 4 (4h)"},
           Mistake{"what = \"no-object\"\nobject = 0x6064", "object 1A00h:2"},
       }) {
    const Findings findings = visit(fault(lines));
    ASSERT_EQ(findings.size(), 2U);
    EXPECT_EQ(findings[0].verdict, Verdict::fine) << findings[0].what;
    EXPECT_THAT(trouble_in(findings), AllOf(HasSubstr("problem axis \"tilt\": "), HasSubstr(words)));
  }
}

TEST(Doctor, TwoDevicesWithOneNodeAreFound) {
  EXPECT_THAT(trouble_in(visit(fault("what = \"flood\"\nat = 0\nframes_per_s = 200"))),
              HasSubstr("problem axis \"tilt\": two devices answer as node 2; give each device"));
}

/// A simulated rig that keeps what is sent on its buses.
class OverheardHardware : public RigHardware {
 public:
  explicit OverheardHardware(const RigFile& rig) : simulated_(rig, {0, 0}) {}
  [[nodiscard]] const std::vector<can::Frame>& sent() const { return sent_; }

  void advance(std::int64_t now_ns) override { simulated_.advance(now_ns); }
  std::unique_ptr<ChipOutputs> open_steps(const std::string& chip, std::span<const std::size_t> axes,
                                          std::span<const StepLines> wires) override {
    return simulated_.open_steps(chip, axes, wires);
  }
  std::unique_ptr<ChipOutputs> open_pulses(const std::string& chip,
                                           std::span<const PulseLine> lines) override {
    return simulated_.open_pulses(chip, lines);
  }
  std::string chip_of(const LineAddress& line) override { return simulated_.chip_of(line); }
  std::vector<OpenedInputs> open_inputs(std::span<const InputLine* const> lines) override {
    return simulated_.open_inputs(lines);
  }
  std::unique_ptr<AxisDrives> open_others(std::span<const std::size_t> axes) override {
    return simulated_.open_others(axes);
  }

 private:
  struct Link : BusLink<can::Frame> {
    Link(std::unique_ptr<BusLink<can::Frame>> to_simulation, std::vector<can::Frame>& of_rig)
        : link(std::move(to_simulation)), sent(of_rig) {}
    [[nodiscard]] bool is_up() const override { return link->is_up(); }
    std::size_t receive(std::span<can::Frame> in, std::int64_t now_ns) override {
      return link->receive(in, now_ns);
    }
    std::size_t send(std::span<const can::Frame> out) override {
      sent.insert(sent.end(), out.begin(), out.end());
      return link->send(out);
    }
    std::size_t drain() override { return link->drain(); }

    std::unique_ptr<BusLink<can::Frame>> link;
    std::vector<can::Frame>& sent;
  };

  std::unique_ptr<BusLink<can::Frame>> open_classic_bus(const std::string& bus,
                                                        std::span<const std::size_t> axes) override {
    return std::make_unique<Link>(simulated_.open_bus<can::Frame>(bus, axes), sent_);
  }
  std::unique_ptr<BusLink<can::FdFrame>> open_fd_bus(const std::string& bus,
                                                     std::span<const std::size_t> axes) override {
    return simulated_.open_bus<can::FdFrame>(bus, axes);
  }

  SimulatedHardware simulated_;
  std::vector<can::Frame> sent_;
};

TEST(Doctor, DrivesThatWereVisitedAreSwitchedOffAndDoNotWaitForAHostThatHasLeft) {
  const RigFile rig = parse_rig(two_axes, "rig.toml");
  OverheardHardware hardware(rig);
  std::int64_t now_ns = 10'000'000'000;
  ASSERT_EQ(trouble_in(check_drives(rig, hardware, [&] { return now_ns += 4'000'000; })), "");
  for (const unsigned node : {1U, 2U}) {
    // CiA 301: object 1016h:1 is the time after which the drive misses the heartbeat of its host.
    std::vector<std::uint32_t> watchdogs;
    for (const can::Frame& frame : hardware.sent()) {
      const bool is_watchdog = frame.id.number() == 0x600U + node && frame.data[0] == 0x23 &&
                               frame.data[1] == 0x16 && frame.data[2] == 0x10 && frame.data[3] == 1;
      if (is_watchdog) watchdogs.push_back(frame.data[4] + 256U * frame.data[5]);
    }
    EXPECT_THAT(watchdogs, ElementsAre(testing::Gt(0U), 0U)) << "node " << node;
  }
}

// --- the command

TEST(DoctorCommand, RunsAnywhereWithALineForEachFindingAndTheSameInJson) {
  const ProgramRun run = run_program({"doctor", "--seconds", "0.02", "--json", "-"});
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(run.status, json["fit"] ? 0 : 4);
  EXPECT_EQ(static_cast<std::size_t>(std::count(run.err.begin(), run.err.end(), '\n')),
            json["findings"].size());
  for (const auto& finding : json["findings"]) {
    const std::string words = std::string(finding["of"]) + ": " + std::string(finding["what"]);
    EXPECT_THAT(run.err, HasSubstr(words));
    EXPECT_EQ(finding["remedy"] == "", finding["verdict"] == "fine") << words;
  }
  EXPECT_GE(json["wake_latency_us"]["max"], json["wake_latency_us"]["p50"]);
}

TEST(DoctorCommand, LooksAtBusesAndLinesOfARigAndNothingElse) {
  const ProgramRun run =
      run_program({"doctor", "--seconds", "0", "--rig", in_checkout("examples/mixed_rig.toml")});
  EXPECT_EQ(run.status, 4);
  EXPECT_THAT(run.out, AllOf(HasSubstr("fine     rig: "), HasSubstr("\nproblem  "),
                             HasSubstr("examples/mixed_rig.toml:11:12: there is no GPIO chip labelled")));
  EXPECT_THAT(run.out, testing::Not(HasSubstr("wake-up")));
  std::istringstream text(run.out);
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  EXPECT_EQ(std::ranges::adjacent_find(lines), lines.end()) << "the three lines of a drive have one place";
  EXPECT_EQ(run_program({"doctor", "--drives"}).status, 2);
}

}  // namespace doctor_test
}  // namespace inbetween
