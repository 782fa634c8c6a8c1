#pragma once

#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402.hpp"
#include "inbetween/can/cia402_homing.hpp"
#include "inbetween/can/emergency.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/nmt.hpp"
#include "inbetween/can/pdo.hpp"
#include "inbetween/can/sdo.hpp"
#include "sim/object_dictionary.hpp"
#include "sim/simulated_motor.hpp"
#include "sim/simulated_servo.hpp"

namespace inbetween {

struct SimulatedCia402Settings {
  can::NodeId node;
  std::int32_t position = 0;  ///< counts, at power-on
  std::int64_t boot_delay_ns = 50'000'000;
  std::int64_t enable_delay_ns = 100'000'000;  ///< the brake opens
  SimulatedMotor::Settings motor{};
  double home_switch = 0;             ///< counts, by which it homes itself
  bool counts_from_power_on = false;  ///< it tells 0 where it stands at power-on
  std::vector<DriveTrouble> troubles{};
  std::optional<ObjectDictionary> objects{};  ///< at power-on; without, those of a drive of no make
  bool keeps_record = false;                  ///< which grows with every tick
};

/// A CiA 402 drive with its motor, frame in and frame out: an object dictionary with the mapping rules of CiA
/// 301, NMT, heartbeats both ways, guarding, EMCY, and the states of the profile in cyclic synchronous
/// position, in interpolated position, where it is a period behind, and in homing. It has been written from
/// the standards and not from the host's side, of which it uses the frames only.
///
/// Time is the caller's, in nanoseconds, and never goes back: a virtual clock, or that of the machine.
class SimulatedCia402Drive : public SimulatedServo<can::Frame> {
 public:
  /// Powered on at `now_ns`.
  SimulatedCia402Drive(const SimulatedCia402Settings& settings, std::int64_t now_ns);

  void advance(std::int64_t now_ns) override;
  void receive(const can::Frame& frame) override;

  /// Since power-on, or since it was taken. A target is one that SYNC applied while it was in operation.
  [[nodiscard]] const DriveRecord& record() const { return record_; }
  [[nodiscard]] bool misses_something() const override { return missing_ != 0; }

  [[nodiscard]] can::NodeId node() const { return settings_.node; }
  [[nodiscard]] can::Cia402State state() const { return state_; }
  [[nodiscard]] can::NmtState nmt() const { return nmt_; }
  [[nodiscard]] const char* state_name() const override { return can::name_of(state_); }
  /// What it tells of its state there is that of the last SYNC, or of the last request.
  [[nodiscard]] const ObjectDictionary& objects() const { return objects_; }
  /// To make another device of it: these last through a reset.
  void add_object(can::ObjectAddress address, const ObjectDictionary::Object& object);
  void remove_object(can::ObjectAddress address);
  void change_access(can::ObjectAddress address, ObjectDictionary::Access access);

 private:
  static constexpr std::uint32_t interpolated_position = 7;
  static constexpr std::uint32_t cyclic_position = 8;
  struct Pdo {
    std::uint16_t communication;
    std::uint16_t mapping;
  };
  static constexpr std::size_t pdos = 4;  ///< each way
  /// What the objects of a PDO say.
  struct PdoSetting {
    bool is_valid = false;
    can::FrameId id = {};
    std::uint32_t type = 0;
    std::uint32_t timer_ms = 0;
    unsigned bits = 0;
    struct Object {
      ObjectDictionary::Place place{};
      unsigned bits = 0;
    };
    std::vector<Object> objects = {};
    bool has_controlword = false;
  };
  /// What the objects say that a client alone changes.
  struct Settings {
    std::bitset<can::cob_id_number + 1> heard;  ///< identifiers: data frames with others do not concern it
    std::array<PdoSetting, pdos> received, sent;
    std::int64_t heartbeat_period_ns = 0;  ///< 0: it tells nobody that it lives
    can::FrameId sync_id = {};
    std::int64_t sync_period_ns = 0;
    bool has_sync_counter = false;
    std::uint32_t host = 0;  ///< whose heartbeat it watches; 0: nobody's
    std::int64_t host_timeout_ns = 0;
    std::uint32_t mode = 0;
    double interpolation_s = 0;  ///< 60C2; 0: it has none
    std::int32_t min = 0, max = 0;
    std::uint32_t following_window = 0, following_ms = 0;
    /// Where the objects are that every SYNC needs.
    ObjectDictionary::Place controlword{}, statusword{}, mode_display{}, target{}, set_point{}, position{},
        velocity{}, following_error{};
  };
  /// What the objects say of the motion: the same for all steps of the motor between two frames.
  struct MotionObjects {
    double period_s = 0;
    double min = 0, max = 0;         ///< no limits where min is not below max
    std::optional<double> target{};  ///< none: it stays where it is
    double window = 0, window_ms = 0;
    bool homes = false;

