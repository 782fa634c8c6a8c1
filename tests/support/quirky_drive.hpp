#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "inbetween/can/frame.hpp"

namespace inbetween {

/// A CiA 402 drive of the tests' own, written from the standards: of the product it knows what a frame is,
/// and nothing else. Its dictionary and its habits come from a table in TOML; without an entry it does what
/// the standards ask for. Its motor is ideal.
///
///     absent    = ["6502", "60C2:2"]      # objects that it does not have
///     read_only = ["1006"]                # are there, and can only be read
///     write_only = ["6060"]               # are there, and cannot be read
///     wide      = ["605A"]                # are told with 4 bytes, extended by their sign
///     segmented = ["6064"]                # are told in segments
///     values    = { "1006" = 0 }          # what it has at power-on
///     sizes     = { "2F00" = 300 }        # objects of so many bytes
///     high_bytes = 0                      # of what is wide: other bytes above the value
///     starts_itself = false               # is operational after boot-up
///     boots_after_communication = true    # obeys "reset communication"
///     heartbeat_step_ms = 1               # 1017 is rounded up to a multiple
///     shows_mode = "at once"              # 6061: "at once", "enabled" (0 before), "never" (what mode_shown
///     says) mode_shown = 0 mode_delay_ms = 0                   # from operation enabled until 6061 shows 8
///     brake_ms = 20                       # from 000F until operation enabled
///     sag_counts = 0                      # how far it is from its target once it is enabled
///     has_bit_12 = true
///     bit_11_ms = 0                       # how long bit 11 is set, 200 ms after it was enabled
///     emergency = 0                       # the code that it sends 200 ms after it was enabled
///     warns = false                       # and whether bit 7 tells of it; otherwise nothing does
///     fails = false                       # or it is in fault
///     toggles = true                      # its answers to guarding have another bit 7 each time
///     loses_answer = 0                    # the answer to guarding of this number does not arrive
///     doubles_answer = 0                  # that of this number comes twice
class QuirkyDrive {
 public:
  explicit QuirkyDrive(std::string_view quirks, unsigned node = 5);

  /// Until `now_ns`, which never goes back.
  void advance(std::int64_t now_ns);
  void receive(const can::Frame& frame);
  /// What it has to send since the last call, in order.
  std::vector<can::Frame> take_frames();

  [[nodiscard]] std::uint32_t value(unsigned index, unsigned sub = 0) const;
  /// How often a client has written an object, whether it was taken or not.
  [[nodiscard]] int writes(unsigned index, unsigned sub = 0) const;
  [[nodiscard]] bool is_in_operation() const { return state_ == 0x27; }
  [[nodiscard]] bool has_power() const { return state_ == 0x23 || state_ == 0x27; }
  [[nodiscard]] const std::vector<std::uint8_t>& bytes(unsigned index) const {
    return objects_.at(index << 8);
  }
  [[nodiscard]] std::int32_t actual() const { return actual_; }
  /// Somebody pushes the axis there.
  void push_to(std::int32_t actual) { actual_ = actual; }
  /// The targets that it applied in operation.
  [[nodiscard]] const std::vector<std::int32_t>& applied() const { return applied_; }

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Transfer {
    unsigned key = 0;
    Bytes bytes;
    std::size_t at = 0;
    bool toggle = false;
    bool is_download = false;
  };
  struct Habits {
    std::uint32_t high_bytes = 0;
    bool starts_itself = false;
    bool boots_after_communication = true;
    unsigned heartbeat_step_ms = 1;
    std::string shows_mode = "at once";
    unsigned mode_shown = 0;
    std::int64_t mode_delay_ms = 0;
    std::int64_t brake_ms = 20;
    std::int32_t sag_counts = 0;
    bool has_bit_12 = true;
    std::int64_t bit_11_ms = 0;
    unsigned emergency = 0;
    bool warns = false;
    bool fails = false;
    bool toggles = true;
    int loses_answer = 0;
    int doubles_answer = 0;
  };
  void read_quirks(std::string_view quirks);
  void fill_dictionary();
  void add(unsigned index, unsigned sub, std::size_t size, std::uint32_t value);
  void set(unsigned index, unsigned sub, std::uint32_t value);
  void send(unsigned id, const Bytes& bytes);
  void boot();
  void obey_nmt(unsigned command);
  void answer_guard();
  // SDO
  void serve(const Bytes& request);
  void answer(std::uint8_t command, unsigned key, const Bytes& bytes);
  void abort(unsigned key, std::uint32_t code);
  void upload(unsigned key);
  void download(unsigned key, const Bytes& bytes);
  void send_segment(bool toggle);
  void take_segment(const Bytes& request);
  [[nodiscard]] std::optional<std::uint32_t> refuses(unsigned key, const Bytes& bytes) const;
  // PDO
  void apply(const Bytes& bytes);
  void hear_sync();
  void tell();
  [[nodiscard]] bool is_valid(unsigned communication) const;
  // the drive
  void obey(std::uint32_t controlword);
  void stop_without_host(unsigned code);
  void go_to(std::uint8_t state);
  void show();
  void send_emergency(unsigned code);
  [[nodiscard]] std::int64_t since_enabled_ms() const { return (now_ns_ - enabled_ns_) / 1'000'000; }

  unsigned node_;
  Habits habits_;
  std::map<unsigned, Bytes> objects_;   ///< by index * 256 + sub
  std::map<unsigned, Bytes> power_on_;  ///< what a reset brings back
  std::set<unsigned> read_only_;
  std::set<unsigned> write_only_;
  std::set<unsigned> wide_;
  std::set<unsigned> segmented_;
  std::map<unsigned, int> writes_;
  std::optional<Transfer> transfer_;
  std::vector<can::Frame> frames_;
  std::int64_t now_ns_ = 0;
  std::optional<std::int64_t> boot_ns_ = 10'000'000;
  std::int64_t heartbeat_ns_ = 0;
  std::optional<std::int64_t> host_deadline_ns_;
  std::optional<std::int64_t> setpoint_deadline_ns_;
  std::optional<std::int64_t> guard_deadline_ns_;
  int guard_answers_ = 0;
  std::uint8_t nmt_ = 0;
  std::optional<Bytes> waiting_;  ///< the RPDO that SYNC will apply
  std::uint8_t state_ = 0x40;
  std::uint32_t last_word_ = 0;
  std::optional<std::int64_t> brake_ns_;
  std::int64_t enabled_ns_ = 0;
  bool has_reported_ = false;
  bool warns_now_ = false;
  std::int32_t actual_ = 0;
  std::vector<std::int32_t> applied_;
};

}  // namespace inbetween
