#include "host_tools/cli/take_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <utility>
#include <variant>

#include "host_tools/cli/command.hpp"
#include "host_tools/text/output_file.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

std::optional<std::string> takes_of_environment() {
  const char* const named = std::getenv("INBETWEEN_TAKES");
  return named != nullptr && *named != '\0' ? std::optional<std::string>(named) : std::nullopt;
}

TakeFile take_file(TakeFile::Role role, const std::string& path, std::size_t max_bytes = max_file_bytes) {
  std::string text = is_special(path) ? "" : read_text_file(path, max_bytes);
  std::string hash = hash_of_content(text);
  return {role, path, std::move(text), std::move(hash)};
}

}  // namespace

void add_keep_size(CLI::App& command, std::optional<std::int64_t>& bytes, const std::string& what) {
  command
      .add_option_function<std::string>(
          "--keep",
          [&bytes](const std::string& text) {
            bytes = size_in_bytes(text);
            if (!bytes) throw UsageError(fmt::format("--keep {}: no size; write 500k, 20M or 1.5G", text));
          },
          what)
      ->type_name("SIZE");
}

void add_take_options(CLI::App& command, TakeArguments& arguments) {
  CLI::Option* no_take = command.add_flag("--no-take", arguments.is_no_take, "keep no take of this run");
  command
      .add_option("--takes-in", arguments.takes_in,
                  "the file that takes are kept in (inbetween-takes.db in the folder of the move, or what\n"
                  "INBETWEEN_TAKES names: a file, or off)")
      ->type_name("FILE")
      ->excludes(no_take);
  add_keep_size(command, arguments.max_take_bytes,
                "forget the oldest takes where all take more (20M, 1.5G), never one that is marked");
  command
      .add_option("--take", arguments.take,
                  "play a take again, tick by tick, from its start to where it first rested")
      ->check(between(std::int64_t{1}, std::int64_t{1} << 40U))
      ->type_name("N");
}

std::optional<std::string> takes_file(const TakeArguments& arguments, const std::string& move) {
  if (arguments.is_no_take) return std::nullopt;
  if (arguments.takes_in) return arguments.takes_in;
  if (const std::optional<std::string> named = takes_of_environment()) {
    return *named == "off" ? std::nullopt : named;
  }
  return is_special(move) ? std::string(take_file_name)
                          : (std::filesystem::path(move).parent_path() / take_file_name).string();
}

std::string named_takes_file(const std::optional<std::string>& name) {
  if (!name) {
    const std::optional<std::string> named = takes_of_environment();
    return named && *named != "off" ? *named : take_file_name;
  }
  std::error_code unknown;
  const std::filesystem::path path = *name;
  if (std::filesystem::is_directory(path, unknown)) return path / take_file_name;
  return path.extension() == ".toml" ? (path.parent_path() / take_file_name).string() : *name;
}

std::vector<TakeFile> files_of_run(const std::string& move, const std::string& rig) {
  return {take_file(TakeFile::Role::move, move), take_file(TakeFile::Role::rig, rig)};
}

void complete_files(const Plan& plan, std::vector<TakeFile>& files) {
  for (const TakeFile& file : files) {
    if (!is_special(file.path) && read_text_file(file.path) != file.text)
      throw InputError({file.path, 0, 0}, "the file was changed while it was read; do it again");
  }
  std::vector<std::string> others = files_beside(plan.move());
  const RigFile& rig = *plan.rig();
  if (rig.kinematics)
    others.push_back((std::filesystem::path(rig.path).parent_path() / rig.kinematics->urdf).string());
  for (const RigAxis& axis : rig.axes) {
    const auto* const drive = std::get_if<Cia402Drive>(&axis.drive);
    if (drive != nullptr && !drive->eds.empty() && std::ranges::count(others, drive->eds) == 0)
      others.push_back(drive->eds);
  }
  for (const std::string& other : others)
    files.push_back(take_file(TakeFile::Role::other, other, max_table_bytes));
}

}  // namespace inbetween
