// What takes were like, as `inbetween takes` tells it: against the plan, against each other, from day to day.
#pragma once

#include "host_tools/cli/takes_arguments.hpp"

namespace inbetween {

// Each does what its subcommand is for and returns the exit status: exit_limit where a budget is exceeded.
// They throw what TakeStore and the files' readers throw.

int show_errors(const TakesArguments& arguments);
/// Two takes; of three and more each against the first, and the path figures of all.
int compare_takes(const TakesArguments& arguments);
/// Of the takes that are named, or all of the move of the last one.
int plot_trend(const TakesArguments& arguments);

}  // namespace inbetween