    /// Whether the motor, which is off by so much after a step, has been for too long. Counts how long.
    [[nodiscard]] bool is_too_far(double off, double seconds, double& beyond_window_s) const {
      const bool is_beyond = std::fabs(off) > window;
      beyond_window_s = is_beyond ? beyond_window_s + seconds : 0;
      return is_beyond && beyond_window_s * 1000 >= window_ms;
    }
  };
  void boot();
  void start_anew() override;
  void raise_error(std::uint16_t code, std::uint8_t error_register);

  // communication
  void obey(const can::NmtOrder& order);
  void enter(can::NmtState nmt);
  void watch_communication();
  void lose_communication(std::uint16_t code);
  /// It watches these; an error lasts until that is there again, or its communication starts anew.
  enum Watched : std::uint8_t { host_heartbeat = 1, setpoints = 2, sync = 4, guarding = 8 };
  void has_come(Watched what);
  void hear_host(const can::Frame& frame);
  void hear_guard();
  // SDO
  struct Transfer {
    can::ObjectAddress object{};
    std::vector<std::uint8_t> bytes{};  ///< to be sent, or received so far
    std::size_t at = 0;
    std::uint32_t announced = 0;  ///< bytes of a download; 0: it is an upload
    bool toggle = false;          ///< of the next segment
  };
  void serve(const can::Frame& frame);
  can::SdoMessage answer_to(const can::SdoMessage& request);
  can::SdoMessage begin_upload(can::ObjectAddress object);
  can::SdoMessage next_segment();
  can::SdoMessage take_segment(const can::SdoMessage& request);
  can::SdoMessage take(can::ObjectAddress object, const std::vector<std::uint8_t>& bytes);
  [[nodiscard]] std::optional<std::uint32_t> refuses_download(can::ObjectAddress object,
                                                              const std::vector<std::uint8_t>& bytes) const;
  // PDO
  [[nodiscard]] std::optional<std::uint32_t> refuses_pdo(can::ObjectAddress object,
                                                         std::uint32_t value) const;
  [[nodiscard]] std::optional<std::uint32_t> refuses_mapping(const Pdo& pdo, bool is_sent, std::uint8_t sub,
                                                             std::uint32_t value) const;
  static Pdo pdo(bool is_sent, std::size_t number);
  [[nodiscard]] bool is_valid(const Pdo& pdo) const;
  [[nodiscard]] std::vector<can::PdoEntry> objects_in(const Pdo& pdo, std::uint32_t count) const;
  void note_written(can::ObjectAddress object);
  void hear_pdo(const can::Frame& frame);
  void apply_pdo(const PdoSetting& pdo, const can::Frame& frame);
  [[nodiscard]] PdoSetting setting_of(const Pdo& pdo) const;
  /// Read again where a client has changed an object.
  [[nodiscard]] const Settings& settings_now() const {
    return settings_revision_ == objects_.revision() ? read_settings_ : read_settings();
  }
  const Settings& read_settings() const;
  void hear_sync(const can::Frame& frame);
  void send_pdos();

