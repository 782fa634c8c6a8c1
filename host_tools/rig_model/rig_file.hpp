// A rig: the machine, its axes, limits and drives. docs/formats.md is the manual of the file.
//
// Reading checks everything that can be seen in the file alone: types, ranges, names and addresses taken
// twice, positions that a drive cannot count to, steps faster than it may take them, a tick that CiA 402
// cannot state, an emergency stop that a broken wire would silence. It opens no bus and no chip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host_tools/rig_model/gpio_line.hpp"
#include "host_tools/rig_model/rig_dragonframe.hpp"
#include "host_tools/rig_model/rig_gear.hpp"
#include "host_tools/rig_model/rig_lens.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

inline constexpr std::int32_t max_rate_hz = 20'000;
inline constexpr std::int64_t max_step_watch_us = 1000;
inline constexpr std::size_t max_rig_axes = 64;
inline constexpr std::size_t max_rig_outputs = 64;
inline constexpr std::size_t max_rig_tips = 16;
/// libgpiod takes 64 lines in a request, and a drive has a STEP and a DIR line in one.
inline constexpr std::size_t max_step_dir_drives_of_chip = 32;
inline constexpr std::int32_t max_step_rate = 1'000'000;  // steps/s
/// ODrive and moteus take positions as float32 turns. Up to here they are at most 1/1024 turn apart.
inline constexpr double max_turns = 16'384;
/// The 16 bits of an RMD motor's velocity limit hold no more, and its angles come in hundredths of a degree.
inline constexpr double max_rmd_deg_per_s = 65'535;
inline constexpr double rmd_steps_per_turn = 36'000;
/// The feedback of a CubeMars motor goes round beyond 3200 degrees.
inline constexpr double max_cubemars_turns = 3'200.0 / 360;
inline constexpr double cubemars_steps_per_turn = 3'600;
/// The 16 bits of an ODrive's velocity feed-forward hold no more.
inline constexpr double max_odrive_turns_per_s = 32.767;

/// A CAN bus, by the name of its Linux network interface.
struct Bus {
  std::string name;
  std::int64_t bitrate = 0;                  // bit/s, of the arbitration phase on CAN FD
  std::optional<std::int64_t> data_bitrate;  // bit/s; exactly on a bus whose drives speak CAN FD
  Place place;
};

/// A homing that a CiA 402 drive does by itself. Speeds and acceleration are 0 where it is home where it
/// stands.
struct DriveHome {
  int method = 0;                // object 6098
  double fast = 0;               // unit/s, at most max_velocity
  double slow = 0;               // unit/s, below fast
  double acceleration = 0;       // unit/s^2, at most max_acceleration
  double at = 0;                 // position of the home, unit
  double timeout_s = 0;          // above 0
  std::uint32_t fast_speed = 0;  // the same in units of the drive (6099:1, 6099:2, 609A)
  std::uint32_t slow_speed = 0;
  std::uint32_t acceleration_rate = 0;
  Place place;
};

/// How far an axis may be from where it is told to be, in its unit and above 0.
struct FollowLimits {
  double max_following_error = 0;  // while it moves
  double in_position = 0;          // a second after its motion at most
};

// Scales are signed (the sign reverses the motor) and never 0; position 0 is count 0.
struct Cia402Drive {
  std::string bus;
  int node = 0;  // 1..127
  double counts_per_unit = 0;
  std::uint32_t stop_deceleration = 0;   // of a quick stop, in units of the drive (object 6085), above 0
  bool resets_node = false;              // reset node instead of reset communication
  bool watches_following_error = false;  // though it has no object 6065
  bool is_guarded = false;               // life guarding instead of heartbeats
  bool interpolates = false;             // interpolated position (mode 7) instead of cyclic (mode 8)
  double enable_timeout_s = 5;
  std::string eds = {};                                                 // path of its data sheet; empty: none
  std::optional<std::uint32_t> vendor = {}, product = {}, serial = {};  // must be so (1018:1, :2, :4)
  double acceleration_scale = 0;  // units of the drive per unit/s^2, above 0
  FollowLimits follow = {};
  std::optional<DriveHome> homing = {};  // there while the drive is used to home itself, and takes no targets
};
enum class OdriveFirmware { v0_5, v0_6 };
struct OdriveDrive {
  std::string bus;
  int node = 0;  // 0..62
  double turns_per_unit = 0;
  OdriveFirmware firmware = OdriveFirmware::v0_6;
  FollowLimits follow = {};
};
/// A MyActuator RMD motor.
struct RmdDrive {
  std::string bus;
  int node = 0;               // 1..32
  double turns_per_unit = 0;  // of the output shaft
  FollowLimits follow = {};
  bool has_no_watchdog = false;  // somebody accepts that
};
/// A CubeMars AK motor in servo mode. It has no watchdog, and somebody accepts that.
struct CubemarsDrive {
  std::string bus;
  int node = 0;               // 1..255
  double turns_per_unit = 0;  // of the output shaft
  FollowLimits follow = {};
  double pole_pairs = 0;
  double gear = 0;                 // turns of the motor per turn of the output shaft
  double counts_per_deg = 10'000;  // of a position
  double erpm_per_count = 10;      // of a velocity and an acceleration
};
struct MoteusDrive {
  std::string bus;
  int node = 0;  // 1..126
  double turns_per_unit = 0;
  FollowLimits follow = {};
};

