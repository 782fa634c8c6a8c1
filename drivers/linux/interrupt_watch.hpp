#pragma once

#include <array>
#include <csignal>
#include <cstddef>

namespace inbetween {

/// Ctrl-C, a polite kill and a lost terminal become a request, for as long as this lives. One at a time.
class InterruptWatch {
 public:
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  /// Whether SIGINT, SIGTERM or SIGHUP has come since.
  [[nodiscard]] static bool asked();

 private:
  using Handler = void (*)(int);
  static constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};
  std::array<Handler, signals.size()> before_{};
};

}  // namespace inbetween
