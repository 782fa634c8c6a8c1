// The pictures of a plan: files of the right kind, numbers that read well, and nothing lost or off the page.
#include "host_tools/plot/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/plot/plot_line.hpp"
#include "host_tools/plot/plot_scale.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace plot_test {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::Le;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

std::string svg_of(const PlotMove& move) {
  const TemporaryFolder folder;
  draw_plot(move, folder.path() / "move.svg");
  return contents(folder.path() / "move.svg");
}

template <class Action>
std::string words_of_error(Action action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

PlotMove empty_move(std::int32_t frames) {
  PlotMove move;
  move.name = "reveal";
  move.frame_rate = "24";
  move.frames_per_second = 24;
  move.frames = frames;
  move.part = {0, frames};
  move.last_frame = frames;
  return move;
}

PlotAxis still_axis(std::string name, std::int32_t frames, double position) {
  return {
      std::move(name), "deg", std::vector<double>(static_cast<std::size_t>(frames) + 1, position), {}, {}};
}

// A track whose axis d goes from 0 to ends[d] in a straight line at constant speed.
void add_straight_track(PlotMove& move, const std::vector<double>& ends) {
  PlotTrack track;
  double length = 0;
  for (std::size_t d = 0; d < ends.size(); ++d) {
    PlotAxis axis{"axis " + std::to_string(move.axes.size()), "mm", {}, {}, {}};
    for (std::int32_t j = 0; j <= move.frames; ++j) axis.positions.push_back(ends[d] * j / move.frames);
    track.axes.push_back(move.axes.size());
    track.path.push_back({0, ends[d]});
    track.tangents.emplace_back(axis.positions.size(), ends[d]);
    track.keys.push_back({0, ends[d]});
    move.axes.push_back(std::move(axis));
    length = std::hypot(length, ends[d]);
  }
  track.key_frames = {0, static_cast<double>(move.frames)};
  track.control_values = {4, 4};
  track.curve = {4, 4, 4};
  track.speed_unit = "mm/s";
  track.speed.assign(static_cast<std::size_t>(move.frames) + 1,
                     length * move.frames_per_second / move.frames);
  move.tracks.push_back(std::move(track));
}

PlotMove straight_move(std::int32_t frames, const std::vector<double>& ends) {
  PlotMove move = empty_move(frames);
  add_straight_track(move, ends);
  return move;
}

// The outlines that are drawn on the page, without the letters' shapes, which stand in <defs>.
std::vector<std::string> shapes_of(const std::string& svg) {
  std::vector<std::string> shapes;
  const std::string_view beginning = " d=\"";
  for (auto at = svg.find(beginning, svg.find("</defs>")); at != std::string::npos;
       at = svg.find(beginning, at)) {
    at += beginning.size();
    shapes.push_back(svg.substr(at, svg.find('"', at) - at));
  }
  return shapes;
}

std::vector<double> numbers_of(const std::string& shape) {
  std::vector<double> numbers;
  for (const char* at = shape.c_str(); *at != '\0';) {
    char* end = nullptr;
    const double number = std::strtod(at, &end);
    if (end != at) numbers.push_back(number);
    at = end != at ? end : at + 1;
  }
  return numbers;
}

std::size_t count(const std::string& text, char wanted) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), wanted));
}

std::size_t count_of(const std::string& text, std::string_view wanted) {
  std::size_t found = 0;
  for (auto at = text.find(wanted); at != std::string::npos; at = text.find(wanted, at + 1)) ++found;
  return found;
}

double page_height(const std::string& svg) {
  return std::stod(svg.substr(svg.find("height=\"") + 8));
}

void expect_all_on_the_page(const std::string& svg) {
  const double height = page_height(svg);
  for (const std::string& shape : shapes_of(svg)) {
    const auto numbers = numbers_of(shape);
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
      ASSERT_THAT(numbers[i], AllOf(Ge(0), Le(1400))) << shape.substr(0, 200);
      ASSERT_THAT(numbers[i + 1], AllOf(Ge(0), Le(height))) << shape.substr(0, 200);
    }
  }
}

// --- which kind of picture ---

