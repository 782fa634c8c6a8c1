#include "tests/support/bus_scene.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <sstream>

#include "host_tools/reference/position_file.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace {

/// An axis of camera_rig.toml: its column in the CSV of plan, and its scale and stop limit.
struct SceneAxis {
  int column;
  double counts_per_unit;
  double stop_acceleration;  ///< unit/s^2, 1.5 times max_acceleration
};
const std::map<std::string, SceneAxis> axes_of_rig{
    {"slide", {2, 1000, 1200}}, {"pan", {3, 4000, 270}}, {"tilt", {4, 4000, 180}}};
constexpr double tick_s = 0.004;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
  return cells;
}

/// Where on the planned path, in ticks, an axis has this many counts. It goes one way only.
double tick_at(const std::vector<double>& planned, double counts) {
  const auto after = std::ranges::upper_bound(planned, counts);
  if (after == planned.begin()) return 0;
  if (after == planned.end()) return static_cast<double>(planned.size() - 1);
  const auto before = after - 1;
  return static_cast<double>(before - planned.begin()) + (counts - *before) / (*after - *before);
}

double between(const std::vector<double>& planned, double tick) {
  const auto before = static_cast<std::size_t>(tick);
  if (before + 1 >= planned.size()) return planned.back();
  const double part = tick - static_cast<double>(before);
  return planned[before] + part * (planned[before + 1] - planned[before]);
}

/// Whoever sets a rig up says where its axes stand, where nobody vouches for their encoders.
std::string placing_command(const std::string& rig, const std::map<std::string, double>& standing) {
  const RigFile read = read_rig_file(rig);
  std::string command;
  for (const std::size_t axis : kept_axes(read)) {
    const auto said = standing.find(read.axes[axis].name);
    if (said != standing.end()) command += fmt::format(" --stands-at {}={}", said->first, said->second);
  }
  return command.empty() ? "" : fmt::format("inbetween goto --rig '{}'{} >/dev/null\n", rig, command);
}

}  // namespace

std::string BusScene::rig() {
  return in_checkout("examples/camera_rig.toml");
}
std::string BusScene::move() {
  return in_checkout("examples/reveal.toml");
}
std::string BusScene::run_command(const std::string& rig) {
  return "inbetween run '" + move() + "' --rig '" + rig + "'";
}

BusScene::BusScene(const BusSceneOptions& options) {
  const std::string record = (folder_.path() / "record.csv").string();
  const std::string err = (folder_.path() / "drives.txt").string();
  const std::string rig = options.rig.empty() ? BusScene::rig() : options.rig;
  const std::string drives_rig = options.rig_of_drives.empty() ? rig : options.rig_of_drives;
  std::string drives_command = "inbetween sim-drives --rig '" + drives_rig + "'";
  for (const auto& [axis, position] : options.standing) {
    drives_command += fmt::format(" --from {}={}", axis, position);
  }
  if (!options.faults.empty()) {
    const std::string faults = (folder_.path() / "faults.toml").string();
    std::ofstream(faults) << options.faults;
    drives_command += " --faults " + faults;
  }
  std::vector<std::string> bench{"--vcan", "can0", "--virtual-time"};
  bench.insert(bench.end(), options.bench.begin(), options.bench.end());
  run = script_in_bench(bench, "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\nexport XDG_STATE_HOME=" +
                                   folder_.path().string() + "\n" + placing_command(rig, options.standing) +
                                   drives_command + " --record " + record + " 2>" + err +
                                   " & drives=$!\nuntil_true grep -q power " + err + "\n" + options.who +
                                   run_command(rig) + " & run=$!\n" + options.during +
                                   "\nstatus=0; wait $run || status=$?\nsleep 3\nkill -TERM $drives; wait "
                                   "$drives; exit $status");
  drives = file_contents(record);
  read_record();
}