  // the drive
  void live(double seconds) override;
  void step(double seconds);
  void run_motor_quietly(std::int64_t until_ns);
  [[nodiscard]] std::int64_t next_event_ns() const;
  [[nodiscard]] MotionObjects motion_objects() const;
  void obey_controlword(std::uint16_t word);
  void react_to_lost_communication();
  void stop_quickly();
  void fail(std::uint16_t code);
  void enter(can::Cia402State state);
  bool slow_demand_down(double seconds);
  void slow_down(double seconds);
  void take_set_point();
  // homing
  enum class Homing : std::uint8_t { none, fast, back, found };
  void begin_homing();
  void set_zero(double home);
  double homing_velocity();
  void home(double seconds);
  [[nodiscard]] unsigned homing_status() const;
  [[nodiscard]] bool is_to_home() const { return mode() == static_cast<std::uint32_t>(can::homing_mode); }
  [[nodiscard]] std::uint32_t mode() const { return settings_now().mode; }
  [[nodiscard]] std::optional<double> target() const;
  void follow(const MotionObjects& objects, double seconds);
  std::int64_t follow_target(const MotionObjects& objects, double seconds, std::int64_t steps);
  void meet(const DriveTrouble& trouble) override;
  [[nodiscard]] bool is_meant_for_it(const can::Frame& frame) const;
  void babble();
  void show();
  [[nodiscard]] std::uint16_t statusword() const;
  [[nodiscard]] bool is_in_operation() const { return state_ == can::Cia402State::operation_enabled; }
  [[nodiscard]] double period_s() const;

  SimulatedCia402Settings settings_;
  ObjectDictionary objects_;
  ObjectDictionary defaults_;
  bool is_booting_ = true;
  can::NmtState nmt_ = can::NmtState::boot_up;
  std::int64_t heartbeat_ns_ = 0;
  std::optional<std::int64_t> host_deadline_ns_;         ///< from the host's first heartbeat on
  std::optional<std::int64_t> guard_deadline_ns_;        ///< from the first request on
  bool guard_toggle_ = false;                            ///< of the next answer
  std::optional<std::int64_t> setpoint_deadline_ns_;     ///< from the first setpoint on
  std::optional<std::int64_t> sync_deadline_ns_;         ///< from the first SYNC on
  unsigned missing_ = 0;                                 ///< Watched
  std::optional<Transfer> transfer_;                     ///< of SDO in segments
  std::array<std::optional<can::Frame>, pdos> waiting_;  ///< RPDOs that SYNC will apply
  mutable Settings read_settings_;
  mutable std::optional<std::uint64_t> settings_revision_;  ///< of the objects that they were read from
  std::uint32_t syncs_ = 0;

  can::Cia402State state_ = can::Cia402State::switch_on_disabled;
  std::uint16_t last_word_ = 0;
  std::int64_t enabled_ns_ = 0;  ///< when the brake will be open
  bool is_enabling_ = false;
  double from_ = 0;  ///< where the demand was at the last SYNC
  double demand_ = 0;
  double demand_velocity_ = 0;
  double since_sync_s_ = 0;
  std::optional<std::int64_t> sync_ns_;  ///< the last
  double sync_period_s_ = 0;             ///< between the last two
  bool is_interpolating_ = false;        ///< in mode 7, since bit 4 of the controlword rose
  std::int32_t set_point_ = 0;           ///< mode 7: it goes there until the next SYNC
  std::int32_t next_set_point_ = 0;
  Homing homing_ = Homing::none;
  double home_direction_ = 1;
  bool is_home_ = false;  ///< since it last homed, whatever it does
  bool has_homing_error_ = false;
  double beyond_window_s_ = 0;
  bool is_following_error_ = false;
  bool is_limited_ = false;
};

}  // namespace inbetween
