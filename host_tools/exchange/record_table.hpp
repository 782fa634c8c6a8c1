// What `run --record` has written, as a table: a row a tick of the rig.
//
// The format is ours (docs/formats.md, "Record of run"; host_tools/loop/run_record.hpp).
#pragma once

#include <string>
#include <string_view>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {

/// The first columns of such a file.
inline constexpr std::string_view record_head = "tick,seconds,state,";

enum class RecordedPositions : std::uint8_t {
  told,    ///< where the axes were told to be
  actual,  ///< where their drives said that they were
};

/// The ticks on which a move was played; those before and behind them have no frame and are left out. The
/// rate is the whole number that all seconds agree with, where there is only one; otherwise it is asked.
/// Throws InputError at the line where a tick is missing, no rate agrees, an axis has no position, or a
/// second motion begins. O(bytes).
BakedTable read_record_table(std::string_view text, const std::string& file,
                             RecordedPositions positions = RecordedPositions::told);

}  // namespace inbetween
