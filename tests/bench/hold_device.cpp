// Somebody at a keyboard with a jog wheel: a device of the kernel's uinput under a program that moves a rig
// of a pipe drive. Reads the rig's lines, and does something at the device when it has read so many.
//
//   inbetween_hold_device FIFO RECORD [LINE:ACTION]... -- COMMAND...
//
// ACTION is press, release (of right), turn (the wheel by a detent), unplug, or a character, which is typed
// at the terminal. One with the line 0 is done before the command starts: enter, which is let go once the
// command asks for that, or grab, by which somebody else has the device alone. A word DEVICE of the command
// becomes the path of the device; its terminal is a pseudo-terminal. RECORD gets the lines, "# ACTION"
// between them, and at the end how many keys somebody else heard on the device while the command had it, and
// afterwards. The exit status is the command's.
#include <fcntl.h>
#include <linux/input.h>
#include <linux/uinput.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace {

class PlayedDevice {
 public:
  PlayedDevice() : file_(::open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC)) {
    ::ioctl(file_, UI_SET_EVBIT, EV_KEY);
    ::ioctl(file_, UI_SET_EVBIT, EV_REL);
    for (const int key : {KEY_RIGHT, KEY_LEFT, KEY_ENTER}) ::ioctl(file_, UI_SET_KEYBIT, key);
    ::ioctl(file_, UI_SET_RELBIT, REL_DIAL);
    uinput_setup setup{};
    std::strcpy(setup.name, "a hand");
    ::ioctl(file_, UI_DEV_SETUP, &setup);
    ::ioctl(file_, UI_DEV_CREATE);
  }
  [[nodiscard]] std::string path() const {
    std::array<char, 64> name{};
    if (::ioctl(file_, UI_GET_SYSNAME(name.size()), name.data()) < 0) return "";
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string("/sys/devices/virtual/input/") + name.data())) {
      const std::string node = entry.path().filename();
      if (node.starts_with("event")) return "/dev/input/" + node;
    }
    return "";
  }
  void tell(std::uint16_t type, std::uint16_t code, std::int32_t value) const {
    std::array<input_event, 2> events{};
    events[0].type = type;
    events[0].code = code;
    events[0].value = value;
    if (::write(file_, events.data(), sizeof(events)) < 0) std::exit(3);
  }
  void unplug() const { ::ioctl(file_, UI_DEV_DESTROY); }

 private:
  int file_;
};

/// Somebody else who listens to the device.
class Listener {
 public:
  explicit Listener(const std::string& path)
      : file_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}
  void have_alone() const { ::ioctl(file_, EVIOCGRAB, 1); }
  [[nodiscard]] int keys() const {
    int count = 0;
    input_event event{};
    while (::read(file_, &event, sizeof(event)) == sizeof(event)) count += event.type == EV_KEY ? 1 : 0;
    return count;
  }

 private:
  int file_;
};

struct Terminal {
  int file = -1;
  pid_t program = -1;

  Terminal(std::vector<char*> words) {
    words.push_back(nullptr);
    program = ::forkpty(&file, nullptr, nullptr, nullptr);
    if (program != 0) return;
    ::execvp(words[0], words.data());
    std::_Exit(127);
  }
};

struct Hand {
  const PlayedDevice& device;
  const Terminal& terminal;
  std::ofstream& record;

  void act(const std::string& action) const {
    record << "# " << action << "\n";
    if (action == "press" || action == "release") device.tell(EV_KEY, KEY_RIGHT, action == "press" ? 1 : 0);
    if (action == "turn") device.tell(EV_REL, REL_DIAL, 1);
    if (action == "unplug") device.unplug();
    if (action.size() == 1 && ::write(terminal.file, action.data(), 1) != 1) std::exit(3);
  }
};

}  // namespace

int main(int count, char** arguments) {
  std::vector<char*> words(arguments + 1, arguments + count);
  std::multimap<int, std::string> actions;
  std::size_t at = 2;
  for (; at < words.size() && std::string_view(words[at]) != "--"; ++at) {
    const std::string word = words[at];
    actions.emplace(std::atoi(word.c_str()), word.substr(word.find(':') + 1));
  }
  if (at >= words.size()) return 2;
  const PlayedDevice device;
  std::string path = device.path();
  const Listener other(path);
  const int rig = ::open(words[0], O_RDWR | O_CLOEXEC);
  std::ofstream record(words[1]);
  if (rig < 0 || path.empty()) return 3;
  std::vector<char*> command(words.begin() + static_cast<std::ptrdiff_t>(at) + 1, words.end());
  for (char*& word : command) {
    if (std::string_view(word) == "DEVICE") word = path.data();
  }
  bool unplugs = false;
  for (const auto& [number, action] : actions) unplugs = unplugs || action == "unplug";
  const bool holds_enter = actions.contains(0) && actions.find(0)->second == "enter";
  if (actions.contains(0) && !holds_enter) other.have_alone();
  actions.erase(0);
  if (holds_enter) device.tell(EV_KEY, KEY_ENTER, 1);
  Terminal terminal(command);
  const Hand hand{device, terminal, record};
  std::string shown;
  int lines = 0;
  while (true) {
    std::array<pollfd, 2> files{pollfd{rig, POLLIN, 0}, pollfd{terminal.file, POLLIN, 0}};
    ::poll(files.data(), files.size(), -1);
    std::array<char, 4096> bytes{};
    if (files[1].revents != 0) {
      const ssize_t read = ::read(terminal.file, bytes.data(), bytes.size());
      if (read <= 0) break;
      const bool was_asked = shown.find("let go of all keys") != std::string::npos;
      shown.append(bytes.data(), static_cast<std::size_t>(read));
      const bool is_asked = shown.find("let go of all keys") != std::string::npos;
      if (holds_enter && is_asked && !was_asked) device.tell(EV_KEY, KEY_ENTER, 0);
    }
    if ((files[0].revents & POLLIN) == 0) continue;
    const ssize_t read = ::read(rig, bytes.data(), bytes.size());
    for (ssize_t i = 0; i < read; ++i) {
      record << bytes[static_cast<std::size_t>(i)];
      if (bytes[static_cast<std::size_t>(i)] != '\n') continue;
      ++lines;
      for (auto [action, end] = actions.equal_range(lines); action != end; ++action) hand.act(action->second);
    }
  }
  record << "# others heard " << other.keys();
  if (!unplugs) device.tell(EV_KEY, KEY_ENTER, 1);
  record << ", and then " << other.keys() << "\n" << shown;
  int status = 0;
  ::waitpid(terminal.program, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}
