// A move: the performance, as its author wrote it. docs/formats.md is the manual of the file.
//
// Reading checks everything that can be seen in the file alone: types, ranges, counts, fields that exclude
// each other. It does not know the rig, and it does not solve: whether the order of locked keys or the area
// under the speed curve makes sense is for the solver, which finds the places to complain about here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_cue.hpp"
#include "host_tools/rig_model/move_unit.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/text_file.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

inline constexpr std::size_t max_tracks = 64;
inline constexpr std::size_t max_keys = 10'000;  // of a track
inline constexpr std::size_t max_track_axes = 64;
inline constexpr std::size_t max_control_values = 2'048;  // of a speed curve
inline constexpr double max_control_value = 100;
inline constexpr std::size_t max_table_bytes = std::size_t{64} << 20U;  // of a file that `table` names

/// Frames per second; numerator and denominator 1..1 000 000, the quotient at most 1000.
struct WrittenFrameRate {
  FrameRate rate;
  std::string as_written;           // "24", "24000/1001"
  bool written_as_integer = false;  // in the file a number, otherwise text
};

enum class Timing { speed, frames };

/// How the frames of the keys make a motion. `pace` is a speed curve, the others are the core's.
enum class MoveKinetic { linear, curves, pace, monotone };
inline constexpr std::array<std::string_view, 4> kinetic_words{"linear", "curves", "pace", "monotone"};
/// In the order of Spline.
inline constexpr std::array<std::string_view, 4> spline_words{"smooth", "catmull-rom", "tcb", "linear"};

/// The ends of the move at which a track rests.
struct RestingEnds {
  bool start = true;
  bool end = true;
  bool operator==(const RestingEnds&) const = default;
};

/// Which way round an axis with a wrap goes to a key.
struct WayRound {
  bool is_long = false;
  std::optional<std::int32_t> turns;  // more than the short way
  bool operator==(const WayRound&) const = default;
};

struct MoveKey {
  std::vector<double> at;       // one coordinate per axis of the track, in its unit
  std::vector<MoveUnit> units;  // of each coordinate; empty: the unit of the rig
  std::vector<WayRound> ways;   // of each coordinate; empty: the short way
  double tension = 0;           // these three -1..1, 0 unless the spline is tcb
  double continuity = 0;
  double bias = 0;
  std::optional<std::int32_t> frame;  // 0..frames of the move
  bool breaks = false;
  std::optional<std::int32_t> hold;  // 1..frames of the move
  bool ease = false;                 // the speed touches 0 here
  Place place;
  std::vector<Place> at_places;         // of each coordinate
  std::vector<bool> is_left_out;        // of each coordinate: it is that of the drawn curve; empty: none is
  std::optional<std::int32_t> overlap;  // these two in place of those of the track
  std::optional<double> round;
  Place frame_place = {};  // of `frame` and `hold`, where the key has them
  Place hold_place = {};
};

/// How many frames an end of the speed curve takes between rest and what is drawn.
struct EaseRequest {
  std::int32_t frames = 0;  // 0: none
  Place place;
};

/// A word of the file that changes what is played of the speed curve, and what to write for as drawn.
struct CurveRequest {
  Place place;
  std::string_view as_drawn;
};

/// Keys that say where a link of the rig is in the world, and not where the axes are. MoveKey::at has the
/// coordinates that keys have, in this order: x, y, z of the link (m), x, y, z of the point at which it looks
/// (m), its roll (deg). Of a row of points it has x, y, z (m) of each.
struct MoveSpace {
  std::vector<std::string> tips;  // one, or of a network the points of its row
  Place place;
  bool has_at = false;
  bool has_aim = false;
  bool has_roll = false;
  MoveUnit unit = MoveUnit::m;          // of numbers in the file; here they are metres
  std::vector<double> fixed_aim;        // one point for all keys (m); empty: none
  std::optional<std::string> aim_node;  // a link in its place
  Place aim_place;
  std::optional<bool> elbow_up;
  Place elbow_place;
  std::vector<std::optional<double>> near;  // of each axis, in the unit of the rig; empty: none
};

/// A tip whose path is the distance.
struct MoveDistance {
  std::string tip;
  Place place;
};

/// The curve over time that is drawn of one axis of a network.
struct DrawnAxis {
  std::size_t axis = 0;              // of coordinates_of() the track
  std::vector<std::int32_t> frames;  // rising, the first 0, the last that of the move
  std::vector<double> at;            // on each of them, in `unit`
  std::vector<Place> places;         // of each of them
  MoveUnit unit = MoveUnit::of_rig;
};

/// A row of axes, or of points in space, of which some are drawn and the others follow, through their keys
/// (plan/network.hpp).
struct MoveNetwork {
  std::vector<double> places;    // of each axis or point in the row, not falling
  std::vector<DrawnAxis> drawn;  // in the order of the axes, or of the coordinates of the points
  Place place;
  std::vector<std::string> files = {};  // that it was read from, with the folder of the move
};

