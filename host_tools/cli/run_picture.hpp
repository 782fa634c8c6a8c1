// From the record of a run to its picture.
#pragma once

#include <string>

#include "host_tools/files/rig_file.hpp"
#include "host_tools/plot/plot_run.hpp"

namespace inbetween {

/// The axes of the rig as its record (run_record.hpp) has them, from where they were first told anything:
/// before that nobody knows where they are. Throws std::runtime_error, one line that starts with the name of
/// the file, where that is not such a record.
RunPlot run_plot_of(const std::string& record, const RigFile& rig);

}  // namespace inbetween
