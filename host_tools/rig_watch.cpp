#include "host_tools/rig_watch.hpp"

#include "host_tools/toml_source.hpp"

namespace inbetween {

RigWatch::RigWatch(const std::string& path) : path_(path), text_(read_text_file(path)) {}

bool RigWatch::has_changed() const {
  try {
    return read_text_file(path_) != text_;
  } catch (const InputError&) {
    return true;
  }
}

}  // namespace inbetween
