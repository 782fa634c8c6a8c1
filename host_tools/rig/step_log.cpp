#include "host_tools/rig/step_log.hpp"

#include <fmt/format.h>

#include <iterator>

#include "host_tools/text/csv_table.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {

StepLog::StepLog(const std::string& file, const std::vector<RigAxis>& motors, bool waits)
    : log_(file, "seconds,motor,step,dir,steps\n", waits,
           [&motors](const LoggedEdge& edge, std::string& text) {
             fmt::format_to(std::back_inserter(text), "{}.{:09},{},{:d},{:d},{}\n", edge.at_ns / ns_per_s,
                            edge.at_ns % ns_per_s, csv_field(motors[edge.motor].name), edge.step, edge.dir,
                            edge.steps);
           }) {}

}  // namespace inbetween
