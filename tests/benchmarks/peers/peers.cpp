// Measures tables of frames beside those of other libraries, in one run:
//   peers [NAME=PROGRAM]...
// A PROGRAM reads a file of cubic Bezier segments and distances along them (see CurveFile), finds the point
// at each distance as accurately as a frame table does, and prints the least seconds of several whole tables
// and then the points, x and y a line. A table in Markdown goes to standard output.
// scripts/update-performance runs it; without any PROGRAM it says which packages bring one. The curves are
// plane ones, because kurbo knows no others.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/benchmarks/subject.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace {

constexpr std::size_t axes = 2;
constexpr double delta = Precision::default_delta;
/// A table is computed again and again for so long, and the least time is taken.
constexpr double seconds_measured = 0.3;
/// Who travels every step within delta is nowhere this far from the drawn place, in mean steps: a peer that
/// is has found something else.
constexpr double max_deviation_in_steps = 1e-2;

/// The positions on all frames, axis after axis, from the keys on.
void solve(Subject& subject, std::span<double> positions) {
  const Track track = subject.make_track();
  track.path().positions(subject.closed_form_of(track).points(), positions);
}

double min_seconds_of(Subject& subject, std::span<double> positions) {
  using Clock = std::chrono::steady_clock;
  double least = std::numeric_limits<double>::infinity();
  for (const auto begin = Clock::now();
       Clock::now() - begin < std::chrono::duration<double>(seconds_measured);) {
    const auto start = Clock::now();
    solve(subject, positions);
    least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return least;
}

/// Writes what a peer reads. A peer need only be accurate to delta of the path between two keys, and not, as
/// a table is, to delta of every step: what none of them offers is not held against them. The file has
/// numbers apart by white space: seconds to measure, the accuracy of a distance, the number of segments, of
/// each its four Bezier points, the number of distances, and these, which rise.
void write_curve_file(const std::string& file, const Track& track) {
  const Path& path = track.path();
  std::ofstream out(file);
  const double accuracy = delta * track.arc_length().total() / path.segment_count();
  fmt::print(out, "{} {}\n{}\n", seconds_measured, accuracy, path.segment_count());
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    std::array<std::array<double, axes>, 4> points{};
    for (std::size_t d = 0; d < axes; ++d) {
      const Cubic& c = path.segment(i)[d];
      points[0][d] = c.c0;
      points[1][d] = c.c0 + c.c1 / 3;
      points[2][d] = c.c0 + (2 * c.c1 + c.c2) / 3;
      points[3][d] = path.segment(i + 1)[d].c0;
    }
    for (const auto& [x, y] : points) fmt::print(out, "{} {} ", x, y);
    fmt::print(out, "\n");
  }
  fmt::print(out, "{}\n", track.frames() + 1);
  for (std::int32_t frame = 0; frame <= track.frames(); ++frame)
    fmt::print(out, "{}\n", track.distance({frame, 0}).high);
  if (!out.flush()) throw std::runtime_error("cannot write " + file);
}

struct Peer {
  std::string name;
  std::string program;
};

Peer peer_of(std::string_view argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string_view::npos)
    throw std::runtime_error(fmt::format("'{}' is no NAME=PROGRAM", argument));
  return {std::string(argument.substr(0, equals)), std::string(argument.substr(equals + 1))};
}

/// The seconds that a peer needs, if its points are those of the table.
double min_seconds_of(const Peer& peer, const std::string& curve_file, std::span<const double> positions,
                      double mean_step) {
  const ProgramRun run = run_command({peer.program, curve_file});
  if (run.status != 0) throw std::runtime_error(fmt::format("{}: {}", peer.name, run.err));
  std::istringstream in(run.out);
  double seconds = 0;
  in >> seconds;
  const std::size_t count = positions.size() / axes;
  for (std::size_t i = 0; i < count; ++i) {
    double x = 0;
    double y = 0;
    if (!(in >> x >> y)) throw std::runtime_error(fmt::format("{}: point {} is missing", peer.name, i));
    const double deviation = std::hypot(x - positions[i], y - positions[count + i]);
    if (!(deviation <= max_deviation_in_steps * mean_step))
      throw std::runtime_error(fmt::format("{}: point {} is {} away", peer.name, i, deviation));
  }
  return seconds;
}

std::string in_units(double seconds) {
  return seconds < 1e-3 ? fmt::format("{:.1f} us", 1e6 * seconds) : fmt::format("{:.2f} ms", 1e3 * seconds);
}

void measure(std::span<const Peer> peers) {
  if (peers.empty()) {
    fmt::print(
        "None is installed here. On Debian librust-kurbo-dev with cargo, and libocct-modeling-data-dev "
        "are measured.\n");
    return;
  }
  fmt::print("| | ours |");
  for (const Peer& peer : peers) fmt::print(" {} | ratio |", peer.name);
  fmt::print("\n|---|---:|");
  for (std::size_t i = 0; i < peers.size(); ++i) fmt::print("---:|---:|");
  fmt::print("\n");
  for (const std::int32_t frames : {240, 100'000}) {
    Subject subject = subject_of(frames, axes);
    std::vector<double> positions(axes * (static_cast<std::size_t>(frames) + 1));
    const double ours = min_seconds_of(subject, positions);
    const Track track = subject.make_track();
    const TemporaryFolder folder;
    const std::string curve_file = folder.path() / "curve.txt";
    write_curve_file(curve_file, track);
    fmt::print("| {} frames, {} keys | {} |", frames, track.path().key_count(), in_units(ours));
    for (const Peer& peer : peers) {
      const double theirs = min_seconds_of(peer, curve_file, positions, track.arc_length().total() / frames);
      fmt::print(" {} | {:.1f} |", in_units(theirs), theirs / ours);
    }
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace inbetween

int main(int argc, char** argv) try {
  std::vector<inbetween::Peer> peers;
  for (const char* argument : std::span(argv, static_cast<std::size_t>(argc)).subspan(1))
    peers.push_back(inbetween::peer_of(argument));
  inbetween::measure(peers);
} catch (const std::exception& error) {
  fmt::print(stderr, "peers: error: {}\n", error.what());
  return 1;
}
