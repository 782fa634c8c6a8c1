#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "inbetween/can/cia402_setup.hpp"
#include "inbetween/can/sdo.hpp"

namespace inbetween::can {

/// The script for a drive; one that cannot be written ends the test.
inline SetupScript script_of(const Cia402Setup& setup) {
  SetupScript script;
  static_cast<void>(write_setup_script(setup, script).value());
  return script;
}

/// The objects of a CiA 402 drive with node 5, as an SDO server without a drive behind it. They can be
/// broken.
class DriveObjects {
 public:
  using Key = std::pair<int, int>;
  DriveObjects() {
    set(0x1000, 0, 4, 0x00020192);
    set(0x1005, 0, 4, 0x80);
    set(0x1006, 0, 4, 0);
    set(0x1016, 1, 4, 0);
    set(0x1017, 0, 2, 0);
    set(0x1018, 1, 4, 0x1234);
    set(0x1018, 2, 4, 0x5678);
    set(0x1019, 0, 1, 0);
    set(0x1029, 1, 1, 1);
    set(0x6502, 0, 4, 0xA5);
    for (int n = 0; n < 4; ++n) {
      set(0x1400 + n, 1, 4, static_cast<std::uint32_t>(0x205 + 0x100 * n));
      set(0x1800 + n, 1, 4, static_cast<std::uint32_t>(0x40000185 + 0x100 * n));
      for (const int sub : {2, 3, 5}) {
        set(0x1400 + n, sub, sub == 2 ? 1 : 2, 0);
        set(0x1800 + n, sub, sub == 2 ? 1 : 2, 7);
      }
      for (int sub = 0; sub <= 8; ++sub) {
        set(0x1600 + n, sub, sub == 0 ? 1 : 4, 0);
        set(0x1A00 + n, sub, sub == 0 ? 1 : 4, 0);
      }
    }
    set(0x605A, 0, 2, 2);
    set(0x605B, 0, 2, 0);
    set(0x605C, 0, 2, 1);
    set(0x605D, 0, 2, 1);
    set(0x605E, 0, 2, 2);
    set(0x6007, 0, 2, 1);
    set(0x6060, 0, 1, 1);
    set(0x6065, 0, 4, 2000);
    set(0x6066, 0, 2, 0);
    set(0x607B, 1, 4, 0x80000000);
    set(0x607B, 2, 4, 0x7FFFFFFF);
    set(0x6064, 0, 4, 0);
    set(0x607D, 1, 4, 0);
    set(0x607D, 2, 4, 0);
    set(0x6085, 0, 4, 1000);
    set(0x60C2, 1, 1, 20);
    set(0x60C2, 2, 1, 0xFD);
  }
  void set(int index, int sub, int size, std::uint32_t value) { values_[{index, sub}] = {size, value}; }
  void remove(int index, int sub) { values_.erase({index, sub}); }
  [[nodiscard]] std::uint32_t value(int index, int sub) const { return values_.at({index, sub}).second; }
  /// The object takes writes, but keeps what it has.
  void freeze(int index, int sub) { frozen_ = {index, sub}; }

  /// It is neither read nor written.
  void silence(int index, int sub) { silent_ = {index, sub}; }
  /// Writing it is refused for this reason.
  void refuse(int index, int sub, std::uint32_t abort_code) { refused_[{index, sub}] = abort_code; }

  SdoMessage answer(const SdoMessage& request) {
    const Key key{request.object.index, request.object.sub};
    if (request.kind == SdoKind::download && refused_.contains(key)) {
      return {.kind = SdoKind::abort, .object = request.object, .value = refused_.at(key)};
    }
    if (!values_.contains(key)) {
      return {.kind = SdoKind::abort, .object = request.object, .value = abort_no_object};
    }
    auto& [size, value] = values_.at(key);
    if (request.kind == SdoKind::upload) {
      return {.kind = SdoKind::upload_value,
              .object = request.object,
              .size = static_cast<std::uint8_t>(size),
              .value = value};
    }
    written.emplace_back(key, request.value);
    if (request.size != size) {
      return {.kind = SdoKind::abort, .object = request.object, .value = abort_wrong_length};
    }
    if (key != frozen_) value = request.value;
    return {.kind = SdoKind::download_done, .object = request.object};
  }

  /// Works a script off, a request a millisecond.
  void work_off(SetupRunner& runner, const SetupScript& script) {
    runner.begin(script);
    for (std::int64_t now_ns = 0; now_ns < 2'000'000'000; now_ns += 1'000'000) {
      if (runner.state() == SetupState::done || runner.state() == SetupState::refused) return;
      const std::optional<Frame> frame = runner.poll(script, now_ns);
      if (!frame) continue;
      const SdoMessage request = *read_sdo_request(*frame);
      if (Key{request.object.index, request.object.sub} == silent_) continue;
      runner.receive(sdo_frame(sdo_answer_id(*NodeId::make(5)), answer(request)));
    }
  }

  std::vector<std::pair<Key, std::uint32_t>> written;

 private:
  std::map<Key, std::pair<int, std::uint32_t>> values_;
  Key frozen_{-1, -1};
  Key silent_{-1, -1};
  std::map<Key, std::uint32_t> refused_;
};

}  // namespace inbetween::can
