#include "host_tools/cli/command.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/plan/turns.hpp"
#include "host_tools/rig/eds_drive.hpp"

namespace inbetween {
namespace {

bool is_same_file(const std::string& one, const std::string& other) {
  std::error_code not_there;
  if (std::filesystem::equivalent(one, other, not_there)) return std::filesystem::is_regular_file(one);
  const auto place = [&](const std::string& name) {
    return std::filesystem::weakly_canonical(name, not_there);
  };
  return !std::filesystem::exists(one, not_there) && place(one) == place(other);
}

}  // namespace

// fmt::print would throw if standard error cannot be written either. The exit status tells in any case.
void complain(const std::string& line) {
  std::fputs((line + '\n').c_str(), stderr);
}

void refuse_outputs_in_one_place(const std::vector<NamedFile>& inputs,
                                 const std::vector<NamedFile>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& output = outputs[i];
    if (!output.name) continue;
    const auto refuse = [&](const NamedFile& other) {
      throw UsageError(fmt::format("{} and {} would both be {}; give each its own file", other.argument,
                                   output.argument,
                                   *output.name == "-" ? "the standard output" : *output.name));
    };
    for (std::size_t k = 0; k < i; ++k) {
      if (!outputs[k].name) continue;
      const bool to_stdout = *output.name == "-" || *outputs[k].name == "-";
      if (to_stdout ? *output.name == *outputs[k].name : is_same_file(*output.name, *outputs[k].name)) {
        refuse(outputs[k]);
      }
    }
    for (const NamedFile& input : inputs) {
      if (input.name && *output.name != "-" && is_same_file(*output.name, *input.name)) refuse(input);
    }
  }
}

void refuse_unknown_picture(const std::optional<std::string>& plot) {
  if (!plot) return;
  try {
    static_cast<void>(picture_format(*plot));
  } catch (const std::runtime_error& error) {
    throw UsageError(fmt::format("--plot {}", error.what()));
  }
}

RigFile read_rig(const std::string& path) {
  RigFile rig = read_rig_file(path);
  const std::vector<std::string> warnings = refuse_unfit_drives(rig);
  constexpr std::size_t max_lines = 20;
  for (std::size_t i = 0; i < std::min(warnings.size(), max_lines); ++i)
    fmt::print(stderr, "{}\n", warnings[i]);
  if (warnings.size() > max_lines) {
    fmt::print(stderr, "{}: warning: its data sheets have {} more such lines\n", path,
               warnings.size() - max_lines);
  }
  return rig;
}

Plan make_plan(const std::string& move, const std::optional<std::string>& rig, Solver solver,
               const PlayedPart& part) {
  std::optional<RigFile> rig_file;
  if (rig) rig_file = read_rig(*rig);
  PlanOptions options{.solver = solver};
  if (rig_file && rig_file->kinematics) {
    options.kinematics = std::make_shared<const Kinematics>(read_kinematics(*rig_file));
    for (const Warning& warning : options.kinematics->warnings()) {
      fmt::print(stderr, "{}\n", to_string(warning));
    }
  }
  if (!part.turns) options.frames = part.frames;
  Plan plan(read_move_file(move), std::move(rig_file), options);
  if (part.turns) {
    options.frames = part.frames;
    plan = Plan(turns_of(plan, *part.turns), plan.rig(), options);
  }
  for (const Warning& warning : plan.warnings()) fmt::print(stderr, "{}\n", to_string(warning));
  return plan;
}

void add_turns(CLI::App& app, std::optional<std::int32_t>& turns) {
  app.add_option("--turns", turns, "so many turns of a periodic move, as one move through its seams")
      ->check(between(1, max_frames));
}

void add_frames(CLI::App& app, std::optional<std::string>& frames, const std::string& what) {
  app.add_option("--frames", frames, what)->type_name("FIRST..LAST");
}

FrameRange frame_range_argument(const std::optional<std::string>& text) {
  if (!text) return {};
  if (const auto range = frame_range_of(*text)) return *range;
  throw UsageError(
      fmt::format("--frames {}: not a part of a move; write FIRST..LAST, FIRST.. or ..LAST, for "
                  "example 20..80",
                  in_quotes(*text)));
}

void add_style(CLI::App& app, PictureStyle& style) {
  app.add_option_function<std::string>(
         "--style",
         [&style](const std::string& name) {
           style = name == "dark" ? PictureStyle::dark : PictureStyle::light;
         },
         "of the picture: light, for paper, or dark, for a screen beside a stage")
      ->check(CLI::IsMember({"light", "dark"}))
      ->default_str("light")
      ->needs("--plot");
}

std::FILE* summary_stream(bool data_on_standard_output) {
  return data_on_standard_output ? stderr : stdout;
}

}  // namespace inbetween
