#include "host_tools/edit/page_files.hpp"

#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> type_of(const fs::path& file) {
  static const std::map<std::string, std::string> types = {{".html", "text/html; charset=utf-8"},
                                                           {".js", "text/javascript; charset=utf-8"},
                                                           {".css", "text/css; charset=utf-8"},
                                                           {".wasm", "application/wasm"},
                                                           {".svg", "image/svg+xml"},
                                                           {".json", "application/json"}};
  const auto found = types.find(file.extension().string());
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

std::optional<fs::path> find_page(const fs::path& program) {
  const fs::path folder = program.parent_path();
  for (const fs::path& place : {folder / "editor/page", folder.parent_path() / "share/inbetween/editor"}) {
    if (fs::is_regular_file(place / "index.html")) return place;
  }
  return std::nullopt;
}

PageFiles read_page(const fs::path& folder) {
  PageFiles files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const auto type = type_of(entry.path());
    if (!entry.is_regular_file() || !type) continue;
    files["/" + entry.path().lexically_relative(folder).generic_string()] = {*type,
                                                                             read_text_file(entry.path())};
  }
  return files;
}

}  // namespace inbetween
