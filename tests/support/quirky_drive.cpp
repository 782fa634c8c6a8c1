#include "tests/support/quirky_drive.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace inbetween {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::uint32_t is_off = 0x80000000;

std::vector<std::uint8_t> bytes_of(std::uint32_t value, std::size_t size) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  return bytes;
}

std::uint32_t number_of(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(bytes.size(), 4); ++i) {
    value |= std::uint32_t{bytes[i]} << (8 * i);
  }
  return value;
}

constexpr unsigned key_of(unsigned index, unsigned sub) {
  return index << 8 | sub;
}

/// "60C2:1", "6060"
unsigned key_of(const std::string& name) {
  char* end = nullptr;
  const auto index = static_cast<unsigned>(std::strtoul(name.c_str(), &end, 16));
  const unsigned sub = *end == ':' ? static_cast<unsigned>(std::strtoul(end + 1, nullptr, 16)) : 0;
  return key_of(index, sub);
}

}  // namespace

QuirkyDrive::QuirkyDrive(std::string_view quirks, unsigned node) : node_(node) {
  fill_dictionary();
  read_quirks(quirks);
  power_on_ = objects_;
}

void QuirkyDrive::add(unsigned index, unsigned sub, std::size_t size, std::uint32_t value) {
  objects_[key_of(index, sub)] = bytes_of(value, size);
}

void QuirkyDrive::set(unsigned index, unsigned sub, std::uint32_t value) {
  const auto found = objects_.find(key_of(index, sub));
  if (found != objects_.end()) found->second = bytes_of(value, found->second.size());
}

std::uint32_t QuirkyDrive::value(unsigned index, unsigned sub) const {
  const auto found = objects_.find(key_of(index, sub));
  return found == objects_.end() ? 0 : number_of(found->second);
}

int QuirkyDrive::writes(unsigned index, unsigned sub) const {
  const auto found = writes_.find(key_of(index, sub));
  return found == writes_.end() ? 0 : found->second;
}

