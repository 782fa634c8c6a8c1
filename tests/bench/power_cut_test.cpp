// The disk of the takes loses its power, fills up, or is write-protected: ext4 on a disk of the bench, whose
// kernel is killed at any moment.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "host_tools/takes/take_store.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/places.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace power_cut_test {

using testing::HasSubstr;
using testing::SizeIs;
using Json = nlohmann::json;

const std::string reveal_on_the_rig =
    "'" + in_checkout("examples/reveal.toml") + "' --rig '" + in_checkout("examples/camera_rig.toml") + "'";
constexpr auto between_looks = std::chrono::milliseconds(5);

/// A file that is a disk of the bench, and a folder for what a script in the bench tells.
class Disk {
 public:
  explicit Disk(const std::string& size) {
    const ProgramRun made = run_command({"/usr/sbin/mkfs.ext4", "-q", place_of("disk"), size});
    if (made.status != 0) throw std::runtime_error("mkfs.ext4: " + made.err);
  }
  [[nodiscard]] std::string place_of(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] bool has(const std::string& name) const { return std::filesystem::exists(place_of(name)); }
  [[nodiscard]] Json json(const std::string& name) const {
    return Json::parse(file_contents(place_of(name)));
  }
  /// Of a script that begins in that folder, with the disk mounted, and with runs as `play`.
  [[nodiscard]] std::vector<std::string> words_of(const std::string& script) const {
    return script_words_in_bench(
        {"--disk", place_of("disk")},
        "cd '" + folder_.path().string() +
            "'\nmkdir /run/disk; mount -t ext4 /dev/ubda /run/disk; db=/run/disk/takes.db\n"
            "play() { inbetween run " +
            reveal_on_the_rig + " --sim --fast --takes-in $db \"$@\"; }\n" + script);
  }
  /// Until the last thread of a kernel that had it is gone: its lock goes with that.
  void wait_until_free() const {
    const int file = ::open(place_of("disk").c_str(), O_RDWR | O_CLOEXEC);
    struct flock whole {};
    whole.l_type = F_WRLCK;
    while (::fcntl(file, F_SETLKW, &whole) != 0 && errno == EINTR) {
    }
    ::close(file);
  }

 private:
  TemporaryFolder folder_;
};

/// A bench that goes on beside the test, until its power is cut.
class RunningBench {
 public:
  explicit RunningBench(const Disk& disk, const std::string& script) : disk_(disk) {
    std::vector<std::string> words = disk.words_of(script);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    process_ = ::fork();
    if (process_ < 0) throw std::runtime_error("cannot make a process");
    if (process_ > 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // it ends with the test, whatever ends that
    ::execv(pointers[0], pointers.data());
    ::_exit(126);
  }
  ~RunningBench() { cut_power(); }
  RunningBench(const RunningBench&) = delete;
  RunningBench& operator=(const RunningBench&) = delete;

  /// Whether the script has made that file before it ended.
  [[nodiscard]] bool tells(const std::string& name) const {
    while (!disk_.has(name)) {
      siginfo_t end{};
      ::waitid(P_PID, static_cast<id_t>(process_), &end, WEXITED | WNOHANG | WNOWAIT);
      if (end.si_pid != 0) return false;
      std::this_thread::sleep_for(between_looks);
    }
    return true;
  }
  /// sim/bench/run ends a bench by SIGKILL to all its processes.
  void cut_power() {
    if (process_ <= 0) return;
    ::kill(process_, SIGTERM);
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    disk_.wait_until_free();
  }

 private:
  const Disk& disk_;
  pid_t process_ = -1;
};

/// What runs have told of their takes, held against what is there after each cut.
class Told {
 public:
  Told(const Disk& disk, Json plain) : disk_(disk), plain_(std::move(plain)) {}

  /// The reports of a cycle that are complete: the script has said so of each.
  void read_reports(const std::string& cycle) {
    for (int i = 1; disk_.has(cycle + "." + std::to_string(i) + ".told"); ++i) {
      Json report = disk_.json(cycle + "." + std::to_string(i) + ".json");
      const Json kept = report["kept"];
      ASSERT_EQ(kept["lost"], 0) << kept;
      ticks_of_[kept["take"]] = kept["ticks"];
      report.erase("kept");
      EXPECT_EQ(report, plain_) << "the rig came to rest as without";
    }
  }
  /// A list of takes, and the records of the last two, which were exported.
  void expect_in(const std::string& cycle) {
    std::map<std::int64_t, Json> there;
    const Json list = disk_.json(cycle + ".list");
    for (const Json& take : list["takes"]) there[take["take"]] = take;
    for (const auto& [number, ticks] : ticks_of_) {
      ASSERT_EQ(there.count(number), 1U) << "take " << number << " was told to be kept";
      EXPECT_EQ(there[number]["ticks"], ticks) << number;
      EXPECT_EQ(there[number]["whole"], true) << number;
    }
    for (const auto& [number, take] : there) {
      const std::string csv = disk_.place_of(cycle + "." + std::to_string(number) + ".csv");
      if (number + 1 < there.rbegin()->first) continue;
      EXPECT_EQ(std::ranges::count(file_contents(csv), '\n'), take["ticks"].get<std::int64_t>() + 1)
          << number;
    }
  }
  [[nodiscard]] const std::map<std::int64_t, std::int64_t>& ticks_of() const { return ticks_of_; }