/// A stepper driver that takes a step at each rising edge of STEP. Times are rounded up to nanoseconds;
/// pulse and pause together permit max_step_rate, and the axis at max_velocity does not exceed it.
struct StepDirDrive {
  std::string chip;  // label, never "gpiochipN"
  GpioLine step;
  GpioLine dir;
  std::optional<GpioLine> enable;
  double steps_per_unit = 0;
  double max_step_rate = 10'000;      // steps/s
  std::int64_t pulse_ns = 5'000;      // STEP high
  std::int64_t pause_ns = 5'000;      // STEP low
  std::int64_t dir_setup_ns = 5'000;  // from a change of DIR to the next rise of STEP
  std::int64_t dir_hold_ns = 5'000;   // from a rise of STEP to the next change of DIR
  Level enable_active = Level::low;
  std::int64_t latest_ns = 500'000;  // an edge later than this means a controlled stop
};
/// A line of text a tick. Positions are whole counts, such as microseconds of a servo's pulse.
struct PipeDrive {
  std::string path;
  double counts_per_unit = 0;
  double count_at_zero = 0;  // the count of position 0
  std::int32_t baud = 115'200;
  bool has_no_watchdog = false;  // somebody accepts that nothing can be read back
};
using Drive =
    std::variant<Cia402Drive, OdriveDrive, MoteusDrive, StepDirDrive, PipeDrive, RmdDrive, CubemarsDrive>;

/// Turns per axis unit of a drive on CAN that counts turns; nothing for the others.
std::optional<double> turns_per_unit_of(const Drive& drive);

/// How far two neighbouring positions of the drive are apart, in axis units: a count, or a step.
double count_of(const Drive& drive);

/// Nothing for a drive that does not tell where it is.
std::optional<FollowLimits> follow_limits_of(const Drive& drive);

/// Whether the drive works open loop: it counts steps or servo pulses, and nothing reports where the axis
/// really is.
bool is_open_loop(const Drive& drive);

/// The source of an axis' position when a run begins.
enum class Reference {
  by_drive,     // the drive knows
  by_operator,  // a person, at a known place; the position file keeps it
  by_home       // its home switch; the position file keeps it
};
std::string_view to_string(Reference reference);

/// The search for the switch: at `fast` towards it, `back_off` away from its edge, at `slow` onto it again.
struct Home {
  InputLine input;
  int direction = -1;   // towards the switch, in axis units: -1 or 1
  double fast = 0;      // unit/s, at most max_velocity
  double slow = 0;      // unit/s, below fast
  double back_off = 0;  // unit, above 0
  double search = 0;    // unit, above 0: the longest distance to the switch
  double at = 0;        // position of the edge, unit
  Place place;
};

/// What an axis does when its drive has no power: it keeps its place by a brake, a self-locking gear or
/// because it is balanced, or its load falls.
struct Unpowered {
  bool holds = false;
  Place place;
};

/// Another motor of an axis.
struct GangedMotor {
  Drive drive;
  double offset = 0;  // of the motor, in its unit
  Place place;
};

/// Limits are magnitudes in unit, unit/s, unit/s^2, unit/s^3, all above 0. They are those of the motion: what
/// its motor needs for the backlash has been taken off.
struct RigAxis {
  std::string name;
  AxisUnit unit = AxisUnit::unit;
  double min = 0;
  double max = 0;
  double max_velocity = 0;
  double max_acceleration = 0;
  std::optional<double> max_jerk;
  std::optional<double> max_acceleration_step;  // unit/s^2
  std::optional<double> stop_acceleration;      // absent: 1.5 * max_acceleration
  std::optional<double> stop_jerk;              // absent: 1.5 * max_jerk
  Drive drive;
  std::optional<Unpowered> unpowered = {};       // nothing: the file does not say
  bool coasts = false;                           // CiA 402: it may roll out where a drive could brake it
  bool stops_without_host = false;               // CiA 402: the manual of a drive without object 6007 says so
  Reference reference = Reference::by_operator;  // by_home exactly if there is a `home`, of either kind
  std::optional<Home> home;                      // of open-loop axes only
  std::optional<DriveHome> drive_home = {};      // of CiA 402 drives only
  std::optional<double> park = {};               // where it goes once it is home, unit, in min..max
  std::optional<InputLine> limit_min;            // switches at the ends of travel; they stop the rig
  std::optional<InputLine> limit_max;
  Place place;
  // What lies between the axis and its motors (rig_motors.hpp).
  double offset = 0;  // of its first motor where the axis is at 0, or its calibration is
  std::optional<AxisCalibration> calibration = {};
  std::optional<AxisBacklash> backlash = {};
  std::vector<GangedMotor> ganged = {};          // beside the motor of `drive`
  double max_skew = 0;                           // above 0 where there are some, in the unit of the motors
  std::optional<MotorLimits> motor_limits = {};  // of the motors, if they are not those of the axis
};

