// A plan as JSON, as CSV and as the data of a picture (plan_plot.cpp), and its rolls for people.
// docs/formats.md describes the formats.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "host_tools/plot/plot.hpp"

namespace inbetween {

/// The hash of everything that decides the motion, 16 hexadecimal digits. Two files that differ in comments
/// or names only have the same.
std::string hash_in_words(const MoveFile& move);

/// Writes version 1 of the format. The axes' arrays have a value per row of `rows`; the tables of the tracks
/// are always per frame. Axes in no track are left out, in the CSV and the picture too. Memory does not grow
/// with the rows.
void write_plan_json(const Plan& plan, PlanRows rows, std::FILE* file);

/// Writes one line of names with units, then one line per row: frame or tick, time, and the position of every
/// axis of the move. Numbers read back exactly, in the JSON too.
void write_plan_csv(const Plan& plan, PlanRows rows, std::FILE* file);

/// Prints a line for the pre-roll and one for the post-roll, if the move has them. Without a rig the line
/// says that the move would have one. If no roll keeps the limits, it says that `check` tells why.
void print_rolls(const Plan& plan, std::FILE* out);

/// Prints a line about a track whose axes follow a link in space, or the reverse: how far the one can be from
/// the other. Prints nothing about other tracks.
void print_followed(const Plan& plan, std::size_t track, std::string_view indent, std::FILE* out);

/// The data that draw_plot shows. Leaves out axes in no track.
PlotMove plot_of(const Plan& plan);

}  // namespace inbetween
