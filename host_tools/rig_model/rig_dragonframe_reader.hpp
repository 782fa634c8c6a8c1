// The section [dragonframe] of a rig file.
#pragma once

#include <optional>
#include <span>

#include "host_tools/rig_model/rig_dragonframe.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// Nothing where the rig has none. Throws InputError at what is wrong: an axis without a number, a name that
/// is no axis, steps that do not fit into the 32 bits of the protocols, more axes than those can number.
std::optional<RigDragonframe> read_dragonframe(const TomlTable& rig, std::span<const RigAxis> axes);

}  // namespace inbetween
