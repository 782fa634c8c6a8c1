// The picture of a run, from its record.
#include "host_tools/cli/run_picture.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace run_picture_test {

using testing::HasSubstr;
using testing::StartsWith;

const std::string nod = in_checkout("examples/nod.toml");
const std::string head = in_checkout("examples/puppet_head.toml");

ProgramRun run_nod(std::vector<std::string> more) {
  more.insert(more.begin(), {"run", nod, "--rig", head, "--sim", "--fast"});
  return run_program(more);
}

TEST(RunPicture, HasWhatTheRecordHas) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "record.csv";
  std::ofstream(record) << "tick,seconds,state,neck,neck actual\n"
                           "0,0.000000,enabling,,1.5\n"
                           "1,0.004000,running,2,1.5\n"
                           "2,0.008000,running,3,1.75\n"
                           "5,0.020000,running,4,3.5\n";
  RigFile rig = read_rig_file(head);
  rig.axes.resize(1);
  const RunPlot plot = read_record(record, &rig).plot;
  ASSERT_EQ(plot.axes.size(), 1U);
  EXPECT_EQ(plot.axes[0].unit, "deg");
  EXPECT_EQ(plot.axes[0].actual.size(), 3U) << "before the drive was on nobody knew where it is";
  ASSERT_EQ(plot.axes[0].commanded.size(), 3U);
  EXPECT_EQ(plot.axes[0].commanded[1].x, 0.008);
  EXPECT_EQ(plot.axes[0].commanded[1].y, 3);
  ASSERT_EQ(plot.axes[0].following_error.size(), 1U) << "not across ticks that are missing";
  EXPECT_EQ(plot.axes[0].following_error[0].y, 2 - 1.75);
}

TEST(RunPicture, APeakInItIsThatOfTheReport) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "record.csv";
  const ProgramRun run = run_nod({"--record", record});
  ASSERT_EQ(run.status, 0) << run.err;
  const RigFile rig = read_rig_file(head);
  const RunPlot plot = read_record(record, &rig).plot;
  for (const RunPlotAxis& axis : plot.axes) {
    double peak = 0;
    for (const Point& point : axis.following_error) peak = std::max(peak, std::fabs(point.y));
    EXPECT_GT(peak, 0);
    EXPECT_THAT(run.out, HasSubstr(fmt::format("{:.4f}  {}", peak, axis.unit))) << axis.name;
  }
}

TEST(RunPicture, IsDrawnInEachFormat) {
  const TemporaryFolder folder;
  for (const auto& [name, magic] : {std::pair("p.svg", "<?xml"), {"p.png", "\x89PNG"}, {"p.pdf", "%PDF"}}) {
    const std::string picture = folder.path() / name;
    const std::string record = folder.path() / (std::string(name) + ".csv");
    const ProgramRun run = run_nod({"--record", record, "--plot", picture, "--style", "dark"});
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_THAT(file_contents(picture), StartsWith(magic));
  }
}

TEST(RunPicture, OfARunInWhichNothingMovedIsEmpty) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "record.csv", picture = folder.path() / "p.svg";
  std::ofstream(record) << "tick,seconds,state,neck,neck actual\n0,0.000000,disarmed,,0\n";
  RigFile rig = read_rig_file(head);
  rig.axes.resize(1);
  draw_run_plot(read_record(record, &rig).plot, picture);
  EXPECT_THAT(file_contents(picture), StartsWith("<?xml"));
}

TEST(RunPicture, WithoutARecordInAFileIsRefusedBeforeAnythingMoves) {
  EXPECT_EQ(run_nod({"--plot", "p.svg"}).status, 2);
  EXPECT_THAT(run_nod({"--plot", "p.svg", "--record", "-"}).err, HasSubstr("add --record FILE"));
  EXPECT_THAT(run_nod({"--plot", "p.bmp", "--record", "r.csv"}).err, HasSubstr("p.bmp"));
}

TEST(RunPicture, OfWhatIsNoRecordIsRefusedAtItsLine) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "record.csv";
  const RigFile rig = read_rig_file(head);
  const std::string first = "tick,seconds,state,frame,neck,neck actual\n";
  for (const auto& [text, where] :
       {std::pair(first + "0,0,ready,,1,2,x\n", ":2: error: "),
        {"frame,time_s,pan\n0,0,1\n", ":1: error: "},
        {"tick,seconds,state,arm,arm actual\n", ":1: error: the rig \"puppet head\" has no axis \"arm\""},
        {"", ":1: error: "}}) {
    std::ofstream(record) << text;
    try {
      read_record(record, &rig);
      ADD_FAILURE() << "was taken";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("record.csv" + std::string(where)));
    }
  }
}

TEST(RunPicture, OfARecordOfYesterdayIsDrawnByPlot) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "3.csv", picture = folder.path() / "3.svg";
  std::ofstream(record) << "tick,seconds,state,neck,neck actual\n0,0,ready,1,1\n1,0.004,running,2,1\n2,0.0";
  const ProgramRun run = run_program({"plot", record, "--rig", head, "--plot", picture});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("3.svg: 2 ticks are drawn")) << "the third was cut off by a full disk";
  EXPECT_THAT(file_contents(picture), StartsWith("<?xml"));
  const ProgramRun gone = run_program({"plot", folder.path() / "4.csv", "--plot", picture});
  EXPECT_EQ(gone.status, 1);
  EXPECT_THAT(gone.err, HasSubstr("4.csv: error: cannot be read: No such file or directory; name a record"));
}

TEST(RunPicture, OfTakesHasANumber) {
  const ProgramRun run = run_nod({"--plot", "%n.svg", "--record", "r.csv"});
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.err, HasSubstr("%n in --plot is the number of a take; add --takes"));
}

}  // namespace run_picture_test
}  // namespace inbetween