/// The axis rests where it goes no further than this in 50 ms: two steps of its encoder, or what it covers at
/// a hundredth of max_velocity, if stop_acceleration brings it to rest from there within a step. The encoder
/// of a drive that counts turns is taken to have 8192 steps a turn where its protocol does not say.
double rest_distance_of(const RigAxis& axis);
/// `stop_acceleration`, or else 1.5 * max_acceleration.
double stop_acceleration_of(const RigAxis& axis);
/// How far an axis may be from a place and still be taken to be there: what it covers at max_velocity in half
/// a millisecond, whatever its scale.
double place_tolerance(const RigAxis& axis);
/// How far from `at` it may rest once its drive has homed it: twice the distance in which it brakes from
/// `slow` more. 0 for an axis that its drive does not home.
double home_tolerance(const RigAxis& axis);

/// `axis "pan"`.
std::string named(const RigAxis& axis);
/// `-90..90 deg`.
std::string range_in_words(const RigAxis& axis);

struct Camera {
  OutputLine shutter;
  std::optional<InputLine> asks;  // the camera, or whoever triggers it, asks for the next frame
  Place place;
};

/// A line for the cues of moves.
struct Output {
  std::string name;  // letters, digits, - and _; never "camera"
  OutputLine line;
  Place place;
};

/// A link of the rig whose path in space is of interest.
struct RigTip {
  std::string name;
  Place place;
};

/// Where a joint of the URDF file is that no axis moves.
struct RigJoint {
  std::string name;
  double value = 0;  // rad or m
  Place place;
};

/// The geometry of the rig.
struct RigKinematics {
  std::string urdf;  // path from the folder of the rig's file
  std::vector<RigTip> tips;
  bool has_limits_of_rig = false;  // those of the URDF file do not count
  std::vector<RigJoint> at = {};   // where joints without an axis are
};

/// In counts of its firmware, of which 16 bits with a sign hold `max`.
struct CubemarsLimits {
  static constexpr double max = 32'767;
  double velocity = 0;           ///< 1.2 times max_velocity
  double stop_acceleration = 0;  ///< of a controlled stop
};
/// What the CubeMars motor of an axis must be able to do.
CubemarsLimits cubemars_limits_of(const RigAxis& axis);

/// The velocity limit that goes with every position to the RMD motor of an axis, in whole degrees/s: what the
/// axis may do at the rates above the drawn one that are certified.
double max_rmd_deg_per_s_of(const RigAxis& axis);

struct RigFile {
  std::string path;
  std::string name;
  std::int32_t rate_hz = 0;
  std::int64_t step_watch_ns = 100'000;  // before an edge the clock is watched for so long
  std::vector<Bus> buses;                // in alphabetical order
  std::vector<RigAxis> axes;
  std::optional<InputLine> emergency_stop = {};  // active: the level that stops
  std::optional<InputLine> start_trigger = {};
  std::optional<Camera> camera = {};
  std::vector<Output> outputs = {};  // in alphabetical order
  std::optional<RigKinematics> kinematics = {};
  std::optional<RigLens> lens = {};  // only with kinematics
  std::optional<RigDragonframe> dragonframe = {};
};

/// The place of a bus by its name.
Place place_of_bus(const RigFile& rig, const std::string& name);
/// A bus that the rig has.
const Bus& bus_named(const RigFile& rig, const std::string& name);

/// Whether CiA 402 can state the tick exactly: the period is a whole number of microseconds (SYNC, object
/// 1006h) and value * 10^index seconds with value 1..255 (interpolation time period, object 60C2h).
bool is_cia402_rate(std::int32_t rate_hz);

/// Reads and checks a rig. Throws InputError at the first thing that is wrong.
RigFile read_rig_file(const std::filesystem::path& path);

/// The same from text; `file_name` stands in places and in RigFile::path.
RigFile parse_rig(std::string_view text, const std::string& file_name);

}  // namespace inbetween
