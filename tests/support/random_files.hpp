// Texts of moves and rigs in which every field may stand beside every other, with few keys and values often.
#pragma once

#include <memory>
#include <optional>
#include <random>
#include <string>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The rig of a random move, and whether it is one of the examples with joints.
struct RandomFiles {
  std::string move;
  std::string rig;         ///< the text of a rig, or ""
  std::string rig_folder;  ///< of an example whose rig it is, or ""
};

/// Most of them can be read; what is refused is refused for what fields say together.
RandomFiles random_files(std::mt19937& random);

/// The rig, if there is one. Throws InputError where it is refused.
std::optional<RigFile> rig_of(const RandomFiles& files);

/// The joints of that rig, if they are read from a file: of each example they are read once.
std::shared_ptr<const Kinematics> joints_of(const RandomFiles& files, const std::optional<RigFile>& rig);

}  // namespace inbetween
