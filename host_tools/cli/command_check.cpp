#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/check/check_output.hpp"
#include "host_tools/cli/command.hpp"
#include "host_tools/cli/progress_bar.hpp"
#include "host_tools/fit/cure.hpp"
#include "host_tools/fit/fewer_values.hpp"
#include "host_tools/fit/fewest_fit.hpp"
#include "host_tools/fit/fit_output.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/move_model/speed_rewrite.hpp"
#include "host_tools/plot/plot_limits.hpp"
#include "host_tools/text/output_file.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

struct CheckArguments {
  std::string move, rig;
  std::optional<std::string> json, plot, fit, frames;
  PictureStyle style = PictureStyle::light;
  std::optional<std::string> start;
  double seconds = 60;
  bool fewest = false;
  std::optional<std::int32_t> turns;
};

FitStart start_of(const CheckArguments& arguments) {
  if (!arguments.start) return FitStart::either;
  return *arguments.start == "drawn" ? FitStart::drawn : FitStart::curvature;
}

/// A fit that is written takes so many seconds, and ends with Ctrl-C; what is only looked at is quick.
FitOptions fit_options(const CheckArguments& arguments) {
  if (!arguments.fit) return {.start = FitStart::drawn, .refinements = 0};
  const auto last_ns = static_cast<double>(MonotonicClock().now_ns()) + arguments.seconds * 1e9;
  return {.start = start_of(arguments), .is_over = [=] {
            return InterruptWatch::asked() || static_cast<double>(MonotonicClock().now_ns()) >= last_ns;
          }};
}

/// The move with the fewest frames for which a curve is found; where nobody wants it written, one with as
/// many control values, which is quick.
FewestFit find_fewest(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest,
                      const FitOptions& options, ProgressBar& bar) {
  return fit_in_fewest_frames(plan, report, smallest, options, [&](double share, std::int32_t frames) {
    bar.show(share, fmt::format("fitting in {}", counted(frames, "frame")));
  });
}

/// What the searches find: how few frames would do, and the move that --fit writes.
struct Searched {
  SmallestFrames smallest;
  std::optional<FewestFit> fitted;
  std::optional<Cure> cure;
  bool was_interrupted = false;
};
Searched search(const CheckArguments& arguments, const Plan& plan, const CheckReport& report) {
  Searched found;
  if (!plan.is_whole()) {
    found.smallest.reason = "other frames are those of another move; only a whole one is tried in fewer";
    return found;
  }
  ProgressBar bar;
  std::optional<InterruptWatch> watch;
  if (arguments.fit) watch.emplace();
  FitOptions options = fit_options(arguments);
  if (arguments.fit && !arguments.fewest) {
    options.progress = [&](double share) { bar.show(share, "looking for a speed curve"); };
    found.fitted = {plan.move(), fit_speed(plan, report, options)};
  }
  const auto trying = [&](double share, std::int32_t frames) {
    bar.show(share, fmt::format("trying {}", counted(frames, "frame")));
  };
  found.smallest = smallest_frames(plan, report, trying, options.is_over);
  if (arguments.fewest || (!arguments.fit && is_quick_to_fit(plan))) {
    FewestFit fewest = find_fewest(plan, report, found.smallest, options, bar);
    if (fewest.fit.found) found.smallest.with_other_curve = fewest.move.frames;
    found.smallest.may_be_refined = arguments.fit.has_value();
    if (arguments.fit) found.fitted = std::move(fewest);
  }
  if (found.fitted && found.fitted->fit.found) {
    const Plan fitted(found.fitted->move, plan);
    add_fewer_values(fitted, found.fitted->fit, options);
  }
  if (!arguments.fit) found.cure = find_cure(plan, report, found.smallest);
  // Nor is it said as the reason why no number of frames would do.
  for (const CheckRefusal& refusal : report.refusals) {
    if (found.cure && found.smallest.reason == refusal.message()) found.smallest.reason = refusal.what;
  }
  found.was_interrupted = watch && InterruptWatch::asked();
  return found;
}

/// Writes the move with its new curves, in its new frames.
void write_fitted(const CheckArguments& arguments, const Plan& plan, const FewestFit& fitted) {
  if (!fitted.fit.found) return;
  std::string text = read_text_file(arguments.move);
  if (fitted.move.frames != plan.move().frames) text = with_frames_of(text, arguments.move, fitted.move);
  for (const TrackFit& track : fitted.fit.tracks) {
    text = with_speed(text, arguments.move, track.track, track.speed);
  }
  write_output(*arguments.fit, [&](std::FILE* file) { std::fwrite(text.data(), 1, text.size(), file); });
}

