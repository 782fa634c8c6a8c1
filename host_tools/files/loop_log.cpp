#include "host_tools/files/loop_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

namespace inbetween {
namespace {

constexpr std::size_t bytes_per_write = 1 << 16;
constexpr int patience_ms = 1000;

int opened(const std::string& file, bool goes_on) {
  // A pipe that nobody reads must not hold up the end of the run.
  const int opened =
      file == "-" ? fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0)
                  : open(file.c_str(),
                         O_WRONLY | O_CREAT | (goes_on ? O_APPEND : O_TRUNC) | O_NONBLOCK | O_CLOEXEC, 0666);
  if (opened >= 0) return opened;
  throw std::runtime_error(fmt::format(
      "{}: error: cannot be written: {}; choose a folder that exists and that you may write to, or another "
      "file",
      file, std::strerror(errno)));
}

}  // namespace

PatientFile::PatientFile(const std::string& name, bool goes_on) : file_(opened(name, goes_on)) {}

PatientFile::~PatientFile() {
  close(file_);
}

void PatientFile::end_record() {
  ++in_text_;
  if (text_.size() >= bytes_per_write) flush();
}

void PatientFile::flush() {
  std::size_t sent = 0;
  while (sent < text_.size() && failure_.empty()) {
    const ssize_t part = write(file_, text_.data() + sent, text_.size() - sent);
    if (part >= 0) {
      sent += static_cast<std::size_t>(part);
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) {
      failure_ = std::strerror(errno);
      break;
    }
    pollfd room{.fd = file_, .events = POLLOUT, .revents = 0};
    if (poll(&room, 1, patience_ms) == 0) failure_ = "nobody reads it";
  }
  if (failure_.empty()) written_ += in_text_;
  text_.clear();
  in_text_ = 0;
}

void block_broken_pipe() {
  sigset_t broken_pipe;
  sigemptyset(&broken_pipe);
  sigaddset(&broken_pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);
}

}  // namespace inbetween
