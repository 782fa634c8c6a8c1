// The page and the solver hand these to each other by name. Each list below is the only one of its fields on
// this side: the structures are made of it, and so is the table of names and offsets that the page reads when
// it starts. editor/page/src/records.ts is the other side, and refuses a module whose names are not its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace inbetween::editor {

/// A track that shall be solved. Counts are those of the arrays behind it (Session::solve_track).
#define INBETWEEN_TRACK_REQUEST(FIELD, record)     \
  FIELD(record, std::int32_t, spline)              \
  FIELD(record, std::int32_t, kinetic)             \
  FIELD(record, std::int32_t, is_closed)           \
  FIELD(record, std::int32_t, is_periodic)         \
  FIELD(record, std::int32_t, overshoots)          \
  FIELD(record, std::int32_t, rests_at_start)      \
  FIELD(record, std::int32_t, rests_at_end)        \
  FIELD(record, std::int32_t, frames)              \
  FIELD(record, std::int32_t, fps_numerator)       \
  FIELD(record, std::int32_t, fps_denominator)     \
  FIELD(record, std::int32_t, axis_count)          \
  FIELD(record, std::int32_t, key_count)           \
  FIELD(record, std::int32_t, lap_count)           \
  FIELD(record, std::int32_t, weight_count)        \
  FIELD(record, std::int32_t, shape_count)         \
  FIELD(record, std::int32_t, control_value_count) \
  FIELD(record, std::int32_t, lock_count)          \
  FIELD(record, std::int32_t, key_frame_count)     \
  FIELD(record, std::int32_t, corner_count)        \
  FIELD(record, std::int32_t, segment_count)

/// The solved tracks as one move on a rig. Without a rig there are no axes and no motors.
#define INBETWEEN_MOVE_REQUEST(FIELD, record) \
  FIELD(record, std::int32_t, track_count)    \
  FIELD(record, std::int32_t, axis_count)     \
  FIELD(record, std::int32_t, motor_count)    \
  FIELD(record, std::int32_t, rate_hz)

/// The last error, as inbetween::Error names its parts.
#define INBETWEEN_ERROR_REPORT(FIELD, record) \
  FIELD(record, std::int32_t, code)           \
  FIELD(record, std::int32_t, key)            \
  FIELD(record, std::int32_t, axis)           \
  FIELD(record, std::int32_t, control_value)  \
  FIELD(record, std::int32_t, frame)          \
  FIELD(record, std::int32_t, needed)

/// A solved track: the two halves of its table's hash, its sizes, and of its speed curve K and Phi(f).
#define INBETWEEN_TRACK_REPORT(FIELD, record)     \
  FIELD(record, std::int32_t, hash_low)           \
  FIELD(record, std::int32_t, hash_high)          \
  FIELD(record, std::int32_t, frames)             \
  FIELD(record, std::int32_t, segment_count)      \
  FIELD(record, std::int32_t, key_count)          \
  FIELD(record, std::int32_t, piece_count)        \
  FIELD(record, std::int32_t, played_value_count) \
  FIELD(record, double, length)                   \
  FIELD(record, double, constant)                 \
  FIELD(record, double, total_integral)

/// It says what is proven of the move: first and last frame with the rolls, sizes, and the first breach,
/// whose kind is BreachKind counted from 1, and 0 where the move fits. Without limits all but the frames is
/// 0.
#define INBETWEEN_MOVE_REPORT(FIELD, record)     \
  FIELD(record, std::int32_t, first_frame)       \
  FIELD(record, std::int32_t, last_frame)        \
  FIELD(record, std::int32_t, axis_count)        \
  FIELD(record, std::int32_t, motor_count)       \
  FIELD(record, std::int32_t, cell_count)        \
  FIELD(record, std::int32_t, step_count)        \
  FIELD(record, std::int32_t, steps_left_out)    \
  FIELD(record, std::int32_t, stops_are_proven)  \
  FIELD(record, std::int32_t, breach_kind)       \
  FIELD(record, std::int32_t, breach_axis)       \
  FIELD(record, std::int32_t, breach_quantity)   \
  FIELD(record, double, highest_rate)            \
  FIELD(record, double, longest_stop_seconds)    \
  FIELD(record, double, longest_stop_frames)     \
  FIELD(record, double, longest_stop_from_frame) \
  FIELD(record, double, breach_value)            \
  FIELD(record, double, breach_limit)            \
  FIELD(record, double, breach_frame)

#define INBETWEEN_MEMBER(record, type, name) type name;
// Without values of their own, so that the compiler warns of an answer that leaves a field out.
struct TrackRequest {
  INBETWEEN_TRACK_REQUEST(INBETWEEN_MEMBER, track_request)
};
struct MoveRequest {
  INBETWEEN_MOVE_REQUEST(INBETWEEN_MEMBER, move_request)
};
struct ErrorReport {
  INBETWEEN_ERROR_REPORT(INBETWEEN_MEMBER, error_report)
};
struct TrackReport {
  INBETWEEN_TRACK_REPORT(INBETWEEN_MEMBER, track_report)
};
struct MoveReport {
  INBETWEEN_MOVE_REPORT(INBETWEEN_MEMBER, move_report)
};
#undef INBETWEEN_MEMBER

struct Records {
  TrackRequest track_request;
  MoveRequest move_request;
  ErrorReport error_report;
  TrackReport track_report;
  MoveReport move_report;
};
static_assert(std::is_standard_layout_v<Records>, "a field has an offset");

struct RecordField {
  const char* name;    ///< "track_request.spline"
  std::size_t offset;  ///< in Records
  bool is_number;      ///< a double; otherwise an integer of 32 bits
};

#define INBETWEEN_DESCRIPTION(record, type, name)                                                       \
  RecordField{#record "." #name, offsetof(Records, record) + offsetof(decltype(Records::record), name), \
              std::is_same_v<type, double>},
// clang-format off
inline constexpr std::array record_fields{
    INBETWEEN_TRACK_REQUEST(INBETWEEN_DESCRIPTION, track_request)
    INBETWEEN_MOVE_REQUEST(INBETWEEN_DESCRIPTION, move_request)
    INBETWEEN_ERROR_REPORT(INBETWEEN_DESCRIPTION, error_report)
    INBETWEEN_TRACK_REPORT(INBETWEEN_DESCRIPTION, track_report)
    INBETWEEN_MOVE_REPORT(INBETWEEN_DESCRIPTION, move_report)
};
// clang-format on
#undef INBETWEEN_DESCRIPTION

}  // namespace inbetween::editor
