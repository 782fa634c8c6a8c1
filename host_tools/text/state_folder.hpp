// Where what the program knows of this machine is kept from one run to the next.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace inbetween {

/// $XDG_STATE_HOME/inbetween, or without an absolute XDG_STATE_HOME (or nullptr) $HOME/.local/state/inbetween
/// (XDG Base Directory Specification 0.8). Nothing where HOME is not absolute either.
std::optional<std::filesystem::path> state_folder(const char* xdg_state_home, const char* home);

/// A name for the file of something with that name: its letters and digits, the others as '_', and a hash of
/// `identity`, which tells it from all others.
std::string state_file_name(std::string_view name, std::string_view identity, std::string_view ending);

}  // namespace inbetween
