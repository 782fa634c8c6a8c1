#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"
#include "tests/support/temporary_file.hpp"

/// Loops at speed: what a periodic move does at its seam, differentiated from what was sent to the drives.

namespace inbetween {
namespace periodic_move_test {

using Json = nlohmann::json;
using testing::HasSubstr;

AxisText axis_of_table(const std::string& name) {
  return axis_text(name, "mm", {-1000, 1000}, {.velocity = 1000, .acceleration = 4000}, "",
                   R"(type = "pipe", path = "/dev/null", counts_per_unit = 1000)");
}
const std::string rig = rig_text({axis_of_table("x"), axis_of_table("y")}, {.rate_hz = 480});

/// A walk that is quicker on one side, in 48 frames a turn.
std::string loop_of(const std::string& timing) {
  return "name = \"loop\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"x\", \"y\"]\nclosed = true\nperiodic "
         "= "
         "true\n" +
         timing;
}
const std::string drawn = loop_of(
    "keys = [{ at = [0, 0] }, { at = [80, 20] }, { at = [100, 90] }, { at = [10, 60] }]\nspeed = [8, 5, 9, "
    "12, "
    "10, 8]\n");
const std::string by_frames = loop_of(
    "timing = \"frames\"\nkeys = [{ at = [0, 0], frame = 0 }, { at = [80, 20], frame = 9 }, { at = [100, "
    "90], "
    "frame = 25 }, { at = [10, 60], frame = 40 }]\n");

/// The same path with a speed curve that its keys change.
const std::string gentle = "speed = [8, 5, 9, 12, 10, 9, 8]\n";
std::string changed(const std::string& first, const std::string& second, const std::string& more) {
  return loop_of("keys = [{ at = [0, 0]" + first + " }, { at = [80, 20]" + second +
                 " }, { at = [100, 90] }, { at = [10, 60] }]\n" + more);
}
const std::string locked = changed("", ", frame = 14", gentle);
const std::string held = changed("", ", frame = 14, hold = 6", gentle);
const std::string held_at_its_seam = changed(", hold = 6", "", gentle);
const std::string eased = changed("", ", ease = true", gentle);
const std::string eased_at_its_seam = changed(", ease = true", "", gentle);
const std::string through = changed("", "", gentle + "through = true\n");
const std::string cornered = changed("", "", gentle + "spline = \"linear\"\ncorners = \"ease\"\n");

/// The column of a record, every tick.
std::vector<double> column(const std::string& csv, const std::string& name) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<std::string> heads;
  std::istringstream head(line);
  for (std::string word; std::getline(head, word, ',');) heads.push_back(word);
  const auto index = static_cast<std::size_t>(std::ranges::find(heads, name) - heads.begin());
  EXPECT_LT(index, heads.size()) << line;
  std::vector<double> values;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t i = 0; i <= index; ++i) std::getline(cells, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

struct Sent {
  std::vector<double> x, y;
};
Sent sent(const std::string& move, const std::string& turns) {
  const TemporaryFolder folder;
  const std::string csv = (folder.path() / "ticks.csv").string();
  const ProgramRun run = run_on(rig, "plan", move, {"--turns", turns, "--per", "tick", "--csv", csv});
  EXPECT_EQ(run.status, 0) << run.err;
  const std::string text = file_contents(csv);
  return {column(text, "x (mm)"), column(text, "y (mm)")};
}

/// The largest magnitude of the k-th difference in [begin, end).
double largest_difference(std::vector<double> values, int k, std::size_t begin, std::size_t end) {
  for (int i = 0; i < k; ++i) {
    for (std::size_t j = 0; j + 1 < values.size(); ++j) values[j] = values[j + 1] - values[j];
    values.pop_back();
  }
  double largest = 0;
  for (std::size_t j = begin; j < std::min(end, values.size()); ++j) {
    largest = std::max(largest, std::fabs(values[j]));
  }
  return largest;
}

TEST(PeriodicMove, RunsThroughItsSeamsForThreeTurnsWithoutAStep) {
  constexpr std::size_t turn = 48 * 20;  // ticks
  for (const std::string& text :
       {drawn, by_frames, locked, held, held_at_its_seam, eased, eased_at_its_seam, through, cornered}) {
    SCOPED_TRACE(text);
    const Sent three = sent(text, "3");
    const ProgramRun json = run_on(rig, "plan", text, {"--turns", "3", "--json", "-"});
    ASSERT_EQ(json.status, 0) << json.err;
    const Json plan = Json::parse(json.out);
    const std::size_t roll =
        plan["pre_roll"].is_object() ? plan["pre_roll"]["frames"].get<std::size_t>() * 20 : 0;
    const bool rests_at_its_seam = text == held_at_its_seam || text == eased_at_its_seam || text == cornered;
    ASSERT_EQ(roll > 0, !rests_at_its_seam) << json.out.substr(0, 400);
    for (const std::vector<double>& axis : {three.x, three.y}) {
      ASSERT_GT(axis.size(), roll + 3 * turn);
      // Each turn is the same motion, seams included.
      for (std::size_t tick = 0; tick <= turn; ++tick) {
        EXPECT_NEAR(axis[roll + tick], axis[roll + turn + tick], 1e-9) << tick;
        EXPECT_NEAR(axis[roll + tick], axis[roll + 2 * turn + tick], 1e-9) << tick;
      }
      // A step of the velocity would be a second difference, one of the acceleration a third difference, far
      // above those elsewhere on the turn.
      const std::size_t begin = roll + turn / 2;
      for (const int k : {2, 3}) {
        const double elsewhere = largest_difference(axis, k, begin, begin + turn / 2 - 10);
        const double whole = largest_difference(axis, k, roll + 5, roll + turn - 10);
        for (const std::size_t seam : {roll + turn, roll + 2 * turn}) {
          EXPECT_LE(largest_difference(axis, k, seam - 5, seam + 5), 1.5 * std::max(whole, elsewhere) + 1e-12)
              << k;
        }
      }
    }
  }
}

TEST(PeriodicMove, HasOnePreRollAndOnePostRollAndItsStopsAreProvenAcrossTheSeams) {
  const ProgramRun one = run_on(rig, "check", drawn, {"--json", "-"});
  const ProgramRun three = run_on(rig, "check", drawn, {"--turns", "3", "--json", "-"});
  ASSERT_EQ(one.status, 0) << one.err;
  ASSERT_EQ(three.status, 0) << three.err;
  const Json of_one = Json::parse(one.out);
  const Json of_three = Json::parse(three.out);
  for (const std::size_t axis : {0U, 1U}) {
    for (const char* quantity : {"velocity", "acceleration"}) {
      EXPECT_NEAR(of_three["axes"][axis][quantity]["peak"].get<double>() /
                      of_one["axes"][axis][quantity]["peak"].get<double>(),
                  1, 0.02)
          << quantity;
    }
    EXPECT_LE(of_three["stop"]["axes"][axis]["acceleration"]["peak"].get<double>(), 6000);
  }
  EXPECT_TRUE(of_three["steps"].empty());
  EXPECT_GT(of_three["stop"]["longest_s"].get<double>(), 0);
  const ProgramRun run = run_on(rig, "run", drawn, {"--sim", "--fast", "--turns", "3"});
  EXPECT_EQ(run.status, 0) << run.err;
}

/// The cardinal cubic B-spline about 0.
double bell(double x) {
  const double u = std::fabs(x);
  if (u >= 2) return 0;
  return u >= 1 ? (2 - u) * (2 - u) * (2 - u) / 6 : 2.0 / 3 - u * u + u * u * u / 2;
}
/// The integral over [begin, end] of what control value i adds to a periodic curve of f spans: Simpson's
/// rule, exact between knots.
double bell_area(std::size_t i, double begin, double end, std::size_t f) {
  const auto value = [&](double a) {
    double sum = 0;
    for (int turn = -3; turn <= 3; ++turn)
      sum += bell(a - static_cast<double>(i) - turn * static_cast<double>(f));
    return sum;
  };
  double sum = 0;
  while (begin < end) {
    const double next = std::min(end, std::floor(begin) + 1);
    sum += (next - begin) / 6 * (value(begin) + 4 * value((begin + next) / 2) + value(next));
    begin = next;
  }
  return sum;
}

/// The control values nearest to the wanted ones for which the curve has these areas up to these places:
/// dense normal equations, without bounds.
std::vector<double> nearest_periodic(const std::vector<double>& wanted, const std::vector<double>& places,
                                     const std::vector<double>& areas) {
  const std::size_t f = wanted.size() - 1;
  const std::size_t n = places.size();
  std::vector<std::vector<double>> rows(n, std::vector<double>(f));
  std::vector<std::vector<double>> matrix(n, std::vector<double>(n + 1));
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t i = 0; i < f; ++i) rows[r][i] = bell_area(i, 0, places[r], f);
  }
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t i = 0; i < f; ++i) matrix[r][c] += rows[r][i] * rows[c][i];
    }
    matrix[r][n] = areas[r];
    for (std::size_t i = 0; i < f; ++i) matrix[r][n] -= rows[r][i] * wanted[i];
  }
  for (std::size_t c = 0; c < n; ++c) {  // positive definite: no pivoting
    for (std::size_t r = 0; r < n; ++r) {
      if (r == c) continue;
      const double factor = matrix[r][c] / matrix[c][c];
      for (std::size_t k = c; k <= n; ++k) matrix[r][k] -= factor * matrix[c][k];
    }
  }
  std::vector<double> values = wanted;
  for (std::size_t i = 0; i < f; ++i) {
    for (std::size_t r = 0; r < n; ++r) values[i] += rows[r][i] * matrix[r][n] / matrix[r][r];
  }
  values.back() = values.front();
  return values;
}

