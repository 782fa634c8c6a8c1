// What a take was played with, from the texts that it has.
#pragma once

#include <memory>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/takes/take.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {

/// Reads the files that the move and the rig of a take name from what it has kept of them. Throws InputError
/// at a file that it has not. Refers to the take.
TextReader kept_texts(const Take& take);

/// The first file of a role. Throws std::runtime_error, one line, where the take has none.
const TakeFile& file_of(const Take& take, TakeFile::Role role);

struct TakenRig {
  RigFile rig;
  std::shared_ptr<const Kinematics> kinematics = nullptr;  ///< null without [kinematics]
};

/// Throws InputError where this version does not read the rig, and std::runtime_error, one line, where it has
/// other axes than the take.
TakenRig rig_of(const Take& take);

}  // namespace inbetween
