#include "host_tools/run_record.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "host_tools/csv_field.hpp"

namespace inbetween {
namespace {

constexpr std::size_t bytes_per_write = 1 << 16;
constexpr int patience_ms = 1000;
constexpr std::chrono::milliseconds between_looks{5};

int opened(const std::string& file) {
  // A pipe that nobody reads must not hold up the end of the run.
  const int opened = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NONBLOCK | O_CLOEXEC, 0666);
  if (opened >= 0) return opened;
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", file, std::strerror(errno)));
}

}  // namespace

RunRecord::RunRecord(const std::string& file, const RigFile& rig, bool waits)
    : axes_(rig.axes.size()), period_s_(1.0 / rig.rate_hz), waits_(waits), file_(opened(file)) {
  write_head(rig);
  thread_ = std::thread([this] { live(); });
}

RunRecord::~RunRecord() {
  finish();
  close(file_);
}

void RunRecord::take(const RunLoop& loop) {
  Tick tick;
  tick.number = number_++;
  tick.state = loop.state();
  tick.is_told = loop.sends_setpoints();
  for (std::size_t i = 0; i < axes_; ++i) {
    tick.told[i] = loop.setpoints()[i].position;
    tick.actual[i] = loop.drive_states()[i].actual;
  }
  while (!ring_->push(tick) && waits_) std::this_thread::sleep_for(between_looks);
}

RunRecordEnd RunRecord::finish() {
  leaves_.store(true);
  if (thread_.joinable()) thread_.join();
  end_.lost = number_ - end_.written;
  if (end_.lost > 0 && end_.why.empty()) end_.why = "it was written more slowly than the rig moved";
  return end_;
}

void RunRecord::write_head(const RigFile& rig) {
  text_ = "tick,seconds,state";
  for (const RigAxis& axis : rig.axes) {
    text_ += "," + csv_field(axis.name) + "," + csv_field(axis.name + " actual");
  }
  text_ += '\n';
}

void RunRecord::live() {
  // A reader that has gone is a failed write.
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);
  for (;;) {
    const bool leaves = leaves_.load();
    while (const std::optional<Tick> tick = ring_->pop()) put(*tick);
    if (leaves) break;
    std::this_thread::sleep_for(between_looks);
  }
  flush();
}

void RunRecord::put(const Tick& tick) {
  if (!end_.why.empty()) return;
  auto out = std::back_inserter(text_);
  fmt::format_to(out, "{},{:.6f},{}", tick.number, static_cast<double>(tick.number) * period_s_,
                 name_of(tick.state));
  for (std::size_t i = 0; i < axes_; ++i) {
    if (tick.is_told) {
      fmt::format_to(out, ",{},{}", tick.told[i], tick.actual[i]);
    } else {
      fmt::format_to(out, ",,{}", tick.actual[i]);
    }
  }
  text_ += '\n';
  ++in_text_;
  if (text_.size() >= bytes_per_write) flush();
}

void RunRecord::flush() {
  std::size_t sent = 0;
  while (sent < text_.size() && end_.why.empty()) {
    const ssize_t part = write(file_, text_.data() + sent, text_.size() - sent);
    if (part >= 0) {
      sent += static_cast<std::size_t>(part);
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) {
      end_.why = std::strerror(errno);
      break;
    }
    pollfd room{.fd = file_, .events = POLLOUT, .revents = 0};
    if (poll(&room, 1, patience_ms) == 0) end_.why = "nobody reads it";
  }
  if (end_.why.empty()) end_.written += in_text_;
  text_.clear();
  in_text_ = 0;
}

}  // namespace inbetween
