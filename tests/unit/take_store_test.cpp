// What was told to be kept is kept, whatever ends the program or fills the disk; and the run goes on.
#include "host_tools/takes/take_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "tests/support/places.hpp"
#include "tests/support/property.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_store_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

Plan plan_of_reveal() {
  return {read_move_file(reveal), read_rig_file(camera_rig), {}};
}

RunReport run_kept(const Plan& plan, const TakeKeeping& keeping) {
  return run(plan, {.simulated = true, .fast = true}, {.take = TakeRequest{.keeping = keeping}});
}

/// Files of this process are at most so long while it lives.
class ShortTakes {
 public:
  explicit ShortTakes(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit shorter{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &shorter);
  }
  ~ShortTakes() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_DFL);
  }
  ShortTakes(const ShortTakes&) = delete;
  ShortTakes& operator=(const ShortTakes&) = delete;

 private:
  rlimit before_{};
};

void kill_child(pid_t child) {
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
}

/// Every tick that the list says is there, and no other.
void expect_whole(TakeStore& store, std::int64_t take) {
  const Take all = store.read(take);
  EXPECT_EQ(static_cast<std::int64_t>(all.ticks_of_take.size()), all.ticks);
  std::int64_t next = 0;
  for (const TakeTick& tick : all.ticks_of_take) ASSERT_EQ(tick.number, next++);
}

// docs/faults.md 55
TEST(TakeStore, ADiskThatFillsUpEndsTheTakeAndNotTheRun) {
  const Plan plan = plan_of_reveal();
  const std::vector<RunAxis> plain = run(plan, {.simulated = true, .fast = true}).axes;
  // Full at the beginning, in the middle, and at the end.
  for (const rlim_t bytes : {4096U, 60'000U, 100'000U, 115'000U, 130'000U, 150'000U}) {
    const TemporaryFolder folder;
    const std::string file = folder.path() / "takes.db";
    RunReport report;
    {
      const ShortTakes full(bytes);
      report = run_kept(plan, {.file = file});
    }
    EXPECT_EQ(report.ending, Ending::finished) << report.reason;
    for (std::size_t a = 0; a < plain.size(); ++a)
      EXPECT_EQ(report.axes[a].last_actual, plain[a].last_actual) << "the rig came to rest as without";
    if (!report.kept) continue;  // it could not be begun
    if (report.kept->lost > 0) {
      EXPECT_NE(report.kept->why, "");
    }
    TakeStore store(file, TakeStore::Access::read);
    const std::vector<TakeInfo> takes = store.list();
    ASSERT_THAT(takes, SizeIs(1));
    EXPECT_EQ(takes[0].ticks, report.kept->ticks) << "what was told is there";
    expect_whole(store, report.kept->number);
  }
}

// docs/faults.md 55
TEST(TakeStore, AFolderThatCannotBeWrittenIsOneLineAndTheRunGoesOn) {
  const ProgramRun run =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--takes-in", "/proc/takes.db"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err,
              HasSubstr("/proc/takes.db: warning: this run is no take: unable to open database file"));
  EXPECT_EQ(std::ranges::count(run.err, '\n'), 1);
  EXPECT_THAT(run.out, HasSubstr("reveal: the move was played to its last frame"));
}

/// Somebody to whom a folder is write-protected, also where the tests run as root.
class Nobody {
 public:
  Nobody() {
    if (geteuid() == 0) is_other_ = setresuid(65534, 65534, 0) == 0;
  }
  ~Nobody() {
    if (is_other_ && setresuid(0, 0, 0) != 0) std::abort();
  }
  Nobody(const Nobody&) = delete;
  Nobody& operator=(const Nobody&) = delete;

 private:
  bool is_other_ = false;
};

void protect(const std::filesystem::path& folder) {
  for (const auto& file : std::filesystem::directory_iterator(folder))
    std::filesystem::permissions(file.path(), std::filesystem::perms(0444));
  std::filesystem::permissions(folder, std::filesystem::perms(0555));
}

