#include "tests/support/golden_table.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "tests/support/oracle_curves.hpp"
#include "tests/support/oracle_table.hpp"

namespace inbetween {
namespace {

constexpr const char* header = "track,frame,s,distance,position of each axis";

const toml::array& list(const toml::table& table, const char* field) {
  const toml::array* found = table[field].as_array();
  if (found == nullptr) throw std::runtime_error(fmt::format("no list {}", field));
  return *found;
}

std::vector<double> numbers(const toml::array& list) {
  std::vector<double> all;
  for (const toml::node& node : list) all.push_back(node.value<double>().value());
  return all;
}

std::vector<long double> widened(const std::vector<double>& numbers) {
  return {numbers.begin(), numbers.end()};
}

oracle::Kind kind_of(const std::string& spline) {
  if (spline == "smooth") return oracle::Kind::smooth;
  if (spline == "catmull-rom") return oracle::Kind::catmull_rom;
  if (spline == "tcb") return oracle::Kind::tcb;
  if (spline == "linear") return oracle::Kind::linear;
  throw std::runtime_error("no such spline: " + spline);
}

DrawnTrack drawn_track(const toml::table& table, int frames) {
  DrawnTrack track;
  track.frames = frames;
  track.speed = numbers(list(table, "speed"));
  track.keys.kind = kind_of(table["spline"].value_or<std::string>("smooth"));
  track.keys.closed = table["closed"].value_or(false);
  for (const toml::node& node : list(table, "keys")) {
    const toml::table& key = *node.as_table();
    track.keys.at.push_back(widened(numbers(list(key, "at"))));
    const auto parameter = [&](const char* field) -> long double {
      return static_cast<long double>(key[field].value_or(0.0));
    };
    track.keys.tension_continuity_bias.push_back(
        {parameter("tension"), parameter("continuity"), parameter("bias")});
  }
  if (table.contains("weights")) track.keys.weights = widened(numbers(list(table, "weights")));
  return track;
}

}  // namespace

std::vector<DrawnTrack> read_drawn_tracks(const std::filesystem::path& move) {
  const toml::table root = toml::parse_file(move.string());
  std::vector<DrawnTrack> tracks;
  for (const toml::node& track : list(root, "track")) {
    tracks.push_back(drawn_track(*track.as_table(), root["frames"].value<int>().value()));
  }
  return tracks;
}

std::vector<GoldenRow> golden_table(const std::vector<DrawnTrack>& tracks) {
  std::vector<GoldenRow> golden;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    const DrawnTrack& track = tracks[t];
    const oracle::Path path(track.keys);
    const std::vector<oracle::Row> rows = frame_table(path, oracle::Profile(track.speed), track.frames);
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const oracle::Place& place = rows[j].place;
      GoldenRow row{.track = static_cast<int>(t),
                    .frame = static_cast<int>(j),
                    .s = static_cast<double>(place.segment + place.t),
                    .distance = static_cast<double>(rows[j].distance),
                    .position = {}};
      for (int axis = 0; axis < path.axes(); ++axis) {
        row.position.push_back(static_cast<double>(path.position(place.segment, place.t, axis)));
      }
      golden.push_back(std::move(row));
    }
  }
  return golden;
}

std::string as_csv(const std::vector<GoldenRow>& rows) {
  std::string text = fmt::format("{}\n", header);
  for (const GoldenRow& row : rows) {
    text += fmt::format("{},{},{},{},{}\n", row.track, row.frame, row.s, row.distance,
                        fmt::join(row.position, ","));
  }
  return text;
}

std::vector<GoldenRow> read_golden_csv(const std::filesystem::path& file) {
  std::ifstream lines(file);
  std::string line;
  if (!std::getline(lines, line) || line != header) {
    throw std::runtime_error(file.string() + " does not begin with the header of a golden table");
  }
  std::vector<GoldenRow> rows;
  while (std::getline(lines, line)) {
    std::vector<double> cells;
    for (const char* at = line.c_str();; ++at) {
      char* end = nullptr;
      cells.push_back(std::strtod(at, &end));
      if (end == at || (*end != ',' && *end != '\0')) throw std::runtime_error(file.string() + ": " + line);
      if (*end == '\0') break;
      at = end;
    }
    if (cells.size() < 5) throw std::runtime_error(file.string() + ": " + line);
    rows.push_back({static_cast<int>(cells[0]),
                    static_cast<int>(cells[1]),
                    cells[2],
                    cells[3],
                    {cells.begin() + 4, cells.end()}});
  }
  return rows;
}

std::vector<GoldenRow> timed_golden_table(const std::filesystem::path& move) {
  const toml::table root = toml::parse_file(move.string());
  const int frames = root["frames"].value<int>().value();
  std::vector<GoldenRow> golden;
  for (const toml::node& track : list(root, "track")) {
    std::vector<oracle::TimedKeys> axes;
    for (const toml::node& node : list(*track.as_table(), "keys")) {
      const toml::table& key = *node.as_table();
      const std::vector<double> at = numbers(list(key, "at"));
      axes.resize(at.size());
      for (std::size_t d = 0; d < at.size(); ++d) {
        axes[d].at.push_back(at[d]);
        axes[d].frames.push_back(key["frame"].value<int>().value());
      }
    }
    std::vector<std::vector<oracle::TimedPiece>> curves;
    for (const oracle::TimedKeys& axis : axes) curves.push_back(smooth_curve(axis));
    const int index = golden.empty() ? 0 : golden.back().track + 1;
    for (int frame = 0; frame <= frames; ++frame) {
      GoldenRow row{.track = index, .frame = frame, .position = {}};
      for (const auto& curve : curves) row.position.push_back(static_cast<double>(curve_at(curve, frame, 0)));
      golden.push_back(std::move(row));
    }
  }
  return golden;
}

const std::vector<std::string>& timed_golden_examples() {
  static const std::vector<std::string> names = {"blink"};
  return names;
}

const std::vector<std::string>& golden_examples() {
  static const std::vector<std::string> names = {
      "paper_figure_4", "paper_figure_5", "paper_figure_6", "reveal", "nod",
      "slide_and_pan",  "track_and_focus"};
  return names;
}

}  // namespace inbetween
