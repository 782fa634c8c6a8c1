#include "host_tools/takes/take_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

constexpr std::chrono::milliseconds between_looks_for_ticks{5};
/// Where a drive has no whole counts an axis is kept in so much finer ones than its positions are apart.
constexpr double finer = 1.0 / 64;

/// Of an old take that goes, about 30 ms for 16 axes: between two chunks the ring must not fill.
constexpr std::int64_t chunks_at_once = 64;

/// Nothing has gone wrong, and nobody has stopped it.
bool is_orderly(SupervisorState state) {
  return state == SupervisorState::disarmed || state == SupervisorState::enabling ||
         state == SupervisorState::ready || state == SupervisorState::running;
}

}  // namespace

TakeAxis take_axis_of(const RigAxis& axis, std::optional<std::size_t> move_axis) {
  // Behind a calibration the axis goes as far in a count of its motor as that says.
  const bool has_counts = !turns_per_unit_of(axis.drive) && !axis.calibration;
  return {.name = axis.name,
          .unit = std::string(to_string(axis.unit)),
          .resolution = count_of(axis.drive) * (has_counts ? 1 : finer),
          .move_axis = move_axis};
}

TakeRecorder::TakeRecorder(const TakeKeeping& keeping, const Take& take)
    : keeping_(keeping),
      axes_(take.axes.size()),
      store_(keeping.file, TakeStore::Access::write),
      motion_(TakenMotion::read(take.trajectory)),
      ticks_of_chunk_(std::max(take.rate_hz, 1)) {
  if (!motion_) throw std::logic_error("what is played is not what was made of it");
  encoder_.emplace(TickShape{.axes = take.axes,
                             .motion = &motion_->motion(),
                             .frame_rate = take.frame_rate,
                             .rate_hz = take.rate_hz});
  kept_.file = keeping.file;
  kept_.number = store_.begin(take);
  thread_ = std::thread([this] { live(); });
}

TakeRecorder::~TakeRecorder() {
  if (thread_.joinable()) static_cast<void>(finish("an error ended the run", false));
}

void TakeRecorder::take(const RunLoop& loop, const LoopTask* act) {
  Tick tick;
  tick.number = number_++;
  tick.state = loop.state();
  tick.is_told = loop.sends_setpoints();
  if (act != nullptr) {
    tick.shows_frame = act->frame().has_value();
    if (const std::optional<PlayedPlace> played = act->played()) {
      tick.is_played = true;
      tick.played = *played;
      has_played_ = true;
    }
  }
  for (std::size_t a = 0; a < axes_; ++a) {
    tick.told[a] = loop.setpoints()[a].position;
    tick.actual[a] = loop.drive_states()[a].actual;
  }
  while (!ring_->push(tick) && keeping_.waits) std::this_thread::sleep_for(between_looks_for_ticks);
}

void TakeRecorder::press(TransportKey key) {
  happened_->push({number_, TakeEvent::Kind::key, static_cast<std::size_t>(key)});
}

void TakeRecorder::pulse(std::size_t number) {
  happened_->push({number_, TakeEvent::Kind::pulse, number});
}

// --- the writing thread

void TakeRecorder::live() {
  for (;;) {
    const bool leaves = leaves_.load();
    while (const std::optional<Tick> tick = ring_->pop()) {
      if (why_.empty()) encode(*tick);
    }
    take_events();
    if (leaves) break;
    std::this_thread::sleep_for(between_looks_for_ticks);
  }
}

void TakeRecorder::take_events() {
  while (const std::optional<Happened> event = happened_->pop()) {
    const std::string words = event->kind == TakeEvent::Kind::key
                                  ? name_of(static_cast<TransportKey>(event->number))
                                  : keeping_.pulse_words(event->number);
    if (!words.empty()) events_.push_back({event->tick, event->kind, words});
  }
}

