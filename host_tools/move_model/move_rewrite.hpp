// Writes what an editor has changed into a move file and leaves the rest as its author wrote it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "inbetween/path/path.hpp"

namespace inbetween {

/// A key of the edited track. Its words in the file are those of key `from` of the old track, but for what
/// differs.
struct EditedKey {
  std::optional<std::size_t> from = {};  ///< nothing: a new key
  std::vector<double> at = {};           ///< one coordinate for each axis
  double tension = 0;
  double continuity = 0;
  double bias = 0;
  std::optional<std::int32_t> frame = {};
  std::optional<std::int32_t> hold = {};
  bool breaks = false;
  bool ease = false;
  std::optional<std::int32_t> overlap = {};  ///< of the key itself; nothing: as the track says
  std::optional<double> round = {};
};

/// The curve of one axis of a network, as it is drawn anew: in the unit of the rig.
struct EditedCurve {
  std::size_t axis = 0;
  std::vector<std::int32_t> frames;
  std::vector<double> at;
};

struct EditedTrack {
  std::vector<EditedKey> keys;               ///< none: all as they are
  std::optional<std::vector<double>> speed;  ///< control values; nothing: as it is
  Spline spline = Spline::smooth;
  bool closed = false;
  bool in_own_units = false;            ///< coordinates are in the units that the track has in its file
  std::vector<EditedCurve> drawn = {};  ///< of a network; the other curves are as they are
};

/// A whole move as an editor wants it. Whatever is not named here stays.
struct EditedMove {
  std::int32_t frames = 0;
  std::string fps;                  ///< "24", "24000/1001"
  std::vector<EditedTrack> tracks;  ///< as many as the file has
};

/// The move as it is.
EditedMove edits_of(const MoveFile& move);

/// Why the keys of this track cannot be edited; nothing where they can: they have units or turns, are in the
/// world, or stand in sections of their own.
std::optional<std::string> why_keys_are_fixed(std::string_view text, const std::string& file_name,
                                              std::size_t track);

/// Returns `text`, a move, as `edited` has it. All bytes that need not change stay: comments, spacing, line
/// ends, order, fields that an editor knows nothing of. A key keeps the line and the comment that it stands
/// on wherever it goes; a new key is written as its neighbour is. A number that changes is written in the
/// shortest form that reads back to the same double, with a decimal point where the old one had one.
///
/// The result is read again, and is the move that was asked for; otherwise this throws.
///
/// Throws InputError where `text` or what it would become is not a move, and at what cannot be edited, with
/// what to write instead; std::invalid_argument where `edited` is not of this move (tracks, axes, keys that
/// are not there).
std::string with_edits(std::string_view text, const std::string& file_name, const EditedMove& edited);

}  // namespace inbetween
