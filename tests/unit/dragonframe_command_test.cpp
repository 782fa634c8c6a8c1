// The program itself as Dragonframe's device, at a pseudo-terminal, with a simulated rig.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
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
    const std::string program = in_build("inbetween"), rig = rig_.path(), notes = folder_.path() / "notes";
    child_ = ::fork();
    if (child_ == 0) {
      const int out = ::open(notes.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      const int in = ::open("/dev/null", O_RDONLY);
      ::dup2(in, 0);
      ::dup2(out, 1);
      ::dup2(out, 2);
      ::execl(program.c_str(), program.c_str(), "dragonframe", "--rig", rig.c_str(), "--device", port.c_str(),
              "--protocol", protocol.c_str(), "--sim", "--yes", nullptr);
      ::_exit(126);
    }
    while (file_ < 0) {
      file_ = ::open(port_name().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
      if (file_ < 0) ::poll(nullptr, 0, 5);
      if (file_ < 0 && ::waitpid(child_, nullptr, WNOHANG) != 0) throw std::runtime_error("it has ended");
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() {
    if (file_ >= 0) ::close(file_);
    if (child_ > 0) end();
  }
  /// The exit status behind an interrupt.
  int end() {
    ::kill(child_, SIGINT);
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }
  [[nodiscard]] std::string notes() const { return file_contents(folder_.path() / "notes"); }
  [[nodiscard]] std::string port_name() const { return folder_.path() / "port"; }

  void write(const oracle::DmcBytes& bytes) const {
    if (::write(file_, bytes.data(), bytes.size()) < 0) throw std::runtime_error("the port is gone");
  }
  /// What has come, at least a byte.
  [[nodiscard]] oracle::DmcBytes read() const {
    pollfd watched{.fd = file_, .events = POLLIN, .revents = 0};
    if (::poll(&watched, 1, 10'000) <= 0) throw std::runtime_error("the device is silent");
    std::array<std::uint8_t, 1024> bytes{};
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    return {bytes.begin(), bytes.begin() + (count > 0 ? count : 0)};
  }
  unsigned ask(const oracle::DmcBytes& request) {
    write(request);
    host.hear(read());
    while (host.answers() == 0) host.hear(read());
    return host.code();
  }
  void wait_until_still() {
    do {
      ::poll(nullptr, 0, 5);
      static_cast<void>(ask(host.status()));
    } while (host.data()->number(0, 4) != 0);
  }
  std::int32_t position() {
    static_cast<void>(ask(host.positions()));
    return host.data()->position(1);
  }

  oracle::DmcHost host;

 private:
  TemporaryFolder folder_;
  TemporaryFile rig_;
  pid_t child_ = -1;
  int file_ = -1;
};

TEST(DragonframeCommand, MovesASimulatedRigForAHost) {
  Program program("dmc");
  static_cast<void>(program.ask(program.host.hi()));
  EXPECT_EQ(program.host.data()->payload.at(35), 1) << "motors";
  while (program.ask(program.host.move(1, 500)) != ok) ::poll(nullptr, 0, 5);  // the consent of --yes
  program.wait_until_still();
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
  program.wait_until_still();
  ASSERT_EQ(program.ask(program.host.run({.fps_1000 = 25'000, .start = 1, .end = 40, .preroll_ms = 200})),
            ok);
  program.wait_until_still();
  while (program.ask(program.host.go()) != ok) ::poll(nullptr, 0, 5);
  program.wait_until_still();
  EXPECT_EQ(program.position(), steps.back());
  ASSERT_EQ(program.ask(program.host.stop_all()), ok);
  EXPECT_EQ(program.ask(program.host.move(1, 0)), general) << "a stop takes the consent away";
  EXPECT_EQ(program.end(), 0);
  EXPECT_THAT(program.notes(), HasSubstr("outside its limits -180..180 deg"));
  EXPECT_THAT(program.notes(), HasSubstr("the host stopped the rig"));
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
