// Dragonframe's device under a host that says all it can, on a bus with drives in another process: the loop
// that ticks those drives is as punctual as without it. How punctual that is, is the machine's affair, and is
// printed.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "drivers/linux/host_port.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/hosted/host_session.hpp"
#include "tests/bench/inside/drives_process.hpp"
#include "tests/support/oracle_dmc_host.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace hosted_on_bus_test {

constexpr unsigned ok = 0x10;
constexpr unsigned axes = 8;
constexpr std::int32_t frames = 2000;
constexpr std::int32_t far_away = 150'000;
constexpr int requests = 64 * 500;

/// Slow enough for drives that are a process of a machine with other work to hear every SYNC in time.
std::string rig_of_eight() {
  std::vector<AxisText> texts;
  std::string steps;
  for (unsigned a = 1; a <= axes; ++a) {
    const std::string name = "axis" + std::to_string(a);
    texts.push_back(axis_text(name, "deg", {-180, 180}, {.velocity = 10, .acceleration = 100},
                              R"(unpowered = "holds")", cia402_text(static_cast<int>(a))));
    steps += (a > 1 ? ", " : "") + name + " = 1000";
  }
  return rig_text(texts,
                  {.rate_hz = 50, .more = bus_can0 + "[dragonframe]\nsteps_per_unit = { " + steps + " }\n"});
}

/// A host at the other end of the port, which waits for every answer.
class HostAtPort {
 public:
  explicit HostAtPort(const std::string& name) : file_(::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (file_ < 0) throw std::runtime_error("there is no port");
  }
  ~HostAtPort() { ::close(file_); }
  HostAtPort(const HostAtPort&) = delete;
  HostAtPort& operator=(const HostAtPort&) = delete;

