// Whether a key of a terminal is pressed once or held.
#pragma once

#include <cstdint>
#include <optional>

namespace inbetween {

/// A press counts if no other came so long before it, and none so long after it; and a key that is held is
/// let go when it is not repeated for so long.
inline constexpr double key_silence_s = 0.15;
/// Repeats of a keyboard are so far apart: nobody types faster for long, and slower ones cannot be told from
/// somebody who types.
inline constexpr double min_key_repeat_s = 0.01;
inline constexpr double max_key_repeat_s = 0.12;

/// What an operator is told of keys that are refused (KeyHold::is_refused).
inline constexpr const char* refused_keys_in_words =
    "two keys at once, or late ones: let go, and press again";

/// Most terminals send a key that is held again and again, 11 to 30 times a second after a delay, and do not
/// tell when it is let go: there it counts as held once two repeats came at the rate of a keyboard, and as
/// let go key_silence_s after the last one. Terminals with kitty's keyboard protocol (its progressive
/// enhancement 2, https://sw.kovidgoyal.net/kitty/keyboard-protocol) tell presses, repeats and releases
/// apart: there a press counts at once, and a release ends it at once. The silence ends it there as well: a
/// release that the connection has lost, or that another window got, leaves nothing held.
///
/// Keys that come faster than any keyboard repeats them have waited somewhere, in a terminal that hung or on
/// a line that was interrupted, and whoever pressed them may have let go long ago. They move nothing, until
/// no key has come for key_silence_s, or with releases until the next press. The same is true of two
/// directions at once. Times are monotonic; of the caller. O(1), no memory.
class KeyHold {
 public:
  /// The terminal tells presses, repeats and releases apart.
  void tells_releases() { tells_releases_ = true; }
  /// A key of direction -1 or 1 came: it was pressed, or repeated where the terminal does not tell.
  void press(int direction, std::int64_t now_ns);
  /// The terminal told that it was repeated, or let go.
  void repeat(int direction, std::int64_t now_ns);
  void release();
  /// A device tells that a key is held, and that it still is: a press that counts as held at once.
  void hold(int direction, std::int64_t now_ns);
  void hear(std::int64_t now_ns);
  /// Something else was pressed: what came until now counts no more.
  void forget();

  /// The direction of a press that counts from now on, once; 0 for none.
  int take_press(std::int64_t now_ns);
  /// When that key came.
  [[nodiscard]] std::int64_t pressed_ns() const { return pressed_ns_; }
  /// The direction of a key that is held; 0 for none.
  int held(std::int64_t now_ns);
  /// A key that comes moves nothing until there was silence, or a press.
  [[nodiscard]] bool is_refused() const { return is_refused_; }

 private:
  void begin(int direction, std::int64_t now_ns);
  void count(int direction, std::int64_t now_ns);
  void refuse();
  [[nodiscard]] bool is_silent(std::int64_t now_ns) const;

  bool tells_releases_ = false;
  int direction_ = 0;                         ///< of the keys that follow each other
  std::optional<std::int64_t> last_ns_ = {};  ///< when the last of them came
  std::int64_t first_ns_ = 0;
  int keys_ = 0;     ///< since then
  int repeats_ = 0;  ///< of them, at the rate of a keyboard
  int press_ = 0;    ///< a press that is not taken yet
  std::int64_t pressed_ns_ = 0;
  bool is_refused_ = false;
};

}  // namespace inbetween
