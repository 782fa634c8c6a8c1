// The device's side of Dragonframe's DMC protocol: bytes of the host in, answers and orders out. Every
// request is answered exactly once, at once.
//
// Nothing moves until arm() is called: somebody at the rig's terminal has agreed. The consent ends with a
// stop (STOP_ALL that is not silent, stop(), a HardStop) and with the connection. What needs it and has it
// not is answered GENERAL.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dmc_frame.hpp"
#include "host_tools/dragonframe/dmc_message.hpp"
#include "host_tools/dragonframe/dmc_stage.hpp"
#include "host_tools/dragonframe/go_motion.hpp"
#include "host_tools/dragonframe/jog_hold.hpp"
#include "host_tools/dragonframe/port_notice.hpp"
#include "host_tools/dragonframe/rig_port.hpp"
#include "host_tools/dragonframe/uploaded_move.hpp"

namespace inbetween::dragonframe {

/// The maker's firmware tells positions 50 ms apart at least, its sheet about 100.
inline constexpr std::int64_t dmc_push_ns = 100'000'000;
/// A second STOP_ALL within this time of the first stops harder.
inline constexpr std::int64_t dmc_harder_stop_ns = 1'000'000'000;
/// Behind a stop everything that moves is refused for so long at least, and while something moves.
inline constexpr std::int64_t dmc_gate_ns = 2'000'000'000;
/// A frame takes 0.2 s at 115200 bit/s, with all its 2048 bytes: what pauses for longer comes from no living
/// host.
inline constexpr std::int64_t dmc_silence_ns = 250'000'000;
/// A pulse on the bloop outputs that HI's host gave no length, and the one at the end of a move.
inline constexpr std::int64_t dmc_bloop_ns = 100'000'000;

/// What HI tells. Without `dmc_can::camera` a rig has no camera outputs.
struct DmcFacts {
  std::string name = "inbetween";  ///< 31 bytes at most
  std::array<std::uint8_t, 3> version{1, 0, 0};
  std::uint8_t motors = 1;   ///< 1 to 32
  std::uint8_t outputs = 0;  ///< 0 to 32, of GIO
  std::uint8_t inputs = 0;
  std::uint8_t hardware_limit_sets = 0;
  std::uint32_t frame_capacity = 10'000;
  std::uint32_t capabilities =
      dmc_can::real_time | dmc_can::shoot_frame | dmc_can::shoot_frame2 | dmc_can::loop;
};

class DmcDevice {
 public:
  /// Takes all the memory of an upload. Throws std::invalid_argument where a fact is outside of its range.
  DmcDevice(const DmcFacts& facts, RigPort rig);

  /// A host has opened the port: it is greeted, and everything is as after switching on. False: there is one
  /// already, which keeps the rig.
  bool connect(std::int64_t now_ns);
  /// The port is closed or unplugged: everything stops, outputs go off, consent, settings and move are
  /// forgotten.
  void disconnect(std::int64_t now_ns);

  /// Somebody has agreed. False, and nothing changes: nobody is connected, or a stop is not yet over.
  bool arm();
  /// Stops what moves, and takes the consent away: the stop button of the rig.
  void stop(std::int64_t now_ns);
  [[nodiscard]] bool is_armed() const { return is_armed_; }
  [[nodiscard]] bool is_connected() const { return is_connected_; }
  [[nodiscard]] DmcStage stage() const { return stage_; }

