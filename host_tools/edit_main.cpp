// The program that `inbetween edit` becomes: a web server for one page.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/command_line.hpp"
#include "host_tools/edit/edit_server.hpp"
#include "host_tools/edit/edit_session.hpp"
#include "host_tools/edit/folder_files.hpp"
#include "host_tools/edit/page_files.hpp"

namespace inbetween {
namespace {

namespace fs = std::filesystem;

fs::path page_folder() {
  const auto found = find_page(fs::read_symlink("/proc/self/exe"));
  if (found) return *found;
  throw std::runtime_error(
      "inbetween: error: the page of the editor is not built; run scripts/bootstrap editor, then cmake "
      "--preset demo, "
      "then cmake --build --preset demo --target inbetween_editor_page");
}

/// Asks the desktop to open an address; nothing happens where there is none.
void open_browser(const std::string& address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  std::string program = "xdg-open";
  std::string argument = address;
  const std::array<char*, 3> words{program.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, program.c_str(), nullptr, nullptr, words.data(), environ) != 0) return;
  std::thread([child] { ::waitpid(child, nullptr, 0); }).detach();
}

/// Stops the server at Ctrl-C and at SIGTERM. The signals are blocked in every thread but taken by this one.
class StopAtSignal {
 public:
  explicit StopAtSignal(EditServer& server) {
    sigemptyset(&signals_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR2}) sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    waiter_ = std::thread([this, &server] {
      int signal = 0;
      sigwait(&signals_, &signal);
      server.stop();
    });
  }
  ~StopAtSignal() {
    pthread_kill(waiter_.native_handle(), SIGUSR2);
    waiter_.join();
  }
  StopAtSignal(const StopAtSignal&) = delete;
  StopAtSignal& operator=(const StopAtSignal&) = delete;

 private:
  sigset_t signals_{};
  std::thread waiter_;
};

/// The HTTP library waits with select(), which knows the first 1024 descriptors only, and would wait for ever
/// on others. Connections beyond them wait until there is one.
void stay_within_select() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = std::min<rlim_t>(files.rlim_cur, FD_SETSIZE);
  ::setrlimit(RLIMIT_NOFILE, &files);
}

int edit_command(const EditArguments& arguments) {
  PageFiles page = read_page(page_folder());
  // Refuses what cannot be solved, in the words that plan has for it.
  const Plan plan = make_plan(arguments.move, arguments.rig, Solver::closed_form);
  const fs::path move = fs::canonical(arguments.move);
  EditSession session(files_beneath(move.parent_path().string()), move.filename().string(), plan.rig(),
                      plan.kinematics());
  stay_within_select();
  EditServer server(session, std::move(page), arguments.port);
  const StopAtSignal stop(server);
  fmt::print("editing {} at {}\nCtrl-C ends it.\n", arguments.move, server.address());
  std::fflush(stdout);
  if (!arguments.no_browser) open_browser(server.address());
  server.run();
  return 0;
}

}  // namespace
}  // namespace inbetween

int main(int argc, char** argv) {
  return inbetween::run_command_line(argc, argv, inbetween::edit_command);
}
