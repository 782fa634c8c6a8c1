// Frame tables of example moves by the oracle alone: what tests/golden/*.csv hold.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/oracle_path.hpp"

namespace inbetween {

/// A track of a move file, as the oracle takes it.
struct DrawnTrack {
  oracle::Keys keys;
  std::vector<double> speed;
  int frames = 0;
};

/// Reads a move file that is known to be good with toml++, without the product's reader.
/// Throws toml::parse_error or std::runtime_error where it is not good.
std::vector<DrawnTrack> read_drawn_tracks(const std::filesystem::path& move);

struct GoldenRow {
  int track = 0;
  int frame = 0;
  double s = 0;
  double distance = 0;
  std::vector<double> position;  ///< per axis of the track
};

/// Every frame of every track, by quadrature and inversion in long double; rounded once, at the end.
std::vector<GoldenRow> golden_table(const std::vector<DrawnTrack>& tracks);

/// The same of a move with timing = "frames" whose tracks are smooth curves that rest at their ends. Its s
/// and its distance are 0: nobody drew a speed.
std::vector<GoldenRow> timed_golden_table(const std::filesystem::path& move);

/// A header and a line per row; numbers read back exactly.
std::string as_csv(const std::vector<GoldenRow>& rows);
/// Throws std::runtime_error for what as_csv would not write.
std::vector<GoldenRow> read_golden_csv(const std::filesystem::path& file);

/// The examples that have a golden table, by the name of both files without the ending.
const std::vector<std::string>& golden_examples();
/// Those of timed_golden_table().
const std::vector<std::string>& timed_golden_examples();

}  // namespace inbetween