  /// Bytes of the host. Without a connection they are none, and ignored.
  void hear(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  /// What the rig tells by itself.
  void tell(const RigEvent& event, std::int64_t now_ns);
  /// The rig as it is, told every 50 ms or more often, behind the orders that it shows: this is the device's
  /// clock.
  void observe(const RigState& state, std::int64_t now_ns);

  /// For the host, since the last call; and for the person.
  [[nodiscard]] std::vector<std::uint8_t> take_bytes();
  [[nodiscard]] std::vector<PortNotice> take_notices();

  [[nodiscard]] const DmcDecoderCounters& counters() const { return decoder_.counters(); }
  [[nodiscard]] const UploadedMove& move() const { return move_; }

 private:
  // dmc_device.cpp: the connection, and what is told.
  void hear_frame(const DmcFrame& frame);
  /// Whether it is one, and is answered now.
  bool answer_question(DmcType type, std::uint32_t id);
  void hear_whole(std::span<const std::uint8_t> bytes);
  [[nodiscard]] bool is_gated(std::uint16_t type) const;
  void send(DmcType type, std::uint32_t id, std::span<const std::uint8_t> payload);
  void acknowledge(std::uint16_t type, std::uint32_t id, DmcCode code);
  void greet(std::uint32_t id);
  void push_positions(std::uint32_t id = 0);
  void note(PortNotice::Kind kind, std::uint8_t motor = 0, std::int64_t value = 0);
  void forget();
  void disarm(PortNotice::Kind why);
  [[nodiscard]] bool has_motor(std::uint8_t motor) const { return motor >= 1 && motor <= facts_.motors; }
  [[nodiscard]] MotorSettings& settings_of(std::uint8_t motor) { return settings_.at(motor - 1U); }
  [[nodiscard]] bool moves() const;
  [[nodiscard]] MotorMask live_motors() const;
  [[nodiscard]] MotorMask playing_motors() const;
  /// To the rig; a refusal is told.
  RigAnswer order(const RigOrder& what, std::uint8_t motor = 0);
  /// The same for a motion, with consent only.
  RigAnswer move_by(const RigOrder& what, std::uint8_t motor = 0);
  void begin_bloop(std::int64_t for_ns);
  void end_bloop();
  RigAnswer show_outputs();
  [[nodiscard]] std::uint32_t output_bits() const;
  [[nodiscard]] bool has_outputs(std::uint32_t bits) const { return (bits & ~output_bits()) == 0; }
  RigAnswer set_camera(const SetCamera& camera);

  // dmc_motors.cpp: one motor, or the outputs.
  RigAnswer handle(const DmcPlain& request);
  RigAnswer handle(const DmcGioOut& request);
  RigAnswer handle(const DmcGioCam& request);
  RigAnswer handle(const DmcMove& request);
  RigAnswer handle(const DmcStop& request);
  RigAnswer handle(const DmcStopAll& request);
  RigAnswer handle(const DmcResetPosition& request);
  RigAnswer handle(const DmcJog& request);
  RigAnswer handle(const DmcConfigure& request);
  RigAnswer handle(const DmcSetSpeed& request);
  RigAnswer handle(const DmcSetLimits& request);
  RigAnswer change(std::uint8_t motor, const MotorSettings& settings);
  [[nodiscard]] RigAnswer may_move(std::uint8_t motor);
  RigAnswer move_motor(std::uint8_t motor, std::int32_t target);
  void leave_frame(std::uint8_t motor);
  RigAnswer stop_motor(std::uint8_t motor);
  void stop_all();

  // dmc_play.cpp: the move.
  RigAnswer handle(const DmcUploadBegin& request);
  RigAnswer handle(const DmcUploadAxis& request);
  RigAnswer handle(const DmcUploadTriggers& request);
  RigAnswer handle(const DmcPositionFrame& request);
  RigAnswer handle(const DmcRunMove& request);
  RigAnswer handle(const DmcShootFrame& request);
  RigAnswer handle(const DmcShootFrame2& request);
  RigAnswer handle(const DmcJogAll& request);
  RigAnswer end_upload();
  RigAnswer stop_loop();
  RigAnswer go_to_frame(std::int32_t frame);
  RigAnswer go();
  [[nodiscard]] RigAnswer may_play(DmcStep step) const;
  [[nodiscard]] RigAnswer judge_run(const DmcRunMove& request) const;
  RigAnswer place_rolls(PrepareRun& run) const;
  struct ShotMath;
  RigAnswer prepare_shot(std::int32_t frame, const std::vector<DmcOverride>& overrides, const ShotMath& math);
  RigAnswer add_to_shot(PrepareShot& shot, std::uint8_t motor, const BlurWay& way,
                        const ShotMath& math) const;
  void handle_event(const FrameReached& event);
  void handle_event(const Approached& event);
  void handle_event(const InPlace& event);
  void handle_event(const MoveEnded& event);
  void handle_event(const AtRest& event);
  void handle_event(const HardStop& event);
  void handle_event(const StartSwitch& event);

  DmcFacts facts_;
  RigPort rig_;
  UploadedMove move_;
  std::array<MotorSettings, max_motors> settings_{};
  DmcDecoder decoder_;
  JogHold jogs_;
  RigState state_;
  DmcStage stage_ = DmcStage::jog;
  bool is_connected_ = false;
  bool is_armed_ = false;
  std::int64_t now_ns_ = 0;
  std::int64_t heard_ns_ = 0;
  std::int64_t pushed_ns_ = 0;
  std::optional<std::int64_t> stopped_ns_;  ///< when STOP_ALL came last
  std::optional<std::int64_t> gated_ns_;    ///< when the gate closed

  std::optional<std::int32_t> position_frame_;  ///< the uploaded frame where the rig stands
  bool stops_on_path_ = false;                  ///< and may come to rest on a frame
  std::optional<PrepareRun> run_;               ///< the one that is prepared or plays; nothing: it is a shot
  bool is_synced_ = false;
  bool has_ended_ = false;
  std::uint32_t host_outputs_ = 0;
  std::uint32_t bloop_bits_ = 0;
  std::int64_t bloop_for_ns_ = 0;
  std::optional<std::int64_t> bloop_until_ns_;
  std::uint32_t shown_outputs_ = 0;
  SetCamera camera_;

  std::vector<std::uint8_t> bytes_;
  std::vector<PortNotice> notices_;
};

}  // namespace inbetween::dragonframe
