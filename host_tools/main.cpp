#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "host_tools/cli/command_line.hpp"

namespace {

/// The editor is a program beside this one, with the same arguments, and this process becomes it.
int become_editor(char** argv) {
  const std::filesystem::path editor =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "inbetween-edit";
  ::execv(editor.c_str(), argv);
  throw std::runtime_error(
      fmt::format("inbetween: error: {} cannot be started; it belongs beside inbetween", editor.string()));
}

}  // namespace

int main(int argc, char** argv) {
  return inbetween::run_command_line(argc, argv,
                                     [argv](const inbetween::EditArguments&) { return become_editor(argv); });
}
