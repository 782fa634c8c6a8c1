// Writes a file whole or not at all.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

namespace inbetween {

/// A pipe, a device, or a folder is there: what is no file of bytes is not replaced by one of its name.
bool is_special(const std::string& name);

/// Opens `name` ("-" is standard output), lets `write` fill it, and checks that all of it arrived. It writes
/// beside the file and then renames, so that a full disk or an error leaves the old file as it was. The
/// permissions stay, and a symbolic link still points to the file. A write-protected file is refused. It
/// writes directly to a pipe or a device, and refuses a FIFO that nobody reads. Throws std::runtime_error,
/// one line that starts with the file's name.
void write_output(const std::string& name, const std::function<void(std::FILE*)>& write);

/// Throws what write_output would throw if it is clear already that `name` cannot be written. Call it before
/// work that takes long. It creates nothing. It opens a FIFO and holds it open until the program ends.
void check_output(const std::string& name);

/// Throws if printed text did not arrive on standard output.
void check_standard_output();

}  // namespace inbetween
