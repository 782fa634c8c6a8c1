// glTF 2.0, as JSON (.gltf, with numbers in it or in files beside it) or binary (.glb).
//
// Read are nodes, what they are called, where they are and how they move: translations, rotations and scales
// of all animations, on straight lines, in steps and as cubics. Meshes, materials and the like are passed
// over.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/scene/scene_file.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {

/// `read` gives the files that the scene names, in its own folder. What the writer of inbetween says of the
/// rate and the first frame is taken. Throws InputError at line and column of the JSON where something is
/// wrong, where numbers are packed in a way that is not read (sparse, meshopt), or beyond the bounds of
/// scene_bounds.hpp. O(bytes).
SceneFile read_gltf(std::string_view bytes, const std::string& file, const TextReader& read = read_text_file);

}  // namespace inbetween
