#include "drivers/linux/raw_terminal.hpp"

#include <termios.h>

#include <algorithm>
#include <array>
#include <utility>

namespace inbetween {
namespace {

constexpr std::array bauds{std::pair<std::int32_t, speed_t>{9'600, B9600},
                           std::pair<std::int32_t, speed_t>{19'200, B19200},
                           std::pair<std::int32_t, speed_t>{38'400, B38400},
                           std::pair<std::int32_t, speed_t>{57'600, B57600},
                           std::pair<std::int32_t, speed_t>{115'200, B115200},
                           std::pair<std::int32_t, speed_t>{230'400, B230400},
                           std::pair<std::int32_t, speed_t>{460'800, B460800},
                           std::pair<std::int32_t, speed_t>{500'000, B500000},
                           std::pair<std::int32_t, speed_t>{921'600, B921600},
                           std::pair<std::int32_t, speed_t>{1'000'000, B1000000}};

auto baud_of(std::int32_t baud) {
  return std::ranges::find(bauds, baud, &std::pair<std::int32_t, speed_t>::first);
}

}  // namespace

bool is_baud(std::int32_t baud) {
  return baud_of(baud) != bauds.end();
}

bool make_raw(int file, std::int32_t baud) {
  termios settings{};
  const auto known = baud_of(baud);
  if (known == bauds.end() || ::tcgetattr(file, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  // cfmakeraw leaves a second stop bit and half of the flow control as the last program has set them.
  settings.c_iflag &= ~static_cast<tcflag_t>(IXOFF | IXANY);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL);  // many boards start anew when the port is closed
  return ::cfsetspeed(&settings, known->second) == 0 && ::tcsetattr(file, TCSANOW, &settings) == 0;
}

}  // namespace inbetween
