// The outputs of a rig as another program switches them: what each of its chips is told.
#include "host_tools/rig/level_outputs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace level_outputs_test {

using testing::ElementsAre;
using testing::HasSubstr;

/// What a chip was told, and whether it still takes anything.
struct ToldChip {
  std::vector<std::string> lines;
  std::vector<EdgeInstant> instants;
  bool is_full = false;
  bool has_gone = false;
};

class ToldOutputs final : public ChipOutputs {
 public:
  explicit ToldOutputs(ToldChip& chip) : chip_(chip) {}
  bool push(const EdgeInstant& instant) override {
    if (!chip_.is_full) chip_.instants.push_back(instant);
    return !chip_.is_full;
  }
  void discard() override {}
  [[nodiscard]] std::uint64_t waiting() const override { return 0; }
  [[nodiscard]] bool has_ended() const override { return chip_.has_gone; }

 private:
  ToldChip& chip_;
};

/// Has chips, and nothing else that a rig stands on.
class Chips final : public RigHardware {
 public:
  std::map<std::string, ToldChip> chips;

  std::unique_ptr<ChipOutputs> open_pulses(const std::string& chip,
                                           std::span<const PulseLine> lines) override {
    ToldChip& told = chips[chip];
    for (const PulseLine& line : lines) told.lines.emplace_back(line.name);
    return std::make_unique<ToldOutputs>(told);
  }
  std::string chip_of(const LineAddress& line) override { return line.chip; }
  std::unique_ptr<ChipOutputs> open_steps(const std::string& /*chip*/, std::span<const std::size_t> /*axes*/,
                                          std::span<const StepLines> /*wires*/) override {
    throw std::logic_error("no steps");
  }
  std::vector<OpenedInputs> open_inputs(std::span<const InputLine* const> /*lines*/) override { return {}; }
  std::unique_ptr<AxisDrives> open_others(std::span<const std::size_t> /*axes*/) override { return nullptr; }

 private:
  std::unique_ptr<BusLink<can::Frame>> open_classic_bus(const std::string& /*bus*/,
                                                        std::span<const std::size_t> /*axes*/) override {
    return nullptr;
  }
  std::unique_ptr<BusLink<can::FdFrame>> open_fd_bus(const std::string& /*bus*/,
                                                     std::span<const std::size_t> /*axes*/) override {
    return nullptr;
  }
};

RigFile rig_with(const std::string& outputs) {
  return parse_rig(rig_text({axis_text("pan", "deg", {-180, 180})}, {.rate_hz = 250, .more = outputs}),
                   "rig.toml");
}

const std::string three = R"([output.a_lamp]
chip = "relays"
line = 3
[output.b_lamp]
chip = "others"
line = 0
[output.clapper]
chip = "relays"
line = 7
)";

TEST(LevelOutputs, EachGoesToItsLineAndOnlyWhatChanges) {
  const RigFile rig = rig_with(three);
  Chips hardware;
  const std::unique_ptr<LevelOutputs> outputs = LevelOutputs::open(rig, hardware);
  ASSERT_NE(outputs, nullptr);
  ToldChip& relays = hardware.chips["relays"];
  ToldChip& others = hardware.chips["others"];
  EXPECT_THAT(relays.lines, ElementsAre("a_lamp", "clapper"));
  EXPECT_THAT(others.lines, ElementsAre("b_lamp"));

  outputs->set(0, 1'000'000'000);
  EXPECT_TRUE(relays.instants.empty() && others.instants.empty()) << "all are idle already";
  outputs->set(0b101, 2'000'000'000);
  ASSERT_EQ(relays.instants.size(), 1U);
  EXPECT_TRUE(others.instants.empty());
  EXPECT_EQ(relays.instants[0].levels, 0b11U);
  EXPECT_EQ(relays.instants[0].mask, 0b11U);
  EXPECT_EQ(relays.instants[0].at_ns, 2'000'000'000 + played_lead_ns(rig)) << "when the axes are there";
  outputs->set(0b110, 2'004'000'000);
  ASSERT_EQ(relays.instants.size(), 2U);
  EXPECT_EQ(relays.instants[1].levels, 0U);
  EXPECT_EQ(relays.instants[1].mask, 0b01U) << "the clapper stays on";
  ASSERT_EQ(others.instants.size(), 1U);
  EXPECT_EQ(others.instants[0].levels, 1U);
  EXPECT_EQ(outputs->bits(), 0b110U);
  EXPECT_EQ(outputs->trouble(), "");
}

TEST(LevelOutputs, AChipThatTakesNothingIsTold) {
  const RigFile rig = rig_with(three);
  Chips hardware;
  const std::unique_ptr<LevelOutputs> outputs = LevelOutputs::open(rig, hardware);
  hardware.chips["others"].is_full = true;
  outputs->set(0b010, 0);
  EXPECT_THAT(outputs->trouble(), HasSubstr("did not take a level"));
  hardware.chips["others"].has_gone = true;
  EXPECT_THAT(outputs->trouble(), HasSubstr("\"others\" of the outputs has gone"));
}

TEST(LevelOutputs, ARigWithoutAnyHasNone) {
  const RigFile rig = rig_with("");
  Chips hardware;
  EXPECT_EQ(LevelOutputs::open(rig, hardware), nullptr);
}

}  // namespace level_outputs_test
}  // namespace inbetween
