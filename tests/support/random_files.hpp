// Texts of moves and rigs in which every field may stand beside every other, with few keys and values often.
#pragma once

#include <random>
#include <string>

namespace inbetween {

/// The rig of a random move, and whether it is one of the examples with joints.
struct RandomFiles {
  std::string move;
  std::string rig;         ///< the text of a rig, or ""
  std::string rig_folder;  ///< of an example whose rig it is, or ""
};

/// Most of them can be read; what is refused is refused for what fields say together.
RandomFiles random_files(std::mt19937& random);

}  // namespace inbetween
