// An import that is filled in as a form asks what the command line asks, and takes what it takes.
#include "host_tools/exchange/import_form.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/import_answers.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace import_form_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

/// Two axes: `track` in mm, `pan` in degrees.
RigFile camera_rig() {
  return parse_rig(rig_text({axis_text("track", "mm", {-1000, 1000}), axis_text("pan", "deg", {-90, 90})}),
                   "rig.toml");
}

ImportForm form_of(const std::string& file, const std::string& text, const FormAnswers& answers = {}) {
  return import_form(file, text, camera_rig(), answers, "pan");
}

std::vector<std::string> ids_of(const ImportForm& form) {
  std::vector<std::string> ids;
  for (const FormQuestion& question : form.questions) ids.push_back(question.id);
  return ids;
}

const FormQuestion& question_of(const ImportForm& form, const std::string& id) {
  static const FormQuestion none;
  const auto found = std::ranges::find(form.questions, id, &FormQuestion::id);
  EXPECT_NE(found, form.questions.end()) << id;
  return found == form.questions.end() ? none : *found;
}

const char* const bare = "0 0\n10 45\n20 90\n";
const FormAnswers all_of_bare = {{"fps", "24"},    {"axis 1", "track"}, {"axis 2", "-pan"},
                                 {"unit 1", "cm"}, {"unit 2", "deg"},   {"phase", "boundary"}};

TEST(ImportForm, AsksInTheWordsOfTheCommandLine) {
  const ImportForm form = form_of("a.txt", bare);
  const BakedTable table = read_baked_table(ExchangeFormat::raw_move, bare, "a.txt");
  const std::vector<OpenQuestion> open = open_questions(table, camera_rig(), {});
  ASSERT_EQ(form.questions.size(), open.size());
  for (std::size_t i = 0; i < open.size(); ++i) {
    EXPECT_EQ(form.questions[i].words, open[i].words);
    EXPECT_EQ(form.questions[i].suggestion, open[i].suggestion);
    EXPECT_EQ(form.questions[i].answer, "") << "a suggestion is no answer";
  }
  EXPECT_THAT(ids_of(form), ElementsAre("fps", "axis 1", "axis 2", "phase"));
  EXPECT_FALSE(form.move);
  EXPECT_THAT(form.refused, IsEmpty());
}

TEST(ImportForm, EveryChoiceIsAnAnswer) {
  const RigFile rig = camera_rig();
  const ImportForm form = form_of("a.txt", bare, {{"axis 1", "track"}});
  const BakedTable table = read_baked_table(ExchangeFormat::raw_move, bare, "a.txt");
  const ImportSaid with_axis{.axes = {*axis_word_of("1=track")}};
  std::size_t choices = 0;
  for (const ImportSaid& before : {ImportSaid{}, with_axis}) {
    for (const OpenQuestion& question : open_questions(table, rig, before)) {
      for (const std::string& choice : choices_of(question, rig)) {
        ImportSaid said = before;
        EXPECT_EQ(take_answer(question, choice, rig, said), std::nullopt) << choice;
        ++choices;
      }
    }
  }
  EXPECT_GE(choices, 20U);
  EXPECT_THAT(question_of(form, "unit 1").choices, ElementsAre("mm", "cm", "m", "in", "ft", "rig"));
  EXPECT_THAT(question_of(form, "axis 2").choices, ElementsAre("-", "track", "-track", "pan", "-pan"));
}

TEST(ImportForm, AUnitIsAskedOnceItsAxisIsKnownAndGoesWithIt) {
  EXPECT_THAT(ids_of(form_of("a.txt", bare, {{"axis 2", "pan"}})),
              ElementsAre("fps", "axis 1", "axis 2", "unit 2", "phase"));
  // What was said of a unit before counts for nothing where the column is of no axis.
  const ImportForm none = form_of("a.txt", bare, {{"axis 2", "-"}, {"unit 2", "deg"}});
  EXPECT_THAT(ids_of(none), ElementsAre("fps", "axis 1", "axis 2", "phase"));
}

