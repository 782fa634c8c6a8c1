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

/// From the bytes that a terminal sends, also by kitty's keyboard protocol, which tells of right, left, + and
/// - when they are repeated and let go (KeyReleases asks for it). Other keys are ignored. An Esc that begins
/// no arrow key is a stop: what follows it in the same read decides (a terminal sends an arrow key in one
/// piece).
class TransportKeys {
 public:
  /// Takes the text of one read.
  void feed(std::string_view bytes);
  [[nodiscard]] std::optional<TransportKey> next();

 private:
  std::deque<TransportKey> keys_;
};

}  // namespace inbetween
