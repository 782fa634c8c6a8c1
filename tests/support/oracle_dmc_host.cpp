#include "tests/support/oracle_dmc_host.hpp"

#include <stdexcept>
#include <utility>

namespace inbetween::oracle {
namespace {

/// Fletcher's sums as sums, modulus 255: the second counts each byte as often as it is summed.
std::pair<std::uint64_t, std::uint64_t> dmc_sums(const DmcBytes& bytes) {
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    first += bytes[i];
    second += (bytes.size() - i) * bytes[i];
  }
  return {first % 255, second % 255};
}

}  // namespace

std::uint32_t DmcHeard::number(std::size_t offset, std::size_t count) const {
  std::uint32_t value = 0;
  for (std::size_t i = count; i > 0; --i) value = value << 8U | payload.at(offset + i - 1);
  return value;
}

std::int32_t DmcHeard::position(std::size_t motor) const {
  return static_cast<std::int32_t>(number(4 * motor, 4));
}

DmcPayload& DmcPayload::add(std::int64_t number, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(number) >> (8 * i)));
  }
  return *this;
}

DmcBytes dmc_message(unsigned type, std::uint32_t id, const DmcBytes& payload) {
  DmcPayload whole;
  whole.add('D', 1).add('F', 1).add(id, 4).add(type, 2).add(static_cast<std::int64_t>(payload.size()), 2);
  for (const std::uint8_t byte : payload) whole.add(byte, 1);
  const auto [first, second] = dmc_sums(whole.bytes());
  const std::uint64_t check = 255 - (first + second) % 255;
  whole.add(static_cast<std::int64_t>(check), 1);
  whole.add(static_cast<std::int64_t>(255 - (first + check) % 255), 1);
  return whole.bytes();
}

DmcBytes DmcHost::ask(unsigned type, const DmcBytes& payload) {
  answers_.clear();
  return dmc_message(type, id_++, payload);
}

