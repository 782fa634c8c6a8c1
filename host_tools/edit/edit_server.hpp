// HTTP around an editing session, for the page in a browser on this machine and for nobody else.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "host_tools/edit/edit_session.hpp"
#include "host_tools/edit/page_files.hpp"

namespace inbetween {

/// Listens on 127.0.0.1 only.
///
/// Whoever asks for anything must name this server in Host (against DNS rebinding) and, if it says where it
/// comes from, in Origin; whoever asks for more than the files of the page must send the token
/// in X-Inbetween-Token. Only POST changes anything, and a POST has Origin and the type application/json.
/// Everything else is refused before its body is read: 403 for a wrong Host, Origin or token, 405 for another
/// method, 415 for another type, 404 for another path, 411 for a body whose length is not said, 413 for more
/// than max_request_bytes. A client that
/// says nothing for Patience::silence is left, and so is one whose request takes longer than Patience::total
/// to come, or its answer to go; a connection carries one request; max_connections are served at a time, and
/// the others wait. Nothing here moves a rig.
class EditServer {
 public:
  struct Patience {
    std::chrono::milliseconds silence{2000}, total{10'000};
  };
  static constexpr int max_connections = 256;

  /// `port` 0: any that is free. Throws std::runtime_error, one line, where it cannot be listened on.
  EditServer(EditSession& session, PageFiles page, std::string token, int port, const Patience& patience);
  EditServer(EditSession& session, PageFiles page, std::string token, int port)
      : EditServer(session, std::move(page), std::move(token), port, {}) {}
  ~EditServer();
  EditServer(const EditServer&) = delete;
  EditServer& operator=(const EditServer&) = delete;

  [[nodiscard]] int port() const;
  [[nodiscard]] const std::string& token() const;
  /// What to open in a browser. The token is behind '#', which a browser sends to nobody.
  [[nodiscard]] std::string address() const;

  /// Serves until stop() is called from another thread, which may be before run() is.
  void run();
  void stop();

 private:
  class Door;
  std::unique_ptr<Door> door_;
};

}  // namespace inbetween
