#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/track.hpp"

/// Moves that are the same on every target, because they are constants of the program.

namespace inbetween::embedded {

inline constexpr std::size_t max_keys = 8;
inline constexpr std::size_t max_axes = 3;
inline constexpr std::size_t max_values = 97;  ///< those that locked keys may refine a curve to
inline constexpr std::size_t max_locks = 2;
inline constexpr std::size_t max_pieces = 1120;  ///< of arc length; beside a rest they are short
inline constexpr std::int32_t max_move_frames = 240;

struct Move {
  std::string_view name;
  Spline spline = Spline::smooth;
  bool closed = false;
  std::int32_t axis_count = 2;
  std::span<const double> keys = {};
  std::span<const double> weights = {};
  std::span<const KeyShape> shapes = {};
  std::span<const double> lap = {};
  std::span<const double> speed = {};
  CurveEnds ends = CurveEnds::natural;
  std::span<const KeyLock> locks = {};            ///< what keys ask of the drawn speed
  std::span<const std::int32_t> key_frames = {};  ///< instead of a speed
  Kinetic kinetic = Kinetic::curves;              ///< with key_frames
  bool rests = true;                              ///< curves, at their ends
  bool overshoot = true;
  std::span<const std::int32_t> overlap_frames = {};  ///< straight lines over frames
  std::span<const double> path_tolerances = {};       ///< a straight path
  std::span<const Cubic> cubics = {};                 ///< curves over frames, in place of keys
  std::span<const FrameKnot> knots = {};              ///< of them
  std::int32_t frames = 72;
  FrameRate fps{24, 1};
  std::int32_t rate_hz = 100;
  double counts_per_unit = 1000;
};

namespace data {
inline constexpr std::array reveal_keys{60.0, -62.0,  -4.0, 420.0, -58.0,  -3.0, 860.0, -30.0,
                                        4.0,  1240.0, 14.0, 9.0,   1640.0, 32.0, 6.0};
inline constexpr std::array reveal_weights{1.0, 6.0, 6.0};
inline constexpr std::array reveal_speed{0.0, 0.0, 3.0, 4.0, 9.0, 12.0, 8.0, 5.0, 0.0, 0.0};

inline constexpr std::array loop_keys{0.0, 0.0, 31.7, 12.0, 40.1, 44.4, 12.5, 60.0, -20.25, 30.0};
inline constexpr std::array loop_speed{5.0, 9.0, 2.0, 5.0};

inline constexpr std::array shaped_keys{0.0,  0.0,  5.0, 22.0, 34.0, 1.0,  50.0, 40.0, -7.0,
                                        70.0, 14.0, 3.0, 96.0, 8.0,  12.0, 124., 30.0, 0.0};
inline constexpr std::array<KeyShape, 6> shapes{
    {{0.3, -0.2, 0.5}, {-0.7, 0.4, 0.1}, {0.0, 1.0, -1.0}, {0.9, 0.0, 0.0}, {0.2, 0.2, 0.2}, {0, 0, 0}}};
inline constexpr std::array shaped_speed{1.0, 8.0, 20.0, 25.0, 20.0, 8.0, 1.0};

inline constexpr std::array corner_keys{0.0, 0.0, 10.0, 0.0, 10.0, 7.5, -3.0, 7.5};
inline constexpr std::array steady_speed{10.0};

/// A tension of 1 at every key: the path stands still there.
inline constexpr std::array<KeyShape, 4> tense_shapes{{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}}};
inline constexpr std::array tense_keys{0.0, 0.0, 33.0, 21.0, 50.0, -10.0, 80.0, 5.0};
inline constexpr std::array tense_speed{0.0, 0.0, 7.0, 11.0, 3.0, 0.0, 0.0};

/// Three control values of zero in a row and more at the ends: the rig rests in the middle of the move.
inline constexpr std::array dwell_speed{0.0, 0.0, 9.0, 9.0, 0.0, 0.0, 0.0, 0.0, 9.0, 4.0, 0.0, 0.0};

/// There and back on one line.
inline constexpr std::array back_keys{0.0, 0.0, 40.0, 20.0, 10.0, 5.0, 30.0, 15.0, -20.0, -10.0};
inline constexpr std::array back_speed{2.0, 6.0, 3.0};

/// The same key three times, in the middle.
inline constexpr std::array repeated_keys{0.0, 0.0, 15.0, 20.0, 15.0, 20.0, 15.0, 20.0, 40.0, 0.0};

inline constexpr std::array lone_key{12.5, -3.0, 99.0};

/// Far from zero, in 24000/1001 frames a second.
inline constexpr std::array far_keys{1'000'000.0, 1'000'012.0, 1'000'030.0, 1'000'031.0};
inline constexpr std::array far_speed{3.0, 3.0, 8.0, 1.0, 0.0, 0.0};

/// Keys on frames: it rests at both ends, and one axis holds its value for a while.
inline constexpr std::array timed_keys{0.0, 0.0, 33.0, 21.0, 50.0, 21.0, 80.0, 5.0, 64.0, -12.0};
inline constexpr std::array<std::int32_t, 5> key_frames{0, 11, 30, 37, 72};
inline constexpr std::array<std::int32_t, 5> overlaps{3, 7, 5, 0, 12};
inline constexpr std::array tolerances{0.0, 1.5, 0.3, 20.0, 0.0};

/// An eyelid: it shuts, stays shut, and opens.
inline constexpr std::array lid_keys{0.0, 25.0, 25.0, -4.0, 6.0};

/// Round and round: one axis goes on by a turn, the other comes back.
inline constexpr std::array turning_keys{0.0, 0.0, 100.0, 7.5, 250.0, -3.0};
inline constexpr std::array one_turn{360.0, 0.0};
inline constexpr std::array turning_speed{8.0, 3.0, 9.0, 12.0, 8.0};
inline constexpr std::array<std::int32_t, 4> turning_frames{0, 17, 31, 60};

/// What keys may ask of a drawn speed: to be met on a frame, to rest there, to touch 0.
inline constexpr std::array<KeyLock, 2> held_locks{
    {{.key = 1, .frame = 19}, {.key = 3, .frame = 40, .hold = 9}}};
inline constexpr std::array<KeyLock, 1> eased_locks{{{.key = 2, .ease = true}}};
inline constexpr std::array<KeyLock, 2> loop_locks{{{.key = 0, .ease = true}, {.key = 2, .frame = 33}}};
/// A line that comes back: with a touch at the turn.
inline constexpr std::array nodding_keys{0.0, 30.0, -15.0, 5.0};
inline constexpr std::array nodding_speed{0.0, 0.0, 6.0, 9.0, 7.0, 8.0, 5.0, 0.0, 0.0};
/// Curves over frames that are solved already, as a network is: two axes, three segments, two of them before
/// the second of three keys.
inline constexpr std::array<Cubic, 6> network_cubics{{{0.0, 0.0, 0.0, 1.0},
                                                      {100.0, 0.0, 0.0, -2.0},
                                                      {1.0, 3.0, 3.0, -2.0},
                                                      {98.0, -6.0, -6.0, 4.0},
                                                      {5.0, 12.0, -48.0, 20.0},
                                                      {90.0, -24.0, 96.0, -40.5}}};
inline constexpr std::array<FrameKnot, 3> network_knots{{{.key = 0, .part = 0, .parts = 32, .length = 16},
                                                         {.key = 0, .part = 16, .parts = 32, .length = 16},
                                                         {.key = 1, .part = 0, .parts = 64, .length = 64}}};
inline constexpr std::array<std::int32_t, 3> network_frames{0, 8, 24};
/// The values of a pace, which a host has found, as a drawn speed.
inline constexpr std::array pace_speed{0.0, 0.0,  1.25, 4.75, 11.5,  21.0, 30.25, 33.5, 24.0,
                                       9.5, 3.75, 8.0,  19.5, 22.25, 12.0, 3.0,   0.0,  0.0};
}  // namespace data