/// The rows of a file beside the move, which are played as they are (plan/table_track.hpp). The keys of the
/// track are the first row and the last.
struct MoveTable {
  std::string file;                  // with the folder of the move
  std::vector<std::int32_t> frames;  // of each row, rising, the first 0, the last that of the move
  std::vector<double> at;            // row after row, in each the axes of the track
  std::vector<MoveUnit> units;       // of each axis
  std::vector<std::uint32_t> lines;  // of the file, on which each row stands
  Place place;

  [[nodiscard]] Place place_of(std::size_t row) const { return {file, lines[row], 0}; }
};

struct MoveTrack {
  std::vector<std::string> axes;
  std::vector<Place> axis_places;
  std::vector<MoveUnit> units;  // one per axis; empty: the unit of the rig
  std::vector<double> wraps;    // one per axis, in its unit, 0: none; empty: none
  std::vector<double> lap;      // how far beyond key 0 a closed path returns (key_positions.hpp); empty: 0
  Spline spline = Spline::smooth;
  bool closed = false;
  bool periodic = false;                 // the closed path is passed at a speed through its seam
  std::optional<MoveSpace> space;        // the axes follow
  std::optional<MoveDistance> distance;  // in place of weights
  std::optional<MoveNetwork> network;
  std::optional<MoveTable> table;
  std::vector<MoveKey> keys;
  std::vector<double> speed;  // control values 0..100; empty with Timing::frames
  std::vector<Place> speed_places;
  Place speed_place;            // of the whole list; the track's own with Timing::frames
  std::vector<double> weights;  // one per axis, >= 0, not all 0; empty: all 1
  std::vector<Place> weight_places;
  Timing timing = Timing::speed;
  std::optional<MoveKinetic> kinetic;  // only with Timing::frames
  std::optional<RestingEnds> rest;     // absent: of a drawn speed, as drawn; of a table, as its rows
  std::optional<EaseRequest> ease_in, ease_out;
  bool through = false;  // `speed` are values of the curve, not control values
  std::vector<CurveRequest>
      curve_requests;         // rest, ease_in, ease_out, through of a drawn speed, in order of the file
  bool ease_corners = false;  // the speed touches 0 wherever the path turns at once
  bool overshoot = true;      // false: no axis leaves the values of neighbouring keys between them
  std::optional<std::int32_t> overlap;  // frames, of straight lines timed by frames
  std::optional<double> round;          // weighted distance, of a straight path with a speed curve
  Place place;
};

struct MoveFile {
  std::string path;
  std::string name;
  WrittenFrameRate fps;
  std::int32_t frames = 0;  // N: frames 0..N are N + 1 positions
  std::vector<MoveTrack> tracks;
  std::vector<MoveCue> cues = {};  // pulses of a line neither overlap nor touch
  std::optional<Clapper> clapper = {};
  Start start = Start::command;
  Place frames_place;
  Place start_place = {};  // of `start`, if the move has it
};

/// The kinetic of a track with Timing::frames, written or not.
MoveKinetic kinetic_of(const MoveTrack& track);
/// Whether a speed curve says how fast: a drawn one, or a pace.
bool has_speed_curve(const MoveTrack& track);
/// Whether every axis is a curve over time: the keys have frames, and the kinetic is "curves".
bool is_over_time(const MoveTrack& track);

/// For how many frames the actions before and behind a key overlap, and how far from a key the path may pass
/// it, in weighted distance; 0 where nothing is said.
std::int32_t overlap_of(const MoveTrack& track, const MoveKey& key);
double round_of(const MoveTrack& track, const MoveKey& key);
/// Whether the track or one of its keys says so.
bool has_overlap(const MoveTrack& track);
bool has_round(const MoveTrack& track);

/// x, y and z of a point.
inline constexpr std::size_t world_coordinates = 3;
/// Of a point in a row: "brow.x".
std::string coordinate_name(const std::string& tip, std::size_t coordinate);
/// Whether the track is a network of points in space.
bool is_row_of_points(const MoveTrack& track);
/// What a coordinate of a key is called: the axes, or those of MoveSpace.
std::vector<std::string> coordinates_of(const MoveTrack& track);

/// Replaces what is drawn of the track by a curve that is played as it is.
void replace_curve(MoveTrack& track, std::vector<double> control_values);

/// Reads and checks a move. Throws InputError at the first thing that is wrong.
MoveFile read_move_file(const std::filesystem::path& path);

/// The same from text; `file_name` stands in places and in MoveFile::path.
MoveFile parse_move(std::string_view text, const std::string& file_name);
/// The same, with the files that it names from `read`.
MoveFile parse_move_beside(const TextReader& read, std::string_view text, const std::string& file_name);
/// The files that a move names.
std::vector<std::string> files_beside(const MoveFile& move);

}  // namespace inbetween
