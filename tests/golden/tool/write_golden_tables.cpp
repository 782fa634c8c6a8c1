// Writes tests/golden/*.csv, the oracle's frame tables of the examples.
//
//   write_golden_tables ROOT
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>

#include "host_tools/text/output_file.hpp"
#include "tests/support/golden_table.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "write_golden_tables: error: one argument, the checkout's folder\n");
    return 2;
  }
  try {
    const std::filesystem::path root = argv[1];
    const auto write = [&](const std::string& name, const std::vector<inbetween::GoldenRow>& rows) {
      const std::string table = as_csv(rows);
      const std::filesystem::path file = root / "tests/golden" / (name + ".csv");
      inbetween::write_output(file.string(), [&](std::FILE* out) { std::fputs(table.c_str(), out); });
      fmt::print("{}\n", file.string());
    };
    const auto example = [&](const std::string& name) { return root / "examples" / (name + ".toml"); };
    for (const std::string& name : inbetween::golden_examples()) {
      write(name, golden_table(inbetween::read_drawn_tracks(example(name))));
    }
    for (const std::string& name : inbetween::timed_golden_examples()) {
      write(name, inbetween::timed_golden_table(example(name)));
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "write_golden_tables: error: {}\n", error.what());
    return 1;
  }
  return 0;
}