inline constexpr std::array moves{
    Move{.name = "reveal",
         .axis_count = 3,
         .keys = data::reveal_keys,
         .weights = data::reveal_weights,
         .speed = data::reveal_speed,
         .frames = 192,
         .rate_hz = 250},
    Move{.name = "closed_loop",
         .spline = Spline::catmull_rom,
         .closed = true,
         .keys = data::loop_keys,
         .speed = data::loop_speed,
         .frames = 48},
    Move{.name = "closed_smooth",
         .closed = true,
         .keys = data::loop_keys,
         .speed = data::steady_speed,
         .frames = 50,
         .fps = {25, 1}},
    Move{.name = "shaped",
         .spline = Spline::tcb,
         .axis_count = 3,
         .keys = data::shaped_keys,
         .shapes = data::shapes,
         .speed = data::shaped_speed},
    Move{.name = "corners",
         .spline = Spline::linear,
         .keys = data::corner_keys,
         .speed = data::steady_speed,
         .frames = 30},
    Move{.name = "tension_1",
         .spline = Spline::tcb,
         .keys = data::tense_keys,
         .shapes = data::tense_shapes,
         .speed = data::tense_speed,
         .frames = 60,
         .counts_per_unit = 1048576.0 / 80.0},
    Move{.name = "dwell", .keys = data::tense_keys, .speed = data::dwell_speed, .frames = 90},
    Move{.name = "there_and_back", .keys = data::back_keys, .speed = data::back_speed, .frames = 40},
    Move{.name = "same_key_thrice",
         .spline = Spline::tcb,
         .keys = data::repeated_keys,
         .speed = data::back_speed,
         .frames = 40},
    Move{.name = "one_key", .axis_count = 3, .keys = data::lone_key, .speed = data::back_speed, .frames = 10},
    Move{.name = "far_away",
         .spline = Spline::catmull_rom,
         .axis_count = 1,
         .keys = data::far_keys,
         .speed = data::far_speed,
         .frames = 100,
         .fps = {24000, 1001}},
    Move{.name = "curves", .keys = data::timed_keys, .key_frames = data::key_frames},
    Move{.name = "turntable",
         .closed = true,
         .keys = data::turning_keys,
         .lap = data::one_turn,
         .speed = data::turning_speed,
         .ends = CurveEnds::periodic,
         .frames = 60},
    Move{.name = "locked_and_held",
         .keys = data::timed_keys,
         .speed = data::nodding_speed,
         .locks = data::held_locks},
    Move{.name = "eased",
         .axis_count = 1,
         .keys = data::nodding_keys,
         .speed = data::nodding_speed,
         .locks = data::eased_locks,
         .frames = 60},
    Move{.name = "loop_with_locks",
         .closed = true,
         .keys = data::turning_keys,
         .lap = data::one_turn,
         .speed = data::turning_speed,
         .ends = CurveEnds::periodic,
         .locks = data::loop_locks,
         .frames = 60},
    Move{.name = "loop_of_curves",
         .closed = true,
         .keys = data::turning_keys,
         .lap = data::one_turn,
         .key_frames = data::turning_frames,
         .rests = false,
         .frames = 60},
    Move{.name = "no_overshoot", .keys = data::timed_keys, .speed = data::nodding_speed, .overshoot = false},
    Move{.name = "curves_without_overshoot",
         .axis_count = 1,
         .keys = data::lid_keys,
         .key_frames = data::key_frames,
         .overshoot = false},
    Move{.name = "monotone",
         .keys = data::timed_keys,
         .key_frames = data::key_frames,
         .kinetic = Kinetic::monotone},
    Move{.name = "linear_in_time",
         .spline = Spline::linear,
         .keys = data::timed_keys,
         .key_frames = data::key_frames,
         .kinetic = Kinetic::linear},
    Move{.name = "overlapping",
         .spline = Spline::linear,
         .keys = data::timed_keys,
         .key_frames = data::key_frames,
         .overlap_frames = data::overlaps},
    Move{.name = "rounded",
         .spline = Spline::linear,
         .keys = data::timed_keys,
         .speed = data::nodding_speed,
         .path_tolerances = data::tolerances},
    Move{.name = "network",
         .key_frames = data::network_frames,
         .cubics = data::network_cubics,
         .knots = data::network_knots,
         .frames = 24},
    Move{.name = "pace", .keys = data::timed_keys, .speed = data::pace_speed},
};

}  // namespace inbetween::embedded
