#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <optional>

#include "inbetween/can/drive_finding.hpp"

/// What passes between a host and a servo drive that knows positions in turns and no SYNC, and what a
/// protocol has to bring for it.

namespace inbetween::can {

/// Where a drive is.
struct ServoPlace {
  double turns = 0;
  double turns_per_s = 0;
};

/// Where it shall be.
struct ServoTarget {
  double turns = 0;
  double turns_per_s = 0;  ///< feed-forward
};

/// How it is.
struct ServoStatus {
  bool is_on = false;            ///< it holds or follows its position
  bool is_off = false;           ///< it has no power; neither, while it is between the two or calibrates
  bool has_missed_host = false;  ///< its watchdog has expired
  bool is_watching = true;       ///< its watchdog runs now; some do so only with power
  std::uint32_t errors = 0;      ///< as the protocol numbers them; 0: none
};

/// What one frame says. A frame may say several things, or nothing that concerns us.
struct ServoReport {
  std::optional<ServoPlace> place{};
  std::optional<ServoStatus> status{};
  /// It says what it is, and that is or is not what the rig has there.
  std::optional<bool> is_expected_device{};
  std::uint32_t version = 0;  ///< that it said then, as the protocol numbers them
  /// Its position counts from the same place as before it was last without power.
  std::optional<bool> knows_place{};
  /// It repeats the time after which it stops alone: the one that it was told, or another.
  std::optional<bool> has_watchdog{};
  bool is_another_device = false;  ///< not the one that has answered before
  bool is_bad = false;             ///< short, or not to be understood
  bool is_of_a_host = false;       ///< only a host sends such a frame
};

/// All that a drive has told since it was connected, and when. Of the time before that its last place, status
/// and version stay.
struct ServoTold {
  ServoPlace place;
  ServoStatus status;
  std::uint32_t version = 0;
  std::int64_t place_ns = 0;  ///< 0: not told
  std::int64_t status_ns = 0;
  std::optional<bool> is_expected_device{};
  std::optional<bool> knows_place{};
  std::optional<bool> has_watchdog{};
  bool is_another_device = false;

  void begin() { *this = {.place = place, .status = status, .version = version}; }
  void take(const ServoReport& report, std::int64_t now_ns) {
    if (report.place) {
      place = *report.place;
      place_ns = now_ns;
    }
    if (report.status) {
      status = *report.status;
      status_ns = now_ns;
    }
    if (report.is_expected_device) {
      is_expected_device = report.is_expected_device;
      version = report.version;
    }
    if (report.knows_place) knows_place = report.knows_place;
    if (report.has_watchdog) has_watchdog = report.has_watchdog;
    is_another_device = is_another_device || report.is_another_device;
  }
  [[nodiscard]] bool is_heard() const { return place_ns != 0 && status_ns != 0; }
  [[nodiscard]] bool is_near(double turns, double tolerance) const {
    return std::fabs(place.turns - turns) <= tolerance;
  }
  /// Its own watchdog stops it, and an order to switch off would end that.
  [[nodiscard]] bool brakes_alone() const { return status.has_missed_host && !status.is_off; }
};

/// What a drive is told beside positions.
enum class ServoOrder : std::uint8_t {
  say_what_you_are,
  clear_errors,
  set_watchdog,
  take_positions,  ///< before it is switched on
  switch_on,
  switch_off,
  stop_at_once,  ///< without power and without braking: the last resort
};

/// What a drive is told in every tick in which it has no target to go to.
enum class ServoHold : std::uint8_t {
  off,           ///< as it is: nothing that takes its power away or gives it any
  watched,       ///< its watchdog shall run, and no torque may come of it
  switching_on,  ///< to be switched on where it is
  stopping,      ///< a quick stop, which ends where it was told to be last
};

/// How it is known that a drive stops if this program dies.
enum class ServoWatch : std::uint8_t {
  tried,      ///< it tells that its watchdog has expired: that is waited for, in silence
  confirmed,  ///< it repeats the time that it is told by ServoOrder::set_watchdog
  accepted,   ///< it does not stop, and the rig accepts that
};

/// In which ways drives differ.
struct ServoHabits {
  /// Between two targets it goes on by the velocity of the last one. Then a target is sent when the drive
  /// shall leave it, otherwise when it shall arrive.
  bool goes_on_by_velocity = false;
  /// A target switches on a drive that is off, wherever it then believes to be. Then none is sent to a drive
  /// that is not known to be on: it may have started anew.
  bool starts_by_target = false;
  /// It does not tell when it has started anew, and may have done so whenever it was silent or targets have
  /// ceased: it gets no target then, and is switched off when it is heard again.
  bool restarts_unsaid = false;
  /// It cannot be told to switch on where it is, only to go to a place. Then it is without power before, and
  /// told the place where it was when it was to be switched on until its first target.
  bool needs_place_to_start = false;
  /// Its answer to a target does not say where it is, and a question feeds its watchdog as a target does: it
  /// is asked beside its targets, and not at all once they have ceased.
  bool is_asked_apart = false;
  /// It takes positions in one scale and tells them in another, of which the rig may have one wrong: they are
  /// compared (ScaleWatch, `scale_watch` of the protocol).
  bool has_two_scales = false;
};

/// How the drives of a protocol are told, and what their frames say. Frame in, frame out.
template <class Protocol>
concept ServoProtocol = requires(Protocol& protocol, const typename Protocol::Frame& frame, ServoOrder order,
                                 ServoHold hold, const ServoTarget& target, double turns) {
  requires std::same_as<const ServoHabits, decltype(Protocol::habits)>;
  /// Whether it says what it is when it is asked.
  { protocol.tells_identity() } -> std::same_as<bool>;
  /// What is wrong with one that says that it is something else, or does not say it.
  { Protocol::misfit } -> std::convertible_to<DriveFinding>;
  { protocol.watch() } -> std::same_as<ServoWatch>;
  /// Whether the frame is from the drive or for it.
  { protocol.is_concerned(frame) } -> std::same_as<bool>;
  { protocol.read(frame) } -> std::same_as<ServoReport>;
  /// Nothing where the drive needs no such order.
  { protocol.order(order) } -> std::same_as<std::optional<typename Protocol::Frame>>;
  /// A target that acts when it arrives. It feeds the watchdog.
  { protocol.command(target) } -> std::same_as<std::optional<typename Protocol::Frame>>;
  /// `turns` is where the drive is, or shall stay.
  { protocol.hold(hold, turns) } -> std::same_as<std::optional<typename Protocol::Frame>>;
  /// Asks how and where it is and feeds no watchdog; nothing where a drive tells that by itself. Sent in
  /// ticks in which the drive is not to be fed.
  { protocol.question() } -> std::same_as<std::optional<typename Protocol::Frame>>;
  /// Whether a target can be said in its frames.
  { Protocol::fits(target) } -> std::same_as<bool>;
};

}  // namespace inbetween::can
