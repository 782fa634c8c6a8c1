// A file that is told by a real-time loop, and never holds it up.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "drivers/linux/telemetry_ring.hpp"

namespace inbetween {

/// What became of such a file.
struct LoopLogEnd {
  std::int64_t written = 0;  ///< records
  std::int64_t lost = 0;     ///< records that are not in the file
  std::string why = {};      ///< "" where none is
};

/// Text for a file, record by record. After the first failure nothing is written any more, and a pipe that
/// nobody reads for a second is one. Of one thread.
class PatientFile {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, where the file
  /// cannot be opened.
  explicit PatientFile(const std::string& name);
  ~PatientFile();
  PatientFile(const PatientFile&) = delete;
  PatientFile& operator=(const PatientFile&) = delete;

  /// For the text of the next record; what is in it is written from time to time.
  [[nodiscard]] std::string& text() { return text_; }
  /// The text of a record is complete.
  void end_record();
  void flush();

  [[nodiscard]] std::int64_t written() const { return written_; }
  /// "" where nothing failed.
  [[nodiscard]] const std::string& failure() const { return failure_; }

 private:
  int file_;
  std::string text_;
  std::int64_t in_text_ = 0;
  std::int64_t written_ = 0;
  std::string failure_;
};

/// In this thread a reader that has gone is a failed write.
void block_broken_pipe();

/// The loop puts records into a ring, a thread of its own writes them. What finds no room, or no disk, is
/// counted.
template <class Record, std::size_t capacity>
class LoopLog {
 public:
  /// `head` is the first line. `put` appends the line of a record to a text, in the thread of the log; it
  /// outlives what it refers to no longer than finish(). `waits`: the loop has time, and waits for room
  /// instead. Throws what PatientFile does.
  LoopLog(const std::string& file, const std::string& head, bool waits,
          std::function<void(const Record&, std::string&)> put)
      : waits_(waits), file_(file), put_(std::move(put)) {
    file_.text() = head;
    thread_ = std::thread([this] { live(); });
  }
  ~LoopLog() { finish(""); }
  LoopLog(const LoopLog&) = delete;
  LoopLog& operator=(const LoopLog&) = delete;

  /// Of the loop's thread. No allocation, no system call unless it waits.
  void take(const Record& record) {
    ++taken_;
    while (!ring_->push(record) && waits_) std::this_thread::sleep_for(between_looks);
  }
  /// Writes what is left. `too_slow` is why, where records were lost and the file is not to blame.
  LoopLogEnd finish(const std::string& too_slow) {
    leaves_.store(true);
    if (thread_.joinable()) thread_.join();
    LoopLogEnd end{.written = file_.written(), .lost = taken_ - file_.written(), .why = file_.failure()};
    if (end.lost > 0 && end.why.empty()) end.why = too_slow;
    return end;
  }

 private:
  static constexpr std::chrono::milliseconds between_looks{5};
  using Ring = TelemetryRing<Record, capacity>;

  void live() {
    block_broken_pipe();
    for (;;) {
      const bool leaves = leaves_.load();
      while (const std::optional<Record> record = ring_->pop()) {
        if (!file_.failure().empty()) continue;
        put_(*record, file_.text());
        file_.end_record();
      }
      if (leaves) break;
      std::this_thread::sleep_for(between_looks);
    }
    file_.flush();
  }

  bool waits_;
  std::unique_ptr<Ring> ring_ = std::make_unique<Ring>();
  std::int64_t taken_ = 0;  // of the loop's thread
  // of the writing thread
  PatientFile file_;
  std::function<void(const Record&, std::string&)> put_;
  std::atomic<bool> leaves_{false};
  std::thread thread_;
};

}  // namespace inbetween
