// Any text is a data sheet that keeps every promise of host_tools/rig_model/eds_file.hpp, or is refused in
// one line.
#include "host_tools/rig_model/eds_file.hpp"

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

void require_object(const EdsObject& object) {
  fuzz_require(object.size <= 4, "a number has at most four bytes");
  fuzz_require(object.size == 0 || object.bytes.empty(), "an object is a number or bytes");
  const bool fits =
      object.size == 0 || object.size == 4 || object.value.value_or(0) >> (8 * object.size) == 0;
  fuzz_require(fits, "a number has room");
  fuzz_require(object.line > 0, "an object has its line");
}

void require_objects(const EdsFile& file) {
  for (const std::string& warning : file.warnings) {
    fuzz_require(warning.starts_with("any.eds:") && warning.find('\n') == warning.npos,
                 "a warning is one line");
  }
  fuzz_require(!file.objects.empty() && file.objects.size() <= max_eds_objects, "objects fit");
  for (std::size_t i = 0; i < file.objects.size(); ++i) {
    const EdsObject& object = file.objects[i];
    require_object(object);
    fuzz_require(file.find(object.index, object.sub) == &object, "an object is there once, and is found");
  }
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return inbetween::fuzz_text(bytes, size, "any.eds", [](std::string_view text, const char* file) {
    inbetween::require_objects(inbetween::parse_eds(text, file, 5));
  });
}
