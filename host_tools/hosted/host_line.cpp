#include "host_tools/hosted/host_line.hpp"

#include <fmt/format.h>

#include <array>
#include <span>
#include <utility>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

using namespace dragonframe;

namespace {

/// The keys that a move may have (max_keys), without a pre-roll, a post-roll and the frame behind the last.
constexpr std::uint32_t frame_capacity = 10'000 - 3;

std::vector<std::uint8_t> taken_from(DmcDevice& device) {
  return device.take_bytes();
}
std::vector<std::uint8_t> taken_from(DfmocoDevice& device) {
  const std::string text = device.take_text();
  return {text.begin(), text.end()};
}

}  // namespace

HostLine::Device HostLine::device_of(HostProtocol protocol, const RigFile& rig, HostedRig& hosted) {
  const auto motors = static_cast<std::uint8_t>(rig.axes.size());
  RigPort port = [&hosted](const RigOrder& order) { return hosted.take(order); };
  if (protocol == HostProtocol::dfmoco)
    return Device(std::in_place_type<DfmocoDevice>, motors, std::move(port));
  DmcFacts facts{.motors = motors,
                 .outputs = static_cast<std::uint8_t>(output_count(rig)),
                 .frame_capacity = frame_capacity};
  facts.name = rig.name.substr(0, 31);
  return Device(std::in_place_type<DmcDevice>, facts, std::move(port));
}

HostLine::HostLine(HostPort& port, HostProtocol protocol, const RigFile& rig, HostedRig& hosted,
                   Consent consent)
    : port_(port), hosted_(hosted), consent_(consent), device_(device_of(protocol, rig, hosted)) {}

void HostLine::serve(std::int64_t now_ns) {
  look_at_rig(now_ns);
  look_at_port(now_ns);
  hear(now_ns);
  send(now_ns);
  note();
}

/// Why comes before what the host was answered.
void HostLine::note() {
  for (std::string& words : hosted_.take_words()) say(std::move(words));
  for (const PortNotice& notice : std::visit([](auto& device) { return device.take_notices(); }, device_)) {
    say(text_of(notice));
  }
}

void HostLine::look_at_port(std::int64_t now_ns) {
  switch (port_.look(now_ns)) {
    case PortChange::none:
      return;
    case PortChange::came:
      unsent_.clear();
      std::visit([&](auto& device) { device.connect(now_ns); }, device_);
      if (consent_ == Consent::given) agree();
      return;
    case PortChange::went:
      return disconnect(now_ns);
    case PortChange::refused:
      ++refused_hosts_;
      return say("a second host was refused: one has the rig already");
  }
}

void HostLine::disconnect(std::int64_t now_ns) {
  std::visit([&](auto& device) { device.disconnect(now_ns); }, device_);
  agrees_ = false;
  unsent_.clear();
}

void HostLine::hear(std::int64_t now_ns) {
  std::array<std::uint8_t, 1024> bytes{};
  constexpr int max_reads = 16;  // a host that never pauses waits for the others, too
  for (int i = 0; i < max_reads; ++i) {
    const std::size_t count = port_.read(bytes);
    if (count == 0) return;
    std::visit([&](auto& device) { device.hear(std::span(bytes).first(count), now_ns); }, device_);
  }
}

void HostLine::send(std::int64_t now_ns) {
  const std::vector<std::uint8_t> bytes =
      std::visit([](auto& device) { return taken_from(device); }, device_);
  if (!port_.has_host()) return;
  unsent_.insert(unsent_.end(), bytes.begin(), bytes.end());
  while (!unsent_.empty()) {
    const std::size_t count = port_.write(unsent_);
    if (count == 0) break;
    unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  if (unsent_.size() <= max_unread_bytes) return;
  say("the host reads nothing any more: it counts as gone");
  disconnect(now_ns);
  std::visit([&](auto& device) { device.connect(now_ns); }, device_);
}

void HostLine::look_at_rig(std::int64_t now_ns) {
  hosted_.look();
  std::visit([&](auto& device) { device.observe(hosted_.state(), now_ns); }, device_);
  while (const auto event = hosted_.take_event()) {
    std::visit([&](auto& device) { device.tell(*event, now_ns); }, device_);
  }
  if (agrees_ && hosted_.is_ready()) arm();
}

void HostLine::arm() {
  agrees_ = false;
  const bool is_armed = std::visit([](auto& device) { return device.arm(); }, device_);
  say(is_armed ? "agreed: the host may move the rig" : "not yet: nobody is connected, or a stop is not over");
}

void HostLine::agree() {
  if (!hosted_.is_ready()) hosted_.acknowledge();
  agrees_ = true;
}

void HostLine::stop(std::int64_t now_ns) {
  agrees_ = false;
  std::visit([&](auto& device) { device.stop(now_ns); }, device_);
}

bool HostLine::is_armed() const {
  return std::visit([](const auto& device) { return device.is_armed(); }, device_);
}

bool HostLine::is_connected() const {
  return std::visit([](const auto& device) { return device.is_connected(); }, device_);
}

std::vector<std::string> HostLine::take_words() {
  note();
  return std::exchange(words_, {});
}

std::string HostLine::state_in_words() const {
  if (!is_connected()) return "no host at " + port_.name();
  return is_armed() ? "a host is connected and may move the rig"
                    : "a host is connected; it moves nothing until you agree: Enter";
}

std::string HostLine::counts_in_words() const {
  const std::string refused =
      refused_hosts_ == 0
          ? ""
          : fmt::format("; {} refused", counted(static_cast<std::int64_t>(refused_hosts_), "host"));
  if (const auto* const dmc = std::get_if<DmcDevice>(&device_)) {
    return fmt::format("{} heard, {} with wrong check bytes, {} bytes skipped{}",
                       counted(static_cast<std::int64_t>(dmc->counters().frames), "message"),
                       dmc->counters().damaged, dmc->counters().skipped_bytes, refused);
  }
  const DfmocoCounters& lines = std::get<DfmocoDevice>(device_).counters();
  return fmt::format("{} heard, {} that are none{}",
                     counted(static_cast<std::int64_t>(lines.lines), "command"), lines.unknown, refused);
}

}  // namespace inbetween
