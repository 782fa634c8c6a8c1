// The server of the editor answers the page on this machine and nobody else: each wrong request has its
// status, and nothing on the disk changes.
#include "host_tools/edit/edit_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "host_tools/edit/kept_address.hpp"
#include "host_tools/edit/launch_page.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/simulated_disk.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace edit_server_test {

using testing::HasSubstr;
using testing::Not;

const std::string move_text = R"(name = "slide"
fps = 24
frames = 96
[[track]]
axes = ["x"]
keys = [{ at = [0] }, { at = [40] }]
speed = [0, 0, 10, 0, 0]
)";

class Client {
 public:
  explicit Client(int port, const char* address = "127.0.0.1") : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, address, &to.sin_addr);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }
  void send(const std::string& bytes) const { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  /// Everything until the server closes.
  [[nodiscard]] std::string receive() const {
    std::string all;
    std::array<char, 4096> block{};
    for (ssize_t count = 0; (count = ::recv(socket_, block.data(), block.size(), 0)) > 0;) {
      all.append(block.data(), static_cast<std::size_t>(count));
    }
    return all;
  }

  /// Whether the server has not closed within that time; what it says is added to `said`.
  [[nodiscard]] bool is_open(std::chrono::milliseconds time, std::string& said) const {
    pollfd waited{.fd = socket_, .events = POLLIN, .revents = 0};
    if (::poll(&waited, 1, static_cast<int>(time.count())) == 0) return true;
    std::array<char, 4096> block{};
    const ssize_t count = ::recv(socket_, block.data(), block.size(), 0);
    if (count > 0) said.append(block.data(), static_cast<std::size_t>(count));
    return count > 0;
  }

 private:
  int socket_;
  bool connected_ = false;
};

class EditServerTest : public testing::Test {
 protected:
  EditServerTest()
      : disk_({{"m.toml", move_text}}),
        session_(disk_.layer(), "m.toml", std::nullopt),
        server_(session_, {{"/index.html", {"text/html", "<p>the page</p>"}}}, random_key(), 0),
        runner_([this] { server_.run(); }) {}
  ~EditServerTest() override {
    server_.stop();
    runner_.join();
  }

  [[nodiscard]] std::string own() const { return fmt::format("127.0.0.1:{}", server_.port()); }
  [[nodiscard]] std::string token() const { return "X-Inbetween-Token: " + server_.token() + "\r\n"; }
  [[nodiscard]] std::string origin() const { return "Origin: http://" + own() + "\r\n"; }
  static std::string json_type() { return "Content-Type: application/json\r\n"; }

  /// The answer to a request as it is, with its own Host unless `headers` has one.
  [[nodiscard]] std::string ask(const std::string& line, const std::string& headers,
                                const std::string& body = "") const {
    std::string text = line + " HTTP/1.1\r\n";
    if (headers.find("Host:") == std::string::npos) text += "Host: " + own() + "\r\n";
    text += headers;
    if (!body.empty() || line.starts_with("POST")) text += fmt::format("Content-Length: {}\r\n", body.size());
    const Client client(server_.port());
    client.send(text + "\r\n" + body);
    return client.receive();
  }
  [[nodiscard]] int status(const std::string& line, const std::string& headers,
                           const std::string& body = "") const {
    const std::string answer = ask(line, headers, body);
    return answer.starts_with("HTTP/1.1 ") ? std::stoi(answer.substr(9, 3)) : 0;
  }
  [[nodiscard]] std::string page_headers() const { return token() + origin() + json_type(); }
  void expect_untouched() const { EXPECT_EQ(disk_.content(), (DiskContent{{"m.toml", move_text}})); }

  SimulatedDisk disk_;
  EditSession session_;
  EditServer server_;
  std::thread runner_;
};