Json planned(const std::string& text, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words = {"--json", "-"};
  words.insert(words.end(), more.begin(), more.end());
  const ProgramRun run = run_on(rig, "plan", text, words);
  EXPECT_EQ(run.status, 0) << run.err;
  return run.status == 0 ? Json::parse(run.out) : Json();
}

TEST(PeriodicMove, MeetsItsLockedKeysByTheLeastChangeAllRoundTheCurve) {
  // A square of 100 mm, so that the distances are known.
  const std::string square = loop_of(
      "spline = \"linear\"\nkeys = [{ at = [0, 0] }, { at = [100, 0], frame = 10 }, { at = [100, 100] }, { "
      "at = "
      "[0, 100], frame = 38 }]\nspeed = [8, 5, 9, 12, 10, 9, 11, 8]\n");
  const Json plan = planned(square);
  ASSERT_FALSE(plan.is_null());
  const auto x = plan["axes"][0]["position"].get<std::vector<double>>();
  const auto y = plan["axes"][1]["position"].get<std::vector<double>>();
  EXPECT_NEAR(x[10], 100, 1e-7);
  EXPECT_NEAR(y[10], 0, 1e-7);
  EXPECT_NEAR(x[38], 0, 1e-7);
  EXPECT_NEAR(y[38], 100, 1e-7);
  const auto speed = plan["tracks"][0]["speed"].get<std::vector<double>>();
  const std::vector<double> before = {8, 5, 9, 12, 10, 9, 11, 8};
  ASSERT_EQ(speed.size(), before.size());
  double area = 0;
  for (std::size_t i = 0; i + 1 < before.size(); ++i) area += before[i];
  const std::vector<double> nearest =
      nearest_periodic(before, {7 * 10 / 48.0, 7 * 38 / 48.0, 7}, {area / 4, 3 * area / 4, area});
  for (std::size_t i = 0; i < speed.size(); ++i) EXPECT_NEAR(speed[i], nearest[i], 1e-9) << i;
  EXPECT_EQ(speed.front(), speed.back());
}

