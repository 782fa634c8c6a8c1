// Any bytes are an edit, a drawn motion, an import or a refusal in one line; and whatever a request says of
// itself, it comes in only with the right Host, Origin, token, method and type.
#include "host_tools/edit/edit_request.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host_tools/edit/edit_knock.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween {
namespace {

constexpr int port = 8080;
constexpr std::string_view token = "0123456789abcdef0123456789abcdef";

void require_finite(const std::vector<double>& numbers) {
  for (const double number : numbers) fuzz_require(std::isfinite(number), "a number is finite");
}

template <class Read>
void require_edit_or_refusal(std::string_view text, const Read& read) {
  try {
    read(text);
  } catch (const RequestError& error) {
    const std::string_view line = error.what();
    fuzz_require(!line.empty() && line.size() < 500, "a refusal is a line");
    // It is sent as JSON as it is.
    for (const char c : line)
      fuzz_require(c >= 0x20 && c < 0x7f && c != '"' && c != '\\',
                   "a refusal repeats nothing of the request");
  }
}

void require_edit(std::string_view text) {
  const EditRequest edit = parse_edit_request(text);
  fuzz_require(edit.edited.fps.find_first_not_of("0123456789/") == std::string::npos, "fps go into a file");
  fuzz_require(edit.edited.tracks.size() <= max_tracks, "tracks fit");
  for (const EditedTrack& track : edit.edited.tracks) {
    fuzz_require(track.keys.size() <= max_keys, "keys fit");
    for (const EditedKey& key : track.keys) require_finite(key.at);
    if (track.speed) require_finite(*track.speed);
    for (const double value : track.speed.value_or(std::vector<double>{}))
      fuzz_require(value >= 0 && value <= max_control_value, "a control value is in its range");
  }
}

void require_motion(std::string_view text) {
  const SampledMotion sampled = parse_drawn_motion(text);
  fuzz_require(sampled.times.size() <= max_motion_samples, "samples fit");
  fuzz_require(sampled.positions.size() == sampled.times.size() * sampled.tolerances.size(),
               "all axes are there");
  require_finite(sampled.times);
  require_finite(sampled.positions);
}

void require_import(std::string_view text) {
  const ImportRequest import = parse_import_request(text);
  fuzz_require(!import.file.empty() && import.file.find('/') == std::string::npos, "a file is in no folder");
  fuzz_require(import.bytes.size() <= text.size(), "no byte comes from nowhere");
  for (const auto& [question, answer] : import.answers)
    fuzz_require(answer.size() <= 255, "an answer is a few words");
}

/// The text as the lines of a request: method, path, host, origin, token, type; "-": no such header.
void require_knock(std::string_view text) {
  std::array<std::optional<std::string_view>, 6> lines;
  for (std::optional<std::string_view>& line : lines) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (text.substr(0, end) != "-") line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  const EditKnock knock{.method = lines[0].value_or(""),
                        .path = lines[1].value_or(""),
                        .host = lines[2],
                        .origin = lines[3],
                        .token = lines[4],
                        .type = lines[5]};
  if (refusal_of(knock, port, token)) return;
  const auto is_here = [](std::string_view host) {
    return host == "127.0.0.1:8080" || host == "localhost:8080";
  };
  fuzz_require(knock.host && is_here(*knock.host), "who comes in names this server");
  fuzz_require(!knock.origin || (knock.origin->starts_with("http://") && is_here(knock.origin->substr(7))),
               "who comes in comes from its page");
  fuzz_require(knock.method == "GET" || knock.method == "POST", "who comes in gets or posts");
  if (knock.method == "GET" && !knock.path.starts_with("/api/")) return;
  fuzz_require(knock.token == token, "who asks has the token");
  if (knock.method == "GET") return;
  fuzz_require(knock.path.starts_with("/api/"), "the files of the page are not changed");
  fuzz_require(knock.origin && knock.type == "application/json",
               "who changes says from where, and sends JSON");
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  inbetween::require_edit_or_refusal(text, inbetween::require_edit);
  inbetween::require_edit_or_refusal(text, inbetween::require_motion);
  inbetween::require_edit_or_refusal(text, inbetween::require_import);
  inbetween::require_knock(text);
  return 0;
}