void QuirkyDrive::fill_dictionary() {
  add(0x1000, 0, 4, 0x00020192);
  add(0x1001, 0, 1, 0);
  add(0x1005, 0, 4, 0x80);
  add(0x1006, 0, 4, 0);
  add(0x100C, 0, 2, 0);
  add(0x100D, 0, 1, 0);
  add(0x1016, 1, 4, 0);
  add(0x1017, 0, 2, 0);
  add(0x1018, 1, 4, 1);
  add(0x1018, 2, 4, 2);
  add(0x1019, 0, 1, 0);
  add(0x1029, 1, 1, 0);
  for (unsigned n = 0; n < 4; ++n) {
    add(0x1400 + n, 1, 4, (n == 0 ? 0 : is_off) | (0x200 + 0x100 * n + node_));
    add(0x1400 + n, 2, 1, 255);
    add(0x1400 + n, 5, 2, 0);
    add(0x1800 + n, 1, 4, (n == 0 ? 0 : is_off) | 0x40000000 | (0x180 + 0x100 * n + node_));
    add(0x1800 + n, 2, 1, 255);
    add(0x1800 + n, 3, 2, 0);
    add(0x1800 + n, 5, 2, 0);
    for (unsigned sub = 0; sub <= 4; ++sub) {
      add(0x1600 + n, sub, sub == 0 ? 1 : 4, 0);
      add(0x1A00 + n, sub, sub == 0 ? 1 : 4, 0);
    }
  }
  add(0x6007, 0, 2, 1);
  add(0x6040, 0, 2, 0);
  add(0x6041, 0, 2, 0x40);
  add(0x605A, 0, 2, 2);
  add(0x605B, 0, 2, 0);
  add(0x605C, 0, 2, 1);
  add(0x605D, 0, 2, 1);
  add(0x605E, 0, 2, 2);
  add(0x6060, 0, 1, 0);
  add(0x6061, 0, 1, 0);
  add(0x6064, 0, 4, 0);
  add(0x6065, 0, 4, 5000);
  add(0x607A, 0, 4, 0);
  add(0x607D, 1, 4, 0);
  add(0x607D, 2, 4, 0);
  add(0x6085, 0, 4, 100'000);
  add(0x60C2, 1, 1, 1);
  add(0x60C2, 2, 1, 0xFD);
  add(0x6502, 0, 4, 0x80);
}

void QuirkyDrive::read_quirks(std::string_view quirks) {
  const toml::table table = toml::parse(quirks);
  const std::map<std::string, std::set<unsigned>*> lists{
      {"read_only", &read_only_}, {"write_only", &write_only_}, {"wide", &wide_}, {"segmented", &segmented_}};
  std::size_t known = 0;
  const auto take = [&](const char* name, auto& habit) {
    if (!table.contains(name)) return;
    using Habit = std::remove_reference_t<decltype(habit)>;
    habit = table[name].value<Habit>().value();
    ++known;
  };
  for (const auto& [key, list] : table) {
    const std::string name(key.str());
    if (name == "values") {
      for (const auto& [object, value] : *list.as_table()) {
        const unsigned at = key_of(std::string(object.str()));
        objects_.at(at) =
            bytes_of(static_cast<std::uint32_t>(value.value<std::int64_t>().value()), objects_.at(at).size());
      }
    } else if (name == "sizes") {
      for (const auto& [object, size] : *list.as_table()) {
        Bytes& bytes = objects_[key_of(std::string(object.str()))];
        bytes.resize(static_cast<std::size_t>(size.value<std::int64_t>().value()));
        for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(7 * i + 1);
      }
    } else if (name != "absent" && !lists.contains(name)) {
      continue;
    } else {
      for (const toml::node& object : *list.as_array()) {
        const unsigned at = key_of(object.value<std::string>().value());
        name == "absent" ? void(objects_.erase(at)) : void(lists.at(name)->insert(at));
      }
    }
    ++known;
  }
  take("high_bytes", habits_.high_bytes);
  take("starts_itself", habits_.starts_itself);
  take("boots_after_communication", habits_.boots_after_communication);
  take("heartbeat_step_ms", habits_.heartbeat_step_ms);
  take("shows_mode", habits_.shows_mode);
  take("mode_shown", habits_.mode_shown);
  take("mode_delay_ms", habits_.mode_delay_ms);
  take("brake_ms", habits_.brake_ms);
  take("sag_counts", habits_.sag_counts);
  take("has_bit_12", habits_.has_bit_12);
  take("bit_11_ms", habits_.bit_11_ms);
  take("emergency", habits_.emergency);
  take("warns", habits_.warns);
  take("toggles", habits_.toggles);
  take("loses_answer", habits_.loses_answer);
  take("doubles_answer", habits_.doubles_answer);
  take("fails", habits_.fails);
  if (known != table.size()) throw std::invalid_argument("a quirk has another name");
}

void QuirkyDrive::send(unsigned id, const Bytes& bytes) {
  can::Frame frame{.id = can::FrameId::standard(id), .length = static_cast<std::uint8_t>(bytes.size())};
  std::ranges::copy(bytes, frame.data.begin());
  frames_.push_back(frame);
}

std::vector<can::Frame> QuirkyDrive::take_frames() {
  std::vector<can::Frame> frames;
  frames.swap(frames_);
  return frames;
}

// --- NMT, heartbeats

void QuirkyDrive::boot() {
  boot_ns_.reset();
  for (const auto& [key, bytes] : power_on_) {
    if (key >> 8 < 0x2000) objects_[key] = bytes;
  }
  send(0x700 + node_, {0});
  nmt_ = habits_.starts_itself ? 0x05 : 0x7F;
  heartbeat_ns_ = now_ns_;
}

void QuirkyDrive::obey_nmt(unsigned command) {
  const bool starts_anew = command == 0x81 || (command == 0x82 && habits_.boots_after_communication);
  if (starts_anew) {
    boot_ns_ = now_ns_ + 10 * ms;
    if (state_ != 0x08) go_to(0x40);
  }
  if (command == 0x01) nmt_ = 0x05;
  if (command == 0x02) nmt_ = 0x04;
  if (command == 0x80) nmt_ = 0x7F;
  if (nmt_ != 0x05) {
    setpoint_deadline_ns_.reset();
    if (has_power()) go_to(0x40);
  }
  if (starts_anew) {
    nmt_ = 0;
    host_deadline_ns_.reset();
    guard_deadline_ns_.reset();
    guard_answers_ = 0;
  }
}

void QuirkyDrive::advance(std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (boot_ns_ && now_ns >= *boot_ns_) boot();
  if (boot_ns_) return;
  const std::int64_t period_ns = value(0x1017) * ms;
  if (period_ns > 0 && now_ns >= heartbeat_ns_) {
    send(0x700 + node_, {nmt_});
    heartbeat_ns_ = now_ns + period_ns;
  }
  if (host_deadline_ns_ && now_ns >= *host_deadline_ns_) {
    host_deadline_ns_.reset();
    stop_without_host(0x8130);
  }
  if (guard_deadline_ns_ && now_ns >= *guard_deadline_ns_) {
    guard_deadline_ns_.reset();
    stop_without_host(0x8130);
  }
  if (setpoint_deadline_ns_ && now_ns >= *setpoint_deadline_ns_) {
    setpoint_deadline_ns_.reset();
    stop_without_host(0x8250);
  }
  if (brake_ns_ && now_ns >= *brake_ns_) go_to(0x27);
  const bool tells_now = is_in_operation() && habits_.emergency != 0 && !has_reported_;
  if (tells_now && since_enabled_ms() >= 200) {
    has_reported_ = true;
    warns_now_ = habits_.warns;
    if (habits_.fails) go_to(0x08);
    send_emergency(habits_.emergency);
  }
}

void QuirkyDrive::stop_without_host(unsigned code) {
  send_emergency(code);
  if (has_power()) go_to(0x08);
}

void QuirkyDrive::send_emergency(unsigned code) {
  send(0x80 + node_,
       {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8), 1, 0, 0, 0, 0, 0});
}

