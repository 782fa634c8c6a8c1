// Lines of Dragonframe's DFMoco protocol: two small letters and whole numbers behind them, one space each, CR
// LF at the end. Found in a stream of bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace inbetween::dragonframe {

/// The maker's sketch says "error: too many args" at the 40th.
inline constexpr std::size_t max_dfmoco_numbers = 39;
/// 39 numbers of 11 characters, the spaces, and room for what a person adds.
inline constexpr std::size_t max_dfmoco_line_bytes = 512;

enum class DfmocoCommand : std::uint8_t {
  hi,  ///< who is there
  ms,  ///< what moves
  mm,  ///< move a motor
  mp,  ///< tell its position
  sm,  ///< stop a motor
  sa,  ///< stop all
  jm,  ///< jog
  im,  ///< an inch
  pr,  ///< pulse rate
  zm,  ///< here is 0
  np,  ///< here is a number
  bf,  ///< prepare a blurred frame
  go,  ///< begin it
};

struct DfmocoLine {
  enum class Kind : std::uint8_t {
    command,
    unknown,           ///< no command: nobody answers
    malformed,         ///< a command with something behind it that is no list of numbers of 32 bits
    too_many_numbers,  ///< or a line that is too long
  };
  Kind kind = Kind::unknown;
  DfmocoCommand command{};
  std::vector<std::int32_t> numbers;
};

/// Reads a line without its end.
[[nodiscard]] DfmocoLine read_dfmoco_line(std::string_view text);

/// What was heard and thrown away.
struct DfmocoCounters {
  std::uint64_t lines = 0;    ///< that are commands
  std::uint64_t unknown = 0;  ///< that are none
  std::uint64_t abandoned_bytes = 0;
};

/// Bytes in, whole lines out, in a fixed memory of one line. The sketch takes CR LF alone for an end; here
/// each of the two is one, and empty lines are none.
class DfmocoDecoder {
 public:
  /// Takes bytes from the front of `bytes` until a line is whole. Nothing: all are taken.
  std::optional<DfmocoLine> next(std::span<const std::uint8_t>& bytes);
  [[nodiscard]] bool has_half() const { return size_ > 0 || is_too_long_; }
  /// Forgets the half line.
  void clear();
  [[nodiscard]] const DfmocoCounters& counters() const { return counters_; }

 private:
  std::array<char, max_dfmoco_line_bytes> buffer_{};
  std::size_t size_ = 0;
  bool is_too_long_ = false;
  DfmocoCounters counters_;
};

}  // namespace inbetween::dragonframe