TEST(PictureFormat, FollowsTheEndingInUpperOrLowerCase) {
  EXPECT_EQ(picture_format("a.svg"), PictureFormat::svg);
  EXPECT_EQ(picture_format("some.where/a.b.PNG"), PictureFormat::png);
  EXPECT_EQ(picture_format("a.Pdf"), PictureFormat::pdf);
}

TEST(PictureFormat, AnUnknownEndingIsRefusedWithTheOnesThatAreKnown) {
  const std::string words = words_of_error([] { static_cast<void>(picture_format("out/move.bmp")); });
  EXPECT_THAT(words, StartsWith("out/move.bmp: "));
  EXPECT_THAT(
      words, AllOf(HasSubstr(".svg, .png or .pdf"), HasSubstr(".bmp is none of them"), Not(HasSubstr("\n"))));
}

TEST(PictureFormat, ANameWithoutAnEndingIsRefused) {
  const std::string words = words_of_error([] { static_cast<void>(picture_format("some.where/svg")); });
  EXPECT_THAT(words, HasSubstr("some.where/svg: the name of a picture ends in .svg, .png or .pdf"));
}

// --- files ---

TEST(Plot, EveryFormatBeginsAsItMust) {
  const TemporaryFolder folder;
  const PlotMove move = straight_move(48, {100, 40});
  for (const char* name : {"move.svg", "move.png", "move.pdf"}) draw_plot(move, folder.path() / name);
  EXPECT_THAT(contents(folder.path() / "move.svg"), StartsWith("<?xml"));
  EXPECT_THAT(contents(folder.path() / "move.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(contents(folder.path() / "move.png"), StartsWith("\x89PNG\r\n\x1a\n"));
  EXPECT_THAT(contents(folder.path() / "move.pdf"), StartsWith("%PDF-"));
  EXPECT_THAT(contents(folder.path() / "move.pdf"), HasSubstr("%%EOF"));
}

TEST(Plot, AnSvgTellsTheNamesOfTheMoveAndOfEveryAxis) {
  PlotMove move = straight_move(48, {100, 40});
  move.name = "pan & <tilt>";
  move.axes[0].name = "track";
  move.axes[1].name = "Höhe\x01";
  const std::string svg = svg_of(move);
  EXPECT_THAT(svg, HasSubstr("<title>pan &amp; &lt;tilt&gt;</title>"));
  EXPECT_THAT(svg,
              HasSubstr("48 frames  ·  24 fps  ·  2 s  ·  1 track; axes: track, Höhe\xEF\xBF\xBD</desc>"));
}

TEST(Plot, TheSameMoveTwiceGivesTheSameSvgBytes) {
  const PlotMove move = straight_move(48, {100, 40, 7});
  EXPECT_EQ(svg_of(move), svg_of(move));
}

TEST(Plot, AFolderThatIsNotThereIsNamedInOneLine) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "no/such/folder/move.png";
  const std::string words = words_of_error([&] { draw_plot(straight_move(4, {1}), file); });
  EXPECT_THAT(words, StartsWith(file.string() +
                                ": error: cannot be written: No such file or directory; choose a folder"));
  EXPECT_THAT(words, Not(HasSubstr("\n")));
}

TEST(Plot, AFullDiskIsReported) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const TemporaryFolder folder;
  const auto file = folder.path() / "move.svg";
  std::filesystem::create_symlink("/dev/full", file);
  const std::string words = words_of_error([&] { draw_plot(straight_move(4, {1}), file); });
  EXPECT_THAT(
      words, StartsWith(file.string() + ": error: could not be written completely: No space left on device"));
}

TEST(Plot, APageTooTallForPngIsRefusedWithTheRemedyAndFitsAnSvg) {
  const TemporaryFolder folder;
  PlotMove move = empty_move(2);
  for (int i = 0; i < 90; ++i) add_straight_track(move, {1});
  const std::string words = words_of_error([&] { draw_plot(move, folder.path() / "move.png"); });
  EXPECT_THAT(
      words, AllOf(HasSubstr("move.png: "), HasSubstr("PNG ends at 32767"), HasSubstr("write .svg or .pdf")));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "move.png"));
  EXPECT_GT(page_height(svg_of(move)), 32767);
}

