#include "host_tools/fit/fit_output.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <optional>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

void write_fit(JsonWriter& json, const SpeedFit& fit, std::int32_t frames) {
  json.line();
  json.object("fit", [&] {
    json.member("found", fit.found);
    json.member("was_ended", fit.was_ended);
    json.member("reason", fit.found ? std::nullopt : std::optional(fit.reason));
    json.member("frames", fit.found ? std::optional(frames) : std::nullopt);
    json.member("least_frames", fit.fewest.frames);
    json.objects("tracks", fit.tracks, [&](const TrackFit& track) {
      json.member("track", static_cast<std::int64_t>(track.track));
      json.member("start", track.start == FitStart::curvature ? "curvature" : "drawn");
      json.member("speed", track.speed);
      json.member("change", track.change);
      json.member("change_share", track.change_share);
      json.member("largest_change", track.largest_change);
      json.member("alpha", track.largest_change_at);
      json.member("frame", track.largest_change_frame);
      if (!track.fewer) return;
      json.object("fewer_values", [&] {
        json.member("speed", track.fewer->speed);
        json.member("further_share", track.fewer->further_share);
      });
    });
  });
}

namespace {

/// With the curve itself, where it can be written in place of the drawn one and nothing else has to go.
void print_fewer(const FewerValues& fewer, const MoveTrack& drawn, std::FILE* out) {
  const bool is_alone = !drawn.ease_in && !drawn.ease_out && !drawn.through && !drawn.rest;
  fmt::print(out, "  editable in {} values: {:.2g} % further from yours{}\n", fewer.speed.size(),
             100 * fewer.further_share,
             is_alone ? fmt::format(": speed = [{}]", fmt::join(fewer.speed, ", ")) : "");
}

}  // namespace

void print_fit(const Plan& plan, const SpeedFit& fit, std::int32_t frames, const std::string& file,
               std::FILE* out) {
  if (!fit.found) return;
  const std::string name = file == "-" ? "the file on standard output" : file;
  if (fit.tracks.empty() && frames == plan.move().frames) {
    fmt::print(out, "nothing to change; {} is the move as it is\n", name);
    return;
  }
  for (const TrackFit& track : fit.tracks) {
    const std::size_t before = plan.tracks()[track.track].control_values().size();
    fmt::print(out, "new speed curve of {}: {} control values",
               comma_separated(plan.move().tracks[track.track].axes), track.speed.size());
    if (track.start == FitStart::curvature)
      fmt::print(out, ", from one that follows the curvature of the path");
    if (track.refinements > 0) fmt::print(out, " (the {} of before, refined)", before);
    fmt::print(
        out,
        "; changed by {:.3g} on the whole ({:.1f} % of its mean), most by {:+.3g} at a = {:.2f}, frame "
        "{:.1f}\n",
        track.change, 100 * track.change_share, track.largest_change, track.largest_change_at,
        track.largest_change_frame);
    if (track.fewer) print_fewer(*track.fewer, plan.move().tracks[track.track], out);
  }
  if (fit.was_ended) fmt::print(out, "the search was ended before its end: there may be a nearer curve\n");
  if (frames == plan.move().frames) {
    fmt::print(out, "with it the move fits in its {}: {}\n", counted(frames, "frame"), name);
  } else {
    fmt::print(out, "the move fits in {}, and in one less no curve was found: {}\n", counted(frames, "frame"),
               name);
  }
}

}  // namespace inbetween