/// Read with what is in its log, and left as it was.
void expect_read_where_it_is_write_protected(const std::filesystem::path& folder, const std::string& file,
                                             std::int64_t ticks) {
  protect(folder);
  const std::string before = file_contents(folder / file) + file_contents(folder / (file + "-wal"));
  {
    const Nobody nobody;
    TakeStore store(folder / file, TakeStore::Access::read);
    const std::vector<TakeInfo> takes = store.list();
    ASSERT_THAT(takes, SizeIs(1));
    EXPECT_EQ(takes[0].ticks, ticks);
    expect_whole(store, 1);
    EXPECT_THAT([&] { store.mark(1, true); },
                testing::ThrowsMessage<TakeStoreError>(HasSubstr("it is write-protected: copy it")));
  }
  EXPECT_EQ(file_contents(folder / file) + file_contents(folder / (file + "-wal")), before);
  EXPECT_FALSE(std::filesystem::exists(folder / (file + "-shm")));
  std::filesystem::permissions(folder, std::filesystem::perms(0755));
}

TEST(TakeStore, InAFolderThatIsWriteProtectedItIsReadAsItIs) {
  const TemporaryFolder folder;
  const RunReport report = run_kept(plan_of_reveal(), {.file = folder.path() / "?takes #1%20.db"});
  expect_read_where_it_is_write_protected(folder.path(), "?takes #1%20.db", report.kept->ticks);
}

TEST(TakeStore, InAFolderThatIsWriteProtectedItIsReadWithItsLog) {
  const TemporaryFolder folder, killed;
  const std::string file = folder.path() / "takes.db";
  // While somebody has it open all of it is in its log. The power is cut: its index is lost.
  TakeStore open(file, TakeStore::Access::write);
  const RunReport report = run_kept(plan_of_reveal(), {.file = file});
  for (const char* name : {"takes.db", "takes.db-wal"})
    std::filesystem::copy_file(folder.path() / name, killed.path() / name);
  ASSERT_GT(std::filesystem::file_size(killed.path() / "takes.db-wal"), 10'000U);
  expect_read_where_it_is_write_protected(killed.path(), "takes.db", report.kept->ticks);
  // Through a link from a folder that is not.
  const std::string link = folder.path() / "link.db";
  std::filesystem::create_symlink(killed.path() / "takes.db", link);
  protect(killed.path());
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  const Nobody nobody;
  EXPECT_THAT(TakeStore(link, TakeStore::Access::read).list(), SizeIs(1));
}

// docs/faults.md 56
TEST(TakeStore, KilledAtAnyMomentItHasWhatWasToldToBeKept) {
  const Plan plan = plan_of_reveal();
  static_cast<void>(plan.motion());  // fitted once
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  std::mt19937 random(7);
  std::map<std::int64_t, std::int64_t> told;
  for (int kill = 0; kill < cases_to_run(60); ++kill) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (;;) {
        const RunReport report = run_kept(plan, {.file = file});
        const std::int64_t kept[2] = {report.kept->number, report.kept->ticks};
        if (write(ends[1], kept, sizeof kept) != sizeof kept) _exit(1);
      }
    }
    close(ends[1]);
    std::this_thread::sleep_for(
        std::chrono::microseconds(std::uniform_int_distribution<int>(1'000, 300'000)(random)));
    kill_child(child);
    std::int64_t kept[2];
    while (read(ends[0], kept, sizeof kept) == sizeof kept) told[kept[0]] = kept[1];
    close(ends[0]);
  }
  TakeStore store(file, TakeStore::Access::write);
  std::map<std::int64_t, TakeInfo> there;
  for (const TakeInfo& take : store.list()) there[take.number] = take;
  for (const auto& [number, ticks] : told) {
    ASSERT_EQ(there.count(number), 1U) << number;
    EXPECT_EQ(there[number].ticks, ticks);
    EXPECT_TRUE(there[number].is_whole);
  }
  for (const auto& [number, take] : there) {
    expect_whole(store, number);
    if (told.count(number) == 0 && !take.ending.empty()) told[number] = take.ticks;  // killed before it told
  }
  EXPECT_FALSE(told.empty());
  EXPECT_EQ(run_kept(plan, {.file = file}).kept->lost, 0) << "and the next run keeps its own";
}