TEST(Plot, ContradictingDataAreTheCallersMistake) {
  const TemporaryFolder folder;
  const auto refused = [&](auto change) {
    PlotMove move = straight_move(4, {1, 2});
    change(move);
    EXPECT_THROW(draw_plot(move, folder.path() / "move.svg"), std::invalid_argument);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "move.svg"));
  };
  refused([](PlotMove& m) { m.frames = 0; });
  refused([](PlotMove& m) { m.frames_per_second = 0; });
  refused([](PlotMove& m) { m.axes.clear(); });
  refused([](PlotMove& m) { m.axes[1].positions.pop_back(); });
  refused([](PlotMove& m) { m.axes[1].positions[2] = std::numeric_limits<double>::quiet_NaN(); });
  refused([](PlotMove& m) { m.axes[0].maximum = std::numeric_limits<double>::infinity(); });
  refused([](PlotMove& m) { m.tracks[0].axes[1] = 2; });
  refused([](PlotMove& m) { m.tracks[0].path[1].pop_back(); });
  refused([](PlotMove& m) { m.tracks[0].tangents.pop_back(); });
  refused([](PlotMove& m) { m.tracks[0].keys[0].push_back(1); });
  refused([](PlotMove& m) { m.tracks[0].key_frames.clear(); });
  refused([](PlotMove& m) { m.tracks[0].curve.clear(); });
  refused([](PlotMove& m) { m.tracks[0].speed.push_back(1); });
}

// --- what is drawn ---

TEST(Plot, ATickCrossesThePathAtEveryFrame) {
  const auto shapes = shapes_of(svg_of(straight_move(30, {100, 10})));
  // Each tick is one "M x y L x y" of a single shape, 12 pixels long and square to the path.
  const auto ticks =
      std::find_if(shapes.begin(), shapes.end(), [](const std::string& s) { return count(s, 'M') == 31; });
  ASSERT_NE(ticks, shapes.end());
  const auto numbers = numbers_of(*ticks);
  ASSERT_THAT(numbers, SizeIs(31 * 4));
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    const double dx = numbers[i + 2] - numbers[i];
    const double dy = numbers[i + 3] - numbers[i + 1];
    EXPECT_NEAR(std::hypot(dx, dy), 12, 0.02);
    EXPECT_NEAR(dx * 100 - dy * 10, 0, 1);  // one scale for both axes; the page's y points down
  }
}

TEST(Plot, AxesOfDifferentUnitsHaveScalesOfTheirOwn) {
  PlotMove move = straight_move(30, {100, 600});
  move.axes[1].unit = "deg";
  const auto shapes = shapes_of(svg_of(move));
  const auto ticks =
      std::find_if(shapes.begin(), shapes.end(), [](const std::string& s) { return count(s, 'M') == 31; });
  ASSERT_NE(ticks, shapes.end());
  const auto numbers = numbers_of(*ticks);
  // Both directions fill the panel: the path crosses at least 400 x 200 pixels.
  EXPECT_GT(numbers[120] - numbers[0], 400);
  EXPECT_GT(numbers[1] - numbers[121], 200);
}

TEST(Plot, ALimitNearTheMotionIsADashedLineAndOneFarAwayIsNot) {
  PlotMove move = straight_move(30, {100, 40});
  const std::size_t without = count_of(svg_of(move), "stroke-dasharray:");
  move.axes[0].minimum = -20;
  move.axes[0].maximum = 110;
  move.axes[1].minimum = -1e6;
  EXPECT_EQ(count_of(svg_of(move), "stroke-dasharray:"), without + 2);
}

TEST(Plot, ASpeedThatDoesNotFollowTheCurveIsDrawnBesideIt) {
  PlotMove move = straight_move(30, {100, 40});
  const std::size_t without = count_of(svg_of(move), "stroke-dasharray:");
  for (std::size_t j = 15; j <= 30; ++j) move.tracks[0].speed[j] *= 1.3;
  EXPECT_EQ(count_of(svg_of(move), "stroke-dasharray:"), without + 1);
}