/// "slide,123,60000", "slide,state,123,switched on,0.000", "slide,emergency,123,8130",
/// "slide,fault,123,stick", "slide,end,switched on,1640000.056,-0.000,misses nothing"
void BusScene::read_record() {
  std::istringstream lines(drives);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() < 3) {
      ADD_FAILURE() << "a record has the line " << line;
    } else if (cells[1] == "end") {
      ends_[cells[0]] = cells;
    } else if (cells[1] == "state") {
      continue;  // the last of them is in "end"
    } else if (cells[1] == "emergency") {
      if (cells[3] != "0000") emergencies_[cells[0]].push_back(cells[3]);
    } else if (cells[1] == "fault") {
      if (fault_ns_ == 0) fault_ns_ = std::stoll(cells[2]);
    } else {
      targets_[cells[0]].push_back({.at_ns = std::stoll(cells[1]), .counts = std::stod(cells[2])});
    }
  }
}

const std::vector<BusScene::Target>& BusScene::targets(const std::string& axis) const {
  static const std::vector<Target> none;
  const auto found = targets_.find(axis);
  return found == targets_.end() ? none : found->second;
}

std::vector<double> BusScene::applied(const std::string& axis) const {
  std::vector<double> counts;
  for (const Target& target : targets(axis)) counts.push_back(target.counts);
  return counts;
}

double BusScene::last_velocity(const std::string& axis) const {
  return ends_.contains(axis) ? std::stod(ends_.at(axis).at(4)) : std::numeric_limits<double>::quiet_NaN();
}

std::string BusScene::last_state(const std::string& axis) const {
  return ends_.contains(axis) ? ends_.at(axis).at(2) : "";
}

std::vector<std::string> BusScene::emergencies(const std::string& axis) const {
  return emergencies_.contains(axis) ? emergencies_.at(axis) : std::vector<std::string>();
}

void BusScene::expect_let_go(const std::vector<std::string>& in_fault) const {
  ASSERT_EQ(ends_.size(), axes_of_rig.size());
  for (const auto& [axis, end] : ends_) {
    const bool may_be_in_fault = std::ranges::count(in_fault, axis) > 0;
    EXPECT_EQ(end.at(2), may_be_in_fault ? "fault" : "switch-on disabled") << axis;
    EXPECT_NEAR(last_velocity(axis), 0, 1) << axis;
    EXPECT_EQ(end.at(5), "misses nothing") << axis;
  }
}

void BusScene::expect_quiet() const {
  expect_let_go();
  for (const auto& [axis, codes] : emergencies_) {
    EXPECT_TRUE(codes.empty()) << axis << " reported " << codes.front();
  }
}

void BusScene::expect_rest() const {
  for (const auto& [axis, of] : axes_of_rig) EXPECT_NEAR(last_velocity(axis), 0, 1) << axis;
}

void BusScene::expect_plan(const std::string& axis, double scale, double resolution) const {
  const std::vector<double> planned = planned_positions(axis);
  const std::vector<double> given = applied(axis);
  ASSERT_GT(given.size(), planned.size());
  EXPECT_THAT(emergencies(axis), testing::IsEmpty());
  // It holds its place before the move: aligned by where both have gone a hundredth of the path.
  const double far = 0.01 * std::fabs(planned.back() - planned.front());
  std::size_t first = 0, first_planned = 0;
  while (std::fabs(given[first] - given.front()) < far * std::fabs(scale)) ++first;
  while (std::fabs(planned[first_planned] - planned.front()) < far) ++first_planned;
  ASSERT_GE(first, first_planned);
  for (std::size_t tick = 0; tick < planned.size(); ++tick) {
    ASSERT_NEAR(given.at(first - first_planned + tick) / scale, planned[tick], resolution) << "tick " << tick;
  }
}

void BusScene::expect_no_motion() const {
  expect_rest();
  for (const auto& [axis, of] : axes_of_rig) {
    for (const double counts : applied(axis)) ASSERT_EQ(counts, applied(axis).front()) << axis;
  }
}

