// Any bytes are the positions that this program would have written so, to the last byte, or are refused in
// words; with a good check sum too, which no fuzzer finds by itself.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "host_tools/reference/position_text.hpp"
#include "inbetween/base/hash.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween {
namespace {

std::string with_sum(std::string_view body) {
  Fnv1a sum;
  for (const char byte : body) sum.add(static_cast<unsigned char>(byte), 1);
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text = std::string(body) + "sum ";
  for (int shift = 60; shift >= 0; shift -= 4) text += digits[(sum.value() >> shift) & 0xFU];
  return text + '\n';
}

void require_positions(std::string_view text) {
  const auto parsed = parse_positions(text);
  if (const auto* problem = std::get_if<std::string>(&parsed)) {
    fuzz_require(!problem->empty() && problem->find('\n') == problem->npos, "a refusal is one line");
    return;
  }
  const auto& kept = std::get<KeptPositions>(parsed);
  for (const KeptAxis& axis : kept.axes) {
    fuzz_require(std::isfinite(axis.position), "a position is finite");
    fuzz_require(axis.rest == AxisRest::at || axis.position == 0, "an unknown position is no number");
    fuzz_require(axis.rest == AxisRest::at || axis.zeros.empty(), "nothing counts from an unknown position");
  }
  fuzz_require(to_text(kept) == text, "what is accepted is what would be written");
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  inbetween::require_positions(text);
  inbetween::require_positions(inbetween::with_sum(text));
  return 0;
}
