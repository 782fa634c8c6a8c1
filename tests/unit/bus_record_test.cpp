// docs/bench.md shows every frame of a run: held against what is on a simulated bus.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/rig/cia402_kind.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "inbetween/can/cia402_port.hpp"
#include "sim/simulated_link.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace bus_record_test {

const std::string rig_of_document =
    rig_text({axis_text("slide", "mm", {-10, 200}, {.velocity = 200, .acceleration = 800},
                        "reference = \"drive\"", cia402_text(5))},
             {.rate_hz = 250, .more = bus_can0});

/// As candump -L writes it.
std::string text_of(const can::Frame& frame) {
  std::string text = fmt::format("{:03X}#", frame.id.number());
  for (std::size_t i = 0; i < frame.length; ++i) text += fmt::format("{:02X}", frame.data[i]);
  return text;
}

/// Every frame from power-on until nothing is sent any more, with the axis taken to 40 mm and held there.
std::vector<std::string> record_of_a_run() {
  const RigFile rig = parse_rig(rig_of_document, "rig.toml");
  std::vector<can::Cia402Drive> host{*can::Cia402Drive::make(settings_of(rig.axes[0], rig.rate_hz))};
  can::Cia402Bus bus = *can::Cia402Bus::make(host, {.host = *can::NodeId::make(127)});
  SimulatedCia402Drive drive(simulated_settings_of(rig.axes[0], 0), 0);
  std::vector<std::string> record;
  SimulatedCanBus wire;
  wire.attach(drive);
  wire.set_fate([&](const can::Frame& frame, std::int64_t) {
    record.push_back(text_of(frame));
    return FrameFate{};
  });
  SimulatedLink link(wire);
  std::array<std::int32_t, 1> targets{};
  std::array<can::PortDrive, 1> known{};
  std::array<can::Frame, can::frames_per_read(1)> frames{};
  const std::array lanes{can::Cia402Lane<SimulatedLink>{&bus, &link, targets, known, frames}};
  std::array axes{can::Cia402Axis{0, 0, 1000}};
  auto port = *can::Cia402Port<SimulatedLink>::make(lanes, axes);
  std::array<DriveState, 1> states{};
  std::array<Setpoint, 1> setpoints{};
  std::int64_t now_ns = 60'000'000;
  link.receive({}, now_ns);  // it has power for a while
  port.enable();
  int ticks_on = 0;
  for (int tick = 0; tick < 3000 && (ticks_on == 0 || ticks_on < 200 || states[0].is_leaving); ++tick) {
    port.read(states, now_ns += 4'000'000);
    if (states[0].is_on) ++ticks_on;
    if (ticks_on > 1) setpoints[0].position = std::min(40.0, 0.5 * (ticks_on - 1));
    if (ticks_on == 200 && states[0].is_on) {
      port.disable();
      states[0].is_leaving = true;
    }
    if (states[0].is_on) {
      port.write(setpoints, now_ns);
    } else {
      port.write({}, now_ns);
    }
  }
  for (int tick = 0; tick < 500; ++tick) {
    port.read(states, now_ns += 4'000'000);
    port.write({}, now_ns);
  }
  return record;
}

std::vector<std::string> frames_of_document() {
  std::vector<std::string> frames;
  std::ifstream file(in_checkout("docs/bench.md"));
  bool is_there = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) is_there = line == "## A run, frame by frame";
    if (!is_there || !line.starts_with("| `")) continue;
    frames.push_back(line.substr(3, line.find('`', 3) - 3));
  }
  return frames;
}

/// A dot is any digit.
bool is_of(const std::string& frame, const std::string& shown) {
  return std::ranges::equal(frame, shown, [](char digit, char of) { return of == '.' || of == digit; });
}

TEST(BusRecord, ThatOfTheDocumentIsTheRecordOfARunInItsOrder) {
  const std::vector<std::string> record = record_of_a_run();
  const std::vector<std::string> shown = frames_of_document();
  ASSERT_GT(shown.size(), 50U);
  for (const std::string& frame : record) {
    EXPECT_TRUE(std::ranges::any_of(shown, [&](const std::string& of) { return is_of(frame, of); }))
        << "docs/bench.md does not explain " << frame;
  }
  auto at = record.begin();
  for (const std::string& of : shown) {
    const auto found =
        std::find_if(at, record.end(), [&](const std::string& frame) { return is_of(frame, of); });
    ASSERT_NE(found, record.end()) << of << " does not come where docs/bench.md has it";
    at = found;
  }
}

}  // namespace bus_record_test
}  // namespace inbetween
