// The program itself as Dragonframe's device, at a pseudo-terminal, with a simulated rig.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/oracle_dmc_host.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace dragonframe_command_test {

using testing::HasSubstr;

constexpr unsigned ok = 0x10, general = 0x15, soft_upper = 0x20;

std::string rig_for_host() {
  return rig_text({axis_text("pan", "deg", {-180, 180}, {.velocity = 60, .acceleration = 240})},
                  {.rate_hz = 250, .more = "[dragonframe]\nsteps_per_unit = { pan = 1000 }\n"});
}

/// The program, as long as this is there, and a host at its port.
class Program {
 public:
  explicit Program(const std::string& protocol) : rig_("rig.toml", rig_for_host()) {
    const std::string port = "pty:" + port_name();
    const std::string program = in_build("inbetween"), rig = rig_.path();
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("there is no pipe");
    child_ = ::fork();
    if (child_ == 0) {
      ::dup2(::open("/dev/null", O_RDONLY), 0);
      ::dup2(ends[1], 1);
      ::dup2(ends[1], 2);
      ::execl(program.c_str(), program.c_str(), "dragonframe", "--rig", rig.c_str(), "--device", port.c_str(),
              "--protocol", protocol.c_str(), "--sim", "--yes", nullptr);
      ::_exit(126);
    }
    ::close(ends[1]);
    out_ = ends[0];
    await_words(protocol + " at " + port);  // the port is there
    file_ = ::open(port_name().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (file_ < 0) throw std::runtime_error("the port is not there");
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() {
    if (file_ >= 0) ::close(file_);
    if (child_ > 0) end();
    ::close(out_);
  }
  /// The exit status behind an interrupt.
  int end() {
    ::kill(child_, SIGINT);
    while (read_words()) {
    }
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }
  /// What it has said so far.
  [[nodiscard]] const std::string& words() const { return words_; }
  void await_words(const std::string& words) {
    while (words_.find(words) == std::string::npos) {
      if (!read_words()) throw std::runtime_error("it has ended: " + words_);
    }
  }
  [[nodiscard]] std::string port_name() const { return folder_.path() / "port"; }

  /// The code of its acknowledgement, 0 where data answered it.
  unsigned ask(const oracle::DmcBytes& request) {
    if (::write(file_, request.data(), request.size()) < 0) throw std::runtime_error("the port is gone");
    while (host.answers() == 0) host.hear(read());
    pushed_ = 0;
    for (const oracle::DmcHeard& message : host.take_heard())
      pushed_ = message.id == host.last_id() ? 0 : pushed_ + 1;
    return host.code();
  }
  /// Until the device has told something by itself since its last answer.
  void await_push() {
    while (pushed_ == 0) {
      host.hear(read());
      pushed_ = host.take_heard().size();
    }
    pushed_ = 0;
  }
  /// A device tells where it is while it moves, and when it rests.
  void await_rest() {
    while (static_cast<void>(ask(host.status())), host.data()->number(0, 4) != 0) await_push();
  }
  std::int32_t position() {
    static_cast<void>(ask(host.positions()));
    return host.data()->position(1);
  }

  oracle::DmcHost host;

 private:
  /// False: there are no more.
  bool read_words() {
    std::array<char, 1024> text{};
    const ssize_t count = ::read(out_, text.data(), text.size());
    if (count > 0) words_.append(text.data(), static_cast<std::size_t>(count));
    return count > 0;
  }
  /// What has come to the port, at least a byte.
  [[nodiscard]] oracle::DmcBytes read() const {
    pollfd watched{.fd = file_, .events = POLLIN, .revents = 0};
    if (::poll(&watched, 1, 10'000) <= 0) throw std::runtime_error("the device is silent");
    std::array<std::uint8_t, 1024> bytes{};
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    return {bytes.begin(), bytes.begin() + (count > 0 ? count : 0)};
  }

  TemporaryFolder folder_;
  TemporaryFile rig_;
  pid_t child_ = -1;
  int out_ = -1;
  int file_ = -1;
  std::string words_;
  std::size_t pushed_ = 0;
};

TEST(DragonframeCommand, MovesASimulatedRigForAHost) {
  Program program("dmc");
  static_cast<void>(program.ask(program.host.hi()));
  EXPECT_EQ(program.host.data()->payload.at(35), 1) << "motors";
  program.await_words("agreed: the host may move the rig");  // the consent of --yes
  ASSERT_EQ(program.ask(program.host.move(1, 500)), ok);
  program.await_rest();
  EXPECT_EQ(program.position(), 500);
  EXPECT_EQ(program.ask(program.host.move(1, 180'001)), soft_upper);

  std::vector<std::int32_t> steps;
  for (int k = 0; k < 20; ++k) steps.push_back(500 + 2 * k * k);
  for (int k = 0; k < 20; ++k) steps.push_back(2 * steps[19] - steps[static_cast<std::size_t>(19 - k)]);
  ASSERT_EQ(program.ask(program.host.configure(1, 1)), ok);
  ASSERT_EQ(program.ask(program.host.upload_begin(1, 40)), ok);
  ASSERT_EQ(program.ask(program.host.upload_axis(1, 0, true, steps)), ok);
  ASSERT_EQ(program.ask(program.host.upload_end()), ok);
  ASSERT_EQ(program.ask(program.host.position_frame(1)), ok);
  program.await_rest();
  ASSERT_EQ(program.ask(program.host.run({.fps_1000 = 25'000, .start = 1, .end = 40, .preroll_ms = 200})),
            ok);
  while (program.ask(program.host.go()) != ok) program.await_push();  // until it waits for it
  program.await_rest();
  EXPECT_EQ(program.position(), steps.back());
  ASSERT_EQ(program.ask(program.host.stop_all()), ok);
  EXPECT_EQ(program.ask(program.host.move(1, 0)), general) << "a stop takes the consent away";
  EXPECT_EQ(program.end(), 0);
  EXPECT_THAT(program.words(), HasSubstr("outside its limits -180..180 deg"));
  EXPECT_THAT(program.words(), HasSubstr("the host stopped the rig"));
}

TEST(DragonframeCommand, RefusesARigWithoutSteps) {
  const TemporaryFile rig("rig.toml", rig_text({axis_text("pan", "deg", {-180, 180})}));
  const ProgramRun run =
      run_program({"dragonframe", "--rig", rig.path(), "--device", "pty:" + rig.path().string() + ".port",
                   "--protocol", "dmc", "--sim", "--yes"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("how many steps of Dragonframe make a unit"));
}

}  // namespace dragonframe_command_test
}  // namespace inbetween