void QuirkyDrive::receive(const can::Frame& frame) {
  if (boot_ns_ || frame.id.is_extended()) return;
  const std::uint32_t id = frame.id.number();
  if (frame.is_remote && id == 0x700 + node_) return answer_guard();
  if (frame.is_remote) return;
  const Bytes bytes(frame.data.begin(), frame.data.begin() + frame.length);
  const std::uint32_t host = value(0x1016, 1);
  if (id == 0x000 && bytes.size() == 2 && (bytes[1] == 0 || bytes[1] == node_)) obey_nmt(bytes[0]);
  if (id == 0x600 + node_ && bytes.size() == 8 && nmt_ != 0x04) serve(bytes);
  if (id == 0x80) hear_sync();
  if (id == 0x700 + (host >> 16) && (host & 0xFFFF) != 0) {
    host_deadline_ns_ = now_ns_ + (host & 0xFFFF) * ms;
  }
  if (nmt_ != 0x05 || !is_valid(0x1400) || id != (value(0x1400, 1) & 0x7FF)) return;
  if (value(0x1400, 5) != 0) setpoint_deadline_ns_ = now_ns_ + value(0x1400, 5) * ms;
  if (value(0x1400, 2) <= 240) {
    waiting_ = bytes;
  } else {
    apply(bytes);
  }
}

void QuirkyDrive::answer_guard() {
  if (value(0x1017) != 0) return;  // it has heartbeats
  const bool is_odd = habits_.toggles && guard_answers_ % 2 == 1;
  ++guard_answers_;
  const int times = guard_answers_ == habits_.loses_answer     ? 0
                    : guard_answers_ == habits_.doubles_answer ? 2
                                                               : 1;
  for (int i = 0; i < times; ++i) {
    send(0x700 + node_, {static_cast<std::uint8_t>(nmt_ | (is_odd ? 0x80 : 0))});
  }
  const std::int64_t life_ms = std::int64_t{value(0x100C)} * value(0x100D);
  if (life_ms != 0) guard_deadline_ns_ = now_ns_ + life_ms * ms;
}

// --- SDO

void QuirkyDrive::answer(std::uint8_t command, unsigned key, const Bytes& bytes) {
  Bytes frame{command, static_cast<std::uint8_t>(key >> 8), static_cast<std::uint8_t>(key >> 16),
              static_cast<std::uint8_t>(key)};
  frame.insert(frame.end(), bytes.begin(), bytes.end());
  frame.resize(8);
  send(0x580 + node_, frame);
}

void QuirkyDrive::abort(unsigned key, std::uint32_t code) {
  transfer_.reset();
  answer(0x80, key, bytes_of(code, 4));
}

void QuirkyDrive::serve(const Bytes& request) {
  const unsigned key = key_of(static_cast<unsigned>(request[1] | request[2] << 8), request[3]);
  const unsigned kind = request[0] >> 5;
  if (kind == 4) {
    transfer_.reset();
  } else if (kind == 2) {
    upload(key);
  } else if (kind == 3 && transfer_ && !transfer_->is_download) {
    send_segment((request[0] & 0x10) != 0);
  } else if (kind == 0 && transfer_ && transfer_->is_download) {
    take_segment(request);
  } else if (kind == 1 && (request[0] & 2) != 0) {
    const std::size_t size = (request[0] & 1) != 0 ? 4 - ((request[0] >> 2) & 3U) : 4;
    download(key, Bytes(request.begin() + 4, request.begin() + 4 + static_cast<std::ptrdiff_t>(size)));
  } else if (kind == 1) {
    transfer_ = Transfer{.key = key, .bytes = {}, .is_download = true};
    answer(0x60, key, {});
  } else {
    abort(key, 0x05040001);
  }
}

