// A file is written whole or not at all.
#include "host_tools/text/output_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace output_file_test {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

void write_text(std::FILE* file) {
  std::fputs("new\n", file);
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

std::ptrdiff_t files_in(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

TEST(OutputFile, IsWrittenAndNothingElseIsLeft) {
  const TemporaryFolder folder;
  write_output((folder.path() / "a").string(), write_text);
  EXPECT_EQ(file_contents((folder.path() / "a").string()), "new\n");
  EXPECT_EQ(files_in(folder.path()), 1);
}

TEST(OutputFile, AnOldOneIsReplaced) {
  const TemporaryFile old("a", "old, and longer");
  write_output(old.path().string(), write_text);
  EXPECT_EQ(file_contents(old.path().string()), "new\n");
  EXPECT_EQ(files_in(old.path().parent_path()), 1);
}

TEST(OutputFile, AnOldOneSurvivesAnErrorWhileTheNewOneIsWritten) {
  const TemporaryFile old("a", "old");
  const auto write = [](std::FILE* file) {
    write_text(file);
    std::fflush(file);
    throw std::runtime_error("half-way");
  };
  EXPECT_EQ(words_of_error([&] { write_output(old.path().string(), write); }), "half-way");
  EXPECT_EQ(file_contents(old.path().string()), "old");
  EXPECT_EQ(files_in(old.path().parent_path()), 1);
}

/// A limit on the size of files stands for a full disk: the first bytes arrive, the others do not.
TEST(OutputFile, AnOldOneSurvivesAFullDisk) {
  const TemporaryFile old("a", "old");
  const std::string script = "ulimit -f 8; trap '' XFSZ; exec \"$@\"";
  const std::string move = in_checkout("examples/reveal.toml");
  for (const char* option : {"--json", "--csv"}) {
    const ProgramRun run = run_command(
        {"/bin/sh", "-c", script, "sh", in_build("inbetween"), "plan", move, option, old.path().string()});
    EXPECT_EQ(run.status, 1) << option;
    EXPECT_THAT(run.err, StartsWith(old.path().string() + ": error: could not be written completely: "));
    EXPECT_EQ(file_contents(old.path().string()), "old") << option;
    EXPECT_EQ(files_in(old.path().parent_path()), 1) << option;
  }
}

TEST(OutputFile, KeepsItsPermissions) {
  const TemporaryFile old("a", "old");
  ::chmod(old.path().c_str(), 0640);
  write_output(old.path().string(), write_text);
  EXPECT_EQ(fs::status(old.path()).permissions(), fs::perms{0640});
}

TEST(OutputFile, AWriteProtectedOneIsRefusedBeforehand) {
  const TemporaryFile old("a", "old");
  ::chmod(old.path().c_str(), 0444);
  const std::string expected = old.path().string() + ": error: is write-protected: Permission denied; ";
  EXPECT_THAT(words_of_error([&] { check_output(old.path().string()); }), StartsWith(expected));
  EXPECT_THAT(words_of_error([&] { write_output(old.path().string(), write_text); }), StartsWith(expected));
  EXPECT_EQ(file_contents(old.path().string()), "old");
  EXPECT_EQ(files_in(old.path().parent_path()), 1);
}

TEST(OutputFile, AFileOfAnotherProgramBesideItIsLeftAlone) {
  const TemporaryFile old("a", "old");
  const std::string theirs = old.path().string() + "." + std::to_string(::getpid()) + ".part";
  const std::string theirs_too = old.path().string() + "." + std::to_string(::getpid()) + "-1.part";
  for (const std::string& name : {theirs, theirs_too}) write_output(name, write_text);
  write_output(old.path().string(), [](std::FILE* file) { std::fputs("newest\n", file); });
  EXPECT_EQ(file_contents(old.path().string()), "newest\n");
  EXPECT_EQ(file_contents(theirs), "new\n");
  EXPECT_EQ(file_contents(theirs_too), "new\n");
  EXPECT_EQ(files_in(old.path().parent_path()), 3);
}

TEST(OutputFile, ASymbolicLinkGoesOnPointingToIt) {
  const TemporaryFolder folder;
  const fs::path link = folder.path() / "link";
  fs::create_directory(folder.path() / "deep");
  fs::create_symlink("deep/file", link);
  write_output(link.string(), write_text);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(file_contents((folder.path() / "deep/file").string()), "new\n");
}

TEST(OutputFile, AFullDeviceIsReportedAndStays) {
  const std::string words = words_of_error([] { write_output("/dev/full", write_text); });
  EXPECT_THAT(words,
              StartsWith("/dev/full: error: could not be written completely: No space left on device; "));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST(OutputFile, AFolderThatIsNotThereIsReportedWithARemedy) {
  const TemporaryFolder folder;
  const std::string name = (folder.path() / "no/such").string();
  const std::string expected =
      name + ": error: cannot be written: No such file or directory; choose a folder";
  EXPECT_THAT(words_of_error([&] { write_output(name, write_text); }), StartsWith(expected));
  EXPECT_THAT(words_of_error([&] { check_output(name); }), StartsWith(expected));
}

TEST(OutputFile, AFolderIsNotAFile) {
  const TemporaryFolder folder;
  const std::string expected = folder.path().string() + ": error: cannot be written: Is a directory; ";
  EXPECT_THAT(words_of_error([&] { write_output(folder.path().string(), write_text); }),
              StartsWith(expected));
  EXPECT_THAT(words_of_error([&] { check_output(folder.path().string()); }), StartsWith(expected));
}

TEST(OutputFile, AFifoThatNobodyReadsIsRefusedAtOnce) {
  const TemporaryFolder folder;
  const std::string pipe = (folder.path() / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string move = in_checkout("examples/reveal.toml");
  const std::string rig = in_checkout("examples/camera_rig.toml");
  const std::vector<std::vector<std::string>> commands = {
      {"plan", move, "--json", pipe},
      {"plan", move, "--csv", pipe},
      {"check", move, "--rig", rig, "--json", pipe},
      {"check", move, "--rig", rig, "--fit", pipe},
      {"run", move, "--rig", rig, "--sim", "--fast", "--json", pipe},
      {"run", move, "--rig", rig, "--sim", "--fast", "--record", pipe},
  };
  for (const std::vector<std::string>& arguments : commands) {
    // Half a minute stands for ever.
    std::vector<std::string> command = {"/usr/bin/timeout", "30", in_build("inbetween")};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const ProgramRun run = run_command(command);
    EXPECT_EQ(run.status, 1) << arguments.front() << " " << arguments[arguments.size() - 2] << run.err;
    EXPECT_THAT(run.err, HasSubstr(pipe + ": ")) << arguments.front();
    EXPECT_EQ(run.out, "") << "said before anything moves";
    EXPECT_TRUE(fs::is_fifo(pipe));
  }
}

TEST(OutputFile, AFifoWithAReaderReceivesAllOfIt) {
  const TemporaryFolder folder;
  const std::string script =
      "mkfifo $1; cat $1 >$2 & exec 3>$1; \"$3\" plan \"$4\" --json $1; exec 3>&-; wait";
  const std::string pipe = (folder.path() / "pipe").string();
  const std::string copy = (folder.path() / "copy").string();
  const std::string move = in_checkout("examples/reveal.toml");
  const ProgramRun run =
      run_command({"/bin/sh", "-c", script, "sh", pipe, copy, in_build("inbetween"), move});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(file_contents(copy), run_program({"plan", move, "--json", "-"}).out);
}

TEST(OutputFile, CheckingCreatesAndChangesNothing) {
  const TemporaryFile old("a", "old");
  check_output("-");
  check_output("/dev/null");
  check_output(old.path().string());
  check_output((old.path().parent_path() / "b").string());
  EXPECT_EQ(file_contents(old.path().string()), "old");
  EXPECT_EQ(files_in(old.path().parent_path()), 1);
}

}  // namespace output_file_test
}  // namespace inbetween
