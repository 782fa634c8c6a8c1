// The keys of a tape recorder, and what they do to a running move.
#pragma once

#include <cstdint>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/rig/cue_outputs.hpp"

namespace inbetween {

/// The lines of the rig that a played move uses.
struct TransportLines {
  CueOutputs* cues = nullptr;  ///< the pulses of the move
  StartSignal start = {};      ///< the move is begun and waits for it
};

/// Plays a move in a loop. Refers to all of them. Allocates nothing.
class Transport final : public LoopTask {
 public:
  /// With somebody who attends a stop can be acknowledged, and the move goes on.
  Transport(RunLoop& loop, StagedMove& staged, bool is_attended, const TransportLines& lines = {})
      : loop_(loop),
        spec_(staged.loop_spec()),
        playhead_(staged.playhead()),
        move_(staged.plan().played()),
        keys_(loop, is_attended),
        lines_(lines) {}

  /// With a start signal it waits for that, or for the key that starts. Errors: those of MotionLoop::load and
  /// start.
  Status begin() override;
  void press(TransportKey key) override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return is_done() || keys_.has_left(); }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  /// It was played to one of its ends.
  [[nodiscard]] bool is_done() const {
    return loop_.state() == SupervisorState::ready && !keys_.was_stopped() && !is_waiting_;
  }
  [[nodiscard]] RunSnapshot snapshot() const override;

 private:
  Status start();
  void pause_or_play();
  void turn();
  void step(Direction direction);
  void change_override(double by);

  RunLoop& loop_;
  LoopSpec<double> spec_;
  Playhead<double>& playhead_;
  const Move<double>& move_;
  OperatorKeys keys_;
  TransportLines lines_;
  bool is_waiting_ = false;  ///< for its start
  bool is_heard_ = false;    ///< since it waits
  Direction direction_ = Direction::forward;
};

}  // namespace inbetween