/// Two axes a track, timed by frames, and tips that walk along.
PlotMove puppet_move(std::size_t tracks, std::size_t tips) {
  PlotMove move = empty_move(96);
  for (std::size_t t = 0; t < tracks; ++t) {
    add_straight_track(move, {40, -25});
    move.tracks.back().control_values.clear();
    move.tracks.back().curve.clear();
  }
  for (std::size_t i = 0; i < tips; ++i) {
    PlotTip tip{.name = "hand", .places = {}, .postures = {}};
    for (int frame = 0; frame <= move.frames; ++frame) tip.places.push_back({0.01 * frame, 0.1, 0.5});
    tip.postures.push_back({.frame = 0, .tip = tip.places[0], .view = {1, 0, 0}, .bones = {}});
    tip.postures.back().bones.push_back({{0, 0, 0}, tip.places[0]});
    move.tips.push_back(tip);
  }
  return move;
}

/// The upper end of the first row of an axis over time, which is as wide as nothing else on the page.
double top_of_positions(const std::string& svg) {
  double top = 1e9;
  for (const std::string& shape : shapes_of(svg)) {
    const auto numbers = numbers_of(shape);
    if (numbers.size() != 10) continue;  // four corners, and the first again
    double left = 1e9, right = 0, upper = 1e9;
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
      left = std::min(left, numbers[i]);
      right = std::max(right, numbers[i]);
      upper = std::min(upper, numbers[i + 1]);
    }
    if (std::abs(right - left - 1002) < 2) top = std::min(top, upper);
  }
  return top;
}

TEST(Plot, OfAPuppetBeginsWithItsAxesOverTimeAndStaysOnASheet) {
  constexpr double sheet = 1400 * 1.4143;  // A4, upright
  for (const auto& [tracks, tips] : {std::pair<std::size_t, std::size_t>{2, 0}, {7, 4}, {32, 8}}) {
    const std::string svg = svg_of(puppet_move(tracks, tips));
    EXPECT_LE(page_height(svg), sheet) << tracks;
    EXPECT_LT(top_of_positions(svg), 200) << tracks;
    expect_all_on_the_page(svg);
  }
  const std::string drawn = svg_of(straight_move(96, {100, 40, 20, 10, 10, 10}));
  EXPECT_GT(top_of_positions(drawn), 600) << "the path comes first where a speed is drawn";
}

TEST(Plot, WhereATipLooksIsAnArrowAndItsTargetACrossAtTheEndOfADashedLine) {
  PlotMove move = straight_move(96, {100, 40});
  move.tips = puppet_move(2, 1).tips;
  move.tips[0].postures[0].view = {};
  const std::string blind = svg_of(move);
  move.tips[0].postures[0].view = {1, 0, 0};
  const std::string looking = svg_of(move);
  EXPECT_GT(shapes_of(looking).size(), shapes_of(blind).size());
  move.tips[0].postures[0].aim = {2, 0.1, 0.5};
  const std::string aimed = svg_of(move);
  constexpr std::size_t views = 3;
  EXPECT_EQ(count_of(aimed, "stroke-dasharray:"), count_of(looking, "stroke-dasharray:") + views);
  expect_all_on_the_page(aimed);
}

TEST(Plot, TicksThatWouldRunTogetherAreThinnedToARoundNumberOfFrames) {
  const auto shapes = shapes_of(svg_of(straight_move(1000, {100, 40})));
  // About 550 pixels of path at no less than 4.5 pixels a tick: every 10th of 1000 frames.
  EXPECT_TRUE(
      std::any_of(shapes.begin(), shapes.end(), [](const std::string& s) { return count(s, 'M') == 101; }));
  EXPECT_FALSE(
      std::any_of(shapes.begin(), shapes.end(), [](const std::string& s) { return count(s, 'M') > 101; }));
}

TEST(Plot, AStripeIsAsWideAsTheDistanceTravelledInItsFrame) {
  PlotMove move = straight_move(4, {100});
  move.tracks[0].speed = {0, 2, 4, 6,
                          8};  // trapezoids 1, 3, 5, 7: the even frames have 1/16 and 5/16 of the path
  std::vector<double> widths;
  for (const std::string& shape : shapes_of(svg_of(move))) {
    const auto numbers = numbers_of(shape);
    if (numbers.size() < 8 || count(shape, 'Z') != 2) continue;
    for (std::size_t i = 0; i + 7 < numbers.size(); i += 8) widths.push_back(numbers[i + 2] - numbers[i]);
  }
  ASSERT_THAT(widths, SizeIs(2));
  EXPECT_NEAR(widths[1] / widths[0], 5, 0.01);
  EXPECT_NEAR(widths[0], 1296 / 16.0, 0.5);
}