  void say(const oracle::DmcBytes& bytes) const {
    if (::write(file_, bytes.data(), bytes.size()) < 0) throw std::runtime_error("the port is gone");
  }
  unsigned ask(const oracle::DmcBytes& request) {
    say(request);
    while (host.answers() == 0) hear();
    return host.code();
  }
  void hear() {
    pollfd watched{.fd = file_, .events = POLLIN, .revents = 0};
    if (::poll(&watched, 1, 10'000) <= 0) throw std::runtime_error("the device is silent");
    std::array<std::uint8_t, 1024> bytes{};
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    if (count > 0) host.hear({bytes.begin(), bytes.begin() + count});
    pushed += host.take_heard().size();
  }
  [[nodiscard]] std::uint32_t moving() {
    static_cast<void>(ask(host.status()));
    return host.data()->number(0, 4);
  }

  oracle::DmcHost host;
  std::size_t pushed = 0;

 private:
  int file_ = -1;
};

void expect_ok(unsigned code) {
  if (code != ok) throw std::runtime_error(fmt::format("the device answers {:#x}", code));
}

/// A whole upload, with its proof, and then questions one behind the other, while all axes move.
void hurry(HostAtPort& at) {
  expect_ok(at.ask(at.host.upload_begin(1, frames)));
  for (unsigned motor = 1; motor <= axes; ++motor) {
    for (std::int32_t first = 0; first < frames; first += 200) {
      std::vector<std::int32_t> positions;
      for (std::int32_t k = first; k < first + 200; ++k)
        positions.push_back(static_cast<std::int32_t>(motor) * k);
      expect_ok(at.ask(
          at.host.upload_axis(motor, static_cast<std::uint32_t>(first), first + 200 == frames, positions)));
    }
  }
  expect_ok(at.ask(at.host.upload_end()));
  // 64 in one breath: more than 10 000 a second, of which a serial port has 960.
  for (int i = 0; i < requests; i += 64) {
    oracle::DmcBytes breath;
    for (int k = 0; k < 63; ++k) {
      const oracle::DmcBytes one = k % 2 == 0 ? at.host.status() : at.host.positions();
      breath.insert(breath.end(), one.begin(), one.end());
    }
    at.say(breath);
    static_cast<void>(at.ask(at.host.status()));
  }
}

struct Stretch {
  HostSessionEnd end = {};
  double seconds = 0;  ///< in which the host said what it had to say
  std::string failure = "";
};

/// Eight axes go far; meanwhile the host hurries, or listens only, for as long.
Stretch stretch(bool hurries, double seconds) {
  const RigFile rig = parse_rig(rig_of_eight(), "rig.toml");
  const DrivesProcess drives(rig);
  const TemporaryFolder folder;
  const std::string name = folder.path() / "port";
  HostPort port;
  if (port.open("pty:" + name, 115'200)) throw std::runtime_error("no port");
  RigReference reference(rig);
  std::atomic<bool> is_over = false;
  std::atomic<bool> is_agreed = false;
  Stretch made;
  const auto play = [&] {
    const MonotonicClock clock;
    HostAtPort at(name);
    is_agreed.wait(false);  // the drives are on
    for (unsigned motor = 1; motor <= axes; ++motor) {
      expect_ok(at.ask(at.host.configure(motor, 1)));
      expect_ok(at.ask(at.host.speed(motor, 10'000, 100'000)));
    }
    for (unsigned motor = 1; motor <= axes; ++motor) expect_ok(at.ask(at.host.move(motor, far_away)));
    const std::int64_t began_ns = clock.now_ns();
    const auto passed_s = [&] { return static_cast<double>(clock.now_ns() - began_ns) / 1e9; };
    if (hurries) hurry(at);
    while (passed_s() < seconds) at.hear();
    made.seconds = passed_s();
    if (at.moving() != (1U << axes) - 1) throw std::runtime_error("something rests too early");
  };
  std::thread host([&] {
    try {
      play();
    } catch (const std::exception& error) {
      made.failure = error.what();
    }
    is_over = true;
  });
  HostSessionOptions options{.consent = Consent::given, .share = 1};
  options.session.audience.interrupted = [&] { return is_over.load(); };
  options.tell = [&](const std::string& /*state*/, const std::vector<std::string>& events) {
    for (const std::string& event : events) {
      if (!event.starts_with("agreed")) continue;
      is_agreed = true;
      is_agreed.notify_all();
    }
  };
  made.end = give_to_host(rig, port, reference, options);
  is_agreed = true;
  is_agreed.notify_all();
  host.join();
  return made;
}

TEST(HostedOnBus, NoTickIsLateForAHostThatUploadsAndAsksWithoutAPauseWhileAllAxesMove) {
  std::ofstream("/proc/sys/kernel/sched_rt_runtime_us") << "-1";
  fmt::print("{:<28}{:>8}{:>12}{:>12}{:>12}\n", "", "s", "late ticks", "99 % us", "worst us");
  std::vector<std::int64_t> late_with, late_without;
  for (int i = 0; i < 2; ++i) {
    const Stretch with = stretch(true, 0);
    ASSERT_EQ(with.failure, "") << with.end.reason;
    const Stretch without = stretch(false, with.seconds);
    ASSERT_EQ(without.failure, "") << without.end.reason;
    for (const auto& [what, made] :
         {std::pair{"a host that hurries", &with}, std::pair{"one that listens", &without}}) {
      fmt::print("{:<28}{:>8.1f}{:>12}{:>12.0f}{:>12.0f}\n", what, made->seconds, made->end.late_ticks,
                 made->end.latency.p99_us, made->end.latency.max_us);
    }
    late_with.push_back(with.end.late_ticks);
    late_without.push_back(without.end.late_ticks);
  }
  // What the machine does besides makes a tick late in either; what the host does would in each of the first.
  EXPECT_LE(*std::ranges::min_element(late_with), *std::ranges::max_element(late_without));
}

}  // namespace hosted_on_bus_test
}  // namespace inbetween
