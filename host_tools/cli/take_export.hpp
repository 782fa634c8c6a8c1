// A take as other files.
#pragma once

#include <cstdint>
#include <string>

#include "host_tools/plot/plot_run.hpp"
#include "host_tools/takes/take_store.hpp"

namespace inbetween {

/// Writes what `run --record` would have written: an actual position that was no whole number of
/// TakeAxis::resolution is off by half of that at most. "-" is standard output. Throws what TakeStore and
/// write_output throw.
void export_take_csv(TakeStore& store, std::int64_t number, const std::string& file);

/// The same as text, for readers of records.
std::string record_of_take(TakeStore& store, std::int64_t number);

/// Writes the trajectory that it played, with proven stops, as `plan --trajectory` does: solved again from
/// the texts that were kept. Throws those, and InputError.
void export_take_trajectory(TakeStore& store, std::int64_t number, const std::string& file);

/// What `run --plot` draws of it.
RunPlot plot_of_take(TakeStore& store, std::int64_t number);

}  // namespace inbetween