TEST(Plot, AHundredThousandFramesWithNoiseStaySmallAndOnThePage) {
  PlotMove move = straight_move(100'000, {100, 40, 20});
  std::mt19937 random(1989);
  std::uniform_real_distribution<double> noise(0, 30);
  for (PlotAxis& axis : move.axes) {
    for (double& position : axis.positions) position += noise(random);
  }
  for (double& speed : move.tracks[0].speed) speed *= 1 + noise(random);
  const std::string svg = svg_of(move);
  EXPECT_LT(svg.size(), 1'500'000U);
  expect_all_on_the_page(svg);
}

struct Degenerate {
  const char* name;
  PlotMove move;
};

std::ostream& operator<<(std::ostream& out, const Degenerate& degenerate) {
  return out << degenerate.name;
}

PlotMove one_key() {
  PlotMove move = straight_move(24, {0, 0});
  PlotTrack& track = move.tracks[0];
  track.path = {{0}, {0}};
  track.keys = {{0}, {0}};
  track.key_frames = {0};
  return move;
}

PlotMove sixty_four_axes(bool in_one_track) {
  PlotMove move = empty_move(24);
  if (in_one_track) {
    std::vector<double> ends;
    for (int i = 0; i < 64; ++i) ends.push_back(i);
    add_straight_track(move, ends);
  } else {
    for (int i = 0; i < 64; ++i) add_straight_track(move, {1.0 * i});
  }
  return move;
}

PlotMove all_keys_in_one_place() {
  PlotMove move = straight_move(24, {0, 0});
  move.tracks[0].keys.assign(2, std::vector<double>(1000, 0.0));
  move.tracks[0].key_frames.assign(1000, 12.0);
  return move;
}

PlotMove closed_path() {
  PlotMove move = straight_move(24, {10, 10});
  PlotTrack& track = move.tracks[0];
  track.path = {{0, 10, 10, 0, 0}, {0, 0, 10, 10, 0}};
  track.keys = {{0, 10, 10, 0}, {0, 0, 10, 10}};
  track.key_frames = {0, 6, 12, 18, 24};
  return move;
}

PlotMove timed_by_frames() {
  PlotMove move = straight_move(24, {10, 10});
  move.tracks[0].curve.clear();
  move.tracks[0].control_values.clear();
  return move;
}

PlotMove at_rest_throughout() {
  PlotMove move = straight_move(1, {10});
  move.tracks[0].curve = {0, 0};
  move.tracks[0].control_values = {0, 0};
  move.tracks[0].speed = {0, 0};
  move.tracks[0].tangents = {{0, 0}};
  return move;
}

PlotMove limits_far_away() {
  PlotMove move = straight_move(24, {10, 10});
  move.axes[0].minimum = -1e9;
  move.axes[0].maximum = 1e9;
  move.axes[1].minimum = 500;
  move.axes[1].maximum = 500.001;
  return move;
}

PlotMove long_names() {
  PlotMove move = straight_move(24, {10, 10});
  move.name = std::string(10'000, 'm');
  move.axes[0].name.clear();
  for (int i = 0; i < 3000; ++i) move.axes[1].name += "é";
  return move;
}

PlotMove no_tracks() {
  PlotMove move = empty_move(24);
  move.axes.push_back(still_axis("pan", 24, 12.5));
  return move;
}

PlotMove offset_and_tiny() {
  PlotMove move = straight_move(24, {1e-3, 1e-300});
  for (double& position : move.axes[0].positions) position += 1e12;
  for (double& position : move.tracks[0].path[0]) position += 1e12;
  for (double& position : move.tracks[0].keys[0]) position += 1e12;
  return move;
}

class DegeneratePlot : public ::testing::TestWithParam<Degenerate> {};

TEST_P(DegeneratePlot, IsDrawnInEveryFormatAndNothingLeavesThePage) {
  const TemporaryFolder folder;
  const PlotMove& move = GetParam().move;
  draw_plot(move, folder.path() / "move.png");
  draw_plot(move, folder.path() / "move.pdf");
  const std::string svg = svg_of(move);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  expect_all_on_the_page(svg);
}

INSTANTIATE_TEST_SUITE_P(
    Moves, DegeneratePlot,
    ::testing::Values(Degenerate{"OneKey", one_key()}, Degenerate{"OneFrame", straight_move(1, {3, 4})},
                      Degenerate{"ZeroLengthRuler", straight_move(24, {0})},
                      Degenerate{"ZeroLengthPlane", straight_move(24, {0, 0})},
                      Degenerate{"FirstAxisStands", straight_move(24, {0, 5, 7})},
                      Degenerate{"OnlyTheThirdAxisMoves", straight_move(24, {0, 0, 7})},
                      Degenerate{"OneAxisIsAThousandTimesTheOther", straight_move(24, {5000, 5})},
                      Degenerate{"SixtyFourAxesInOneTrack", sixty_four_axes(true)},
                      Degenerate{"SixtyFourTracks", sixty_four_axes(false)},
                      Degenerate{"AllKeysInOnePlace", all_keys_in_one_place()},
                      Degenerate{"ClosedPath", closed_path()}, Degenerate{"TimedByFrames", timed_by_frames()},
                      Degenerate{"AtRestThroughout", at_rest_throughout()},
                      Degenerate{"LimitsFarAway", limits_far_away()}, Degenerate{"LongNames", long_names()},
                      Degenerate{"NoTracks", no_tracks()}, Degenerate{"OffsetAndTiny", offset_and_tiny()},
                      Degenerate{"Enormous", straight_move(24, {1e299, -1e299})}),
    [](const auto& instance) { return std::string(instance.param.name); });

// --- numbers at the axes ---

TEST(RoundTicks, AreTheNumbersThatOneWouldWriteByHand) {
  EXPECT_THAT(round_ticks({0, 10}, 6), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(round_ticks({0, 10}, 5), ElementsAre(0, 5, 10));
  EXPECT_THAT(round_ticks({1, 9.9}, 3), ElementsAre(2, 8)) << "5 alone would give no scale";
  EXPECT_THAT(round_ticks({-40, 55.2}, 5), ElementsAre(-40, -20, 0, 20, 40));
  EXPECT_THAT(round_ticks({0, 1500}, 4), ElementsAre(0, 500, 1000, 1500));
  EXPECT_THAT(round_ticks({1234.5, 1234.9}, 5), ElementsAre(1234.5, 1234.6, 1234.7, 1234.8, 1234.9));
  EXPECT_THAT(round_ticks({0.05, 0.75}, 8), ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7));
}

TEST(RoundTicks, OfFramesAreWholeFrames) {
  EXPECT_THAT(round_ticks({0, 3}, 20, 1), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(round_ticks({0, 1}, 20, 1), ElementsAre(0, 1));
}

TEST(RoundTicks, NeverHaveANegativeZero) {
  for (const double tick : round_ticks({-0.4, 10}, 6)) EXPECT_FALSE(tick == 0 && std::signbit(tick));
}

TEST(RoundTicks, OfAnyRangeStepByOneTwoOrFiveAndAreAsManyAsFit) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> exponent(-100, 100);
  std::uniform_real_distribution<double> mantissa(-3, 3);
  for (int i = 0; i < 20'000; ++i) {
    const double size = std::pow(10, exponent(random));
    const double low = mantissa(random) * size;
    const Range range{low, low + size};
    const int at_most = 1 + i % 20;
    const auto ticks = round_ticks(range, at_most);
    ASSERT_THAT(ticks, SizeIs(Le(static_cast<std::size_t>(at_most))));
    ASSERT_THAT(ticks, Each(AllOf(Ge(range.low - 1e-6 * size), Le(range.high + 1e-6 * size))));
    if (ticks.size() < 3) continue;
    char written[32];
    std::snprintf(written, sizeof written, "%.3e", ticks[1] - ticks[0]);
    ASSERT_THAT(std::string(written, 5), ::testing::AnyOf("1.000", "2.000", "5.000"))
        << range.low << ' ' << size;
    // The next finer step, at most 2.5 times finer, would have given too many.
    ASSERT_GT(2.5 * static_cast<double>(ticks.size() + 1), at_most);
  }
}

TEST(TickLabels, HaveAsManyDecimalsAsTheStepNeeds) {
  EXPECT_THAT(tick_labels(std::vector<double>{0, 0.5, 1}).labels, ElementsAre("0.0", "0.5", "1.0"));
  EXPECT_THAT(tick_labels(std::vector<double>{-40, -20, 0}).labels, ElementsAre("-40", "-20", "0"));
  EXPECT_THAT(tick_labels(std::vector<double>{123.45, 123.5}).labels, ElementsAre("123.45", "123.50"));
}

TEST(TickLabels, ThatWouldBeLongMoveTheirCommonPartToTheTitle) {
  const TickLabels large = tick_labels(std::vector<double>{0, 2e6, 4e6});
  EXPECT_THAT(large.labels, ElementsAre("0", "2", "4"));
  EXPECT_EQ(axis_title("track", "mm", large), "track (1e6 mm)");
  const TickLabels offset = tick_labels(std::vector<double>{7000000.1, 7000000.2, 7000000.3});
  EXPECT_THAT(offset.labels, ElementsAre("0.1", "0.2", "0.3"));
  EXPECT_EQ(axis_title("track", "mm", offset), "track - 7000000 (mm)");
  EXPECT_EQ(axis_title("track", "", tick_labels(std::vector<double>{0, 1})), "track");
}

TEST(TickLabels, ReadBackAsTheirTick) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-20, 20);
  std::uniform_real_distribution<double> distance(-6, 9);
  for (int i = 0; i < 20'000; ++i) {
    const double size = std::pow(10, exponent(random));
    const double low = (i % 2 == 0 ? 1 : -1) * size * std::pow(10, distance(random));
    const auto ticks = round_ticks({low, low + size}, 7);
    if (ticks.size() < 2) continue;
    const TickLabels labels = tick_labels(ticks);
    ASSERT_THAT(labels.labels, SizeIs(ticks.size()));
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      ASSERT_LE(labels.labels[k].size(), 8U) << labels.labels[k];
      const double read = labels.offset + std::stod(labels.labels[k]) * labels.factor;
      ASSERT_NEAR(read, ticks[k], 0.01 * (ticks[1] - ticks[0])) << labels.labels[k];
    }
  }
}

