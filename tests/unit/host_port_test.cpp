// A port at which one host at a time is: a serial port, a pseudo-terminal under a name, and TCP of this
// machine.
#include "drivers/linux/host_port.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace host_port_test {

constexpr std::int32_t baud = 115'200;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {std::bit_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string read_from(HostPort& port) {
  std::array<std::uint8_t, 256> bytes{};
  std::string text;
  for (std::size_t count = 0; (count = port.read(bytes)) > 0;) {
    text.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return text;
}

/// What the other end of a file has sent, at least a byte of it.
std::string heard_at(int file) {
  pollfd watched{.fd = file, .events = POLLIN, .revents = 0};
  ::poll(&watched, 1, 2000);
  std::array<char, 256> text{};
  const ssize_t count = ::read(file, text.data(), text.size());
  return {text.data(), count > 0 ? static_cast<std::size_t>(count) : 0};
}

int open_pty_of(const std::string& name) {
  return ::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
}

TEST(HostPort, IsAPseudoTerminalUnderAName) {
  const TemporaryFolder folder;
  const std::string name = folder.path() / "host_port";
  HostPort port;
  ASSERT_FALSE(port.open("pty:" + name, baud));
  EXPECT_EQ(port.look(0), PortChange::none) << "nobody has it open";
  EXPECT_EQ(port.write(bytes_of("lost")), 0U);

  const int host = open_pty_of(name);
  ASSERT_GE(host, 0);
  EXPECT_EQ(port.look(0), PortChange::came);
  EXPECT_EQ(port.look(0), PortChange::none);
  // All bytes pass as they are, a line end and an interrupt among them.
  ASSERT_EQ(::write(host, "a\r\n\x03", 4), 4);
  EXPECT_EQ(read_from(port), "a\r\n\x03");
  EXPECT_EQ(port.write(bytes_of("b\n\x04")), 3U);
  EXPECT_EQ(heard_at(host), "b\n\x04");

  EXPECT_LT(open_pty_of(name), 0) << "a second host finds no port";
  ::close(host);
  EXPECT_EQ(port.look(0), PortChange::went);
  EXPECT_FALSE(port.has_host());
  EXPECT_EQ(port.look(0), PortChange::none);

  const int next = open_pty_of(name);
  ASSERT_GE(next, 0) << "the next one finds it";
  EXPECT_EQ(port.look(0), PortChange::came);
  ::close(next);
  port.close();
  EXPECT_FALSE(std::filesystem::is_symlink(name)) << "and it is not left behind";
}

TEST(HostPort, KeepsNothingForTheNextHostOfAPseudoTerminal) {
  const TemporaryFolder folder;
  const std::string name = folder.path() / "host_port_next";
  HostPort port;
  ASSERT_FALSE(port.open("pty:" + name, baud));
  const int first = open_pty_of(name);
  ASSERT_EQ(port.look(0), PortChange::came);
  ASSERT_GT(port.write(bytes_of("for the first")), 0U);
  ::close(first);
  ASSERT_EQ(port.look(0), PortChange::went);
  const int second = ::open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  ASSERT_EQ(port.look(0), PortChange::came);
  std::array<char, 64> text{};
  EXPECT_LE(::read(second, text.data(), text.size()), 0);
  ::close(second);
}

/// A serial port and what is at the other end of its cable: a pair of pseudo-terminals, whose settings the
/// last program has left as no host can use them.
class SerialCable {
 public:
  SerialCable() : far_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    std::array<char, 128> path{};
    EXPECT_TRUE(::grantpt(far_) == 0 && ::unlockpt(far_) == 0 &&
                ::ptsname_r(far_, path.data(), path.size()) == 0);
    path_ = path.data();
    witness_ = open_pty_of(path_);
    termios spoilt = settings();
    spoilt.c_iflag |= IXON | IXOFF | IXANY | ICRNL | ISTRIP;
    spoilt.c_oflag |= OPOST;
    spoilt.c_lflag |= ICANON | ECHO | ISIG;
    spoilt.c_cflag |= CSTOPB | CRTSCTS | HUPCL;
    spoilt.c_cflag &= ~static_cast<tcflag_t>(CLOCAL);
    EXPECT_EQ(::tcsetattr(witness_, TCSANOW, &spoilt), 0);
  }
  SerialCable(const SerialCable&) = delete;
  SerialCable& operator=(const SerialCable&) = delete;
  ~SerialCable() {
    ::close(witness_);
    unplug();
  }
  void unplug() {
    if (far_ >= 0) ::close(far_);
    far_ = -1;
  }
  [[nodiscard]] int far_end() const { return far_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] termios settings() const {
    termios now{};
    EXPECT_EQ(::tcgetattr(witness_, &now), 0);
    return now;
  }
  [[nodiscard]] bool is_exclusive() const {
    int exclusive = 0;
    EXPECT_EQ(::ioctl(witness_, TIOCGEXCL, &exclusive), 0);
    return exclusive != 0;
  }

 private:
  int far_ = -1;
  int witness_ = -1;  ///< the serial port as another program has it open, before it is taken
  std::string path_;
};

