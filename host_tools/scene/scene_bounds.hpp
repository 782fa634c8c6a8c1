// What a scene file may have at most: what has more is refused.
#pragma once

#include <cstddef>

namespace inbetween {

inline constexpr std::size_t max_gltf_bytes = std::size_t{256} << 20U;
inline constexpr std::size_t max_gltf_json_bytes = std::size_t{128} << 20U;
inline constexpr std::size_t max_usda_bytes = std::size_t{64} << 20U;
inline constexpr std::size_t max_scene_nodes = 65'536;
/// How deep nodes hang on each other, and JSON and USD nest.
inline constexpr std::size_t max_scene_depth = 128;
/// Times of all tracks of all nodes together.
inline constexpr std::size_t max_scene_samples = 16'000'000;
/// A length, in metres or in the unit of a file.
inline constexpr double max_scene_number = 1e12;

}  // namespace inbetween