/// The limits of the move, or of what the fit has made of it, with its curves before and after.
void draw_limits(const CheckArguments& arguments, const Plan& plan, const CheckReport& report,
                 const std::optional<FewestFit>& fitted) {
  if (!fitted || !fitted->fit.found)
    return draw_limits_plot(limits_plot_of(plan, report), *arguments.plot, arguments.style);
  MoveFile move = fitted->move;
  for (const TrackFit& track : fitted->fit.tracks) replace_curve(move.tracks[track.track], track.speed);
  const Plan after(std::move(move), plan);
  LimitsPlot plot = limits_plot_of(after, check(after));
  add_fitted_curves(plan, after, fitted->fit, plot);
  draw_limits_plot(plot, *arguments.plot, arguments.style);
}

/// What a fault asks for as a rule is not said where something else has been tried and is known to help.
void complain_of_limits(const Plan& plan, const CheckReport& report, const std::optional<Cure>& cure) {
  for (const CheckRefusal& refusal : report.refusals)
    complain(LimitError(refusal.place, cure ? refusal.what : refusal.message()).what());
  if (!cure) return;
  const std::string in_frames =
      cure->frames == plan.move().frames
          ? ""
          : fmt::format(", in {}{}", counted(cure->frames, "frame"), in_proportion(plan.move()));
  complain(fmt::format("{}: note: it fits with {}{}; this was tried", to_string(cure->place), cure->words,
                       in_frames));
}

void complain_of_no_fit(const CheckArguments& arguments, const Plan& plan, const SpeedFit& fit,
                        const Searched& searched) {
  const SmallestFrames& smallest = searched.smallest;
  const std::string place = to_string(plan.move().frames_place);
  complain(fmt::format("{}: error: no speed curve was found for {}: {}", place,
                       counted(plan.move().frames, "frame"), fit.reason));
  if (fit.was_ended && !searched.was_interrupted) {
    complain(fmt::format("{}: note: the search ended after {:g} s; --seconds lets it go on for longer", place,
                         arguments.seconds));
  }
  if (smallest.frames) {
    complain(fmt::format("{}: note: the curve as it is fits in {}{}", place,
                         counted(*smallest.frames, "frame"), in_proportion(plan.move())));
  }
  if (plan.move().frames < fit.fewest.frames) return;  // the reason says so already
  complain(fmt::format("{}: note: in fewer than {} there is none, because of {} of axis {}", place,
                       counted(fit.fewest.frames, "frame"),
                       fit.fewest.by_acceleration ? "max_velocity and max_acceleration" : "max_velocity",
                       in_quotes(plan.rig()->axes[fit.fewest.axis].name)));
}

void refuse_contradictions(const CheckArguments& arguments) {
  for (const char* former : {"given", "fewest"}) {
    if (arguments.frames != former) continue;
    throw UsageError(fmt::format(
        "--frames {}: --frames names frames of the move, for example 20..80; for a fitted move in "
        "the fewest frames write --fit OUT --fewest",
        former));
  }
  if (std::isnan(arguments.seconds)) throw UsageError("--seconds nan: not a number of seconds");
  if (arguments.fit && arguments.frames) {
    throw UsageError("--fit fits the whole move; leave out --frames, or --fit");
  }
  if (arguments.fit && arguments.turns) {
    throw UsageError("--fit writes the move as it is, of one turn; leave out --turns");
  }
}

int check_command(const CheckArguments& arguments) {
  refuse_contradictions(arguments);
  refuse_unknown_picture(arguments.plot);
  refuse_outputs_in_one_place(
      {{"MOVE", arguments.move}, {"--rig", arguments.rig}},
      {{"--json", arguments.json}, {"--plot", arguments.plot}, {"--fit", arguments.fit}});
  if (arguments.json) check_output(*arguments.json);
  if (arguments.fit) check_output(*arguments.fit);
  const Plan plan = make_plan(arguments.move, arguments.rig, Solver::closed_form,
                              {.turns = arguments.turns, .frames = frame_range_argument(arguments.frames)});
  const CheckReport report = check(plan);
  const Searched searched = search(arguments, plan, report);
  const SmallestFrames& smallest = searched.smallest;
  const std::optional<FewestFit>& fitted = searched.fitted;
  if (fitted) write_fitted(arguments, plan, *fitted);
  const SpeedFit* fit = fitted ? &fitted->fit : nullptr;
  if (arguments.json) {
    write_output(*arguments.json, [&](std::FILE* file) {
      JsonWriter json(file);
      json.begin_object();
      write_check(json, plan, report, smallest);
      if (searched.cure) {
        json.object("cure", [&] {
          json.member("line", searched.cure->place.line);
          json.member("with", searched.cure->words);
          json.member("frames", searched.cure->frames);
        });
      }
      if (fitted) write_fit(json, fitted->fit, fitted->move.frames);
      json.end_object();
      json.finish();
    });
  }
  if (arguments.plot) draw_limits(arguments, plan, report, fitted);
  std::FILE* out = summary_stream(arguments.json == "-" || arguments.fit == "-");
  print_check(plan, report, smallest, out);
  if (fit != nullptr) print_fit(plan, *fit, fitted->move.frames, *arguments.fit, out);
  if (fit != nullptr && fit->found) return 0;
  complain_of_limits(plan, report, searched.cure);
  if (fit != nullptr) complain_of_no_fit(arguments, plan, *fit, searched);
  if (searched.was_interrupted) return exit_fault;
  return report.fits() ? 0 : exit_limit;
}

