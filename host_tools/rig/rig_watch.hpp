// Whether the file of a rig is still the one that was read.
#pragma once

#include <functional>
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

/// Throws InputError at a rig file of which `has_changed`, which may be empty, says that it is another than
/// was read: what is begun is begun with the rig that was read.
void refuse_changed_rig(const std::string& path, const std::function<bool()>& has_changed);

}  // namespace inbetween