TEST(TakeStore, AnAxisInNoTrackComesBackAsOne) {
  const TemporaryFolder folder;
  TakeStore store(folder.path() / "takes.db", TakeStore::Access::write);
  Take take;
  take.axes = {{.name = "focus", .unit = "mm", .resolution = 0.1},
               {.name = "pan", .unit = "deg", .resolution = 0.01, .move_axis = 0}};
  const Take kept = store.read_head(store.begin(take));
  ASSERT_THAT(kept.axes, SizeIs(2));
  EXPECT_EQ(kept.axes[0].move_axis, std::nullopt);
  EXPECT_EQ(kept.axes[1].move_axis, 0U);
}

TEST(TakeStore, TheOldestAreForgottenAndNeverOneThatIsMarked) {
  const Plan plan = plan_of_reveal();
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  for (int i = 0; i < 4; ++i) run_kept(plan, {.file = file});
  {
    TakeStore store(file, TakeStore::Access::read);
    store.mark(2, true);
  }
  const std::int64_t size = TakeStore(file, TakeStore::Access::read).used_bytes();
  const RunReport report = run_kept(plan, {.file = file, .max_bytes = size});
  EXPECT_EQ(report.kept->lost, 0);
  TakeStore store(file, TakeStore::Access::read);
  std::vector<std::int64_t> left;
  for (const TakeInfo& take : store.list()) left.push_back(take.number);
  std::vector<std::int64_t> expected{1, 2, 3, 4, 5};
  for (const std::int64_t gone : report.kept->forgotten) std::erase(expected, gone);
  EXPECT_EQ(left, expected);
  ASSERT_THAT(report.kept->forgotten, testing::Not(IsEmpty()));
  EXPECT_EQ(report.kept->forgotten.front(), 1) << "the oldest first";
  EXPECT_THAT(left, testing::AllOf(testing::Contains(2), testing::Contains(5)));
  EXPECT_LE(store.used_bytes(), size);
  EXPECT_LE(static_cast<std::int64_t>(std::filesystem::file_size(file)), size + 65'536) << "room goes back";
}

/// The thread that writes a take goes on with it between two portions: hours of an old take go in seconds.
TEST(TakeStore, ALongTakeIsForgottenInPortionsAndIsInNoListMeanwhile) {
  const TemporaryFolder folder;
  TakeStore store(folder.path() / "takes.db", TakeStore::Access::write);
  const auto add_take = [&](std::int64_t chunks) {
    const std::int64_t number = store.begin({});
    for (std::int64_t i = 0; i < chunks; ++i)
      store.append(number, {.first = 250 * i, .ticks = 250, .bytes = std::string(20'000, 'x')}, {}, 0);
    return number;
  };
  add_take(10);
  add_take(3);
  const std::int64_t now = add_take(1);
  const std::int64_t before = store.used_bytes();
  const std::int64_t allowed = before - 30'000;
  const TakeStore::Pruned first = store.prune_some(allowed, 4, now);
  EXPECT_FALSE(first.is_done);
  EXPECT_FALSE(first.gone);
  EXPECT_LT(store.used_bytes(), before - 70'000) << "four chunks have gone";
  EXPECT_THAT(store.list(), SizeIs(2));
  EXPECT_THROW(static_cast<void>(store.read_head(1)), TakeStoreError);
  EXPECT_FALSE(store.prune_some(allowed, 4, now).gone) << "though all that is left is little enough";
  EXPECT_EQ(store.prune_some(allowed, 4, now).gone, 1);
  EXPECT_TRUE(store.prune_some(allowed, 4, now).is_done);
  EXPECT_THAT(store.list(), SizeIs(2));
  EXPECT_THAT(store.prune(0, now), ElementsAre(2));
}

TEST(TakeStore, ATakeThatIsTooLargeAloneEndsThere) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  const std::int64_t empty = TakeStore(file, TakeStore::Access::write).used_bytes();
  const RunReport report = run_kept(plan_of_reveal(), {.file = file, .max_bytes = empty + 8'000});
  EXPECT_EQ(report.ending, Ending::finished);
  EXPECT_GT(report.kept->lost, 0);
  EXPECT_THAT(report.kept->why, HasSubstr("--keep"));
}

TEST(TakeStore, AnotherProgramsFileAndOneOfANewerVersionAreRefused) {
  const TemporaryFile text("takes.db",
                           "no database, but text that is longer than a header of one would be, so\n"
                           "that nobody takes it for an empty file or one that is cut off\n");
  EXPECT_THAT([&] { TakeStore(text.path(), TakeStore::Access::write); },
              testing::ThrowsMessage<TakeStoreError>(HasSubstr("takes.db: error: file is not a database; ")));
  EXPECT_THAT(file_contents(text.path()), testing::StartsWith("no database"));
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  EXPECT_THAT([&] { TakeStore(file, TakeStore::Access::read); },
              testing::ThrowsMessage<TakeStoreError>(HasSubstr("there are no takes")));
  { const TakeStore made(file, TakeStore::Access::write); }
  std::string bytes = file_contents(file);
  ASSERT_GT(bytes.size(), 100U);
  bytes[63] = 2;  // the lowest byte of user_version
  const TemporaryFile newer("takes.db", bytes);
  EXPECT_THAT(
      [&] { TakeStore(newer.path(), TakeStore::Access::read); },
      testing::ThrowsMessage<TakeStoreError>(HasSubstr("it is of version 2, and this program knows 1")));
  bytes[63] = 1;
  bytes[71] = 0;  // of application_id
  const TemporaryFile other("takes.db", bytes);
  EXPECT_THAT([&] { TakeStore(other.path(), TakeStore::Access::read); },
              testing::ThrowsMessage<TakeStoreError>(HasSubstr("this is no file of takes")));
}

TEST(TakeStore, ADamagedChunkIsTold) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  {
    TakeStore store(file, TakeStore::Access::write);
    Take take;
    take.rate_hz = 250;
    take.trajectory = bytes_of(plan_of_reveal().motion());
    take.axes = {{.name = "x", .unit = "mm", .resolution = 0.001}};
    EXPECT_EQ(store.begin(take), 1);
    store.append(1, {.first = 0, .ticks = 1, .bytes = "no chunk of ticks"}, {}, 0);
  }
  TakeStore store(file, TakeStore::Access::read);
  EXPECT_THAT(
      [&] { static_cast<void>(store.read(1)); },
      testing::ThrowsMessage<TakeStoreError>(HasSubstr(
          "takes.db: error: take 1 is damaged from tick 0 on: its check sum is wrong; move the file")));
  EXPECT_EQ(store.list().at(0).ending, "");
}

TEST(TakeStore, ASizeIsWrittenInWords) {
  EXPECT_EQ(size_in_bytes("20M"), 20'000'000);
  EXPECT_EQ(size_in_bytes("1.5G"), 1'500'000'000);
  EXPECT_EQ(size_in_bytes("300"), 300);
  for (const char* wrong : {"", "M", "-3M", "20m", "20MB", "nan", "1e30G"})
    EXPECT_EQ(size_in_bytes(wrong), std::nullopt) << wrong;
  EXPECT_EQ(size_in_words(312'400), "312 kB");
}

}  // namespace take_store_test
}  // namespace inbetween
