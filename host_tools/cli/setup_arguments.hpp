// Which rig a command uses, and how, and where axes stand ("pan=-20"): the shared part of run, goto, home and
// jog.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/loop/rig_session.hpp"

namespace inbetween {

struct SetupArguments {
  std::string rig;
  bool simulated = false;
  bool fast = false;
  bool allow_jitter = false;
  std::vector<std::string> from;
  std::optional<std::string> positions;
};

/// Adds --rig, --sim, --from, --positions, --allow-jitter and, if the command can run unattended, --fast.
void add_setup_options(CLI::App& command, SetupArguments& arguments, bool can_be_fast);

/// Throws UsageError if options exclude each other.
void check_setup_usage(const SetupArguments& arguments);

/// The session options without the audience.
SessionOptions session_options_of(const SetupArguments& arguments);

/// Prints where the given axes rest.
void print_positions(const RigFile& rig, const RigReference& reference, const std::vector<std::size_t>& axes,
                     const std::vector<double>& positions);

/// The whole of `text` as a finite number.
std::optional<double> number_of(std::string_view text);

/// The position that each text AXIS=POSITION names. Throws UsageError, which names `argument`.
std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument = "--from");

}  // namespace inbetween
