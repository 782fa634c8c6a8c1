// Reads the drives of a rig.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>

#include "host_tools/rig_model/gpio_line_reader.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// The names and addresses that are taken already, each with the words that say by whom.
using Taken = std::map<std::string, Place>;

/// Throws InputError at `value` if `what` is taken already.
void take(Taken& taken, const TomlValue& value, const std::string& what, std::string_view remedy);

/// The part of the rig that the reader of an axis needs.
struct RigContext {
  std::span<const Bus> buses;
  Taken& taken;
  TakenLines& lines;
};

/// Reads the table `drive` of an axis whose limits have been read.
Drive read_drive(const TomlValue& value, const RigAxis& axis, const RigContext& rig);

}  // namespace inbetween
