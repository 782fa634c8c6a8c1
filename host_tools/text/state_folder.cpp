#include "host_tools/text/state_folder.hpp"

#include <fmt/format.h>

#include "inbetween/base/hash.hpp"

namespace inbetween {

std::optional<std::filesystem::path> state_folder(const char* xdg_state_home, const char* home) {
  const std::filesystem::path state = xdg_state_home == nullptr ? "" : xdg_state_home;
  if (state.is_absolute()) return state / "inbetween";
  const std::filesystem::path own = home == nullptr ? "" : home;
  if (own.is_absolute()) return own / ".local" / "state" / "inbetween";
  return std::nullopt;
}

std::string state_file_name(std::string_view name, std::string_view identity, std::string_view ending) {
  constexpr std::size_t max_length = 40;
  std::string plain;
  for (const char c : name.substr(0, max_length)) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    plain += is_plain ? c : '_';
  }
  Fnv1a hash;
  hash.add(static_cast<std::uint64_t>(identity.size()), 8);
  for (const char byte : identity) hash.add(static_cast<unsigned char>(byte), 1);
  return fmt::format("{}-{:016x}.{}", plain, hash.value(), ending);
}

}  // namespace inbetween