 private:
  const Disk& disk_;
  Json plain_;
  std::map<std::int64_t, std::int64_t> ticks_of_;
};

/// Looks at what is there, as whoever comes back after a power cut does.
std::string look(const std::string& cycle) {
  return "inbetween takes list --in $db --json " + cycle +
         ".list >/dev/null\n"
         "for take in $(grep --only-matching '\"take\":[0-9]*' " +
         cycle +
         ".list | tail --lines=2); do\n"
         "  inbetween takes export ${take#*:} --in $db --csv " +
         cycle + ".${take#*:}.csv >/dev/null\ndone\n";
}

/// A report is whole when its run has ended, and then another file says so. With a run beside these, none is
/// the last to close the file, and their log is not cleared away at their end.
std::string keep_playing(const std::string& cycle, bool has_another_beside) {
  const std::string another =
      "inbetween run " + reveal_on_the_rig + " --sim --rate 0.01 --takes-in $db &>/dev/null &\n";
  return (has_another_beside ? another : "") + "for ((i = 1;; ++i)); do play --json " + cycle +
         ".$i.json >/dev/null; : >" + cycle + ".$i.told; done\n";
}

// docs/faults.md 56
TEST(PowerCut, AtAnyMomentWhatWasToldToBeKeptIsKeptAndTheFileOpens) {
  const Disk disk("16M");
  const std::string plain = disk.place_of("plain.json");
  ASSERT_EQ(run_command({"/bin/bash", "-c",
                         "'" + in_build("inbetween") + "' run " + reveal_on_the_rig +
                             " --sim --fast --no-take --json '" + plain + "'"})
                .status,
            0);
  Told told(disk, disk.json("plain.json"));
  using Clock = std::chrono::steady_clock;
  constexpr int cuts = 20;
  std::mt19937 random(11);
  for (int cut = 0; cut < cuts; ++cut) {
    SCOPED_TRACE("cut " + std::to_string(cut));
    const std::string cycle = "cycle" + std::to_string(cut);
    RunningBench bench(disk, (cut == 0 ? "" : look(cycle)) + keep_playing(cycle, cut % 2 == 1));
    // Some runs later, and at any moment of one: the last before it took as long.
    const int runs = std::uniform_int_distribution<int>(1, 19)(random);
    Clock::time_point before, now;
    for (int run = 1; run <= runs; ++run) {
      ASSERT_TRUE(bench.tells(cycle + "." + std::to_string(run) + ".told"));
      before = run == 1 ? Clock::now() - std::chrono::seconds(1) : now;
      now = Clock::now();
    }
    std::this_thread::sleep_for((now - before) * std::uniform_real_distribution<double>(0, 1.2)(random));
    bench.cut_power();
    if (cut > 0) told.expect_in(cycle);
    told.read_reports(cycle);
    if (HasFatalFailure()) return;
  }
  const ProgramRun last =
      run_command(disk.words_of(look("last") + "play --json last.1.json >/dev/null; : >last.1.told\n"
                                               "cp $db takes.db; [[ ! -s $db-wal ]]\n"));
  ASSERT_EQ(last.status, 0) << last.err;
  told.expect_in("last");
  told.read_reports("last");
  TakeStore store(disk.place_of("takes.db"), TakeStore::Access::read);
  std::size_t partial = 0;
  for (const TakeInfo& take : store.list()) {
    const Take whole = store.read(take.number);
    ASSERT_EQ(static_cast<std::int64_t>(whole.ticks_of_take.size()), take.ticks) << take.number;
    partial += take.is_whole ? 0U : 1U;
  }
  EXPECT_GT(partial, 0U) << "a cut came into a take of which something was written";
  std::cout << cuts << " cuts, " << told.ticks_of().size() << " takes told to be kept, " << partial
            << " that a cut ended\n";
}

// docs/faults.md 55
TEST(PowerCut, ADiskThatIsFullEndsTheTakeAndNotTheRun) {
  const Disk disk("4M");
  const ProgramRun run = run_command(disk.words_of(R"(
for room in {0..480..40}; do
  head --bytes=8M /dev/zero >/run/disk/rest 2>/dev/null || true
  truncate --size=-${room}K /run/disk/rest
  play --json $room.json >$room.out 2>$room.err
  inbetween takes list --in $db --json $room.list &>/dev/null || true
  rm /run/disk/rest
done
play --json after.json >/dev/null
)"));
  ASSERT_EQ(run.status, 0) << run.err;
  int refused = 0, ended = 0, whole = 0;
  for (int room = 0; room <= 480; room += 40) {
    SCOPED_TRACE(std::to_string(room) + " kB of room");
    const std::string name = std::to_string(room);
    const Json report = disk.json(name + ".json");
    EXPECT_EQ(report["ended"], "finished");
    const std::string err = file_contents(disk.place_of(name + ".err"));
    if (!report.contains("kept")) {
      ++refused;
      EXPECT_THAT(err, HasSubstr("takes.db: warning: this run is no take: "));
      EXPECT_EQ(std::ranges::count(err, '\n'), 1);
      continue;
    }
    const Json kept = report["kept"];
    const Json takes = disk.json(name + ".list")["takes"];
    ASSERT_FALSE(takes.empty());
    EXPECT_EQ(takes.back()["take"], kept["take"]);
    EXPECT_EQ(takes.back()["ticks"], kept["ticks"]) << "what was told is there";
    if (kept["lost"] == 0) {
      ++whole;
      EXPECT_EQ(err, "");
      continue;
    }
    ++ended;
    EXPECT_THAT(err,
                HasSubstr(" warning: take " + kept["take"].dump() + " has " + kept["ticks"].dump() + " of "));
    EXPECT_THAT(err, HasSubstr("make room on the disk"));
    EXPECT_EQ(std::ranges::count(err, '\n'), 1);
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(ended, 0);
  EXPECT_GT(whole, 0);
  EXPECT_EQ(disk.json("after.json")["kept"]["lost"], 0) << "and with room again the next is kept";
}

// docs/faults.md 55
TEST(PowerCut, AWriteProtectedDiskIsOneLineAndItsTakesCanBeRead) {
  const Disk disk("16M");
  const ProgramRun run = run_command(disk.words_of(R"(
play >/dev/null
[[ ! -e $db-wal ]]
mount -o remount,ro /run/disk
play >ro.out 2>ro.err
inbetween takes list --in $db --json closed.list >/dev/null
inbetween takes show 1 --in $db >show.out
inbetween takes export 1 --in $db --csv closed.csv >/dev/null
! inbetween takes keep 1 --in $db 2>keep.err
mount -o remount,rw /run/disk
# A run that is killed leaves all in the log, and another machine leaves no index.
inbetween run )" + reveal_on_the_rig + R"( --sim --rate 0.1 --takes-in $db &>/dev/null &
begun() { inbetween takes list --in $db --json - | grep --quiet '"take":2'; }
until_true begun
kill -KILL $!
wait || true
rm $db-shm
mount -o remount,ro /run/disk
inbetween takes list --in $db --json log.list >/dev/null
! inbetween takes keep 1 --in $db 2>>keep.err
[[ -s $db-wal && ! -e $db-shm ]]
! compgen -G '/tmp/inbetween-takes-*'
)"));
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string err = file_contents(disk.place_of("ro.err"));
  EXPECT_THAT(err, HasSubstr("takes.db: warning: this run is no take: "));
  EXPECT_EQ(std::ranges::count(err, '\n'), 1);
  EXPECT_THAT(file_contents(disk.place_of("ro.out")), HasSubstr("the move was played to its last frame"));
  const Json closed = disk.json("closed.list")["takes"];
  ASSERT_THAT(closed, SizeIs(1));
  EXPECT_EQ(closed[0]["whole"], true);
  EXPECT_THAT(file_contents(disk.place_of("show.out")), HasSubstr("take 1: reveal on "));
  EXPECT_EQ(std::ranges::count(file_contents(disk.place_of("closed.csv")), '\n'),
            closed[0]["ticks"].get<std::int64_t>() + 1);
  const std::string refused = file_contents(disk.place_of("keep.err"));
  EXPECT_EQ(std::ranges::count(refused, '\n'), 2);
  EXPECT_THAT(refused, HasSubstr("it is write-protected: copy it to a folder that you may write to"));
  EXPECT_THAT(disk.json("log.list")["takes"], SizeIs(2)) << "what is in the log alone is read, too";
}

}  // namespace power_cut_test
}  // namespace inbetween
