#include "host_tools/rig/rig_watch.hpp"

#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {

RigWatch::RigWatch(const std::string& path) : path_(path), text_(read_text_file(path)) {}

bool RigWatch::has_changed() const {
  try {
    return read_text_file(path_) != text_;
  } catch (const InputError&) {
    return true;
  }
}

void refuse_changed_rig(const std::string& path, const std::function<bool()>& has_changed) {
  if (!has_changed || !has_changed()) return;
  throw InputError({path, 0, 0}, "the file was changed since it was read, and nothing is begun; do it again");
}

}  // namespace inbetween
