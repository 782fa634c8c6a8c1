#include "host_tools/joints/urdf_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <locale>
#include <string>
#include <string_view>

#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace urdf_file_test {

const char* const crane = R"(<?xml version="1.0"?>
<robot name="crane">
  <link name="camera"/>
  <link name="boom"><inertial><mass value="40"/></inertial></link>
  <link name="base"/>
  <joint name="level" type="revolute">
    <parent link="boom"/>
    <child link="camera"/>
    <origin xyz="2.5 0 -0.1" rpy="0 0.5 0"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="10" velocity="2"/>
    <mimic joint="tilt" multiplier="-1" offset="0.25"/>
  </joint>
  <joint name="tilt" type="revolute">
    <parent link="base"/>
    <child link="boom"/>
    <limit lower="-1" upper="1" effort="100" velocity="1"/>
  </joint>
  <gazebo reference="boom"><material>Gazebo/Red</material></gazebo>
</robot>
)";

TEST(UrdfFile, LinksStandBehindTheirParents) {
  const UrdfFile file = parse_urdf(crane, "crane.urdf");
  EXPECT_THAT(file.links, testing::ElementsAre("base", "boom", "camera"));
  ASSERT_EQ(file.joints.size(), 2U);
  EXPECT_EQ(file.joints[0].name, "tilt");
  EXPECT_EQ(file.joints[0].parent, 0U);
  EXPECT_EQ(file.joints[0].child, 1U);
  const UrdfJoint& level = file.joints[1];
  EXPECT_EQ(level.kind, UrdfJointKind::revolute);
  EXPECT_EQ(level.parent, 1U);
  EXPECT_EQ(level.child, 2U);
  EXPECT_THAT(level.xyz, testing::ElementsAre(2.5, 0, -0.1));
  EXPECT_THAT(level.rpy, testing::ElementsAre(0, 0.5, 0));
  EXPECT_THAT(level.axis, testing::ElementsAre(0, 1, 0));
  EXPECT_EQ(level.limit->lower, -1.5);
  EXPECT_EQ(level.limit->velocity, 2);
  EXPECT_EQ(level.mimic->joint, 0U);
  EXPECT_EQ(level.mimic->multiplier, -1);
  EXPECT_EQ(level.mimic->offset, 0.25);
  EXPECT_EQ(level.place.line, 6U);
  EXPECT_EQ(level.mimic->place.line, 12U);
}

TEST(UrdfFile, WhatIsNotWrittenHasTheDefaultsOfTheFormat) {
  const UrdfJoint tilt = parse_urdf(crane, "crane.urdf").joints[0];
  EXPECT_THAT(tilt.xyz, testing::ElementsAre(0, 0, 0));
  EXPECT_THAT(tilt.rpy, testing::ElementsAre(0, 0, 0));
  EXPECT_THAT(tilt.axis, testing::ElementsAre(1, 0, 0));
  EXPECT_FALSE(tilt.mimic);
}

/// Expects a refusal of the crane with `from` replaced by `to`, at the line of `to` or `later` lines below
/// it.
void expect_refused_at(std::string_view from, std::string_view to,
                       std::initializer_list<std::string_view> words, int later = 0) {
  const std::string text = with(crane, from, to);
  const auto before = text.begin() + static_cast<std::ptrdiff_t>(text.find(to));
  const auto line = std::count(text.begin(), before, '\n') + 1 + later;
  try {
    parse_urdf(text, "crane.urdf");
    FAIL() << "accepted:\n" << text;
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("crane.urdf:" + std::to_string(line) + ": error: "));
    for (const std::string_view word : words)
      EXPECT_THAT(error.what(), testing::HasSubstr(std::string(word)));
  }
}

TEST(UrdfFile, AMisspeltWordIsRefusedAtItsLine) {
  expect_refused_at(R"(<origin xyz="2.5 0 -0.1" )", R"(<origin xzy="2.5 0 -0.1" )", {"\"xzy\"", "xyz, rpy"});
  expect_refused_at("<axis xyz=\"0 1 0\"/>", "<axes xyz=\"0 1 0\"/>", {"<axes>", "axis"});
  expect_refused_at("multiplier=\"-1\"", "multiplyer=\"-1\"", {"\"multiplyer\""});
  expect_refused_at("lower=\"-1\" ", "low=\"-1\" ", {"\"low\""});
  expect_refused_at("<joint name=\"tilt\" type=\"revolute\">", "<joint name=\"tilt\" type=\"hinge\">",
                    {"\"hinge\"", "revolute"});
  expect_refused_at("<joint name=\"tilt\" type=\"revolute\">", "<joint name=\"tilt\" type=\"floating\">",
                    {"\"floating\""});
  expect_refused_at("<joint name=\"tilt\" type", "<joint nam=\"tilt\" type", {"\"nam\""});
}