TEST(PeriodicMove, MeetsRestsAndTouchesItsKeysInEveryTurn) {
  for (const std::string& text : {locked, held, held_at_its_seam, eased, eased_at_its_seam}) {
    SCOPED_TRACE(text);
    const Json plan = planned(text, {"--turns", "3"});
    ASSERT_FALSE(plan.is_null());
    const bool at_seam = text == held_at_its_seam || text == eased_at_its_seam;
    const auto x = plan["axes"][0]["position"].get<std::vector<double>>();
    const auto velocity = plan["axes"][0]["velocity"].get<std::vector<double>>();
    for (std::size_t turn = 0; turn < 3; ++turn) {
      const std::size_t frame = 48 * turn + (at_seam ? 0 : 14);
      const double key = at_seam ? 0 : 80;
      if (text != eased) {
        EXPECT_NEAR(x[frame], key, 1e-7) << frame;
      }
      const bool holds = text == held || text == held_at_its_seam;
      for (std::size_t i = 0; holds && i <= 6; ++i) {
        EXPECT_NEAR(x[frame + i], key, 1e-7) << frame + i;
        EXPECT_NEAR(velocity[frame + i], 0, 1e-7) << frame + i;
      }
      if (text == eased_at_its_seam) {
        EXPECT_NEAR(velocity[frame], 0, 1e-9);
      }
    }
  }
  // Where nobody gave a frame the touch lies between two of them: the speed of the curve is 0 at a knot.
  const Json plan = planned(eased);
  const auto speed = plan["tracks"][0]["speed"].get<std::vector<double>>();
  std::size_t touches = 0;
  for (std::size_t i = 1; i + 1 < speed.size(); ++i) {
    const bool is_touch = speed[i - 1] == 0 && speed[i] == 0 && speed[i + 1] == 0;
    touches += is_touch ? 1U : 0U;
  }
  EXPECT_EQ(touches, 1U);
}

