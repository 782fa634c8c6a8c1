// Which file has the takes: the shared part of run and takes.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/takes/replayed_take.hpp"

namespace inbetween {

/// The arguments of `run` that are about takes.
struct TakeArguments {
  bool is_no_take = false;
  std::optional<std::string> takes_in = {};
  std::optional<std::int64_t> max_take_bytes = {};  ///< --keep
  std::optional<std::int64_t> take = {};            ///< to be played again
};
void add_take_options(CLI::App& command, TakeArguments& arguments);

/// Adds --keep SIZE.
void add_keep_size(CLI::App& command, std::optional<std::int64_t>& bytes, const std::string& what);

/// Where the takes of a move are kept: where the argument, or else the environment variable INBETWEEN_TAKES
/// says, or in the folder of the move. Nothing where either says that the run is no take ("off").
std::optional<std::string> takes_file(const TakeArguments& arguments, const std::string& move);

/// The file of takes that a person means: a folder, and a move in it, stand for the file in it; without one
/// that of INBETWEEN_TAKES, or of the folder where they are.
std::string named_takes_file(const std::optional<std::string>& name);

/// The texts of a move and of its rig, before they are read to be played. What is no file of bytes has none.
std::vector<TakeFile> files_of_run(const std::string& move, const std::string& rig);
/// Adds what they name: CSV files of the move, the URDF file and the data sheets of the rig. Throws
/// InputError where one of those is another by now.
void complete_files(const Plan& plan, std::vector<TakeFile>& files);

}  // namespace inbetween
