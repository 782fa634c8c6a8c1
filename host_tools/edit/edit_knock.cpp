#include "host_tools/edit/edit_knock.hpp"

#include <fmt/format.h>

namespace inbetween {
namespace {

/// Takes as long for a wrong token as for the right one.
bool is_same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned>(a[i] ^ b[i]);
  return difference == 0;
}

bool is_ours(std::string_view host, int port) {
  return host == fmt::format("127.0.0.1:{}", port) || host == fmt::format("localhost:{}", port);
}

}  // namespace

std::optional<EditRefusal> refusal_of(const EditKnock& knock, int port, std::string_view token) {
  constexpr std::string_view scheme = "http://";
  if (!is_ours(knock.host.value_or(""), port)) return EditRefusal{403, "this server has another name"};
  const bool is_own_origin =
      knock.origin && knock.origin->starts_with(scheme) && is_ours(knock.origin->substr(scheme.size()), port);
  if (knock.origin && !is_own_origin) return EditRefusal{403, "that page is not this server's"};
  const bool is_post = knock.method == "POST";
  if (knock.encoding || (is_post && !knock.length))
    return EditRefusal{411, "a request says in Content-Length how long it is, and is sent in one piece"};
  if (!is_post && knock.method != "GET") return EditRefusal{405, "only GET and POST are known"};
  if (!knock.path.starts_with("/api/")) {
    if (is_post) return EditRefusal{405, "the files of the page are only read"};
    return std::nullopt;
  }
  if (!is_same(knock.token.value_or(""), token))
    return EditRefusal{403, "the key is not that of this move; open the address that the program printed"};
  if (!is_post) return std::nullopt;
  if (!is_own_origin) return EditRefusal{403, "a change must come from this server's page"};
  if (knock.type != "application/json") return EditRefusal{415, "a change is sent as application/json"};
  return std::nullopt;
}

}  // namespace inbetween