TEST(PeriodicMove, ACurveThroughItsValuesHasThemAllRound) {
  const Json plan = planned(through);
  ASSERT_FALSE(plan.is_null());
  const Json& table = plan["tracks"][0]["table"];
  const std::vector<double> values = {8, 5, 9, 12, 10, 9, 8};
  const double scale = table[0]["speed"].get<double>() / values[0];
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(table[8 * i]["speed"].get<double>() / scale, values[i], 1e-10) << i;
  }
  const auto speed = plan["tracks"][0]["speed"].get<std::vector<double>>();
  EXPECT_EQ(speed.front(), speed.back());
}

TEST(PeriodicMove, IsFittedAndKeepsItsSeamSmooth) {
  for (const std::string& text : {drawn, locked, held_at_its_seam}) {
    SCOPED_TRACE(text);
    const Json before = planned(text);
    double peak = 0;  // between its ends: a roll takes as long as it needs
    for (const Json& axis : before["axes"]) {
      for (const Json& acceleration : axis["acceleration"]) {
        peak = std::max(peak, std::fabs(acceleration.get<double>()));
      }
    }
    // A rig on which it does not fit by a tenth.
    std::string weak = rig;
    const std::string limit = "max_acceleration = 4000";
    for (std::size_t at = weak.find(limit); at != std::string::npos; at = weak.find(limit)) {
      weak.replace(at, limit.size(), "max_acceleration = " + std::to_string(0.92 * peak));
    }
    const TemporaryFolder folder;
    const std::string fitted = (folder.path() / "fitted.toml").string();
    EXPECT_EQ(run_on(weak, "check", text).status, 3);
    const ProgramRun fit = run_on(weak, "check", text, {"--fit", fitted});
    ASSERT_EQ(fit.status, 0) << fit.err;
    for (const char* turns : {"1", "3"}) {
      const ProgramRun check = run_on(weak, "check", file_contents(fitted), {"--turns", turns});
      EXPECT_EQ(check.status, 0) << turns << check.err;
    }
    const ProgramRun run = run_on(weak, "plan", file_contents(fitted), {"--json", "-"});
    const auto speed = Json::parse(run.out)["tracks"][0]["speed"].get<std::vector<double>>();
    EXPECT_EQ(speed.front(), speed.back());
    // Two turns: the acceleration changes at the seam between them as it does elsewhere.
    const std::string csv = (folder.path() / "ticks.csv").string();
    const ProgramRun two = run_on(weak, "plan", file_contents(fitted),
                                  {"--turns", "2", "--per", "tick", "--csv", csv, "--json", "-"});
    ASSERT_EQ(two.status, 0) << two.err;
    const Json plan = Json::parse(two.out);
    const std::size_t roll = plan["pre_roll"].is_object() ? plan["pre_roll"]["frames"].get<std::size_t>() : 0;
    const std::size_t seam = (roll + 48) * 20;
    const std::string ticks = file_contents(csv);
    for (const char* name : {"x (mm)", "y (mm)"}) {
      const std::vector<double> axis = column(ticks, name);
      EXPECT_LE(largest_difference(axis, 3, seam - 5, seam + 5),
                1.5 * largest_difference(axis, 3, seam + 10, seam + 48 * 20 - 10) + 1e-12);
    }
  }
}

