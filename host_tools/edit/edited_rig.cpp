#include "host_tools/edit/edited_rig.hpp"

#include <filesystem>
#include <utility>

#include "host_tools/edit/edit_session.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

std::string revision_of_rig(const std::string& path, const std::string& text, const RigFile* before) {
  if (before == nullptr || !before->kinematics) return revision_of(text);
  const std::filesystem::path urdf = std::filesystem::path(path).parent_path() / before->kinematics->urdf;
  return revision_of(text) + "+" + revision_of(read_text_file(urdf));
}

EditedRig::State read_state(const std::string& path, const std::string& text) {
  EditedRig::State state{.file = parse_rig(text, path), .kinematics = nullptr, .revision = {}, .error = {}};
  if (state.file->kinematics)
    state.kinematics = std::make_shared<const Kinematics>(read_kinematics(*state.file));
  return state;
}

}  // namespace

EditedRig::State EditedRig::now() {
  const std::lock_guard lock(reading_);
  if (!path_) return {};
  try {
    const std::string before = std::exchange(tried_, "");
    const std::string text = read_text_file(*path_);
    tried_ = revision_of_rig(*path_, text, state_.file ? &*state_.file : nullptr);
    if (tried_ == before) return state_;
    State state = read_state(*path_, text);
    state.revision = tried_ = revision_of_rig(*path_, text, &*state.file);
    state_ = std::move(state);
  } catch (const InputError& error) {
    if (!state_.file) throw;
    state_.error = error.what();
  }
  return state_;
}

}  // namespace inbetween