void TakeRecorder::encode(const Tick& tick) {
  if (tick.number == 0 || tick.state != state_) {
    events_.push_back({tick.number, TakeEvent::Kind::state, name_of(tick.state)});
    if (is_orderly(state_) && !is_orderly(tick.state)) fault_tick_ = tick.number;
    state_ = tick.state;
  }
  tick_.number = tick.number;
  tick_.state = tick.state;
  tick_.shows_frame = tick.shows_frame;
  tick_.time.reset();
  tick_.rate = tick_.rate_change = 0;
  if (tick.is_played) {
    tick_.time = tick.played.at.time;
    tick_.rate = tick.played.at.rate;
    tick_.rate_change = tick.played.at.rate_change;
    tick_.turn = tick.played.turn;
  }
  const auto axes = static_cast<std::ptrdiff_t>(axes_);
  tick_.told.assign(tick.told.begin(), tick.told.begin() + (tick.is_told ? axes : 0));
  tick_.actual.assign(tick.actual.begin(), tick.actual.begin() + axes);
  encoder_->add(tick_);
  if (encoder_->ticks() >= ticks_of_chunk_) write_chunk();
}

void TakeRecorder::write_chunk() {
  const std::int64_t first = encoder_->first(), ticks = encoder_->ticks();
  const TakeChunk chunk{.first = first, .ticks = ticks, .bytes = encoder_->take_chunk()};
  const std::int64_t lost = std::max<std::int64_t>(0, chunk.first - written_);
  try {
    store_.append(kept_.number, chunk, events_, lost);
    written_ += chunk.ticks;
    events_.clear();
    make_room();
  } catch (const TakeStoreError& error) {
    why_ = error.message();
  }
}

/// A take that is too large ends, rather than that it is larger than was allowed.
void TakeRecorder::make_room() {
  if (!keeping_.max_bytes) return;
  TakeStore::Pruned pruned;
  do {
    pruned = store_.prune_some(*keeping_.max_bytes, chunks_at_once, kept_.number);
    if (pruned.gone) kept_.forgotten.push_back(*pruned.gone);
  } while (!pruned.is_done && store_.used_bytes() > *keeping_.max_bytes);
  if (store_.used_bytes() <= *keeping_.max_bytes) return;
  why_ = fmt::format("with it, and those that are marked, the takes are larger than --keep allows ({})",
                     size_in_words(*keeping_.max_bytes));
}

// --- after it

KeptTake TakeRecorder::finish(const std::string& ending, bool is_whole, const std::string& fault) {
  leaves_.store(true);
  if (thread_.joinable()) thread_.join();
  try {
    if (!has_played_) {
      store_.forget(kept_.number);
      kept_.number = 0;
      return kept_;
    }
    if (const std::uint64_t lost = happened_->dropped(); lost > 0) {
      events_.push_back(
          {number_ - 1, TakeEvent::Kind::fault,
           fmt::format("{} found no room in the take", counted(static_cast<std::int64_t>(lost), "event"))});
    }
    if (!fault.empty()) events_.push_back({fault_tick_, TakeEvent::Kind::fault, fault});
    if (why_.empty()) write_chunk();
    // Also of a take that ended before: there may be room for its ending again.
    store_.finish(kept_.number, ending, is_whole, number_ - written_);
    if (keeping_.max_bytes) {
      for (const std::int64_t gone : store_.prune(*keeping_.max_bytes, kept_.number))
        kept_.forgotten.push_back(gone);
    }
  } catch (const TakeStoreError& error) {
    if (why_.empty()) why_ = error.message();
  }
  kept_.ticks = written_;
  kept_.lost = number_ - written_;
  kept_.why = why_;
  if (kept_.lost > 0 && kept_.why.empty()) kept_.why = "it was written more slowly than the rig moved";
  try {
    for (const TakeInfo& info : store_.list()) {
      if (info.number == kept_.number) kept_.bytes = info.bytes;
    }
  } catch (const TakeStoreError&) {
    kept_.bytes = 0;  // a number for people, of a disk that is gone
  }
  return kept_;
}

}  // namespace inbetween