constexpr const char* check_explanation =
    R"(Every moment from the first frame to the last is held against the limits, not samples of it: a peak
is a proven bound, not below the true one and at most 0.001 % above it. Jerk is held only where the rig has a
max_jerk.

A move that starts moving gets a pre-roll from rest, on frames below 0, and one that ends moving a post-roll:
the shortest that keep the limits, one number of frames for all axes.

A step of the velocity (a corner of the path, a break) never fits: no drive can follow it. A step of the
acceleration breaks a max_jerk unless it is within max_acceleration_step; spline = "smooth" has none at its
keys unless the path turns back there (ease, corners), and a speed curve that begins and ends with 0, 0 none
at its ends.

The last line tells in how many frames the move would fit, its locked keys and holds moved in proportion. At
one frame less it was tried and does not fit. Where slowing down cures nothing, it says why. Where another
speed curve with as many control values needs fewer, it tells how many, if such a search is quick (32 values
at most; segments and values, times the axes of the track, 200 at most). --fit OUT --fewest looks for one with
more control values too, and writes the move in the fewest frames.

Where the move does not fit, small changes of it are tried, each by the same proof: keys that are nearly in one
place at one place, ease = true where it is refused, overshoot = false, corners = "ease", a smooth spline,
kinetic = "curves", another speed curve; of a track over frames a key that is written twice, for a rest, and
kinetic = "pace". The first that lets it fit in as many frames is named, or else the one
with which the fewest frames would do.

--frames 20..80 checks a part of the move as what it is when it is played alone: from rest, by a pre-roll into
frame 20 as the move passes it, and by a post-roll out of frame 80 to rest. A part may fit where the whole
does not, and the other way round, where its rolls find no room.

--fit OUT writes the same file with another speed curve, comments and all else kept. It covers the same
distance by the same frames, so that locked keys stay locked; rests stay rests. Where no curve with as many
control values fits, it is given twice as many, and again; a second search begins at a curve that follows the
curvature of the path. Where none is found, it says why, and below how many frames there can be none. After
--seconds, or Ctrl-C, it writes what it has, or says that it has none. With --plot the picture is of the fitted
move, with its speed curves before and after.

A controlled stop from any moment, forward or backward, is proven as well: how long the longest takes, and
that it keeps the stop limits of the rig.

Exit status: 0 the move fits, or --fit found a curve; 3 it does not, and every reason is a line of standard
error; 4 Ctrl-C before --fit had one.

Examples:
  inbetween check move.toml --rig rig.toml                   a table of peaks, and the verdict
  inbetween check move.toml --rig rig.toml --plot limits.svg where the peaks are
  inbetween check move.toml --rig rig.toml --fit slower.toml the move, made to fit
  inbetween check move.toml --rig rig.toml --frames 20..80   a part of it, played alone
  inbetween check move.toml --rig rig.toml --json -          for other programs)";

void describe(CLI::App& app, CheckArguments& arguments) {
  app.add_option("MOVE", arguments.move, "the move: a TOML file with keys, a speed curve and a frame count")
      ->required();
  app.add_option("--rig", arguments.rig, "the rig: gives the axes their limits")->required();
  add_turns(app, arguments.turns);
  add_frames(app, arguments.frames,
             "check a part of the move, 20..80 or 20.. or ..80, with rolls of its own");
  app.add_option("--json", arguments.json, "write everything that was found (- is standard output)");
  app.add_option("--plot", arguments.plot,
                 "draw velocity, acceleration and jerk of every axis with its limits (.svg, .png or .pdf)");
  add_style(app, arguments.style);
  CLI::Option* fit = app.add_option(
      "--fit", arguments.fit,
      "write the move with a speed curve that fits in the same frames, changed as little as can be");
  app.add_option("--start", arguments.start,
                 "what the fitted curve is near to: the drawn one, or one that follows the curvature of the "
                 "path; both "
                 "are tried where nothing is said")
      ->check(CLI::IsMember({"drawn", "curvature"}))
      ->needs(fit);
  app.add_option("--seconds", arguments.seconds, "how long --fit may search; it then writes what it has")
      ->check(CLI::PositiveNumber)
      ->needs(fit)
      ->capture_default_str();
  app.add_flag("--fewest", arguments.fewest,
               "fit in the fewest frames for which a curve is found, not in those of the move")
      ->needs(fit);
  app.footer(check_explanation);
}

}  // namespace

void add_check_command(CLI::App& program, Command& chosen) {
  add_command(program, chosen,
              {"check", "Hold a move against the limits of a rig: is it inside them at every moment?"},
              describe, check_command);
}

}  // namespace inbetween
