// Keeps a take while it is played, beside the loop.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/linux/telemetry_ring.hpp"
#include "host_tools/loop/tick_sink.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/takes/take.hpp"
#include "host_tools/takes/take_store.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/tick_codec.hpp"

namespace inbetween {

/// Where takes are kept, and how.
struct TakeKeeping {
  std::string file;
  /// The oldest are forgotten where all of them take more. A take that alone, or with those that are marked,
  /// would take more ends there.
  std::optional<std::int64_t> max_bytes = {};
  bool waits = false;  ///< the loop has time, and waits for room in the ring instead of losing a tick
  /// What a pulse is called. The writing thread asks.
  std::function<std::string(std::size_t pulse)> pulse_words = {};
};

/// What became of a take.
struct KeptTake {
  std::int64_t number = 0;  ///< 0: nothing was played, and nothing is kept
  std::string file;
  std::int64_t ticks = 0;
  std::int64_t lost = 0;
  std::string why = {};  ///< one line; "" where none is lost
  std::int64_t bytes = 0;
  std::vector<std::int64_t> forgotten = {};  ///< to make room
};

/// How an axis of a rig is kept. `move_axis`: TakeAxis.
TakeAxis take_axis_of(const RigAxis& axis, std::optional<std::size_t> move_axis);

/// The loop puts ticks and keys into rings, and a thread of the recorder makes chunks of them, about one a
/// second, and writes them. A disk that is full, slow or gone never holds the loop up: the take ends there,
/// and what it has not is counted.
class TakeRecorder final : public TickSink {
 public:
  /// `take` has all but its number, ticks, events and ending. Throws TakeStoreError where it cannot be begun.
  TakeRecorder(const TakeKeeping& keeping, const Take& take);
  /// Finishes a take that an error has left.
  ~TakeRecorder() override;
  TakeRecorder(const TakeRecorder&) = delete;
  TakeRecorder& operator=(const TakeRecorder&) = delete;

  void take(const RunLoop& loop, const LoopTask* act) override;
  void press(TransportKey key) override;
  /// The loop's thread calls it: a pulse begins in the tick that comes, or that has just been.
  void pulse(std::size_t number);

  // Once no tick follows, or goes elsewhere.

  /// That was played.
  [[nodiscard]] bool has_played() const { return has_played_; }
  /// Writes what is left, durably: what is returned as kept survives a power cut. What was never played is
  /// forgotten. `fault`: what went wrong, in words, or "".
  KeptTake finish(const std::string& ending, bool is_whole, const std::string& fault = "");

 private:
  struct Tick {
    std::int64_t number = 0;
    SupervisorState state = SupervisorState::disarmed;
    bool is_told = false;
    bool is_played = false;
    bool shows_frame = false;
    PlayedPlace played;
    std::array<double, max_rig_axes> told;
    std::array<double, max_rig_axes> actual;
  };
  /// A key that was pressed, or a pulse that began.
  struct Happened {
    std::int64_t tick = 0;
    TakeEvent::Kind kind = TakeEvent::Kind::key;
    std::size_t number = 0;
  };
  static constexpr std::size_t ring_ticks = 4096;  ///< a slow disk may take 4 s at 1 kHz
  using Ring = TelemetryRing<Tick, ring_ticks>;
  using EventRing = TelemetryRing<Happened, ring_ticks>;

  void live();
  void take_events();
  void encode(const Tick& tick);
  void write_chunk();
  void make_room();

  TakeKeeping keeping_;
  std::size_t axes_;
  std::unique_ptr<Ring> ring_ = std::make_unique<Ring>();
  std::unique_ptr<EventRing> happened_ = std::make_unique<EventRing>();
  std::int64_t number_ = 0;  // of the loop's thread, as the next
  bool has_played_ = false;
  // of the writing thread, until it is gone
  TakeStore store_;
  std::unique_ptr<TakenMotion> motion_;
  std::optional<TickEncoder> encoder_;
  std::int64_t ticks_of_chunk_;
  TakeTick tick_;
  SupervisorState state_ = SupervisorState::disarmed;
  std::int64_t fault_tick_ = 0;  // in which a stop or a cut began
  std::vector<TakeEvent> events_;
  std::int64_t written_ = 0;
  std::string why_;
  KeptTake kept_;
  std::atomic<bool> leaves_{false};
  std::thread thread_;
};

}  // namespace inbetween
