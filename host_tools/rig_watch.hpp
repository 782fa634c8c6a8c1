// Whether the file of a rig is still the one that was read.
#pragma once

#include <string>

namespace inbetween {

/// While a rig is armed nothing but its motion goes on; what was changed in its file meanwhile would not be
/// true of it. So nothing new is begun then.
class RigWatch {
 public:
  /// Remembers the text. Throws InputError where it cannot be read. Made before the rig is read.
  explicit RigWatch(const std::string& path);
  /// Also where it has gone. Reads the file.
  [[nodiscard]] bool has_changed() const;

 private:
  std::string path_;
  std::string text_;
};

}  // namespace inbetween
