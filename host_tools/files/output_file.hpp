// A file that is written whole or not at all.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

namespace inbetween {

/// Opens `name` ("-" is standard output), lets `write` fill it, and checks that all of it arrived. A file
/// is written beside its place and then renamed, so that a full disk or an error leaves the old file as
/// it was; its permissions stay, and a symbolic link goes on pointing to it. A pipe or a device is
/// written directly. Throws std::runtime_error, one line that starts with the file's name.
void write_output(const std::string& name, const std::function<void(std::FILE*)>& write);

/// Throws as write_output would where it is plain already that `name` cannot be written: for work that takes
/// long. Creates nothing.
void check_output(const std::string& name);

/// Throws where something that was printed did not arrive on standard output.
void check_standard_output();

}  // namespace inbetween
