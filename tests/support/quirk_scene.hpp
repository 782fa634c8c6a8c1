// A host with one drive of another make, on a virtual clock at 250 Hz. The bus is memory, or that of the
// bench.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/rig/cia402_kind.hpp"
#include "tests/support/quirk_wire.hpp"
#include "tests/support/quirky_drive.hpp"

namespace inbetween {

/// The rig has one axis with this drive: 838 860.8 counts a mm, 0 to 200 mm. `axis` and `drive` are more of
/// its fields in TOML.
struct QuirkRig {
  std::string axis = "";
  std::string drive = "";
  std::string range = "min = 0\nmax = 200\n";
  [[nodiscard]] std::string text() const {
    return "name = \"one\"\nrate_hz = 250\n[bus.can0]\nbitrate = 1_000_000\n[[axis]]\nname = \"slide\"\nunit "
           "= "
           "\"mm\"\n" +
           range + "max_velocity = 200\nmax_acceleration = 800\nreference = \"drive\"\n" + axis +
           "\ndrive = { type = \"cia402\", bus = \"can0\", node = 5, counts_per_unit = 838860.8" + drive +
           " }\n";
  }
};

class QuirkScene {
 public:
  static constexpr std::int64_t tick_ns = 4'000'000;
  explicit QuirkScene(std::string_view quirks, const QuirkRig& rig = {})
      : drive(quirks), rig_(parse_rig(rig.text(), "rig.toml")) {
    hosts_.push_back(*can::Cia402Drive::make(settings_of(rig_.axes[0], rig_.rate_hz)));
    bus_.push_back(*can::Cia402Bus::make(hosts_, {.host = *can::NodeId::make(127)}));
    for (int i = 0; i < 10; ++i) tick();  // it has power for a while
    host().connect(now_ns);
  }
  QuirkScene(const QuirkScene&) = delete;
  QuirkScene& operator=(const QuirkScene&) = delete;

  [[nodiscard]] can::Cia402Drive& host() { return hosts_.front(); }
  void tick(const std::vector<std::int32_t>& targets = {}) {
    now_ns += tick_ns;
    std::array<can::Frame, 16> frames;
    const std::size_t count = *bus_.front().tick(now_ns, targets, frames);
    drive.advance(now_ns);
    deliver();
    for (std::size_t i = 0; i < count; ++i) {
      sent.push_back(frames.at(i));
      for (const can::Frame& frame : wire_->carry({&frames.at(i), 1}, QuirkWire::Sender::host)) {
        drive.receive(frame);
      }
      deliver();
    }
  }
  /// Until it holds; false: it does not within 20 seconds.
  bool tick_until(const std::function<bool()>& holds) {
    for (int i = 0; i < 5000 && !holds(); ++i) tick();
    return holds();
  }
  /// Set up; false: refused, and trouble() says why.
  bool is_set_up() {
    tick_until([this] { return phase() == can::DrivePhase::idle || phase() == can::DrivePhase::refused; });
    return phase() == can::DrivePhase::idle;
  }
  bool is_switched_on() {
    if (!is_set_up() || !host().enable(now_ns)) return false;
    tick_until([this] { return phase() == can::DrivePhase::following || !host().findings().empty(); });
    return phase() == can::DrivePhase::following;
  }
  /// Set up, switched on, moved by 3 mm in a second, and let go; false: something was found, or it did not
  /// move.
  bool runs() {
    if (!is_switched_on()) return false;
    const std::int32_t begin = host().target();
    for (int i = 0; i <= 250; ++i) tick({begin + std::min(i * 10'000, 2'500'000)});
    if (!host().findings().empty()) return false;
    host().disable(now_ns);
    tick_until([this] { return phase() == can::DrivePhase::disabled; });
    host().leave(now_ns);
    tick_until([this] { return phase() == can::DrivePhase::off; });
    return phase() == can::DrivePhase::off && host().findings().empty() && !drive.has_power() &&
           !drive.applied().empty() && drive.applied().back() == begin + 2'500'000;
  }
  /// As the program tells it.
  [[nodiscard]] std::string trouble() {
    if (!host().first_finding()) return "";
    const can::DriveFindingWords words = can::words_of(*host().first_finding());
    return std::string(words.what) + " (" + words_of(host().refusal()) + "); " + words.remedy;
  }
  [[nodiscard]] can::DrivePhase phase() const { return hosts_.front().phase(); }
  [[nodiscard]] int times_sent(can::FrameId id, std::initializer_list<std::uint8_t> first_bytes) const {
    return static_cast<int>(std::ranges::count_if(sent, [&](const can::Frame& frame) {
      return frame.id == id &&
             std::ranges::equal(first_bytes, std::span(frame.data).first(first_bytes.size()));
    }));
  }

  std::int64_t now_ns = 0;
  QuirkyDrive drive;
  std::vector<can::Frame> sent;  ///< by the host

 private:
  void deliver() {
    const std::vector<can::Frame> frames = drive.take_frames();
    for (const can::Frame& frame : wire_->carry(frames, QuirkWire::Sender::drive)) {
      bus_.front().receive(frame, now_ns);
    }
  }
  RigFile rig_;
  std::unique_ptr<QuirkWire> wire_ = make_quirk_wire();
  std::vector<can::Cia402Drive> hosts_;
  std::vector<can::Cia402Bus> bus_;
};

}  // namespace inbetween