TEST(HostPort, SetsASerialPortAndHasItAlone) {
  for (const auto& [speed, constant] : {std::pair{115'200, B115200}, std::pair{57'600, B57600}}) {
    const SerialCable cable;
    ASSERT_FALSE(cable.is_exclusive());
    HostPort port;
    ASSERT_FALSE(port.open(cable.path(), speed));
    const termios set = cable.settings();
    EXPECT_EQ(::cfgetispeed(&set), constant);
    EXPECT_EQ(::cfgetospeed(&set), constant);
    EXPECT_EQ(set.c_cflag & (CSIZE | PARENB | CSTOPB | CRTSCTS | CLOCAL | CREAD | HUPCL),
              static_cast<tcflag_t>(CS8 | CLOCAL | CREAD))
        << "8N1, no flow control by lines, and no lines of a modem";
    EXPECT_EQ(set.c_iflag & (IXON | IXOFF | IXANY | ICRNL | INLCR | IGNCR | ISTRIP | BRKINT | PARMRK), 0U);
    EXPECT_EQ(set.c_oflag & OPOST, 0U);
    EXPECT_EQ(set.c_lflag & (ICANON | ECHO | ECHONL | ISIG | IEXTEN), 0U);
    EXPECT_TRUE(cable.is_exclusive()) << "no other program hears the host";
  }
}

TEST(HostPort, PassesAllBytesOfASerialPortAndTellsThatItWasUnplugged) {
  SerialCable cable;
  HostPort port;
  ASSERT_FALSE(port.open(cable.path(), baud));
  EXPECT_EQ(port.look(0), PortChange::came) << "who is behind a serial port does not tell";
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all.push_back(static_cast<char>(byte));
  ASSERT_EQ(::write(cable.far_end(), all.data(), all.size()), 256);
  EXPECT_EQ(read_from(port), all);
  ASSERT_EQ(port.write(bytes_of(all)), 256U);
  std::string back;
  while (back.size() < all.size()) back += heard_at(cable.far_end());
  EXPECT_EQ(back, all);

  cable.unplug();
  EXPECT_EQ(port.look(1), PortChange::went);
  EXPECT_FALSE(port.has_host());
  EXPECT_EQ(port.write(bytes_of("lost")), 0U);
  EXPECT_EQ(port.look(2'000'000'000), PortChange::none) << "tried again, and there is no port";
}

int connected_to(const HostPort& port) {
  const std::string number = port.name().substr(port.name().rfind(':') + 1);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(number)));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int file = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  EXPECT_EQ(::connect(file, std::bit_cast<const sockaddr*>(&address), sizeof address), 0);
  return file;
}

TEST(HostPort, TellsASecondHostThatTheRigIsTaken) {
  HostPort port;
  ASSERT_FALSE(port.open("tcp:127.0.0.1:0", baud));
  const int first = connected_to(port);
  EXPECT_EQ(port.look(0), PortChange::came);
  const int second = connected_to(port);
  EXPECT_EQ(port.look(0), PortChange::refused);
  EXPECT_EQ(heard_at(second), "inbetween: another host has this rig\r\n");
  EXPECT_EQ(heard_at(second), "") << "it is cut off";
  ::close(second);

  EXPECT_EQ(port.write(bytes_of("hello")), 5U) << "the first keeps it";
  EXPECT_EQ(heard_at(first), "hello");
  ASSERT_EQ(::write(first, "bye", 3), 3);
  ::close(first);
  EXPECT_EQ(read_from(port), "bye") << "what it said last is heard";
  EXPECT_EQ(port.look(0), PortChange::went);
  const int third = connected_to(port);
  EXPECT_EQ(port.look(0), PortChange::came);
  ::close(third);
}

TEST(HostPort, SaysWhyItCannotBeOpened) {
  HostPort port;
  EXPECT_NE(port.open("/dev/no_such_port", baud)->what.find("/dev/no_such_port"), std::string::npos);
  EXPECT_NE(port.open("/dev/null", baud)->what.find("115200 bit/s"), std::string::npos);
  EXPECT_NE(port.open("tcp:127.0.0.1:many", baud)->what.find("no port number"), std::string::npos);
  EXPECT_TRUE(port.open("pty:", baud).has_value());
  const TemporaryFolder folder;
  const std::string file = folder.path() / "host_port_file";
  std::ofstream(file) << "kept";
  EXPECT_NE(port.open("pty:" + file, baud)->what.find("is no link"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_regular_file(file)) << "and is left alone";
}

}  // namespace host_port_test
}  // namespace inbetween