TEST(UrdfFile, AnAttributeIsRefusedAtItsOwnLine) {
  expect_refused_at("effort=\"100\" velocity", "effort\n =\t'\n\"&gt;velocity=' velocity=\"1\"\n\n velocty",
                    {"\"velocty\""}, 4);
  expect_refused_at("upper=\"1\" effort=\"100\"", "effort='>'\r\n  upper = \"&lt;>'\"", {"upper is \"<>'\""},
                    1);
}

TEST(UrdfFile, AWrongNumberIsRefusedAtItsLine) {
  for (const char* numbers : {"0 1", "0 1 0 0", "0 1 x", "0 1 0,5", "nan 0 0", "inf 0 0", "0 1e400 0",
                              "0 2e6 0", "", "0 0 +-1", "0x1 0 0", "${a} 0 0"}) {
    expect_refused_at("<axis xyz=\"0 1 0\"/>", std::string("<axis xyz=\"") + numbers + "\"/>",
                      {"three numbers"});
  }
  expect_refused_at("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"${axis}\"/>", {"xacro"});
  expect_refused_at("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 0 0\"/>", {"no direction"});
  expect_refused_at("lower=\"-1\" ", "lower=\"-1 rad\" ", {"one number"});
  expect_refused_at("lower=\"-1\" upper=\"1\"", "lower=\"1\" upper=\"-1\"", {"exchange"});
  expect_refused_at("effort=\"100\" velocity=\"1\"", "effort=\"100\"", {"no velocity"});
  expect_refused_at("effort=\"100\" velocity=\"1\"", "effort=\"100\" velocity=\"-1\"", {"magnitude"});
}

// Cases 20 and 21: what exporters and other programs write.
TEST(UrdfFile, WhatPlacesNothingIsPassedOverWithOneWarning) {
  std::string text =
      with(crane, "<axis xyz=\"0 1 0\"/>",
           "<axis xyz=\"0 1 0\" gz:frame=\"a\"/><controller_gains p=\"1\"/><controller_gains p=\"2\"/>\n"
           "<drake:effort/><traits/>");
  text = with(text, "<robot", "<robot xmlns:gz=\"x\" xmlns:drake=\"y\"");
  const UrdfFile file = parse_urdf(text, "crane.urdf");
  ASSERT_EQ(file.warnings.size(), 1U);
  EXPECT_THAT(file.warnings[0].message,
              testing::HasSubstr("<controller_gains>, <drake:effort>, <traits>, gz:frame"));
  EXPECT_TRUE(parse_urdf(crane, "crane.urdf").warnings.empty());
}

TEST(UrdfFile, TheAxisOfAFixedJointMeansNothingAndThatOfAMovingOneHasADirection) {
  const std::string fixed = R"(<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">
<parent link="a"/><child link="b"/><axis xyz="0 0 0"/></joint></robot>)";
  EXPECT_EQ(parse_urdf(fixed, "a.urdf").joints[0].axis, (std::array<double, 3>{1, 0, 0}));
  EXPECT_THROW(parse_urdf(with(fixed, "\"fixed\"", "\"continuous\""), "a.urdf"), InputError);
}

// Templates and exporters write a whole limit and a mimic into every joint.
TEST(UrdfFile, WhatAJointOfItsKindCannotHaveMeansNothing) {
  const std::string fixed = R"(<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">
<parent link="a"/><child link="b"/><Axis xyz="0 0 0"/><limit lower="one" effort="0"/><limit/>
<mimic joint=""/></joint></robot>)";
  const UrdfFile file = parse_urdf(fixed, "a.urdf");
  EXPECT_FALSE(file.joints[0].limit || file.joints[0].mimic);
  ASSERT_EQ(file.warnings.size(), 1U);
  EXPECT_THAT(file.warnings[0].message, testing::HasSubstr(": <Axis>"));
  EXPECT_THROW(parse_urdf(with(fixed, "\"fixed\"", "\"continuous\""), "a.urdf"), InputError) << "it mimics";
  const std::string turning = with(with(fixed, "\"fixed\"", "\"continuous\""), "<mimic joint=\"\"/>", "");
  EXPECT_FALSE(parse_urdf(with(turning, "<Axis xyz=\"0 0 0\"/>", "<Limit/>"), "a.urdf").joints[0].limit);
}

