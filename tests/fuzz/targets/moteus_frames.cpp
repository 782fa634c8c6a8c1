// Any frames to a bus with two moteus controllers.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/can/moteus.hpp"
#include "inbetween/can/moteus_register.hpp"
#include "tests/fuzz/targets/servo_bus_under_test.hpp"

namespace inbetween::can {
namespace {

struct MoteusDialect {
  using Protocol = Moteus;
  static Moteus protocol(std::size_t axis) {
    // The identifiers of the answers of the second have 29 bits.
    return Moteus({.node = MoteusNode::make(axis == 0 ? 3 : 9).value(), .must_know_place = axis == 0});
  }
  static FdFrame answer(std::size_t axis) { return {.id = FrameId::shortest(axis == 0 ? 0x300U : 0x900U)}; }

  static FdFrame any_frame(Bytes& bytes) {
    const std::uint8_t kind = bytes.next();
    FdFrame frame = answer(kind & 1);
    if ((kind & 0x40) != 0) frame.id = (kind & 1) != 0 ? FrameId::extended(0x109) : FrameId(0x03);
    frame.is_classic = (kind & 0x20) != 0;
    frame.length = static_cast<std::uint8_t>(fd_length_for(bytes.next() % 65));
    for (std::size_t i = 0; i < frame.length; ++i) frame.data.at(i) = bytes.next();
    return frame;
  }
  /// Most of it sensible.
  static FdFrame told(std::size_t axis, std::uint8_t what) {
    FdFrame frame = answer(axis);
    MoteusWriter writer(frame);
    if ((what & 0x0E) == 0) {
      writer.reply(MoteusRegister::model, MoteusType::int32,
                   std::array{1.0, 1.0, (what & 0x10) != 0 ? 4.0 : 5.0});
      writer.reply(MoteusRegister::home_state, MoteusType::int8, std::array{(what & 0x20) != 0 ? 0.0 : 2.0});
    } else {
      constexpr std::array modes{0.0, 0.0, 2.0, 10.0, 10.0, 1.0, 11.0, 9.0};
      writer.reply(MoteusRegister::mode, MoteusType::int8, std::array{modes.at((what >> 1) & 7)});
      writer.reply(MoteusRegister::position, MoteusType::float32, std::array{(what >> 5) * 0.125, 0.0, 0.0});
      writer.reply(MoteusRegister::fault, MoteusType::int8, std::array{(what & 0x10) != 0 ? 38.0 : 0.0});
    }
    fuzz_require(writer.finish(), "an answer fits");
    return frame;
  }

  static std::optional<std::size_t> axis_of(const FdFrame& frame) {
    const std::uint32_t receiver = frame.id.number() & 0x7F;
    MoteusReader reader(frame);
    while (reader.next()) continue;
    const bool is_whole = !reader.is_bad() && is_fd_length(frame.length) && !frame.is_classic &&
                          frame.id == FrameId::shortest(frame.id.number());
    if (!is_whole || (receiver != 3 && receiver != 9)) return {};
    return receiver == 3 ? 0U : 1U;
  }
  static bool feeds(const FdFrame& frame) { return is_command(frame); }
  /// Nothing where it is to stay where it is.
  static std::optional<double> target_of(const FdFrame& frame, std::size_t /*axis*/) {
    if (!is_command(frame)) return {};
    bool has_watchdog = false;
    std::optional<double> turns;
    MoteusReader reader(frame);
    while (const auto item = reader.next()) {
      if (item->kind != MoteusItem::Kind::write) continue;
      if (item->reg == MoteusRegister::watchdog) has_watchdog = item->value > 0 && item->value < 1;
      if (item->reg == MoteusRegister::command_position) turns = item->value;
    }
    fuzz_require(turns.has_value(), "a command without a position goes to 0");
    fuzz_require(has_watchdog, "a command without a watchdog");
    if (std::isnan(*turns)) return {};
    return turns;
  }

 private:
  static bool is_command(const FdFrame& frame) {
    MoteusReader reader(frame);
    const auto first = reader.next();
    return first && first->kind == MoteusItem::Kind::write && first->reg == MoteusRegister::mode &&
           first->value == 10;
  }
};

}  // namespace
}  // namespace inbetween::can

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace inbetween::can;
  ServoBusUnderTest<MoteusDialect>().run(Bytes({data, size}));
  return 0;
}
