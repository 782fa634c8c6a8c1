#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

namespace inbetween::can {

/// An axis rests where it has not been further than `distance` from one place for `rest_ns`. Places are in
/// units of the drive. O(1).
class RestWatch {
 public:
  RestWatch(double distance, std::int64_t rest_ns) : distance_(distance), rest_ns_(rest_ns) {}

  /// It may have moved since it was looked at last.
  void begin() {
    since_ns_.reset();
    rests_ = false;
  }
  void look(double place, std::int64_t now_ns) {
    if (!since_ns_ || !(std::fabs(place - place_) <= distance_)) {
      place_ = place;
      since_ns_ = now_ns;
    }
    rests_ = now_ns - *since_ns_ >= rest_ns_;
  }
  [[nodiscard]] bool rests() const { return rests_; }
  /// Since when it has been at its place; none: nobody has looked.
  [[nodiscard]] std::optional<std::int64_t> since_ns() const { return since_ns_; }

 private:
  double distance_;
  std::int64_t rest_ns_;
  double place_ = 0;
  std::optional<std::int64_t> since_ns_;
  bool rests_ = false;
};

}  // namespace inbetween::can
