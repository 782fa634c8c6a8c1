// A connection that ends in time, however slowly its client sends.
#pragma once

#include <httplib.h>

#include <chrono>

namespace inbetween {

/// httplib waits for each byte anew, so that a client that sends one a second would hold a thread for days.
/// Here a request must have come after `max_seconds`, and its answer have gone so long after it was begun;
/// a client that is silent for `max_silence` is left before.
class TimedStream : public httplib::Stream {
 public:
  using Clock = std::chrono::steady_clock;
  struct Patience {
    std::chrono::milliseconds max_silence, max_seconds;
  };

  TimedStream(socket_t socket, const Patience& patience)
      : socket_(socket), patience_(patience), read_until_(Clock::now() + patience.max_seconds) {}

  [[nodiscard]] bool is_readable() const override;
  [[nodiscard]] bool is_writable() const override;
  ssize_t read(char* bytes, std::size_t size) override;
  ssize_t write(const char* bytes, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  [[nodiscard]] bool waits_for(short event, Clock::time_point until) const;

  socket_t socket_;
  Patience patience_;
  Clock::time_point read_until_;
  mutable Clock::time_point write_until_{};  ///< from the first byte of the answer on
};

}  // namespace inbetween
