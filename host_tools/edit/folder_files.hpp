// The files of one folder and of nothing else.
#pragma once

#include <string>

#include "host_tools/text/file_layer.hpp"

namespace inbetween {

/// The operations of Linux on the files of `folder`, named relative to it ("." is the folder). The kernel
/// refuses whatever leads out of the folder (openat2 with RESOLVE_BENEATH) and does not follow symbolic
/// links, also if a name changes meanwhile. Throws std::runtime_error, one line, where the folder cannot be
/// opened, or the kernel has no openat2 (before Linux 5.6).
FileLayer files_beneath(const std::string& folder);

}  // namespace inbetween
