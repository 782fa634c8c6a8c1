#include "host_tools/takes/taken_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

TextReader kept_texts(const Take& take) {
  return [&take](const std::filesystem::path& path, std::size_t /*max_bytes*/) {
    const auto found = std::ranges::find(take.files, path.string(), &TakeFile::path);
    if (found != take.files.end()) return found->text;
    throw InputError({path.string(), 0, 0},
                     fmt::format("take {} has not kept this file; choose another take", take.number));
  };
}

const TakeFile& file_of(const Take& take, TakeFile::Role role) {
  const auto found = std::ranges::find(take.files, role, &TakeFile::role);
  if (found != take.files.end() && !found->text.empty()) return *found;
  throw std::runtime_error(fmt::format(
      "inbetween: error: take {} has not the text of the {} that it was played with; choose another",
      take.number, role == TakeFile::Role::move ? "move" : "rig"));
}

TakenRig rig_of(const Take& take) {
  const TakeFile& text = file_of(take, TakeFile::Role::rig);
  TakenRig taken{.rig = parse_rig(text.text, text.path)};
  if (!std::ranges::equal(take.axes, taken.rig.axes, {}, &TakeAxis::name, &RigAxis::name)) {
    throw std::runtime_error(fmt::format(
        "inbetween: error: take {} has other axes than its rig; the take is damaged", take.number));
  }
  if (taken.rig.kinematics)
    taken.kinematics = std::make_shared<const Kinematics>(read_kinematics(taken.rig, kept_texts(take)));
  return taken;
}

}  // namespace inbetween
