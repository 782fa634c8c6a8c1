// Somebody types to which frame or key a rig shall go: g 9 6 Enter.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "host_tools/loop/run_snapshot.hpp"
#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {

/// A frame or a key that was asked for.
struct WantedPlace {
  bool is_key = false;
  std::int32_t number = 0;
};

/// Nothing moves before Enter. Allocates nothing.
class PlaceEntry {
 public:
  /// Whether the key was one of the entry's. Another ends the entry, and means what it means elsewhere.
  bool press(TransportKey key);
  /// What was asked for, once.
  [[nodiscard]] std::optional<WantedPlace> take() { return std::exchange(wanted_, std::nullopt); }
  [[nodiscard]] const std::optional<EntrySnapshot>& shown() const { return typed_; }

 private:
  void press_digit(std::int32_t digit);

  std::optional<EntrySnapshot> typed_;
  std::optional<WantedPlace> wanted_;
};

}  // namespace inbetween
