#include <fmt/format.h>

#include "host_tools/doctor/doctor.hpp"

namespace inbetween {
namespace {

/// Frames that an interface may hold back. What waits there is sent when the bus works again, and it is old.
constexpr std::uint32_t long_queue_frames = 128;

class BusCheck {
 public:
  BusCheck(const std::string& name, const can::CanLink& link, const std::optional<BusNeeds>& needs)
      : name_(name), link_(link), needs_(needs) {}

  Findings all() {
    look_at_link();
    if (needs_ && needs_->data_bitrate) look_at_fd();
    if (link_.bitrate) look_at_bitrate();
    if (link_.controller && link_.is_up) look_at_controller();
    look_at_queue();
    return std::move(findings_);
  }

 private:
  void add(Verdict verdict, std::string what, std::string remedy = "") {
    findings_.push_back(
        {.of = "bus " + name_, .verdict = verdict, .what = std::move(what), .remedy = std::move(remedy)});
  }
  void look_at_link() {
    if (link_.is_up) return add(Verdict::fine, link_.controller ? "up" : "up, and virtual");
    add(Verdict::problem, "is down",
        fmt::format("as root: ip link set {} up{}", name_,
                    needs_ && link_.controller ? " " + type_and_bitrates() : ""));
  }
  /// Such as `ip link` takes them.
  [[nodiscard]] std::string type_and_bitrates() const {
    return fmt::format("type can bitrate {}{}", needs_->bitrate,
                       needs_->data_bitrate ? fmt::format(" dbitrate {} fd on", *needs_->data_bitrate) : "");
  }
  void look_at_fd() {
    const std::string by_type =
        fmt::format("as root: ip link set {0} down; ip link set {0} up {1}", name_, type_and_bitrates());
    if (!link_.carries_fd) {
      return add(Verdict::problem, "does not carry CAN FD frames, which its drives speak",
                 link_.controller
                     ? by_type
                     : fmt::format("as root: ip link set {0} down; ip link set {0} mtu 72 up", name_));
    }
    if (!link_.data_bitrate) return;
    if (*link_.data_bitrate == *needs_->data_bitrate) {
      return add(Verdict::fine, fmt::format("carries CAN FD, its data with {} bit/s", *link_.data_bitrate));
    }
    add(Verdict::problem,
        fmt::format("sends data with {} bit/s, and the rig says {}", *link_.data_bitrate,
                    *needs_->data_bitrate),
        by_type + "; or correct data_bitrate in the rig");
  }
  void look_at_bitrate() {
    if (needs_ && *link_.bitrate != needs_->bitrate) {
      add(Verdict::problem,
          fmt::format("runs at {} bit/s, and the rig says {}", *link_.bitrate, needs_->bitrate),
          fmt::format("as root: ip link set {0} down; ip link set {0} up {1}; or correct bitrate in the rig",
                      name_, type_and_bitrates()));
      return;
    }
    // CiA 301 recommends 87.5 %; what is far below leaves no time for a long cable.
    constexpr std::uint32_t low = 700;
    constexpr std::uint32_t high = 900;
    const std::uint32_t sample = link_.sample_point_permille.value_or(0);
    const std::string what =
        fmt::format("{} bit/s, sampled at {:.1f} % of a bit", *link_.bitrate, sample / 10.0);
    // Drives with CAN FD have a place of their own for it.
    if (link_.data_bitrate || (sample >= low && sample <= high)) return add(Verdict::fine, what);
    add(Verdict::note, what + ", where CANopen recommends 87.5 %",
        fmt::format(
            "as root: ip link set {0} down; ip link set {0} up type can bitrate {1} sample-point 0.875",
            name_, *link_.bitrate));
  }
  void look_at_controller() {
    switch (*link_.controller) {
      case can::ControllerState::active:
        return;
      case can::ControllerState::warning:
        return add(Verdict::note, "has seen many errors (error-warning)",
                   "look at the cable, the two terminating resistors and the bitrate of every drive");
      case can::ControllerState::passive:
        return add(
            Verdict::problem, "is error-passive: nobody acknowledges its frames, or the bus is disturbed",
            "look whether the drives have power, at the cable, the terminating resistors and the bitrate");
      case can::ControllerState::bus_off:
        break;
    }
    add(Verdict::problem, "is bus-off",
        fmt::format(
            "look at the cable and the bitrate, then as root: ip link set {0} down; ip link set {0} up",
            name_));
  }
  void look_at_queue() {
    if (link_.queue_frames == 0) return;
    const auto frames = static_cast<std::int64_t>(link_.queue_frames);
    if (needs_ && frames < needs_->frames_per_tick) {
      add(Verdict::problem,
          fmt::format("holds {} frames to be sent, and a tick has {}", frames, needs_->frames_per_tick),
          fmt::format("as root: ip link set {} txqueuelen {}", name_, 2 * needs_->frames_per_tick));
    } else if (link_.queue_frames > long_queue_frames) {
      add(Verdict::note,
          fmt::format("holds {} frames to be sent: after a fault of the cable old ones would come first",
                      frames),
          fmt::format("as root: ip link set {} txqueuelen {}", name_, long_queue_frames));
    } else {
      add(Verdict::fine, fmt::format("holds {} frames to be sent", frames));
    }
  }

  const std::string& name_;
  const can::CanLink& link_;
  const std::optional<BusNeeds>& needs_;
  Findings findings_;
};

}  // namespace

Findings check_bus(const std::string& name, const std::optional<can::CanLink>& link,
                   const std::optional<BusNeeds>& needs) {
  if (link) return BusCheck(name, *link, needs).all();
  return {{.of = "bus " + name,
           .verdict = Verdict::problem,
           .what = "there is no such CAN interface",
           .remedy = "look at the names with: ip link; plug the adapter in, and load its driver"}};
}

}  // namespace inbetween
