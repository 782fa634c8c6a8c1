#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/can/fd_frame.hpp"

/// The registers of a moteus and the sub-frames that carry them. Sources: mjbots/moteus docs/protocol/can.md
/// and registers.md, register map version 5.

namespace inbetween::can {

/// Those that are used here.
enum class MoteusRegister : std::uint32_t {
  mode = 0x000,
  position = 0x001,
  velocity = 0x002,
  torque = 0x003,
  home_state = 0x00C,
  voltage = 0x00D,
  temperature = 0x00E,
  fault = 0x00F,
  command_position = 0x020,
  command_velocity = 0x021,
  max_torque = 0x025,
  watchdog = 0x027,
  model = 0x100,
  firmware = 0x101,
  map_version = 0x102,
};

/// How a value is written.
enum class MoteusType : std::uint8_t { int8, int16, int32, float32 };
constexpr std::size_t size_of(MoteusType type) {
  return type == MoteusType::float32 ? 4 : std::size_t{1} << static_cast<unsigned>(type);
}

/// A value in the unit of its register (turns, turns/s, Nm, V, degrees C, s), as bits of `type`. Integers
/// count in steps of the register, cut off towards 0 and kept within the type; its lowest number stands for
/// what is none.
std::uint32_t moteus_bits_of(double value, MoteusRegister reg, MoteusType type);
/// The inverse; not a number where the bits say none.
double moteus_value_of(std::uint32_t bits, MoteusRegister reg, MoteusType type);

/// Writes sub-frames into a frame, one behind the other.
class MoteusWriter {
 public:
  /// `frame` stays the caller's; its bytes are written from the first on.
  explicit MoteusWriter(FdFrame& frame) : frame_(frame) { frame_.length = 0; }

  /// The registers from `first` on shall have these values.
  void write(MoteusRegister first, MoteusType type, std::span<const double> values) {
    put_values(0x00, first, type, values);
  }
  /// The drive shall say the values of `count` registers from `first` on.
  void read(MoteusRegister first, MoteusType type, std::uint32_t count) {
    put_head(0x10, first, type, count);
  }
  /// It says them.
  void reply(MoteusRegister first, MoteusType type, std::span<const double> values) {
    put_values(0x20, first, type, values);
  }
  /// It cannot say one.
  void read_error(MoteusRegister reg, std::uint32_t error);
  /// Fills up to a length that a frame can have. False: it did not fit, and the frame must not be sent.
  [[nodiscard]] bool finish();

 private:
  void put(std::uint32_t byte);
  void put_number(std::uint32_t number);
  void put_head(std::uint32_t operation, MoteusRegister first, MoteusType type, std::uint32_t count);
  void put_values(std::uint32_t operation, MoteusRegister first, MoteusType type,
                  std::span<const double> values);

  FdFrame& frame_;
  bool fits_ = true;
};

/// One register of a sub-frame.
struct MoteusItem {
  enum class Kind : std::uint8_t {
    write,
    read,
    reply,
    write_error,
    read_error,
    stream,  ///< of a set-up tool; what is behind it is not looked at
  };
  Kind kind{};
  MoteusRegister reg{};
  MoteusType type{};
  std::uint32_t bits = 0;  ///< of a written or answered value; the number of an error
  double value = 0;        ///< of a written or answered value
};

/// Reads the registers of a frame one by one: at most 64 of a sub-frame, whatever it says.
class MoteusReader {
 public:
  explicit MoteusReader(const FdFrame& frame) : frame_(frame) {}
  /// Nothing at the end, and from the first byte on that is no part of a sub-frame.
  std::optional<MoteusItem> next();
  /// The last next() met such a byte.
  [[nodiscard]] bool is_bad() const { return is_bad_; }

 private:
  std::optional<std::uint32_t> byte();
  std::optional<std::uint32_t> number();
  bool begin(std::uint32_t head);
  std::optional<MoteusItem> item();
  std::optional<MoteusItem> refuse() {
    is_bad_ = true;
    at_ = frame_.length;
    return {};
  }

  const FdFrame& frame_;
  std::size_t at_ = 0;
  MoteusItem item_;         ///< of the sub-frame that is read
  std::uint32_t left_ = 0;  ///< registers of it
  bool is_bad_ = false;
};

}  // namespace inbetween::can