void QuirkyDrive::upload(unsigned key) {
  show();
  if (!objects_.contains(key)) {
    const auto next = objects_.lower_bound(key & ~0xFFU);
    const bool has_index = next != objects_.end() && next->first >> 8 == key >> 8;
    return abort(key, has_index ? 0x06090011 : 0x06020000);
  }
  if (write_only_.contains(key)) return abort(key, 0x06010001);
  Bytes bytes = objects_.at(key);
  if (wide_.contains(key)) {
    const bool is_negative = (bytes.back() & 0x80) != 0;
    bytes.resize(4, is_negative ? 0xFF : 0x00);
    bytes = bytes_of(number_of(bytes) ^ habits_.high_bytes, 4);
  }
  if (bytes.size() <= 4 && !segmented_.contains(key)) {
    return answer(static_cast<std::uint8_t>(0x43 | (4 - bytes.size()) << 2), key, bytes);
  }
  transfer_ = Transfer{.key = key, .bytes = bytes};
  answer(0x41, key, bytes_of(static_cast<std::uint32_t>(bytes.size()), 4));
}

void QuirkyDrive::send_segment(bool toggle) {
  if (toggle != transfer_->toggle) return abort(transfer_->key, 0x05030000);
  const std::size_t size = std::min<std::size_t>(7, transfer_->bytes.size() - transfer_->at);
  const bool is_last = transfer_->at + size == transfer_->bytes.size();
  Bytes frame{static_cast<std::uint8_t>((toggle ? 0x10 : 0) | (7 - size) << 1 | (is_last ? 1 : 0))};
  const auto first = transfer_->bytes.begin() + static_cast<std::ptrdiff_t>(transfer_->at);
  frame.insert(frame.end(), first, first + static_cast<std::ptrdiff_t>(size));
  frame.resize(8);
  transfer_->at += size;
  transfer_->toggle = !toggle;
  if (is_last) transfer_.reset();
  send(0x580 + node_, frame);
}

void QuirkyDrive::take_segment(const Bytes& request) {
  const bool toggle = (request[0] & 0x10) != 0;
  if (toggle != transfer_->toggle) return abort(transfer_->key, 0x05030000);
  const std::size_t size = 7 - ((request[0] >> 1) & 7U);
  transfer_->bytes.insert(transfer_->bytes.end(), request.begin() + 1,
                          request.begin() + 1 + static_cast<std::ptrdiff_t>(size));
  transfer_->toggle = !toggle;
  const bool is_last = (request[0] & 1) != 0;
  if (is_last && refuses(transfer_->key, transfer_->bytes)) {
    return abort(transfer_->key, *refuses(transfer_->key, transfer_->bytes));
  }
  if (is_last) {
    objects_[transfer_->key] = transfer_->bytes;
    transfer_.reset();
  }
  Bytes frame(8);
  frame[0] = static_cast<std::uint8_t>(0x20 | (toggle ? 0x10 : 0));
  send(0x580 + node_, frame);
}

bool QuirkyDrive::is_valid(unsigned communication) const {
  return (value(communication, 1) & is_off) == 0;
}

std::optional<std::uint32_t> QuirkyDrive::refuses(unsigned key, const Bytes& bytes) const {
  const unsigned index = key >> 8;
  const unsigned sub = key & 0xFF;
  if (!objects_.contains(key)) return 0x06020000;
  if (read_only_.contains(key)) return 0x06010002;
  if (bytes.size() != objects_.at(key).size()) return 0x06070010;
  const std::uint32_t wanted = number_of(bytes);
  const unsigned group = index & 0xFFFC;
  const bool is_mapping = group == 0x1600 || group == 0x1A00;
  const bool is_cob_id = (group == 0x1400 || group == 0x1800) && sub == 1;
  if ((is_mapping || is_cob_id) && nmt_ == 0x05) return 0x08000022;
  if (is_mapping && is_valid(index - 0x200)) return 0x06010000;
  if (is_mapping && sub != 0 && value(index) != 0) return 0x06010000;
  const bool is_change = is_cob_id && is_valid(index) && (wanted & is_off) == 0;
  if (is_change && wanted != value(index, 1)) return 0x06090030;
  if (index == 0x1019 && value(0x1006) != 0) return 0x08000022;
  if (index == 0x607D) {
    const auto min = static_cast<std::int32_t>(sub == 1 ? wanted : value(index, 1));
    const auto max = static_cast<std::int32_t>(sub == 2 ? wanted : value(index, 2));
    if (min > max) return 0x06090036;
  }
  if (index == 0x6060 && wanted != 8) return 0x06090030;
  return {};
}