TEST(UrdfFile, AMisspeltWordThatPlacesNothingIsPassedOver) {
  const std::string text = with(crane, "effort=\"100\" velocity=\"1\"/>",
                                "efort=\"100\" velocity=\"1\"/><dynamic/><safety_controler/>");
  const UrdfFile file = parse_urdf(text, "crane.urdf");
  ASSERT_EQ(file.warnings.size(), 1U);
  EXPECT_THAT(file.warnings[0].message, testing::HasSubstr(": <dynamic>, <safety_controler>, efort"));
}

// Later versions of the format, and other formats.
TEST(UrdfFile, APlaceInOtherWordsIsRefused) {
  expect_refused_at("rpy=\"0 0.5 0\"", "quat_xyzw=\"0 0 0 1\"", {"<origin> has quat_xyzw", "rpy="});
  expect_refused_at("xyz=\"2.5 0 -0.1\"", "x=\"2.5\"", {"<origin> has x,"});
  expect_refused_at("<axis xyz=\"0 1 0\"/>", "<axis y=\"1\"/>", {"<axis> has no xyz"});
}

TEST(UrdfFile, NumbersAreReadAlikeWhereverTheReaderLives) {
  struct Comma : std::numpunct<char> {
    [[nodiscard]] char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  EXPECT_EQ(parse_urdf(crane, "crane.urdf").joints[1].xyz[0], 2.5);
  expect_refused_at("lower=\"-1\" ", "lower=\"-0,5\" ", {"one number"});
  std::locale::global(before);
}

// A limit of 1e16 is none to the programs that write it.
TEST(UrdfFile, ALimitMayBeAsFarAwayAsANumberGoes) {
  const std::string far =
      with(crane, "lower=\"-1\" upper=\"1\"", "lower=\"-1e+16\" upper=\"1.7976931348623157e+308\"");
  EXPECT_EQ(parse_urdf(far, "crane.urdf").joints[0].limit->lower, -1e16);
  expect_refused_at("lower=\"-1\" ", "lower=\"-inf\" ", {"one number"});
}

TEST(UrdfFile, WhatStandsBesideTheElementsIsNoMatterOfTheParser) {
  std::string text = with(crane, "<?xml version=\"1.0\"?>", "\n<!-- of\na log -->\n<?xml version='1.0' ?>");
  text = with(text, "  <link name=\"base\"/>", "<!------ <link> \" -- \xe4 ------>  <link name=\"base\"/>");
  EXPECT_EQ(parse_urdf(text, "crane.urdf").joints[0].place.line, 17U);
  EXPECT_EQ(parse_urdf("\xef\xbb\xbf" + std::string(crane), "crane.urdf").joints.size(), 2U);
  const auto refused = [](const std::string& wrong) {
    EXPECT_THROW(parse_urdf(wrong, "crane.urdf"), InputError) << wrong;
  };
  refused(with(crane, "name=\"crane\"", "name=\"<!-- -->\""));
  refused(with(crane, "</robot>", "<!-- </robot>"));
  refused(with(crane, "</robot>", "</robot><?xml"));
  const std::string data = with(crane, "Gazebo/Red", "<![CDATA[a > <!-- ]]>");
  EXPECT_EQ(parse_urdf(with(data, "</robot>", "<!-- b --></robot>"), "crane.urdf").joints.size(), 2U);
}

TEST(UrdfFile, WhatXacroHasNotExpandedIsCalledThat) {
  try {
    parse_urdf(R"(<robot name="r" xmlns:xacro="x">
<xacro:include filename="b"/><link name="a"/></robot>)",
               "r.urdf.xacro");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "r.urdf.xacro:2: error: <xacro:include> is of xacro, and this file was not expanded; "
                 "write: xacro r.urdf.xacro > robot.urdf");
  }
}

TEST(UrdfFile, WhatIsGivenTwiceIsRefused) {
  expect_refused_at("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><axis xyz=\"0 0 1\"/>",
                    {"<axis>", "second"});
  expect_refused_at("<link name=\"base\"/>", "<link name=\"boom\"/>", {"\"boom\"", "another"});
  expect_refused_at("<joint name=\"tilt\"", "<joint name=\"level\"", {"\"level\"", "another"}, 8);
  expect_refused_at("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\" xyz=\"0 0 1\"/>", {"not valid XML"});
}

