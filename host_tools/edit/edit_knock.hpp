// Who may come in: what a request says of itself, before anybody reads its body.
#pragma once

#include <optional>
#include <string_view>

namespace inbetween {

/// Nothing where the request has no such header.
struct EditKnock {
  std::string_view method, path;
  std::optional<std::string_view> host, origin, token, type;
  std::optional<std::string_view> length, encoding;  ///< of the body: Content-Length, Transfer-Encoding
};

struct EditRefusal {
  int status = 0;
  const char* why = nullptr;
};

/// Why the request is refused by a server on `port` of this machine, whose token is `token`; nothing: it may
/// come in. Whoever comes in names this server in Host and in Origin, if there is one; reads the files of the
/// page, or has the token; and changes something only by POST, with an Origin, as application/json, and says
/// beforehand how long it is: a body in chunks would be read to its end, however long.
std::optional<EditRefusal> refusal_of(const EditKnock& knock, int port, std::string_view token);

}  // namespace inbetween
