// From the record of a run to its picture.
#pragma once

#include <cstdint>
#include <string>

#include "host_tools/plot/plot_run.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// A record, to be drawn.
struct ReadRecord {
  RunPlot plot;
  std::int64_t ticks = 0;
};

/// The axes that a record names (run_record.hpp; those without frames too), from where they were first told
/// anything: before that nobody knows where they are. Their units are those of the rig, if one is given. A
/// last line that was cut off counts for nothing. Throws std::runtime_error, one line that starts with the
/// name of the file, where that is not such a record, or of another rig.
ReadRecord read_record(const std::string& record, const RigFile* rig = nullptr);

}  // namespace inbetween
