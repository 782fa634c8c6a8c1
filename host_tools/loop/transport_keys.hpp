// The keys of a tape recorder on a terminal.
#pragma once

#include <deque>
#include <optional>
#include <string_view>

namespace inbetween {

enum class TransportKey {
  pause,          ///< space: rest on the path, or go on
  step_forward,   ///< right arrow: to the next frame
  step_backward,  ///< left arrow
  previous_axis,  ///< up arrow: where axes are moved one by one
  next_axis,      ///< down arrow
  home,           ///< Home: back along the path to where the move begins
  reverse,        ///< r: the other way
  faster,         ///< +: the override rate up
  slower,         ///< -
  stop,           ///< Esc: the controlled stop, which has to be acknowledged
  acknowledge,    ///< a
  start,          ///< Enter: after an acknowledged stop; a new key at the end of a move that is taught
  expose,         ///< e: the frame that the rig stands on, once more
  size_1,         ///< 1 to 5: the size of a step
  size_2,
  size_3,
  size_4,
  size_5,
  digit_0,  ///< of a number that is typed; 1 to 5 are the sizes of a step
  digit_6,
  digit_7,
  digit_8,
  digit_9,
  erase,           ///< Backspace: the last digit
  go_to_frame,     ///< g: the frame whose number follows, then Enter
  go_to_key,       ///< k: the key
  quit,            ///< q: stop, and leave
  hold_forward,    ///< of a device that tells when it is let go: pressed
  hold_backward,   ///< the same
  still_held,      ///< told again and again meanwhile
  let_go,          ///< of such a device, and of a terminal that tells it
  repeat_forward,  ///< of a terminal that tells releases: held
  repeat_backward,
  tells_releases,  ///< the terminal does, from now on
  device_gone,     ///< unplugged
  detent_forward,  ///< of a wheel
  detent_backward,
  teach_next,      ///< n: the next key of the move that is taught
  teach_previous,  ///< p
  teach_insert,    ///< i: a new key before the chosen one
  teach_replace,   ///< t: in the place of the chosen one
  teach_undo,      ///< u
  refused,         ///< what would begin something, after the rig file was changed
};

/// 1 for an arrow or a detent that goes forward, however it is told, -1 for backward, 0 for any other key.
int direction_of(TransportKey key);
/// "space", "Esc": how a person calls it; "" for what a terminal tells without a key.
const char* name_of(TransportKey key);

/// From the bytes that a terminal sends, also by kitty's keyboard protocol, which tells of right, left, + and
/// - when they are repeated and let go, and xterm's reports of a wheel (RunScreen asks for both). Other keys
/// are ignored. An Esc that begins no arrow key is a stop: what follows it in the same read decides (a
/// terminal sends an arrow key in one piece).
class TransportKeys {
 public:
  /// Takes the text of one read.
  void feed(std::string_view bytes);
  [[nodiscard]] std::optional<TransportKey> next();
  /// The terminal has told that it tells when a key is let go: what begins to listen later must be told, too.
  [[nodiscard]] bool tells_releases() const { return tells_releases_; }

 private:
  std::deque<TransportKey> keys_;
  bool tells_releases_ = false;
};

}  // namespace inbetween
