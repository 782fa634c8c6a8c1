#include "host_tools/cue_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "host_tools/csv_field.hpp"

namespace inbetween {
namespace {

constexpr std::size_t bytes_per_write = 1 << 16;
constexpr int patience_ms = 1000;
constexpr std::chrono::milliseconds between_looks{5};

int opened(const std::string& file) {
  // A pipe that nobody reads must not hold up the end of the run.
  const int opened = file == "-"
                         ? fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0)
                         : open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NONBLOCK | O_CLOEXEC, 0666);
  if (opened >= 0) return opened;
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", file, std::strerror(errno)));
}

}  // namespace

CueLog::CueLog(const std::string& file, const std::vector<CuePulse>& pulses, bool waits)
    : pulses_(pulses), waits_(waits), file_(opened(file)), text_("seconds,line,frame,width_ms,merged\n") {
  thread_ = std::thread([this] { live(); });
}

CueLog::~CueLog() {
  finish();
  close(file_);
}

void CueLog::take(const BegunPulse& begun) {
  ++taken_;
  while (!ring_->push(begun) && waits_) std::this_thread::sleep_for(between_looks);
}

CueLogEnd CueLog::finish() {
  leaves_.store(true);
  if (thread_.joinable()) thread_.join();
  end_.lost = taken_ - end_.written;
  if (end_.lost > 0 && end_.why.empty()) end_.why = "it was written more slowly than pulses came";
  return end_;
}

void CueLog::live() {
  // A reader that has gone is a failed write.
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);
  for (;;) {
    const bool leaves = leaves_.load();
    while (const std::optional<BegunPulse> begun = ring_->pop()) put(*begun);
    if (leaves) break;
    std::this_thread::sleep_for(between_looks);
  }
  flush();
}

void CueLog::put(const BegunPulse& begun) {
  if (!end_.why.empty()) return;
  const CuePulse& pulse = pulses_[begun.pulse];
  constexpr std::int64_t ns_per_s = 1'000'000'000;
  fmt::format_to(std::back_inserter(text_), "{}.{:09},{},{},{},{}\n", begun.at_ns / ns_per_s,
                 begun.at_ns % ns_per_s, csv_field(std::string(pulse.line)), pulse.frame + pulse.phase,
                 static_cast<double>(pulse.width_ns) * 1e-6, begun.is_merged ? 1 : 0);
  ++in_text_;
  if (text_.size() >= bytes_per_write) flush();
}

void CueLog::flush() {
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
