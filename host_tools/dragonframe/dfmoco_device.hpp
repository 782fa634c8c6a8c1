// The device's side of Dragonframe's DFMoco protocol: lines of the host in, lines and orders out. It answers
// as the maker's sketch 2.0.0 does where that differs from the maker's document.
//
// Nothing moves until arm() is called: somebody at the rig's terminal has agreed. The consent ends with a
// stop of what moves (`sa`, stop(), a HardStop) and with the connection. The protocol has two errors only:
// what needs the consent and has it not is answered "parse error", as all that is not possible now.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dfmoco_line.hpp"
#include "host_tools/dragonframe/jog_hold.hpp"
#include "host_tools/dragonframe/port_notice.hpp"
#include "host_tools/dragonframe/rig_port.hpp"

namespace inbetween::dragonframe {

/// Positions of what moves are told once in this time.
inline constexpr std::int64_t dfmoco_cycle_ns = 1'000'000'000;
/// A line that pauses for longer is dropped: what comes behind is another host's, or another try. A person
/// who types is faster.
inline constexpr std::int64_t dfmoco_silence_ns = 2'000'000'000;
/// What `bf` answers: the exposure begins so many ms behind `go`.
inline constexpr int dfmoco_delay_ms = 1000;
/// The sketch's: `pr` answers what it made of a rate, and `bf` refuses faster motors.
inline constexpr std::int32_t min_dfmoco_rate = 100;
inline constexpr std::int32_t max_dfmoco_rate = 20'000;

class DfmocoDevice {
 public:
  /// `motors` 1 to 32; throws std::invalid_argument otherwise. Dragonframe's own devices have 4 or 8.
  DfmocoDevice(std::uint8_t motors, RigPort rig);

  /// As those of DmcDevice.
  bool connect(std::int64_t now_ns);
  void disconnect(std::int64_t now_ns);
  bool arm();
  void stop(std::int64_t now_ns);
  [[nodiscard]] bool is_armed() const { return is_armed_; }
  [[nodiscard]] bool is_connected() const { return is_connected_; }
  void hear(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  void tell(const RigEvent& event, std::int64_t now_ns);
  void observe(const RigState& state, std::int64_t now_ns);
  [[nodiscard]] std::string take_text();
  [[nodiscard]] std::vector<PortNotice> take_notices();
  [[nodiscard]] const DfmocoCounters& counters() const { return decoder_.counters(); }

 private:
  enum class Stage : std::uint8_t {
    free,      ///< motors by themselves
    prepared,  ///< `bf` was accepted: on the way to its start, or there
    shooting,  ///< from `go` until the rig rests
  };

  void hear_line(const DfmocoLine& line);
  /// False: a parse error.
  bool obey(const DfmocoLine& line);
  bool obey_motor(const DfmocoLine& line);
  bool move(std::uint8_t motor, std::int32_t target);
  bool halt(std::uint8_t motor);
  bool jog(std::uint8_t motor, std::int32_t destination, std::int32_t speed);
  bool inch(std::uint8_t motor, std::int32_t destination);
  bool set_rate(std::uint8_t motor, std::int32_t rate);
  bool place(std::uint8_t motor, std::int32_t position);
  bool prepare(const std::vector<std::int32_t>& numbers);
  [[nodiscard]] std::optional<PrepareShot> shot_of(const std::vector<std::int32_t>& numbers,
                                                   bool& is_too_fast) const;
  bool go();
  void stop_all();
  void say(const std::string& line);
  void say_position(std::uint8_t motor);
  void note(PortNotice::Kind kind, std::uint8_t motor = 0, std::int64_t value = 0);
  void disarm(PortNotice::Kind why);
  [[nodiscard]] bool is_moving(std::uint8_t motor) const { return (state_.moving & mask_of(motor)) != 0; }
  bool order(const RigOrder& what, std::uint8_t motor = 0);
  bool move_by(const RigOrder& what, std::uint8_t motor = 0);
  void moved(std::uint8_t motor);

  std::uint8_t motors_ = 0;
  RigPort rig_;
  DfmocoDecoder decoder_;
  JogHold jogs_;
  RigState state_;
  Stage stage_ = Stage::free;
  bool is_connected_ = false;
  bool is_armed_ = false;
  std::int64_t now_ns_ = 0;
  std::int64_t heard_ns_ = 0;
  std::int64_t cycle_ns_ = 0;
  MotorMask to_tell_ = 0;  ///< what moved since the last cycle
  std::array<MotorSettings, max_motors> settings_{};
  std::string text_;
  std::vector<PortNotice> notices_;
};

}  // namespace inbetween::dragonframe
