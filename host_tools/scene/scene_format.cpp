#include "host_tools/scene/scene_format.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

struct OtherForm {
  std::string_view ending, what;
};
constexpr std::array<OtherForm, 5> other_forms = {{{"usd", "USD in binary, or in text"},
                                                   {"usdc", "USD in binary"},
                                                   {"usdz", "USD in an archive"},
                                                   {"fbx", "FBX"},
                                                   {"abc", "Alembic"}}};

std::optional<SceneFormat> format_of_word(std::string_view word) {
  const auto* const found = std::ranges::find(scene_format_words, word);
  if (found == scene_format_words.end()) return std::nullopt;
  return static_cast<SceneFormat>(found - scene_format_words.begin());
}

}  // namespace

std::string_view to_string(SceneFormat format) {
  return scene_format_words.at(static_cast<std::size_t>(format));
}

std::optional<SceneFormat> scene_format_of(const std::optional<std::string>& word, const std::string& file) {
  if (word) return format_of_word(*word);
  const std::size_t dot = file.rfind('.');
  if (dot == std::string::npos) return std::nullopt;
  const std::string ending = lower_case(std::string_view(file).substr(dot + 1));
  const auto* const other = std::ranges::find(other_forms, ending, &OtherForm::ending);
  if (other != other_forms.end()) {
    throw InputError({file},
                     fmt::format("this is {}, by its ending; take USD as text (.usda) or glTF (.gltf, .glb)",
                                 other->what));
  }
  return format_of_word(ending);
}

}  // namespace inbetween
