// The keys of a tape recorder, and what they do to a running move.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/loop/key_hold.hpp"
#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/motions/place_entry.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/plan/turns.hpp"
#include "host_tools/rig/cue_outputs.hpp"

namespace inbetween {

/// What a played move uses beside the rig's axes.
struct TransportLines {
  CueOutputs* cues = nullptr;  ///< the pulses of the move
  StartSignal start = {};      ///< the move is begun and waits for it
  std::optional<PlayedTurns> turns = {};
  std::vector<double> key_frames = {};  ///< on which the keys are met to which somebody may go
  /// From the beginning it does what another playhead did (Playhead::can_follow), instead of playing.
  std::span<const PlayheadPlace> followed = {};
};

/// Plays a move in a loop, once, or take after take. Refers to all of them. Allocates nothing.
///
/// Home goes back along the path to where the move begins, and rests there. With takes the act begins with
/// the rig at rest where the move begins, and waits: Enter there begins a take, nothing else does. It is over
/// whenever a take is to begin, so that the caller makes ready for it and comes back, and when it has ended.
///
/// g and k, a number and Enter go to a frame or a key, along the path and slowly: no axis faster than
/// transit_share of its limits, as far as the move is not drawn slower. So do the arrows, a frame a press and
/// on and on while they are held (KeyHold), and a wheel, a frame a detent; between takes as well. Whatever
/// begins so ends at rest on the path.
///
/// Turns that go round never come to the end of their time line: behind the turn in the middle the playhead
/// is carried back a turn, where the move does the same, and played backward forward again, up to where it
/// began. The frame is exact however long it goes on (Playhead::shift_by).
class Transport final : public LoopTask {
 public:
  enum class Ask : std::uint8_t {
    none,
    begin_take,  ///< somebody has asked for one; take_is_ready() makes the act go on with it
    end_take,    ///< its last frame was played, or somebody went back before it was
  };

  /// With somebody who attends a stop can be acknowledged, and the move goes on.
  Transport(RunLoop& loop, StagedMove& staged, bool is_attended, const TransportLines& lines = {})
      : loop_(loop),
        spec_(staged.loop_spec()),
        playhead_(staged.playhead()),
        move_(staged.plan().played()),
        keys_(loop, is_attended),
        lines_(lines),
        slow_rate_(staged.slow_rate()),
        asked_rate_(playhead_.override_rate()) {}

  /// With a start signal it waits for that, or for the key that starts. Errors: those of MotionLoop::load and
  /// start.
  Status begin() override;
  void press(TransportKey key) override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return is_done() || ask_ != Ask::none || keys_.has_left(); }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  /// It was played to one of its ends; with takes somebody has left, and no take is under way.
  [[nodiscard]] bool is_done() const {
    if (has_takes_) return keys_.has_left() && take_ != Take::playing;
    return is_at_end();
  }

  // With takes: between the acts, and before the first.

  void play_takes() { has_takes_ = true; }
  [[nodiscard]] Ask asks() const { return ask_; }
  /// Every tick of the take goes to the sinks, by the trace of the loop.
  void take_is_ready(LoopTrace& trace, const TickSinks& sinks);
  /// What was asked for is done.
  void take_is_noted();
  /// The take that ended was played to its last frame.
  [[nodiscard]] bool was_whole() const { return was_whole_; }

  [[nodiscard]] RunSnapshot snapshot() const override;
  /// Of the turn that is played, where turns are.
  [[nodiscard]] std::optional<double> frame() const override { return frame_of_turn(); }
  [[nodiscard]] std::optional<PlayedPlace> played() const override { return played_; }
  /// The turn that it is in, or was stopped in; nothing where nothing is repeated.
  [[nodiscard]] std::optional<TurnSnapshot> turn() const;

 private:
  Status start();
  void go_round();
  bool press_always(TransportKey key);
  bool is_on_path();
  bool can_go();
  void go_to(const WantedPlace& place);
  void set_off();
  bool press_arrow(TransportKey key);
  bool can_step();
  void step(Direction direction);
  void look_at_arrow();
  void scrub(Direction direction);
  void go_nowhere();
  void use_rate(double rate) { static_cast<void>(playhead_.set_override(rate)); }
  [[nodiscard]] const char* doing() const;
  [[nodiscard]] const char* keys_that_work() const;
  [[nodiscard]] std::int32_t turn_on_time_line() const;
  /// Of the time line, before the turn that is played.
  [[nodiscard]] std::int32_t frames_before_turn() const;
  [[nodiscard]] double frame_of_turn() const;
  [[nodiscard]] bool goes_round() const { return lines_.turns && lines_.turns->goes_round; }
  void pause_or_play();
  void turn();
  void change_override(int by);
  void go_home();
  void press_start();
  void end_take(bool is_whole);
  void begin_take();
  void note(const LoopTick& tick);
  Status follow();
  void end_following();
  [[nodiscard]] bool plays() const {
    return playhead_.state() == PlayheadState::playing || playhead_.state() == PlayheadState::following;
  }
  [[nodiscard]] std::optional<double> seconds_left(double frame) const;
  [[nodiscard]] bool is_at_end() const {
    return loop_.state() == SupervisorState::ready && !keys_.was_stopped() && !is_waiting_ && !is_back_;
  }
  [[nodiscard]] bool is_at_start() const {
    return playhead_.is_resting() && playhead_.time() == FrameTime{move_.first_frame(), 0};
  }
  [[nodiscard]] bool is_between_takes() const { return has_takes_ && take_ != Take::playing; }

  RunLoop& loop_;
  LoopSpec spec_;
  Playhead& playhead_;
  const Move& move_;
  OperatorKeys keys_;
  TransportLines lines_;
  bool is_waiting_ = false;  ///< for its start
  bool is_heard_ = false;    ///< since it waits
  Direction direction_ = Direction::forward;
  bool is_back_ = false;  ///< it was played backward to its beginning, and rests there
  bool goes_home_ = false;
  std::int64_t turns_gone_ = 0;  ///< by which the playhead was carried back, or that it has repeated
  bool was_carried_ = false;     ///< after the last tick
  std::optional<PlayedPlace> played_ = {};

  PlaceEntry entry_;
  std::optional<FrameTime> goal_ = {};    ///< in the turn, to which it was asked to go
  std::optional<Direction> scrubs_ = {};  ///< to that end of the time line, until somebody lets go
  bool sets_off_ = false;                 ///< for one of them, once it rests
  double slow_rate_;
  double asked_rate_;  ///< the override rate of what is played
  KeyHold arrow_;
  std::int64_t now_ns_ = 0;  ///< of the last tick

  enum class Take : std::uint8_t { none, asked, playing, ended, closed };
  bool has_takes_ = false;
  Take take_ = Take::none;
  Ask ask_ = Ask::none;
  bool was_whole_ = false;
  LoopTrace* trace_ = nullptr;
  TickSinks sinks_{};
};

}  // namespace inbetween
