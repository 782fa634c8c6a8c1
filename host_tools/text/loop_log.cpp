#include "host_tools/text/loop_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

constexpr std::size_t bytes_per_write = 1 << 16;
constexpr int patience_ms = 1000;

int opened(const std::string& file, bool goes_on) {
  if (file == "-") return fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
  const int anew = is_special(file) ? 0 : O_CREAT | O_EXCL;
  // A pipe that nobody reads must not hold up the end of the run.
  const int opened =
      open(file.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC | (goes_on ? O_CREAT | O_APPEND : anew), 0666);
  if (opened >= 0) return opened;
  if (errno == EEXIST) {
    throw std::runtime_error(fmt::format(
        "{}: error: it is there already, and is not written over; name another file, or move it away", file));
  }
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

/// A disk that fills up takes the first `sent` bytes of the text. The line that this cuts is removed.
void PatientFile::keep_whole_lines(std::size_t sent) {
  const std::string_view taken = std::string_view(text_).substr(0, sent);
  const std::size_t whole = taken.rfind('\n') + 1;  // 0 where there is none
  const off_t end = lseek(file_, 0, SEEK_CUR);
  // Only a file on a disk can be cut, and elsewhere half a line is read by somebody already.
  if (end >= 0) static_cast<void>(!ftruncate(file_, end - static_cast<off_t>(sent - whole)));
  const std::int64_t heads = std::ranges::count(text_, '\n') - in_text_;
  written_ += std::max<std::int64_t>(0, std::ranges::count(taken, '\n') - heads);
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
  if (failure_.empty()) {
    written_ += in_text_;
  } else if (!text_.empty()) {
    keep_whole_lines(sent);
  }
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
