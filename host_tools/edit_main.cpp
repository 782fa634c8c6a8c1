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
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host_tools/cli/command.hpp"
#include "host_tools/cli/command_line.hpp"
#include "host_tools/edit/edit_server.hpp"
#include "host_tools/edit/edit_session.hpp"
#include "host_tools/edit/folder_files.hpp"
#include "host_tools/edit/kept_address.hpp"
#include "host_tools/edit/launch_page.hpp"
#include "host_tools/edit/page_files.hpp"
#include "host_tools/text/state_folder.hpp"

namespace inbetween {
namespace {

namespace fs = std::filesystem;

fs::path page_folder() {
  const auto found = find_page(fs::read_symlink("/proc/self/exe"));
  if (found) return *found;
  throw std::runtime_error(
      "inbetween: error: the page of the editor is not built; run scripts/demo, which installs what that "
      "takes and builds it");
}

/// Asks the desktop to open an address; nothing happens where there is none. What is returned has to stay as
/// long as a browser may read it.
std::unique_ptr<LaunchPage> open_browser(const std::string& address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return nullptr;
  std::unique_ptr<LaunchPage> page;
  try {
    page = std::make_unique<LaunchPage>(address);
  } catch (const std::exception& error) {
    fmt::print("open the address yourself: {}\n", error.what());
    return nullptr;
  }
  std::string program = "xdg-open";
  std::string argument = page->path();
  const std::array<char*, 3> words{program.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, program.c_str(), nullptr, nullptr, words.data(), environ) != 0) return nullptr;
  std::thread([child] { ::waitpid(child, nullptr, 0); }).detach();
  return page;
}

/// The HTTP library waits with select(), which knows the first 1024 descriptors only, and would wait for ever
/// on others. Connections beyond them wait until there is one.
void stay_within_select() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = std::min<rlim_t>(files.rlim_cur, FD_SETSIZE);
  ::setrlimit(RLIMIT_NOFILE, &files);
}

void tell_not_kept(const std::string& why) {
  fmt::print("the address will be another one at the next launch: {}\n", why);
}

/// The address that pages of this move have. Nothing, and a line about it, where none can be kept.
std::unique_ptr<KeptAddress> kept_address(const fs::path& move) {
  std::string why = "set XDG_STATE_HOME or HOME to a folder";
  try {
    if (const auto folder = state_folder(std::getenv("XDG_STATE_HOME"), std::getenv("HOME")))
      return std::make_unique<KeptAddress>(*folder, move.string());
  } catch (const EditedElsewhere&) {
    throw;
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  tell_not_kept(why);
  return nullptr;
}

/// At `port`, or where it is 0 at one that pages of this move know; or else at any that is free.
std::unique_ptr<EditServer> listen(EditSession& session, const PageFiles& page, int port,
                                   KeptAddress* address) {
  const std::string key = address != nullptr ? address->key() : random_key();
  if (port == 0 && address != nullptr) {
    for (const int known : address->ports()) {
      try {
        return std::make_unique<EditServer>(session, page, key, known);
      } catch (const std::runtime_error&) {
        fmt::print("port {} is taken by another program; a page that is open there is not found again\n",
                   known);
      }
    }
  }
  auto server = std::make_unique<EditServer>(session, page, key, port);
  try {
    if (port == 0 && address != nullptr) address->add_port(server->port());
  } catch (const std::runtime_error& error) {
    tell_not_kept(error.what());
  }
  return server;
}

/// A move with its page, at an address of its own: none of them can edit another's file.
class OpenMove {
 public:
  using Open = std::function<std::string(const std::string& move)>;

  OpenMove(const fs::path& move, const std::optional<std::string>& rig, const PageFiles& page, int port,
           Open open_import)
      : address_(kept_address(move)),
        session_(files_beneath(move.parent_path().string()), move.filename().string(), rig,
                 file_id(move.string())),
        server_(listen(session_, page, port, address_.get())) {
    session_.open_imports_with(std::move(open_import));
    thread_ = std::thread([this] { server_->run(); });
  }
  ~OpenMove() {
    stop();
    wait();
  }
  OpenMove(const OpenMove&) = delete;
  OpenMove& operator=(const OpenMove&) = delete;

  [[nodiscard]] std::string address() const { return server_->address(); }
  void stop() { server_->stop(); }
  void wait() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::unique_ptr<KeptAddress> address_;
  EditSession session_;
  std::unique_ptr<EditServer> server_;
  std::thread thread_;
};

/// The move that was named, and those that are imported beside it. Thread-safe.
class OpenMoves {
 public:
  OpenMoves(fs::path folder, std::optional<std::string> rig, PageFiles page)
      : folder_(std::move(folder)), rig_(std::move(rig)), page_(std::move(page)) {}

  /// Returns its address. Throws std::runtime_error, one line.
  std::string open(const std::string& name, int port) {
    const std::lock_guard lock(mutex_);
    if (is_ending_) throw std::runtime_error("the program ends");
    if (moves_.size() >= max_open)
      throw std::runtime_error(
          fmt::format("{} moves are open already; start inbetween edit for it", max_open));
    moves_.push_back(std::make_unique<OpenMove>(folder_ / name, rig_, page_, port,
                                                [this](const std::string& move) { return open(move, 0); }));
    return moves_.back()->address();
  }
  /// Until stop(), which another thread calls.
  void wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return is_ending_; });
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    ended_.notify_all();
  }

 private:
  static constexpr std::size_t max_open = 32;

  fs::path folder_;
  std::optional<std::string> rig_;
  PageFiles page_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_ending_ = false;
  std::vector<std::unique_ptr<OpenMove>> moves_;
};

/// Stops the servers at Ctrl-C and at SIGTERM. The signals are blocked in every thread that is started from
/// then on, but taken by this one.
class StopAtSignal {
 public:
  explicit StopAtSignal(OpenMoves& moves) {
    sigemptyset(&signals_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR2}) sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    waiter_ = std::thread([this, &moves] {
      int signal = 0;
      sigwait(&signals_, &signal);
      moves.stop();
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

int edit_command(const EditArguments& arguments) {
  const PageFiles page = read_page(page_folder());
  // Refuses what cannot be solved, in the words that plan has for it.
  static_cast<void>(make_plan(arguments.move, arguments.rig, Solver::closed_form));
  const fs::path move = fs::canonical(arguments.move);
  std::optional<std::string> rig = arguments.rig;
  if (rig) rig = fs::absolute(*rig).string();
  // Files that the move names are beside it.
  fs::current_path(move.parent_path());
  stay_within_select();
  // A file that grows beyond a limit of its size is an error of a write like a full disk, and no end.
  std::signal(SIGXFSZ, SIG_IGN);
  OpenMoves moves(move.parent_path(), rig, page);
  const StopAtSignal stop(moves);
  const std::string address = moves.open(move.filename().string(), arguments.port);
  fmt::print("editing {} at {}\nCtrl-C ends it.\n", arguments.move, address);
  std::fflush(stdout);
  const std::unique_ptr<LaunchPage> launched = arguments.no_browser ? nullptr : open_browser(address);
  moves.wait();
  return 0;
}

}  // namespace
}  // namespace inbetween

int main(int argc, char** argv) {
  return inbetween::run_command_line(argc, argv, inbetween::edit_command);
}
