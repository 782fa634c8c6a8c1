// The files of the page, read once.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace inbetween {

struct PageFile {
  std::string type;  ///< "text/html"
  std::string bytes;
};

/// By the path under which they are served: "/index.html", "/assets/solver.wasm".
using PageFiles = std::map<std::string, PageFile>;

/// Where the page is: beside the program in a build (editor/page), under share/inbetween where it is
/// installed. Nothing where it has not been built.
std::optional<std::filesystem::path> find_page(const std::filesystem::path& program);

/// Reads every file below `folder` whose ending has a known type.
PageFiles read_page(const std::filesystem::path& folder);

}  // namespace inbetween