DmcBytes DmcHost::move(unsigned motor, std::int32_t target) {
  return ask(0x0031, DmcPayload().add(motor, 1).add(target, 4).bytes());
}
DmcBytes DmcHost::stop(unsigned motor) {
  return ask(0x0032, DmcPayload().add(motor, 1).bytes());
}
DmcBytes DmcHost::stop_all(std::optional<std::uint32_t> flags) {
  return flags ? ask(0x0033, DmcPayload().add(*flags, 4).bytes()) : ask(0x0033);
}
DmcBytes DmcHost::reset(unsigned motor, std::int32_t position) {
  return ask(0x0035, DmcPayload().add(motor, 1).add(position, 4).bytes());
}
DmcBytes DmcHost::jog(unsigned motor, unsigned speed, std::int32_t destination) {
  return ask(0x0036, DmcPayload().add(motor, 1).add(speed, 2).add(destination, 4).bytes());
}
DmcBytes DmcHost::configure(unsigned motor, unsigned flags) {
  return ask(0x0037, DmcPayload().add(motor, 1).add(flags, 1).bytes());
}
DmcBytes DmcHost::speed(unsigned motor, std::uint32_t velocity, std::uint32_t acceleration) {
  return ask(0x0038, DmcPayload().add(motor, 1).add(velocity, 4).add(acceleration, 4).bytes());
}
DmcBytes DmcHost::limits(unsigned motor, std::optional<std::int32_t> lower,
                         std::optional<std::int32_t> upper) {
  return ask(0x0039, DmcPayload()
                         .add(motor, 1)
                         .add(lower ? 1 : 0, 1)
                         .add(lower.value_or(0), 4)
                         .add(upper ? 1 : 0, 1)
                         .add(upper.value_or(0), 4)
                         .add(0, 1)
                         .bytes());
}
DmcBytes DmcHost::upload_begin(std::int32_t start, std::int32_t end) {
  return ask(0x0100, DmcPayload().add(start, 4).add(end, 4).bytes());
}
DmcBytes DmcHost::upload_axis(unsigned motor, std::uint32_t index, bool is_last,
                              const std::vector<std::int32_t>& positions) {
  DmcPayload payload;
  payload.add(motor, 1).add(index | (is_last ? 0x8000'0000U : 0U), 4);
  for (const std::int32_t position : positions) payload.add(position, 4);
  return ask(0x0101, payload.bytes());
}
DmcBytes DmcHost::upload_triggers(std::uint32_t mask,
                                  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& triggers) {
  DmcPayload payload;
  payload.add(mask, 4);
  for (const auto& [index, values] : triggers) payload.add(index, 4).add(values, 4);
  return ask(0x0104, payload.bytes());
}
DmcBytes DmcHost::position_frame(std::int32_t frame) {
  return ask(0x0110, DmcPayload().add(frame, 4).bytes());
}
DmcBytes DmcHost::run(const DmcRunScript& script) {
  DmcPayload payload;
  payload.add(script.fps_1000, 4).add(script.start, 4).add(script.end, 4);
  payload.add(script.preroll_ms, 4).add(script.postroll_ms, 4).add(script.is_synced ? 1 : 0, 1);
  payload.add(script.bloop_bits, 4).add(0, 2).add(script.bloop_ms, 2);
  payload.add(script.flags | (script.shutter_deg ? 0x0020U : 0U), 2);
  if (script.shutter_deg) payload.add(script.shutter_deg->first, 2).add(script.shutter_deg->second, 2);
  return ask(0x0111, payload.bytes());
}
DmcBytes DmcHost::shoot(std::int32_t frame, bool forward, std::uint32_t exposure_ms, unsigned blur_permille,
                        const std::vector<DmcWayScript>& ways) {
  DmcPayload payload;
  payload.add(frame, 4).add(forward ? 1 : 0, 1).add(exposure_ms, 4).add(blur_permille, 2);
  for (const DmcWayScript& way : ways) payload.add(way.motor, 1).add(way.from, 4).add(way.to, 4);
  return ask(0x0112, payload.bytes());
}
DmcBytes DmcHost::shoot2(std::int32_t frame, std::uint32_t exposure_ms, std::pair<int, int> shutter_deg,
                         const std::vector<DmcWayScript>& ways) {
  DmcPayload payload;
  payload.add(frame, 4).add(exposure_ms, 4).add(shutter_deg.first, 2).add(shutter_deg.second, 2);
  for (const DmcWayScript& way : ways) payload.add(way.motor, 1).add(way.from, 4).add(way.to, 4);
  return ask(0x0115, payload.bytes());
}
DmcBytes DmcHost::jog_all(std::uint32_t fps_1000, std::int32_t frame) {
  return ask(0x0120, DmcPayload().add(fps_1000, 4).add(frame, 4).bytes());
}

void DmcHost::hear(const DmcBytes& bytes) {
  half_.insert(half_.end(), bytes.begin(), bytes.end());
  while (half_.size() >= 10) {
    if (half_[0] != 'D' || half_[1] != 'F') throw std::runtime_error("what the device sends is no frame");
    const std::size_t length = 12U + half_[8] + 256U * half_[9];
    if (half_.size() < length) return;
    const auto end = half_.begin() + static_cast<std::ptrdiff_t>(length);
    const DmcBytes frame(half_.begin(), end);
    half_.erase(half_.begin(), end);
    if (dmc_sums(frame) != std::pair<std::uint64_t, std::uint64_t>{0, 0}) {
      throw std::runtime_error("the check bytes of the device are wrong");
    }
    DmcHeard heard{.payload = DmcBytes(frame.begin() + 10, frame.end() - 2)};
    heard.id = DmcHeard{.payload = frame}.number(2, 4);
    heard.type = DmcHeard{.payload = frame}.number(6, 2);
    if (heard.id == last_id()) answers_.push_back(heard);
    heard_.push_back(std::move(heard));
  }
}

std::vector<DmcHeard> DmcHost::take_heard() {
  return std::exchange(heard_, {});
}

std::size_t DmcHost::answers() const {
  return answers_.size();
}

unsigned DmcHost::code() const {
  for (const DmcHeard& heard : answers_) {
    if ((heard.type & 0x8000U) != 0) return heard.number(0, 2);
  }
  return 0;
}

std::optional<DmcHeard> DmcHost::data() const {
  for (const DmcHeard& heard : answers_) {
    if ((heard.type & 0x8000U) == 0) return heard;
  }
  return {};
}

}  // namespace inbetween::oracle
