// A move over the bench's CAN, `run` on one side and `sim-drives` on the other, and what the drives recorded.
#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {

struct BusSceneOptions {
  std::string during = "";  ///< bash; $run and $drives are the two processes
  std::vector<std::string> bench = {};
  std::string who = "";  ///< stands before `run`: who it is
  std::string faults = "";
  std::map<std::string, double> standing = {{"slide", 60}, {"pan", -62}, {"tilt", -4}};
  std::string rig = "";            ///< camera_rig.toml
  std::string rig_of_drives = "";  ///< the rig as the drives have it: the same
};

/// The move reveal.toml on camera_rig.toml, or on another rig with the same axes. The drives stand at its
/// start; `during` happens beside it, and three seconds after `run` the drives are ended. The clock of the
/// kernel jumps, so that nothing depends on how loaded this machine is.
struct BusScene {
  ProgramRun run;
  std::string drives;  ///< what they recorded, as it is written

  explicit BusScene(const BusSceneOptions& options);
  explicit BusScene(std::string_view during, const std::vector<std::string>& bench = {},
                    std::string_view who = "")
      : BusScene(BusSceneOptions{.during = std::string(during), .bench = bench, .who = std::string(who)}) {}

  static std::string rig();
  static std::string move();
  /// run with the move and the rig, for `during`.
  static std::string run_command(const std::string& rig = BusScene::rig());

  struct Target {
    std::int64_t at_ns = 0;
    double counts = 0;
  };
  /// The targets that an axis applied.
  [[nodiscard]] const std::vector<Target>& targets(const std::string& axis) const;
  [[nodiscard]] std::vector<double> applied(const std::string& axis) const;
  /// Not a number where there is none.
  [[nodiscard]] double last_velocity(const std::string& axis) const;
  /// The CiA 402 state in which it was at the end.
  [[nodiscard]] std::string last_state(const std::string& axis) const;
  /// When the first fault of the script began; 0 where none has.
  [[nodiscard]] std::int64_t fault_ns() const { return fault_ns_; }

  /// The codes that it sent, without those that say that an error is gone.
  [[nodiscard]] std::vector<std::string> emergencies(const std::string& axis) const;

  void expect_rest() const;
  /// slide, pan and tilt stand, in a state like that.
  void expect_all_stand(const testing::Matcher<std::string>& state) const;
  /// None of the three was told to go anywhere.
  void expect_no_targets() const;
  /// The slide, whose drive has `scale` of its units per axis unit, was on its way and did not go to its end.
  void expect_part_of_path(double scale) const;
  /// Three seconds after `run` every axis rests without power and misses nothing that `run` would send. Those
  /// that had a fault of their own may show it.
  void expect_let_go(const std::vector<std::string>& in_fault = {}) const;
  /// The same, and no drive has ever sent an emergency.
  void expect_quiet() const;
  /// No target but the place where each axis was switched on, or none at all.
  void expect_no_motion() const;
  /// The drive of the axis, with `scale` of its units per axis unit, has applied the plan at every tick,
  /// within `resolution` in axis units, and has sent no emergency.
  void expect_plan(const std::string& axis, double scale, double resolution) const;
  /// From the fault on, these axes leave the path of the plan at no tick, brake no harder than the rig's stop
  /// limits, come to rest within `seconds` and before the end of the move, and stay there.
  void expect_stop_on_path(const std::vector<std::string>& axes, double seconds = 1.5) const;

 private:
  void read_record();

  TemporaryFolder folder_;
  std::map<std::string, std::vector<Target>> targets_;
  std::map<std::string, std::vector<std::string>> ends_;
  std::map<std::string, std::vector<std::string>> emergencies_;
  std::int64_t fault_ns_ = 0;
};

/// A fault of a script, with further lines.
std::string fault_text(const std::string& axis, const std::string& what, const std::string& more = "");

/// What goes wrong with the drive of pan in motion, and what `run` says of it.
struct FaultInMotion {
  std::string what, more, words;
};
/// Each ends a run of this rig with its words. `judge` gets the scene.
template <class Judge>
void expect_faults_said(const std::string& rig, std::initializer_list<FaultInMotion> faults,
                        const Judge& judge) {
  for (const FaultInMotion& fault : faults) {
    SCOPED_TRACE(fault.what);
    const BusScene scene(
        {.faults = fault_text("pan", fault.what, fault.more + "\nafter_motion = 4"), .rig = rig});
    EXPECT_EQ(scene.run.status, 4) << scene.run.err;
    EXPECT_THAT(scene.run.out, testing::HasSubstr("axis \"pan\": " + fault.words));
    judge(scene);
  }
}

/// Column `column` of CSV text without its first line.
std::vector<double> column_of(const std::string& csv, int column);
/// The positions of an axis of the scene at every tick of the plan, and in counts of its drive.
std::vector<double> planned_positions(const std::string& axis);
const std::vector<double>& planned_counts(const std::string& axis);

}  // namespace inbetween