TEST(ImportForm, AWrongAnswerStaysAQuestionWithItsMistake) {
  FormAnswers answers = all_of_bare;
  answers["axis 2"] = "pam";
  answers["fps"] = "23.976";
  const ImportForm form = form_of("a.txt", bare, answers);
  EXPECT_THAT(question_of(form, "axis 2").mistake, HasSubstr("did you mean \"pan\"?"));
  EXPECT_THAT(question_of(form, "fps").mistake, HasSubstr("write a rate such as 24 or 24000/1001"));
  EXPECT_EQ(question_of(form, "axis 1").mistake, "");
  EXPECT_EQ(question_of(form, "axis 1").answer, "track");
  EXPECT_FALSE(form.move);
}

TEST(ImportForm, WithEveryAnswerItHasTheMove) {
  const ImportForm form = form_of("a.txt", bare, all_of_bare);
  ASSERT_TRUE(form.move) << (form.refused.empty() ? "" : form.refused.front());
  EXPECT_EQ(summary_of(*form.move), "2 frames of track, pan at 24 fps, 0.083 s");
  EXPECT_THAT(form.move->positions, ElementsAre(ElementsAre(0, 100, 200), ElementsAre(0, -45, -90)));
  EXPECT_EQ(form.move->name, "pan");
  EXPECT_THAT(form.questions, SizeIs(6)) << "what was answered can be answered otherwise";
}

TEST(ImportForm, EveryWrongRowHasItsLineAndTheQuestionsStay) {
  FormAnswers answers = all_of_bare;
  const ImportForm form = form_of("a.txt", "0 0\n10 200\n20 0\n5 -300\n", answers);
  EXPECT_THAT(form.refused, ElementsAre(StartsWith("a.txt:2: error: axis \"pan\" is at -200 deg"),
                                        StartsWith("a.txt:4: error: axis \"pan\" is at 300 deg")));
  EXPECT_THAT(form.questions, SizeIs(6));
  EXPECT_FALSE(form.move);
  EXPECT_THAT(form_of("a.txt", "0 0\n1 x\n").refused, ElementsAre(StartsWith("a.txt:2:3: error: ")));
}

TEST(ImportForm, AFormatThatNobodyCanBeSureOfIsAsked) {
  const ImportForm form = form_of("a.dat", bare);
  EXPECT_THAT(ids_of(form), ElementsAre("format"));
  EXPECT_THAT(question_of(form, "format").choices, ElementsAre("maya-mov", "raw-move"));
  EXPECT_THAT(form.refused, IsEmpty());
  EXPECT_THAT(ids_of(form_of("a.dat", bare, {{"format", "raw-move"}})),
              ElementsAre("format", "fps", "axis 1", "axis 2", "phase"));
  EXPECT_NE(question_of(form_of("a.dat", bare, {{"format", "csv"}}), "format").mistake, "");
}

TEST(ImportForm, HowACsvFileIsReadIsOfferedWhereItIsRefused) {
  const std::string commas = "frame;pan\n1;0,5\n2;1,5\n";
  const ImportForm refused = form_of("a.csv", commas);
  EXPECT_THAT(refused.refused.front(), HasSubstr("state that decimals have commas"));
  EXPECT_THAT(ids_of(refused), ElementsAre("separator", "decimal commas", "gaps"));
  EXPECT_TRUE(question_of(refused, "gaps").may_stay_open);
  EXPECT_THAT(ids_of(form_of("a.csv", commas, {{"decimal commas", "yes"}})),
              ElementsAre("separator", "decimal commas", "gaps", "fps", "unit 1", "phase"));
  EXPECT_THAT(ids_of(form_of("a.csv", "frame,pan\n1,0\n2,1\n")), ElementsAre("fps", "unit 1", "phase"));
}

TEST(ImportForm, WhatIsNoMotionIsNamed) {
  EXPECT_THAT(form_of("a.urdf", "<robot/>").refused.front(), HasSubstr("becomes a rig"));
  EXPECT_THAT(form_of("takes.db", "SQLite format 3 ...").refused.front(), HasSubstr("--take N"));
  EXPECT_THAT(form_of("a.mov", "").refused, SizeIs(1));
}

TEST(ImportForm, AColumnWhoseNameIsNoTextIsAnsweredToo) {
  const ImportForm form = form_of("a.csv", "frame,H\xf6he\n1,0\n2,1\n", {{"axis 1", "track"}});
  EXPECT_EQ(question_of(form, "axis 1").mistake, "");
  EXPECT_EQ(question_of(form, "axis 1").answer, "track");
}

}  // namespace import_form_test
}  // namespace inbetween
