#include "host_tools/cli/run_screen.hpp"

#define NCURSES_NOMACROS  // functions, which hide no other names
#include <curses.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <clocale>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <utility>

#include "host_tools/cli/screen_text.hpp"

namespace inbetween {

/// The library takes the terminal's modes and some signals for itself; the keys and the stop keep theirs.
class RunScreen::Curses {
 public:
  explicit Curses(bool takes_wheel) : takes_wheel_(takes_wheel) {
    std::setlocale(LC_CTYPE, "");
    std::array<struct sigaction, signals.size()> before{};
    for (std::size_t i = 0; i < signals.size(); ++i) ::sigaction(signals[i], nullptr, &before[i]);
    termios keys{};
    ::tcgetattr(STDIN_FILENO, &keys);
    screen_ = ::newterm(nullptr, stderr, stdin);
    for (std::size_t i = 0; i < signals.size(); ++i) ::sigaction(signals[i], &before[i], nullptr);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &keys);
    if (screen_ == nullptr) return;
    ::def_prog_mode();
    can_place_cursor_ = ::tigetstr("cup") != nullptr && ::tigetstr("clear") != nullptr;
    if (can_place_cursor_) ::curs_set(0);
  }
  ~Curses() {
    if (screen_ == nullptr) return;
    if (reports_) tell_terminal("\x1b[<u\x1b[?1006l\x1b[?1000l");
    ::endwin();
    ::delscreen(screen_);
  }
  Curses(const Curses&) = delete;
  Curses& operator=(const Curses&) = delete;

  [[nodiscard]] bool can_place_cursor() const { return can_place_cursor_; }

  void show(const std::string& title, const RigFile& rig, const RunSnapshot& snapshot,
            const std::vector<std::string>& notes) {
    winsize size{};
    if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 && size.ws_col > 0 &&
        ::is_term_resized(size.ws_row, size.ws_col)) {
      ::resizeterm(size.ws_row, size.ws_col);
    }
    ::erase();
    int row = 0;
    // The last column stays free: whoever writes there scrolls some terminals.
    for (const std::string& line : screen_text(title, rig, snapshot, COLS - 1, LINES, notes)) {
      ::mvaddstr(row++, 0, line.c_str());
    }
    ::refresh();
    ask_for_reports();
  }

 private:
  static constexpr std::array signals{SIGINT, SIGTERM, SIGTSTP, SIGWINCH};

  /// A terminal that is lost has nothing to be told.
  static void tell_terminal(std::string_view sequence) {
    static_cast<void>(!::write(STDERR_FILENO, sequence.data(), sequence.size()));
  }

  /// Asks once the screen is there, and until it is left: each screen of a terminal has a keyboard of its own
  /// (https://sw.kovidgoyal.net/kitty/keyboard-protocol, its progressive enhancement 2). A terminal that
  /// tells when a key is let go answers CSI ? FLAGS u among the keys; others ignore it.
  void ask_for_reports() {
    if (std::exchange(reports_, true)) return;
    tell_terminal("\x1b[>2u\x1b[?u");
    if (takes_wheel_) tell_terminal("\x1b[?1000h\x1b[?1006h");  // as xterm reports a mouse (SGR)
  }

  bool takes_wheel_;
  bool reports_ = false;
  SCREEN* screen_ = nullptr;
  bool can_place_cursor_ = false;
};

RunScreen::RunScreen(std::string title, const RigFile& rig)
    : title_(std::move(title)), rig_(rig), kind_(::isatty(STDERR_FILENO) == 0 ? Kind::plain : Kind::screen) {}

RunScreen::~RunScreen() = default;

void RunScreen::leave() {
  curses_.reset();
}

void RunScreen::tell(std::vector<std::string> notes) {
  if (notes == notes_) return;
  notes_ = std::move(notes);
  if (kind_ == Kind::screen) return;
  for (const std::string& note : notes_) fmt::print(stderr, "{}\n", note);
}

void RunScreen::show(const RunSnapshot& snapshot) {
  if (kind_ == Kind::screen) {
    if (!curses_) curses_ = std::make_unique<Curses>(takes_wheel_);
    if (curses_->can_place_cursor()) return curses_->show(title_, rig_, snapshot, notes_);
    leave();
    kind_ = Kind::line;
  }
  if (kind_ == Kind::line) return bar_.show(snapshot.share, status_line(snapshot));
  const std::string phase = phase_of(snapshot);
  if (phase == phase_) return;
  phase_ = phase;
  fmt::print(stderr, "{}\n", state_line(snapshot));
}

}  // namespace inbetween
