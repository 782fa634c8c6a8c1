#include "host_tools/plot/drawing_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <stdexcept>

namespace inbetween {
namespace {

/// The others come with it.
constexpr const char* first_library = "libpangocairo-1.0.so.0";

DrawingLibrary loaded() {
  // It stays until the program ends: fontconfig and glib cannot be unloaded.
  void* const library = ::dlopen(first_library, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  const auto find = [&](const char* name) {
    void* const function = library != nullptr ? ::dlsym(library, name) : nullptr;
    if (function != nullptr) return function;
    throw std::runtime_error(
        fmt::format("inbetween: error: pictures are drawn by pango and cairo, which are not there ({}); "
                    "install the package "
                    "libpangocairo-1.0-0",
                    ::dlerror()));
  };
  DrawingLibrary found;
#define INBETWEEN_FIND(name) found.name = reinterpret_cast<decltype(&::name)>(find(#name));
  INBETWEEN_DRAWING_FUNCTIONS(INBETWEEN_FIND)
#undef INBETWEEN_FIND
  return found;
}

}  // namespace

const DrawingLibrary& drawing() {
  static const DrawingLibrary library = loaded();
  return library;
}

}  // namespace inbetween
