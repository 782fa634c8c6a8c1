#pragma once

#include <csignal>

namespace inbetween {

/// Ctrl-C and a polite kill become a wish, for as long as this lives. One at a time.
class InterruptWatch {
 public:
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  /// Whether SIGINT or SIGTERM has come since.
  [[nodiscard]] static bool asked();

 private:
  using Handler = void (*)(int);
  Handler interrupt_before_;
  Handler terminate_before_;
};

}  // namespace inbetween
