// A file that is written whole or not at all.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

namespace inbetween {

/// Opens `name` ("-" is standard output), lets `write` fill it, and checks that all of it arrived. A file
/// is written beside its place and then renamed, so that a full disk or an error leaves the old file as
/// it was. Throws std::runtime_error, one line that starts with the file's name.
void write_output(const std::string& name, const std::function<void(std::FILE*)>& write);

}  // namespace inbetween