TEST(UrdfFile, WhatIsNoTreeIsRefused) {
  expect_refused_at("<joint name=\"tilt\" type=\"revolute\">\n    <parent link=\"base\"/>",
                    "<joint name=\"tilt\" type=\"revolute\">\n    <parent link=\"floor\"/>", {"\"floor\""});
  expect_refused_at("<joint name=\"tilt\" type=\"revolute\">\n    <parent link=\"base\"/>",
                    "<joint name=\"tilt\" type=\"revolute\">\n", {"no <parent>"});
  expect_refused_at("<link name=\"base\"/>", "<link name=\"base\"/>\n<link name=\"hook\"/>",
                    {"\"hook\"", "nothing"}, 1);
  expect_refused_at("<child link=\"camera\"/>", "<child link=\"boom\"/>", {"\"boom\"", "already"}, 6);
  // base on camera, camera on boom, boom on base
  expect_refused_at(
      "  <gazebo",
      "  <joint name=\"j\" type=\"fixed\"><parent link=\"camera\"/><child link=\"base\"/></joint>\n"
      "  <gazebo",
      {"\"camera\"", "circle"}, -13);
  EXPECT_THROW(parse_urdf("<robot name=\"r\"/>", "r.urdf"), InputError);
}

TEST(UrdfFile, AMimicFollowsAnotherJointThatMoves) {
  expect_refused_at("<mimic joint=\"tilt\"", "<mimic joint=\"pan\"", {"\"pan\""});
  expect_refused_at("<mimic joint=\"tilt\"", "<mimic joint=\"level\"", {"\"level\"", "itself"});
  expect_refused_at("<mimic joint=\"tilt\"", "<mimic", {"no joint"});
}

// A humanoid with hands, a chain of tracks, a link for every screw. In whichever order they are written.
TEST(UrdfFile, ThousandsOfLinksAreRead) {
  for (const bool is_backward : {false, true}) {
    std::string text = "<robot><link name=\"l0\"/>";
    for (std::size_t i = 1; i < max_urdf_links; ++i) {
      const std::size_t child = is_backward ? max_urdf_links - i : i;
      text += fmt::format(R"(<link name="l{0}"/><joint name="j{0}" type="continuous"><parent link="l{1}"/>)"
                          R"(<child link="l{0}"/></joint>)",
                          child, child - 1);
    }
    const UrdfFile file = parse_urdf(text + "</robot>", "r.urdf");
    ASSERT_EQ(file.links.size(), max_urdf_links);
    EXPECT_EQ(file.links.back(), fmt::format("l{}", max_urdf_links - 1));
  }
}

TEST(UrdfFile, WhatIsNoUrdfSaysSo) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      parse_urdf(text, "r.urdf");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message(""), testing::StartsWith("r.urdf:1: error: not valid XML"));
  EXPECT_THAT(message("name = \"crane\"\n"), testing::HasSubstr("error: not valid XML"));
  EXPECT_THAT(message("<robot>\n<link name=\"a\">\n</robot>"),
              testing::StartsWith("r.urdf:3: error: not valid XML (mismatched tag)"));
  EXPECT_THAT(message("<?xml version=\"1.0\"?>\n<!DOCTYPE robot [<!ENTITY a 'b'>]>\n<robot/>"),
              testing::StartsWith("r.urdf:2: error: a document type is not read"));
  EXPECT_THAT(message("<robot name=\"\xe4\"/>"), testing::HasSubstr("error: not valid XML"));
  EXPECT_THAT(message(std::string("\xff\xfe<\0a\0/\0>\0", 10)), testing::HasSubstr("save it as UTF-8"));
  EXPECT_THAT(message("<sdf/>"),
              testing::StartsWith("r.urdf:1: error: the file does not begin with <robot>"));
  EXPECT_THAT(message("<robot><link/></robot>"), testing::StartsWith("r.urdf:1: error: <link> has no name"));
  EXPECT_THAT(message(std::string(100'000, '<')), testing::HasSubstr("not valid XML"));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_THAT(message(deep), testing::HasSubstr("not valid XML"));
  std::string many = "<robot>";
  for (std::size_t i = 0; i <= max_urdf_links; ++i) many += "\n<link name=\"l" + std::to_string(i) + "\"/>";
  EXPECT_THAT(message(many + "</robot>"),
              testing::StartsWith(
                  fmt::format("r.urdf:{}: error: <link> is one more than the 4096", max_urdf_links + 2)));
}

}  // namespace urdf_file_test
}  // namespace inbetween
