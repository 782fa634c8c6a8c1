// JSON as it is streamed: every text reads back as what was written.
#include "host_tools/text/json_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

namespace inbetween {
namespace json_writer_test {

/// What `write` gives to the writer, as text.
template <class Write>
std::string written(Write write) {
  char* bytes = nullptr;
  std::size_t size = 0;
  std::FILE* file = open_memstream(&bytes, &size);
  {
    JsonWriter json(file);
    write(json);
  }
  std::fclose(file);
  const std::unique_ptr<char, decltype(&std::free)> owner(bytes, std::free);
  return {bytes, size};
}

template <class Write>
nlohmann::json read_back(Write write) {
  return nlohmann::json::parse(written(write));
}

std::string number(double value) {
  return written([&](JsonWriter& json) { json.value(value); });
}

TEST(JsonWriter, PutsCommasBetweenItemsOnly) {
  const std::string text = written([](JsonWriter& json) {
    json.begin_object();
    json.key("none");
    json.begin_array();
    json.end_array();
    json.member("one", 1);
    json.member("three", std::vector<double>{1, 2.5, -3});
    json.key("objects");
    json.begin_array();
    for (const bool truth : {true, false}) {
      json.begin_object();
      json.member("truth", truth);
      json.end_object();
    }
    json.end_array();
    json.end_object();
  });
  EXPECT_EQ(text, R"({"none":[],"one":1,"three":[1,2.5,-3],"objects":[{"truth":true},{"truth":false}]})");
}

TEST(JsonWriter, LinesBreakAfterACommaAndAreIndentedByTheirDepth) {
  const std::string text = written([](JsonWriter& json) {
    json.begin_array();
    json.line();
    json.value(1);
    json.line();
    json.value(2);
    json.end_array();
    json.finish();
  });
  EXPECT_EQ(text, "[\n 1,\n 2]\n");
}

TEST(JsonWriter, NumbersAreTheShortestThatReadBackExactly) {
  EXPECT_EQ(number(0.1), "0.1");
  EXPECT_EQ(number(24), "24");
  EXPECT_EQ(number(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(number(std::numeric_limits<double>::denorm_min()), "5e-324");
}

TEST(JsonWriter, AnyNumberReadsBackToTheLastBit) {
  std::mt19937_64 random(1989);
  for (int i = 0; i < 20'000; ++i) {
    const auto value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    const auto back = nlohmann::json::parse(number(value)).get<double>();
    ASSERT_EQ(std::bit_cast<std::uint64_t>(back), std::bit_cast<std::uint64_t>(value)) << number(value);
  }
}

TEST(JsonWriter, WholeNumbersReadBackToTheLastBitToo) {
  for (const double value : {0.0, -0.0, 1e15, 1e16, 9007199254740992.0, 1e22, 1e100, -1e17}) {
    const auto back = nlohmann::json::parse(number(value)).get<double>();
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back), std::bit_cast<std::uint64_t>(value)) << number(value);
  }
}

TEST(JsonWriter, WhatIsNotFiniteIsNull) {
  EXPECT_EQ(number(std::numeric_limits<double>::infinity()), "null");
  EXPECT_EQ(number(std::numeric_limits<double>::quiet_NaN()), "null");
}

TEST(JsonWriter, TextIsQuotedAndStaysAsItIs) {
  const std::string text = "a \"quote\", a \\, a\nline, \x01, Höhe, \xF0\x9F\x8E\xAC";
  EXPECT_EQ(read_back([&](JsonWriter& json) { json.value(text); }), text);
  const nlohmann::json object = read_back([&](JsonWriter& json) {
    json.begin_object();
    json.member(text, text);
    json.end_object();
  });
  EXPECT_EQ(object.at(text), text);
}

TEST(JsonWriter, MoreThanItsBufferArrivesWhole) {
  const nlohmann::json list = read_back([](JsonWriter& json) {
    json.begin_array();
    for (int i = 0; i < 100'000; ++i) json.value(i + 0.125);
    json.end_array();
  });
  ASSERT_EQ(list.size(), 100'000U);
  EXPECT_EQ(list.at(99'999), 99'999.125);
}

}  // namespace json_writer_test
}  // namespace inbetween
