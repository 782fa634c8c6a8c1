#include "tests/support/timing_kinds.hpp"

#include <ostream>

namespace inbetween {
namespace {

std::string keys_of(const std::vector<std::string>& more) {
  const std::vector<std::string> places = {"0, 0", "80, 20", "100, 90", "10, 60"};
  std::string keys = "keys = [";
  for (std::size_t k = 0; k < places.size(); ++k) {
    keys += "{ at = [" + places[k] + "]" + (k < more.size() ? more[k] : "") + " }, ";
  }
  return keys + "]\n";
}
const std::string rests = "speed = [0, 0, 6, 9, 7, 8, 5, 0, 0]\n";
const std::string moves = "speed = [8, 5, 9, 12, 10, 9, 8]\n";
const std::string periodic = "closed = true\nperiodic = true\n";
const std::vector<std::string> at_frames = {", frame = 0", ", frame = 13", ", frame = 30", ", frame = 48"};
const std::string by_frames = "timing = \"frames\"\n" + keys_of(at_frames);
const std::string corners =
    "keys = [{ at = [0, 0] }, { at = [60, 15] }, { at = [-40, -10] }, { at = [20, 5] }]\n";
/// No key at which every axis turns: there a path without overshoot has a corner.
const std::string one_turn =
    "keys = [{ at = [0, 0] }, { at = [80, 20] }, { at = [100, 90] }, { at = [10, 130] }]\n";
/// Evenly in s, so that neither steps.
const std::string even =
    "spline = \"linear\"\ntiming = \"frames\"\nkeys = [{ at = [0, 3], frame = 0 }, { at = "
    "[20, 9], frame = 16 }, { at = [40, 15], frame = 32 }, { at = [60, 21], frame = 48 }]\n";
const std::string uneven =
    "spline = \"linear\"\ntiming = \"frames\"\nkeys = [{ at = [0, 3], frame = 0 }, { at "
    "= [20, 9], frame = 11 }, { at = [40, 15], frame = 30 }, { at = [60, 21], frame = "
    "48 }]\n";

const std::string straight = "spline = \"linear\"\n";
const std::string overlapping = straight + by_frames;
const std::string returning = straight + "timing = \"frames\"\n" +
                              keys_of({", frame = 0", ", frame = 9", ", frame = 25", ", frame = 40"});

}  // namespace

const std::vector<TimingKind>& timing_kinds() {
  static const std::vector<TimingKind> kinds = {
      {.name = "drawn", .track = keys_of({}) + rests},
      {.name = "locked", .track = keys_of({"", ", frame = 17"}) + rests},
      {.name = "held", .track = keys_of({"", ", frame = 14, hold = 6"}) + rests},
      {.name = "eased", .track = "corners = \"ease\"\n" + corners + rests},
      {.name = "eased_ends", .track = keys_of({}) + "speed = [8]\nease_in = 12\nease_out = 9\n"},
      {.name = "rest_at_the_start", .track = keys_of({}) + moves + "rest = \"start\"\n"},
      {.name = "through", .track = keys_of({}) + moves + "through = true\n", .rolls = true},
      {.name = "no_overshoot", .track = one_turn + rests + "overshoot = false\n"},
      {.name = "curves", .track = by_frames, .is_drawn = false},
      {.name = "curves_that_move",
       .track = by_frames + "rest = \"none\"\n",
       .rolls = true,
       .is_drawn = false},
      {.name = "curves_without_overshoot", .track = by_frames + "overshoot = false\n", .is_drawn = false},
      {.name = "curves_of_catmull_rom", .track = by_frames + "spline = \"catmull-rom\"\n", .is_drawn = false},
      {.name = "pace", .track = by_frames + "kinetic = \"pace\"\n", .is_drawn = false},
      {.name = "monotone", .track = uneven + "kinetic = \"monotone\"\n", .rolls = true, .is_drawn = false},
      {.name = "linear", .track = even + "kinetic = \"linear\"\n", .rolls = true, .is_drawn = false},
      {.name = "periodic", .track = keys_of({}) + moves + periodic, .rolls = true},
      {.name = "periodic_locked", .track = keys_of({"", ", frame = 14"}) + moves + periodic, .rolls = true},
      {.name = "periodic_held",
       .track = keys_of({"", ", frame = 14, hold = 6"}) + moves + periodic,
       .rolls = true},
      {.name = "periodic_eased", .track = keys_of({"", ", ease = true"}) + moves + periodic, .rolls = true},
      {.name = "periodic_through",
       .track = keys_of({}) + moves + "through = true\n" + periodic,
       .rolls = true},
      {.name = "periodic_curves",
       .track = "timing = \"frames\"\n" +
                keys_of({", frame = 0", ", frame = 9", ", frame = 25", ", frame = 40"}) + periodic,
       .rolls = true,
       .is_drawn = false},
      {.name = "overlap", .track = overlapping + "overlap = 8\n", .is_drawn = false},
      {.name = "overlap_that_moves",
       .track = overlapping + "overlap = 12\nrest = \"none\"\n",
       .rolls = true,
       .is_drawn = false},
      {.name = "periodic_overlap",
       .track = returning + "overlap = 8\n" + periodic,
       .rolls = true,
       .is_drawn = false},
      {.name = "rounded", .track = straight + "round = 90\n" + keys_of({}) + rests},
      {.name = "rounded_held",
       .track = straight + keys_of({"", ", frame = 14, round = 20, hold = 6", ", round = 90"}) + rests},
      {.name = "periodic_rounded",
       .track = straight + "round = 90\n" + keys_of({}) + moves + periodic,
       .rolls = true},
      {.name = "rounded_pace", .track = overlapping + "kinetic = \"pace\"\nround = 3\n", .is_drawn = false},
  };
  return kinds;
}

MoveFile move_of(const TimingKind& kind) {
  return parse_move("name = \"m\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"x\", \"y\"]\n" + kind.track,
                    kind.name + ".toml");
}

void PrintTo(const TimingKind& kind, std::ostream* out) {
  *out << kind.track;
}

}  // namespace inbetween
