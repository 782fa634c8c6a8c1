// The keys of somebody who teaches a move.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host_tools/loop/transport_keys.hpp"
#include "host_tools/move_model/taught_move.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// Refers to the rig and the reference.
class TaughtKeys {
 public:
  /// A new move gets these axes, or all of the rig where none are named. Throws what TaughtMove throws; what
  /// check_output throws where `path` cannot be written; InputError where an axis is none of the rig.
  TaughtKeys(const std::string& path, const std::vector<std::string>& axes_of_new, const RigFile& rig,
             const RigReference& reference);

  /// Does what the key means (Jog::taught) for the axis that is moved, with where every axis of the rig
  /// stands.
  void press(TransportKey key, std::size_t axis, const std::vector<double>& positions);
  /// The notes of the screen while this axis is moved.
  [[nodiscard]] std::vector<std::string> shown(const char* axis) const;
  /// "move.toml: 3 keys stored".
  [[nodiscard]] std::string summary() const;

 private:
  std::string path_;
  const RigFile& rig_;
  const RigReference& reference_;
  TaughtMove move_;
};

}  // namespace inbetween