void BusScene::expect_stop_on_path(const std::vector<std::string>& axes, double seconds) const {
  ASSERT_NE(fault_ns(), 0) << "there was no fault";
  const std::string& leader = axes.front();
  std::map<std::int64_t, double> tick_of_time;
  for (const Target& target : targets(leader)) {
    tick_of_time[target.at_ns] = tick_at(planned_counts(leader), target.counts);
  }
  for (const std::string& axis : axes) {
    const SceneAxis& of = axes_of_rig.at(axis);
    const std::vector<Target>& all = targets(axis);
    ASSERT_GT(all.size(), 1000U) << axis;
    ASSERT_LT(std::fabs(all.back().counts - all.front().counts),
              0.95 * std::fabs(planned_counts(axis).back() - all.front().counts) + 1)
        << axis << " went on to the end";
    // Three roundings to counts are in a second difference.
    const double hardest = of.stop_acceleration * of.counts_per_unit * tick_s * tick_s + 2.01;
    std::int64_t rest_ns = all.front().at_ns;
    for (std::size_t i = 2; i < all.size(); ++i) {
      if (all[i].counts != all[i - 1].counts) rest_ns = all[i].at_ns;
      const double change = all[i].counts - 2 * all[i - 1].counts + all[i - 2].counts;
      ASSERT_LE(std::fabs(change), hardest) << axis << " at " << all[i].at_ns;
      ASSERT_TRUE(tick_of_time.contains(all[i].at_ns)) << axis << " and " << leader << " lost each other";
      ASSERT_NEAR(all[i].counts, between(planned_counts(axis), tick_of_time[all[i].at_ns]), 4)
          << axis << " left the path at " << all[i].at_ns;
    }
    EXPECT_GT(rest_ns, fault_ns()) << axis << " stood before the fault";
    EXPECT_LT(static_cast<double>(rest_ns - fault_ns()) * 1e-9, seconds) << axis;
    EXPECT_GT(all.back().at_ns, rest_ns) << axis << " was let go before it stood";
    EXPECT_NEAR(last_velocity(axis), 0, 1) << axis;
  }
}

void BusScene::expect_all_stand(const testing::Matcher<std::string>& state) const {
  for (const char* axis : {"slide", "pan", "tilt"}) {
    EXPECT_THAT(last_state(axis), state) << axis;
    EXPECT_NEAR(last_velocity(axis), 0, 1e-3) << axis;
  }
}

void BusScene::expect_no_targets() const {
  for (const char* axis : {"slide", "pan", "tilt"}) EXPECT_TRUE(targets(axis).empty()) << axis;
}

void BusScene::expect_part_of_path(double scale) const {
  const std::vector<double> planned = planned_positions("slide");
  const std::vector<double> given = applied("slide");
  ASSERT_FALSE(given.empty());
  const double part = (given.back() - given.front()) / scale / (planned.back() - planned.front());
  EXPECT_GT(part, 0.1);
  EXPECT_LT(part, 0.95);
}

std::string fault_text(const std::string& axis, const std::string& what, const std::string& more) {
  return fmt::format("[[fault]]\naxis = \"{}\"\nwhat = \"{}\"\n{}\n", axis, what, more);
}

std::vector<double> column_of(const std::string& csv, int column) {
  std::vector<double> values;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line))
    values.push_back(std::stod(cells_of(line).at(static_cast<std::size_t>(column))));
  return values;
}

std::vector<double> planned_positions(const std::string& axis) {
  std::vector<double> positions = planned_counts(axis);
  for (double& position : positions) position /= axes_of_rig.at(axis).counts_per_unit;
  return positions;
}

const std::vector<double>& planned_counts(const std::string& axis) {
  static const std::map<std::string, std::vector<double>> counts = [] {
    const std::string csv =
        run_program({"plan", BusScene::move(), "--rig", BusScene::rig(), "--per", "tick", "--csv", "-"}).out;
    std::map<std::string, std::vector<double>> of_axes;
    for (const auto& [name, of] : axes_of_rig) {
      of_axes[name] = column_of(csv, of.column);
      for (double& position : of_axes[name]) position *= of.counts_per_unit;
    }
    return of_axes;
  }();
  return counts.at(axis);
}

}  // namespace inbetween