TEST(PeriodicMove, IsRefusedWhereItWouldStep) {
  const auto refused = [](const std::string& text, const std::string& words) {
    const TemporaryFile file("move.toml", text);
    const ProgramRun run = run_program({"plan", file.path().string()});
    EXPECT_EQ(run.status, 1);
    EXPECT_THAT(run.err, HasSubstr(words));
  };
  const std::string keys = "keys = [{ at = [0, 0] }, { at = [80, 20] }, { at = [9, 60] }]\n";
  refused(loop_of(keys + "speed = [8, 5, 9]\n"), "the speed is 9 at the end and 8 at the start");
  refused(loop_of(keys + "speed = [8, 8]\nease_in = 4\n"), "has a speed curve without ends");
  refused(loop_of("keys = [{ at = [0, 0] }, { at = [80, 20], frame = 9, break = true }]\nspeed = [8, 8]\n"),
          "would step at the seam too; remove break");
  refused(loop_of("keys = [{ at = [0, 0], frame = 3 }, { at = [80, 20] }]\nspeed = [8, 8]\n"),
          "the first key is met on frame 0");
  refused(loop_of(keys + "speed = [8, 0, 0, 0, 1, 8]\nthrough = true\n"), "goes below 0");
  std::string open = loop_of(keys + "speed = [8, 8]\n");
  open.replace(open.find("closed = true"), 13, "closed = false");
  refused(open, "needs a closed path");
  std::string plain = loop_of(keys + "speed = [8, 8]\n");
  plain.replace(plain.find("periodic = true"), 15, "periodic = false");
  const ProgramRun run = run_on(rig, "run", plain, {"--sim", "--fast", "--turns", "2"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("only a periodic move has turns"));
}

TEST(PeriodicMove, IsShotInNFramesATurnOfWhichFrameNIsFrame0) {
  const ProgramRun once =
      run_on(rig, "run", drawn, {"--sim", "--fast", "--step", "--settle", "0", "--exposure", "0.01"});
  EXPECT_THAT(once.out, HasSubstr("frames 0..48: 49 due, 49 shot\n")) << once.err;
  const ProgramRun loop = run_on(
      rig, "run", drawn, {"--sim", "--fast", "--step", "--loop", "--settle", "0", "--exposure", "0.01"});
  EXPECT_THAT(loop.out, HasSubstr("frames 0..47: 48 due, 48 shot\n")) << loop.err;
  const ProgramRun two =
      run_on(rig, "run", drawn,
             {"--sim", "--fast", "--step", "--turns", "2", "--settle", "0", "--exposure", "0.01"});
  EXPECT_THAT(two.out, HasSubstr("frames 0..95: 96 due, 96 shot\n")) << two.err;
}

TEST(PeriodicMove, ATurntableGoesRoundAndItsCountsGoOn) {
  const std::string move = in_checkout("examples/turntable.toml");
  const std::string table = in_checkout("examples/turntable_rig.toml");
  const ProgramRun run = run_program({"run", move, "--rig", table, "--sim", "--fast", "--turns", "3"});
  EXPECT_EQ(run.status, 0) << run.err;
  const ProgramRun json = run_program({"plan", move, "--rig", table, "--turns", "3", "--json", "-"});
  ASSERT_EQ(json.status, 0) << json.err;
  const Json axis = Json::parse(json.out)["axes"][0];
  const auto position = axis["position"].get<std::vector<double>>();
  const double frames = static_cast<double>(position.size() - 1);
  for (std::size_t frame = 0; frame < position.size(); ++frame) {
    EXPECT_NEAR(position[frame], 1080 * static_cast<double>(frame) / frames, 1e-6) << frame;
  }
  const ProgramRun many = run_program({"run", move, "--rig", table, "--sim", "--fast", "--turns", "1000"});
  EXPECT_EQ(many.status, 3) << "the rig has fewer turns";
}

}  // namespace periodic_move_test
}  // namespace inbetween
