// A log file of a real-time loop. It never holds up the loop.
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

/// The counts of a log file at its end.
struct LoopLogEnd {
  std::int64_t written = 0;  ///< records
  std::int64_t lost = 0;     ///< records that the file does not have
  std::string why = {};      ///< "" where none is
};

/// How a log is written.
struct LogWriting {
  bool goes_on = false;  ///< at the end of a file that is there, instead of in one that is not
  bool at_once = false;  ///< record by record, for a log of few
};

/// Writes text to a file, a record a line. It stops writing at the first failure, at the end of a line; a
/// pipe that nobody reads for 1 s is a failure too. One thread uses it.
class PatientFile {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, if the file
  /// cannot be opened, or is there already and it does not go on with it. Pipes and devices may be there.
  explicit PatientFile(const std::string& name, bool goes_on = false);
  ~PatientFile();
  PatientFile(const PatientFile&) = delete;
  PatientFile& operator=(const PatientFile&) = delete;

  /// The caller appends the next record to this text. The text is written from time to time.
  [[nodiscard]] std::string& text() { return text_; }
  /// Tells that the text of a record is complete.
  void end_record();
  void flush();

  /// Records that the file has whole.
  [[nodiscard]] std::int64_t written() const { return written_; }
  /// The first failure; "" without one.
  [[nodiscard]] const std::string& failure() const { return failure_; }

 private:
  void keep_whole_lines(std::size_t sent);

  int file_;
  std::string text_;
  std::int64_t in_text_ = 0;
  std::int64_t written_ = 0;
  std::string failure_;
};

/// Makes a pipe without a reader a failed write in this thread, instead of a signal.
void block_broken_pipe();

/// The loop puts records into a ring, and a thread of the log writes them. Records without room in the ring
/// or on the disk are counted.
template <class Record, std::size_t capacity>
class LoopLog {
 public:
  /// `head` is the first line. The thread of the log calls `put`, which appends the line of a record to a
  /// text; what `put` refers to must live until finish(). With `waits` the loop has time, and waits for room
  /// instead of losing a record. Throws what PatientFile throws.
  LoopLog(const std::string& file, const std::string& head, bool waits,
          std::function<void(const Record&, std::string&)> put, const LogWriting& writing = {})
      : waits_(waits), at_once_(writing.at_once), file_(file, writing.goes_on), put_(std::move(put)) {
    file_.text() = head;
    thread_ = std::thread([this] { live(); });
  }
  ~LoopLog() { finish(""); }
  LoopLog(const LoopLog&) = delete;
  LoopLog& operator=(const LoopLog&) = delete;

  /// The loop's thread calls this. It allocates nothing and makes no system call unless it waits.
  void take(const Record& record) {
    ++taken_;
    while (!ring_->push(record) && waits_) std::this_thread::sleep_for(between_looks);
  }
  /// Writes the records that are left. `too_slow` is the reason if records were lost although the file did
  /// not fail.
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
        if (at_once_) file_.flush();
      }
      if (leaves) break;
      std::this_thread::sleep_for(between_looks);
    }
    file_.flush();
  }

  bool waits_;
  bool at_once_;
  std::unique_ptr<Ring> ring_ = std::make_unique<Ring>();
  std::int64_t taken_ = 0;  // of the loop's thread
  // of the writing thread
  PatientFile file_;
  std::function<void(const Record&, std::string&)> put_;
  std::atomic<bool> leaves_{false};
  std::thread thread_;
};

}  // namespace inbetween
