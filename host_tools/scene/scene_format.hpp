// Which files are scenes of other programs.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace inbetween {

enum class SceneFormat : std::uint8_t { gltf, glb, usda };
/// In the order of SceneFormat: as --format names them, and as files end.
inline constexpr std::array<std::string_view, 3> scene_format_words = {"gltf", "glb", "usda"};
std::string_view to_string(SceneFormat format);

/// By the word, or else by the ending of the file; nothing where the file is no scene. Throws InputError at
/// a file that is a scene in a form that is not read: binary USD (.usd, .usdc, .usdz), FBX, Alembic.
std::optional<SceneFormat> scene_format_of(const std::optional<std::string>& word, const std::string& file);

}  // namespace inbetween
