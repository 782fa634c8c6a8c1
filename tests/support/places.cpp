#include "tests/support/places.hpp"

namespace inbetween {

std::string in_checkout(std::string_view path) {
  return std::string(INBETWEEN_SOURCE_DIR "/").append(path);
}

std::string in_build(std::string_view path) {
  return std::string(INBETWEEN_BUILD_DIR "/").append(path);
}

}  // namespace inbetween
