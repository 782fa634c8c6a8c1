// A take as rows for other programs.
#pragma once

#include <cstdint>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/exchange/record_table.hpp"
#include "host_tools/scene/axis_rows.hpp"
#include "host_tools/takes/take_store.hpp"

namespace inbetween {

/// A row a tick, as read_record_table reads a record of it, with the units of its rig. Throws what TakeStore
/// and that reader throw.
BakedTable ticks_of_take(TakeStore& store, std::int64_t number, RecordedPositions positions);

/// A row a frame of the move, of the axes that were in a track: where they were when the move first passed
/// it, between two ticks on a straight line. A drive answers in a tick the setpoint of the one before, and an
/// actual position is taken for that. Where the take ended earlier its rows do, with a warning. Throws
/// TakeStoreError, and InputError where it has fewer than two frames.
BakedTable frames_of_take(TakeStore& store, std::int64_t number, RecordedPositions positions);

/// The same rows for a scene. Between two ticks an axis is taken to be on a straight line, so that
/// AxisRow::off is exact: the farthest tick between two frames.
AxisRows rows_of_take(TakeStore& store, std::int64_t number, RecordedPositions positions);

}  // namespace inbetween
