// The section [lens] of a rig file.
#pragma once

#include <optional>

#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/rig_model/rig_lens.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// Nothing where the rig has none. Throws InputError at what is wrong: without [kinematics] nobody knows
/// where the lens is, and with several tips the file says at which it is.
std::optional<RigLens> read_lens(const TomlTable& rig, const std::optional<RigKinematics>& kinematics);

}  // namespace inbetween
