#include "host_tools/edit/edit_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "host_tools/edit/connection_threads.hpp"
#include "host_tools/edit/edit_knock.hpp"
#include "host_tools/edit/timed_stream.hpp"

namespace inbetween {
namespace {

using httplib::Request;
using httplib::Response;
using Outcome = httplib::Server::HandlerResponse;

void refuse(Response& response, int status, const char* why) {
  response.status = status;
  response.set_content(fmt::format("{{\"error\":\"{}\"}}", why), "application/json");
}

/// Each connection through a TimedStream: one request, and its answer.
class TimedServer : public httplib::Server {
 public:
  explicit TimedServer(const TimedStream::Patience& patience) : patience_(patience) {}

 private:
  bool process_and_close_socket(socket_t socket) override {
    TimedStream stream(socket, patience_);
    bool is_closed = false;
    const bool is_answered = answer(*this, stream, is_closed);
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return is_answered;
  }
  /// Since version 0.16 the library wants to be told the addresses.
  template <class Server>
  static bool answer(Server& server, TimedStream& stream, bool& is_closed) {
    if constexpr (requires { server.process_request(stream, true, is_closed, nullptr); }) {
      return server.process_request(stream, true, is_closed, nullptr);
    } else {
      return server.process_request(stream, "127.0.0.1", 0, "127.0.0.1", 0, true, is_closed, nullptr);
    }
  }

  TimedStream::Patience patience_;
};

constexpr const char* policy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

class EditServer::Door {
 public:
  Door(EditSession& session, PageFiles page, std::string token, int port, const Patience& patience)
      : session_(session),
        page_(std::move(page)),
        token_(std::move(token)),
        server_({patience.silence, patience.total}) {
    server_.new_task_queue = [] { return new ConnectionThreads(max_connections); };
    server_.set_payload_max_length(max_request_bytes);
    server_.set_default_headers({{"Content-Security-Policy", policy},
                                 {"X-Content-Type-Options", "nosniff"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cross-Origin-Opener-Policy", "same-origin"},
                                 {"Cross-Origin-Resource-Policy", "same-origin"},
                                 {"Cache-Control", "no-store"}});
    server_.set_pre_routing_handler(
        [this](const Request& request, Response& response) { return admit(request, response); });
    server_.set_exception_handler([](const Request&, Response& response, const std::exception_ptr&) {
      refuse(response, 500, "the request could not be answered");
    });
    add_answers();
    listen(port);
  }

  void run() {
    server_.listen_after_bind();
    has_ended_ = true;
  }
  /// The library forgets a stop that comes before it listens, and tells nobody when it does.
  void stop() {
    while (!server_.is_running() && !has_ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    server_.stop();
  }
  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] const std::string& token() const { return token_; }

 private:
  void listen(int port) {
    // The library would share the port with whoever asks, and let five connections wait.
    int listening = -1;
    server_.set_socket_options([&listening](int socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      listening = socket;
    });
    if (port == 0) {
      port_ = server_.bind_to_any_port("127.0.0.1");
    } else if (server_.bind_to_port("127.0.0.1", port)) {
      port_ = port;
    }
    server_.set_socket_options({});
    if (port_ > 0 && ::listen(listening, max_waiting) == 0) return;
    throw std::runtime_error(fmt::format(
        "inbetween: error: port {} cannot be listened on; name another with --port, or leave it out", port));
  }

  /// Before the body is read. Header values that come twice are refused: another reader might take the other
  /// one.
  Outcome admit(const Request& request, Response& response) {
    const auto refused = [&](int status, const char* why) {
      refuse(response, status, why);
      return Outcome::Handled;
    };
    const auto header = [&](const char* name) -> std::optional<std::string_view> {
      const auto found = request.headers.find(name);
      return found == request.headers.end() ? std::nullopt : std::optional<std::string_view>(found->second);
    };
    for (const char* name : {"Host", "Origin", "X-Inbetween-Token", "Content-Type", "Content-Length"}) {
      if (request.get_header_value_count(name) > 1) return refused(400, "a header comes twice");
    }
    const auto refusal = refusal_of({.method = request.method,
                                     .path = request.path,
                                     .host = header("Host"),
                                     .origin = header("Origin"),
                                     .token = header("X-Inbetween-Token"),
                                     .type = header("Content-Type"),
                                     .length = header("Content-Length"),
                                     .encoding = header("Transfer-Encoding")},
                                    port_, token_);
    return refusal ? refused(refusal->status, refusal->why) : Outcome::Unhandled;
  }

  void answer(Response& response, const EditAnswer& answer) {
    response.status = answer.status;
    response.set_content(answer.json, "application/json");
  }

  void add_get(const char* path, EditAnswer (EditSession::*ask)()) {
    server_.Get(path,
                [this, ask](const Request&, Response& response) { answer(response, (session_.*ask)()); });
    server_.Post(path,
                 [](const Request&, Response& response) { refuse(response, 405, "this is only read"); });
  }
  /// `ask` answers what `read` makes of the body.
  template <class Read, class Ask>
  void add_post(const char* path, const Read& read, const Ask& ask) {
    server_.Get(path,
                [](const Request&, Response& response) { refuse(response, 405, "ask for this with POST"); });
    server_.Post(path, [this, read, ask](const Request& request, Response& response) {
      try {
        answer(response, ask(read(request.body)));
      } catch (const RequestError& error) {
        refuse(response, 400, error.what());
      }
    });
  }
  void add_edit(const char* path, EditAnswer (EditSession::*ask)(const EditRequest&)) {
    add_post(path, parse_edit_request,
             [this, ask](const EditRequest& edit) { return (session_.*ask)(edit); });
  }

  void add_answers() {
    add_get("/api/move", &EditSession::open);
    add_post("/api/document", parse_base,
             [this](const std::string& base) { return session_.document_of_base(base); });
    add_edit("/api/text", &EditSession::text);
    add_get("/api/revision", &EditSession::revision);
    add_edit("/api/resolve", &EditSession::resolve);
    add_edit("/api/fit", &EditSession::fit);
    add_edit("/api/fewest", &EditSession::fewest);
    add_post("/api/draw", parse_drawn_motion, answer_to_drawn);
    add_edit("/api/save", &EditSession::save);
    add_edit("/api/keep", &EditSession::keep);
    add_post("/api/import", parse_import_request,
             [this](const ImportRequest& request) { return session_.import_motion(request); });
    server_.Get(".*", [this](const Request& request, Response& response) {
      const auto found = page_.find(request.path == "/" ? "/index.html" : request.path);
      if (found == page_.end()) return refuse(response, 404, "there is no such file");
      response.set_content(found->second.bytes, found->second.type);
    });
    server_.Post(
        ".*", [](const Request&, Response& response) { refuse(response, 404, "there is no such request"); });
  }

  static constexpr int max_waiting = 1024;

  EditSession& session_;
  PageFiles page_;
  std::string token_;
  int port_ = 0;
  std::atomic<bool> has_ended_ = false;
  TimedServer server_;
};

EditServer::EditServer(EditSession& session, PageFiles page, std::string token, int port,
                       const Patience& patience)
    : door_(std::make_unique<Door>(session, std::move(page), std::move(token), port, patience)) {}
EditServer::~EditServer() = default;

int EditServer::port() const {
  return door_->port();
}
const std::string& EditServer::token() const {
  return door_->token();
}
std::string EditServer::address() const {
  return fmt::format("http://127.0.0.1:{}/#{}", port(), token());
}
void EditServer::run() {
  door_->run();
}
void EditServer::stop() {
  door_->stop();
}

}  // namespace inbetween