void QuirkyDrive::download(unsigned key, const Bytes& bytes) {
  ++writes_[key];
  if (const auto code = refuses(key, bytes)) return abort(key, *code);
  objects_[key] = bytes;
  if (key >> 8 == 0x1017) {
    const unsigned step = habits_.heartbeat_step_ms;
    set(0x1017, 0, (value(0x1017) + step - 1) / step * step);
    heartbeat_ns_ = now_ns_;
  }
  if (key >> 8 == 0x1016) host_deadline_ns_.reset();
  if (key >> 8 == 0x100C || key >> 8 == 0x100D) guard_deadline_ns_.reset();
  if (key == key_of(0x1400, 5)) setpoint_deadline_ns_.reset();
  if (key >> 8 == 0x6040) obey(value(0x6040));
  answer(0x60, key, {});
}

// --- PDO

void QuirkyDrive::apply(const Bytes& bytes) {
  std::size_t at = 0;
  for (unsigned sub = 1; sub <= value(0x1600); ++sub) {
    const std::uint32_t entry = value(0x1600, sub);
    const std::size_t size = (entry & 0xFF) / 8;
    if (at + size > bytes.size()) return;
    objects_[entry >> 8] = Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                                 bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
    at += size;
  }
  obey(value(0x6040));
}

void QuirkyDrive::hear_sync() {
  if (nmt_ != 0x05) return;
  tell();
  if (waiting_) apply(*waiting_);
  waiting_.reset();
  if (!is_in_operation()) return;
  const auto target = static_cast<std::int32_t>(value(0x607A));
  applied_.push_back(target);
  actual_ = target - habits_.sag_counts;
}

void QuirkyDrive::tell() {
  if (!is_valid(0x1800) || value(0x1800, 2) == 0 || value(0x1800, 2) > 240) return;
  show();
  Bytes bytes;
  for (unsigned sub = 1; sub <= value(0x1A00); ++sub) {
    const std::uint32_t entry = value(0x1A00, sub);
    Bytes part = bytes_of(value(entry >> 16, entry >> 8 & 0xFF), (entry & 0xFF) / 8);
    bytes.insert(bytes.end(), part.begin(), part.end());
  }
  if (bytes.size() <= 8) send(value(0x1800, 1) & 0x7FF, bytes);
}

// --- the drive

void QuirkyDrive::go_to(std::uint8_t state) {
  state_ = state;
  brake_ns_.reset();
  if (state != 0x27) return;
  enabled_ns_ = now_ns_;
  actual_ -= habits_.sag_counts;
}

void QuirkyDrive::obey(std::uint32_t word) {
  const bool resets = (word & 0x80) != 0 && (last_word_ & 0x80) == 0;
  last_word_ = word;
  if (state_ == 0x08) {
    if (resets) go_to(0x40);
    return;
  }
  const unsigned order = word & 0x0F;
  if ((order & 2) == 0 || (order & 4) == 0) return go_to(0x40);
  if (order == 0x6) return go_to(0x21);
  if (order == 0x7 && (state_ == 0x21 || state_ == 0x27)) return go_to(0x23);
  if (order == 0x7) brake_ns_.reset();
  if (order == 0xF && state_ == 0x23 && !brake_ns_) brake_ns_ = now_ns_ + habits_.brake_ms * ms;
}

/// What it tells of itself: 6041, 6061, 6064.
void QuirkyDrive::show() {
  unsigned word = state_ | 0x0200U;
  if (has_power()) word |= 0x10;
  if (is_in_operation() && habits_.has_bit_12) word |= 0x1000;
  const std::int64_t into_limit_ms = since_enabled_ms() - 200;
  if (is_in_operation() && into_limit_ms >= 0 && into_limit_ms < habits_.bit_11_ms) word |= 0x0800;
  if (warns_now_) word |= 0x80;
  set(0x6041, 0, word);
  set(0x6064, 0, static_cast<std::uint32_t>(actual_));
  const bool is_late = !is_in_operation() || since_enabled_ms() < habits_.mode_delay_ms;
  const bool shows_other = habits_.shows_mode == "never" || (habits_.shows_mode == "enabled" && is_late);
  set(0x6061, 0, shows_other ? habits_.mode_shown : value(0x6060));
}

}  // namespace inbetween
