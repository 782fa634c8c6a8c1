// The rig of a move that is edited, as its file is now.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// Thread-safe.
class EditedRig {
 public:
  struct State {
    std::optional<RigFile> file;  ///< nothing: the move is edited without a rig
    std::shared_ptr<const Kinematics> kinematics;
    std::string revision;  ///< of the bytes of its file and of the URDF file that it names
    std::string error;     ///< why the file of today cannot be read, and `file` is that of before; one line
  };

  /// `path` is that of its file, whatever folder the program goes to; nothing: there is no rig.
  explicit EditedRig(std::optional<std::string> path) : path_(std::move(path)) {}

  /// Reads the files again where their bytes have changed. Throws InputError where they could never be read.
  State now();

 private:
  std::mutex reading_;
  std::optional<std::string> path_;
  std::string tried_;  // revision
  State state_;
};

}  // namespace inbetween