TEST_F(EditServerTest, ThePageIsServedWithAStrictPolicy) {
  const std::string page = ask("GET /", "");
  EXPECT_THAT(page, HasSubstr("200 OK"));
  EXPECT_THAT(page, HasSubstr("the page"));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'none'; script-src 'self'"));
  EXPECT_THAT(page, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(page, Not(HasSubstr("Access-Control-Allow-Origin")));
  EXPECT_THAT(page, Not(HasSubstr("unsafe-inline")));
  EXPECT_THAT(page, Not(HasSubstr(server_.token())));
}

TEST_F(EditServerTest, ThePageGetsItsMove) {
  const std::string answer = ask("GET /api/move", token());
  EXPECT_THAT(answer, HasSubstr("200 OK"));
  EXPECT_THAT(answer, HasSubstr("\"name\":\"slide\""));
}

TEST_F(EditServerTest, AWrongHostIsRefused) {
  for (const char* host : {"evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", "[::1]:80", ""}) {
    EXPECT_EQ(status("GET /api/move", token() + "Host: " + host + "\r\n"), 403) << host;
    EXPECT_EQ(status("GET /", std::string("Host: ") + host + "\r\n"), 403) << host;
  }
  EXPECT_EQ(status("GET /", fmt::format("Host: {}\r\nHost: evil.example\r\n", own())), 400);
}

TEST_F(EditServerTest, AWrongOriginIsRefused) {
  for (const char* other : {"http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1:1"}) {
    EXPECT_EQ(status("GET /api/move", token() + "Origin: " + other + "\r\n"), 403) << other;
    EXPECT_EQ(status("POST /api/save", token() + json_type() + "Origin: " + other + "\r\n", "{}"), 403)
        << other;
  }
  EXPECT_EQ(status("POST /api/save", token() + json_type(), "{}"), 403) << "a form of old sends none";
  expect_untouched();
}

TEST_F(EditServerTest, AWrongTokenIsRefused) {
  for (const std::string& wrong : {std::string(), std::string("X-Inbetween-Token: 0\r\n"),
                                   "X-Inbetween-Token: " + std::string(32, '0') + "\r\n",
                                   "Cookie: token=" + server_.token() + "\r\n", token() + token()}) {
    EXPECT_GE(status("GET /api/move", wrong), 400) << wrong;
    EXPECT_GE(status("POST /api/save", wrong + origin() + json_type(), "{}"), 400) << wrong;
  }
  EXPECT_EQ(status("GET /api/move?token=" + server_.token(), ""), 403);
  expect_untouched();
}

TEST_F(EditServerTest, OnlyPostChangesAnythingAndNothingElseIsKnown) {
  for (const char* path : {"/api/save", "/api/keep", "/api/fit", "/api/fewest", "/api/resolve", "/api/text",
                           "/api/document", "/api/import"}) {
    EXPECT_EQ(status(fmt::format("GET {}", path), page_headers()), 405) << path;
  }
  for (const char* method : {"PUT", "DELETE", "PATCH", "OPTIONS", "HEAD"}) {
    EXPECT_EQ(status(fmt::format("{} /api/save", method), page_headers()), 405) << method;
  }
  EXPECT_GE(status("BREW /api/save", page_headers()), 400);
  EXPECT_EQ(status("POST /api/move", page_headers(), "{}"), 405);
  EXPECT_EQ(status("POST /index.html", page_headers(), "{}"), 405);
  EXPECT_EQ(status("POST /api/run", page_headers(), "{}"), 404);
  expect_untouched();
}

TEST_F(EditServerTest, AnotherTypeIsRefused) {
  for (const char* type : {"text/plain", "application/x-www-form-urlencoded",
                           "multipart/form-data; boundary=x", "application/json;charset=utf-8", ""}) {
    EXPECT_EQ(status("POST /api/save", token() + origin() + "Content-Type: " + type + "\r\n", "{}"), 415)
        << type;
  }
  expect_untouched();
}

TEST_F(EditServerTest, WhatIsNoRequestIsRefused) {
  EXPECT_EQ(status("POST /api/save", page_headers(), "{}"), 400);
  EXPECT_EQ(status("POST /api/save", page_headers(), std::string(1000, '[')), 400);
  EXPECT_EQ(status("POST /api/save", page_headers(), "\xff\xfe"), 400);
  EXPECT_EQ(status("POST /api/save", page_headers(), std::string(max_request_bytes + 1, ' ')), 413);
  EXPECT_GE(status("GET /" + std::string(10'000, 'x'), ""), 400);
  EXPECT_EQ(status("nonsense", ""), 400);
  EXPECT_THAT(ask("POST /api/save", page_headers(), "\x01<script>"), HasSubstr("application/json"));
  expect_untouched();
}

TEST_F(EditServerTest, AFileOfAnotherProgramIsTakenFromThePageAlone) {
  const std::string body = R"({"file":"a.csv","bytes":"","answers":{},"writes":true})";
  EXPECT_EQ(status("POST /api/import", page_headers(), body), 422) << "there is no rig";
  EXPECT_EQ(status("POST /api/import", origin() + json_type(), body), 403);
  EXPECT_EQ(status("POST /api/import", "X-Inbetween-Token: 0\r\n" + origin() + json_type(), body), 403);
  EXPECT_EQ(status("POST /api/import", token() + json_type(), body), 403) << "from no page";
  EXPECT_EQ(status("POST /api/import", token() + origin() + "Content-Type: text/csv\r\n", body), 415);
  EXPECT_EQ(status("POST /api/import", page_headers(), std::string(max_request_bytes + 1, ' ')), 413);
  EXPECT_EQ(status("POST /api/import", page_headers(), "frame,pan\n1,\xff\n"), 400);
  expect_untouched();
}

// A body in chunks, or without a length, would be read until it ends, however long it is.
TEST_F(EditServerTest, ABodyWhoseLengthIsNotSaidIsRefusedBeforeItIsRead) {
  const auto answer_to = [&](const std::string& line, const std::string& headers) {
    const Client client(server_.port());
    client.send(line + " HTTP/1.1\r\nHost: " + own() + "\r\n" + page_headers() + headers + "\r\n2\r\n{}\r\n");
    return client.receive();  // although the last chunk never comes
  };
  for (const char* headers : {"Transfer-Encoding: chunked\r\n", "transfer-encoding: gzip, chunked\r\n",
                              "Transfer-Encoding: chunked\r\nContent-Length: 2\r\n", ""}) {
    EXPECT_THAT(answer_to("POST /api/save", headers), HasSubstr("HTTP/1.1 411 ")) << headers;
  }
  EXPECT_THAT(answer_to("GET /api/move", "Transfer-Encoding: chunked\r\n"), HasSubstr("HTTP/1.1 411 "));
  expect_untouched();
}

TEST_F(EditServerTest, NoPathLeadsOutOfThePage) {
  for (const char* path : {"/../m.toml", "/..%2fm.toml", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                           "/m.toml", "/index.html/../m.toml", "/index.html%00", "/api/../m.toml"}) {
    EXPECT_GE(status(fmt::format("GET {}", path), token()), 400) << path;
  }
}

TEST_F(EditServerTest, ListensOnTheLoopbackOnly) {
  EXPECT_TRUE(Client(server_.port()).connected());
  EXPECT_FALSE(Client(server_.port(), "127.0.0.2").connected());
}

TEST_F(EditServerTest, SilentClientsAreLeftAndKeepNobodyOut) {
  std::vector<std::unique_ptr<Client>> silent;
  for (int i = 0; i < 300; ++i) {  // tests/editor has a thousand, in a process of their own
    silent.push_back(std::make_unique<Client>(server_.port()));
    silent.back()->send(i % 2 == 0 ? "" : "POST /api/save HTTP/1.1\r\nHost: ");
  }
  EXPECT_EQ(status("GET /api/move", token()), 200);
  EXPECT_THAT(silent.front()->receive(), Not(HasSubstr("200")));
  EXPECT_THAT(silent.back()->receive(), Not(HasSubstr("200")));
  silent.clear();
  const Client half(server_.port());
  half.send("POST /api/save HTTP/1.1\r\nHost: " + own() + "\r\n" + page_headers() +
            "Content-Length: 100\r\n\r\n{");
  EXPECT_THAT(half.receive(), Not(HasSubstr("200")));
  expect_untouched();
}

TEST_F(EditServerTest, AClientThatSendsAByteAtATimeIsLeftInTheEnd) {
  // It says something before each silence ends, and would stay for ever.
  EditServer hasty(session_, {}, random_key(), 0,
                   {std::chrono::milliseconds(400), std::chrono::milliseconds(1200)});
  std::thread runner([&] { hasty.run(); });
  const Client slow(hasty.port());
  slow.send("GET / HTTP/1.1\r\nHost: ");
  std::string answer;
  int bytes = 0;
  while (bytes < 600 && slow.is_open(std::chrono::milliseconds(100), answer)) {
    slow.send("x");
    ++bytes;
  }
  EXPECT_GT(bytes, 4) << "not for its silence";
  EXPECT_LT(bytes, 600);
  EXPECT_THAT(answer, Not(HasSubstr("200 OK")));
  hasty.stop();
  runner.join();
  expect_untouched();
}

TEST_F(EditServerTest, ADrawnMotionComesBackAsKeysAndASpeedCurve) {
  std::string times;
  std::string positions;
  for (int i = 0; i <= 60; ++i) {
    const double share = i / 60.0;
    times += fmt::format("{}{}", i > 0 ? "," : "", i / 30.0);
    positions += fmt::format("{}{},{}", i > 0 ? "," : "", 100 * share * share * (3 - 2 * share), 5);
  }
  const std::string body = fmt::format(
      R"({{"times":[{}],"positions":[{}],"tolerances":[1,null],"weights":[1,1],"frames_per_second":24}})",
      times, positions);
  const std::string answer = ask("POST /api/draw", page_headers(), body);
  EXPECT_THAT(answer, HasSubstr("200 OK"));
  EXPECT_THAT(answer, HasSubstr("\"frames\":48"));
  EXPECT_THAT(answer, HasSubstr("\"keys\":[["));
  EXPECT_EQ(status("POST /api/draw", page_headers(), R"({"times":[0]})"), 400);
  EXPECT_EQ(status("POST /api/draw", page_headers(),
                   R"({"times":[],"positions":[],"tolerances":[1],"weights":[1],"frames_per_second":24})"),
            422);
  EXPECT_EQ(status("POST /api/draw", token() + json_type(), body), 403);
  expect_untouched();
}

TEST_F(EditServerTest, APortThatIsTakenIsRefused) {
  EXPECT_THROW(EditServer(session_, {}, random_key(), server_.port()), std::runtime_error);
}

TEST_F(EditServerTest, EditsThatWereMeantForAnotherFileAreRefused) {
  const std::string body =
      R"({"id":"another","base":"x","frames":1,"fps":"24","tracks":[],"expects":"gone"})";
  for (const char* path : {"/api/save", "/api/keep", "/api/resolve"})
    EXPECT_EQ(status(fmt::format("POST {}", path), page_headers(), body), 403) << path;
  expect_untouched();
}

/// What stat() says of the permissions of the only file below a folder.
std::filesystem::path only_file_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) found.push_back(entry.path());
  EXPECT_EQ(found.size(), 1U);
  return found.at(0);
}

TEST(KeptAddress, IsTheSameAtEveryLaunchAndOnlyForItsMoveAndItsOwner) {
  TemporaryFolder folder;
  const std::filesystem::path state = folder.path() / "made" / "inbetween";
  std::string key;
  {
    KeptAddress first(state, "/moves/a.toml");
    key = first.key();
    EXPECT_EQ(key.size(), 32U);
    first.add_port(4000);
    first.add_port(4001);
    first.add_port(4000);
    EXPECT_THROW(KeptAddress(state, "/moves/a.toml"), EditedElsewhere);
  }
  const std::filesystem::path file = only_file_in(state);
  EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms{0600});
  {
    const KeptAddress again(state, "/moves/a.toml");
    EXPECT_EQ(again.key(), key);
    EXPECT_EQ(again.ports(), (std::vector{4000, 4001}));
  }
  EXPECT_NE(KeptAddress(state, "/moves/b/a.toml").key(), key);

  std::filesystem::permissions(file, std::filesystem::perms{0644});
  const std::string after = KeptAddress(state, "/moves/a.toml").key();
  EXPECT_NE(after, key) << "somebody may have read it";
  EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms{0600});
  std::ofstream(file) << "{\"move\":";
  EXPECT_NE(KeptAddress(state, "/moves/a.toml").key(), after);
}

TEST(LaunchPage, OnlyItsOwnerReadsTheAddressAndItGoesWithTheProgram) {
  const std::string address = "http://127.0.0.1:4000/#0123456789abcdef";
  std::filesystem::path file;
  {
    const LaunchPage page(address);
    file = page.path();
    EXPECT_THAT(file_contents(file.string()), HasSubstr("content=\"0;url=" + address + "\""));
    EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms{0600});
    EXPECT_EQ(std::filesystem::status(file.parent_path()).permissions(), std::filesystem::perms{0700});
    EXPECT_NE(LaunchPage(address).path(), page.path());
  }
  EXPECT_FALSE(std::filesystem::exists(file.parent_path()));
}

TEST(KeptAddress, WhereNothingCanBeKeptIsSaid) {
  TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  EXPECT_THROW(KeptAddress(folder.path() / "file", "/moves/a.toml"), std::runtime_error);
}

}  // namespace edit_server_test
}  // namespace inbetween