TEST(WidenedRange, OfAPointIsOneUnitAroundIt) {
  EXPECT_EQ(widened({12.5, 12.5}, 0.1).low, 12);
  EXPECT_EQ(widened({12.5, 12.5}, 0.1).high, 13);
  const Range rounding = widened({1e12, 1e12 + 1e-3}, 0);
  EXPECT_GE(rounding.size(), 1);
}

// --- lines ---

double distance_to_segment(Point p, Point a, Point b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double square = dx * dx + dy * dy;
  const double t = square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0;
  return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

double distance_to_line(Point p, const std::vector<Point>& line) {
  double least = std::hypot(p.x - line.front().x, p.y - line.front().y);
  for (std::size_t i = 1; i < line.size(); ++i)
    least = std::min(least, distance_to_segment(p, line[i - 1], line[i]));
  return least;
}

TEST(SimplifiedLine, OfAStraightLineIsItsTwoEnds) {
  std::vector<Point> points;
  for (int i = 0; i <= 1000; ++i) points.push_back({0.3 * i, 0.1 * i});
  EXPECT_THAT(simplified(points, 0.1), SizeIs(2));
}

TEST(SimplifiedLine, StaysWithinItsToleranceOfEveryPoint) {
  std::mt19937 random(6);
  std::normal_distribution<double> step(0, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<Point> points;
    Point at;
    const double scale = std::pow(10, -round % 4);
    for (int i = 0; i < 500; ++i) {
      at = {at.x + scale * step(random), at.y + scale * step(random)};
      points.push_back(at);
    }
    const auto kept = simplified(points, 0.5);
    for (const Point p : points) ASSERT_LE(distance_to_line(p, kept), 0.5 + 1e-9);
    EXPECT_EQ(kept.back().x, points.back().x);
  }
}

TEST(SimplifiedLine, KeepsTheTurningPointOfAPathThatComesBackOnItself) {
  std::vector<Point> points;
  for (int i = 0; i <= 100; ++i) points.push_back({i <= 60 ? 1.0 * i : 120.0 - i, 0});
  const auto kept = simplified(points, 0.1);
  ASSERT_THAT(kept, SizeIs(3));
  EXPECT_EQ(kept[1].x, 60);
}

TEST(SimplifiedLine, HasNoMorePointsThanAllowed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(0, 500);
  std::vector<Point> points;
  for (int i = 0; i < 50'000; ++i) points.push_back({anywhere(random), anywhere(random)});
  EXPECT_THAT(simplified_to(points, 20'000), SizeIs(Le(20'000U)));
  EXPECT_THAT(simplified_to(points, 2), SizeIs(2));
}

TEST(SeriesLine, KeepsASpikeOfOneFrameInAHundredThousand) {
  std::vector<double> values(100'001, 0.0);
  values[61'803] = 7;
  values[61'805] = -3;
  const Scale x({0, 100'000}, 100, 1100);
  const Scale y({-10, 10}, 200, 0);
  const auto line = series_line(values, x, y);
  EXPECT_THAT(line, SizeIs(Le(10U)));
  const auto [top, bottom] =
      std::minmax_element(line.begin(), line.end(), [](Point a, Point b) { return a.y < b.y; });
  EXPECT_DOUBLE_EQ(top->y, 30);
  EXPECT_DOUBLE_EQ(bottom->y, 130);
  EXPECT_NEAR(top->x, 100 + 618.03, 1e-6);
  EXPECT_EQ(line.front().x, 100);
  EXPECT_EQ(line.back().x, 1100);
}

TEST(SeriesLine, OfNoiseHasAtMostFourPointsAPixelColumn) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> noise(-10, 10);
  std::vector<double> values(100'001);
  std::generate(values.begin(), values.end(), [&] { return noise(random); });
  EXPECT_THAT(series_line(values, Scale({0, 100'000}, 0, 500), Scale({-10, 10}, 200, 0)),
              SizeIs(Le(4U * 501)));
}

TEST(ElidedText, IsWholeWhereItFitsAndIsCutBetweenLettersWhereNot) {
  Canvas canvas("page.svg", 200, 100);
  const TextStyle style{.size = 12};
  EXPECT_EQ(elided(canvas, "pan", style, 100), "pan");
  const std::string shown = elided(canvas, "ééééééééééééééééééééééé", style, 60);
  EXPECT_THAT(shown, AllOf(StartsWith("éé"), ::testing::EndsWith("é…")));
  EXPECT_LE(canvas.text_width(shown, style), 60);
  EXPECT_EQ(shown.size() % 2, 1U) << "an é has two bytes, the ellipsis three";
}

TEST(ShrunkText, FitsWithAllItsFigures) {
  Canvas canvas("page.svg", 200, 100);
  const TextStyle style{.size = 11};
  EXPECT_EQ(shrunk(canvas, "max 1800", style, 110).size, 11);
  const std::string figures = "↑ max 1234567.8901234567";
  const TextStyle smaller = shrunk(canvas, figures, style, 110);
  EXPECT_THAT(smaller.size, AllOf(Ge(6), Le(11)));
  EXPECT_LE(canvas.text_width(figures, smaller), 110.01);
}

TEST(Text, OfOtherScriptsIsShapedAndNotLetterAfterLetter) {
  Canvas canvas("page.svg", 200, 100);
  const TextStyle style{.size = 20};
  const auto width = [&](std::string_view words) { return canvas.text_width(words, style); };
  const std::string beh = "\u0628";  // joins its neighbour in Arabic script, and is narrower for it
  EXPECT_LT(width(beh + beh), 2 * width(beh) - 1);
  EXPECT_NEAR(width("e\u0301"), width("\u00e9"), 1e-3) << "an accent stands over its letter";
}

TEST(PictureStyle, ADarkPageIsBlackWhereALightOneIsWhite) {
  const TemporaryFolder folder;
  const auto corner = [&](PictureStyle style) {
    draw_plot(straight_move(4, {1, 2}), folder.path() / "move.svg", style);
    const std::string svg = contents(folder.path() / "move.svg");
    const auto rectangle = svg.find("<rect");
    return svg.substr(rectangle, svg.find("/>", rectangle) - rectangle);
  };
  EXPECT_THAT(corner(PictureStyle::light), HasSubstr("rgb(100%"));
  EXPECT_THAT(corner(PictureStyle::dark), HasSubstr("rgb(11%"));
}

}  // namespace plot_test
}  // namespace inbetween
