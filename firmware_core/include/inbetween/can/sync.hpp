#pragma once

#include <cstdint>

#include "inbetween/base/result.hpp"
#include "inbetween/can/frame.hpp"

/// SYNC, CiA 301 section 7.2.5: every drive applies what it has received and samples what it sends.

namespace inbetween::can {

/// The last value of the counter in SYNC (object 1019): 0 for no counter, otherwise 2 to 240.
constexpr bool is_sync_overflow(std::uint8_t overflow) {
  return overflow == 0 || (overflow >= 2 && overflow <= 240);
}

class SyncProducer {
 public:
  /// Errors: out_of_range (1 and 241 to 255 are reserved).
  static Result<SyncProducer> make(std::uint8_t overflow);
  /// The next SYNC: empty, or with a counter that goes from 1 to the overflow and begins again.
  Frame next();

 private:
  constexpr explicit SyncProducer(std::uint8_t overflow) : overflow_(overflow) {}
  std::uint8_t overflow_;
  std::uint8_t last_ = 0;
};

}  // namespace inbetween::can
