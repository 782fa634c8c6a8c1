#include "host_tools/takes/byte_text.hpp"

#include "inbetween/base/hash.hpp"

namespace inbetween {

std::uint64_t sum_of(std::string_view bytes) {
  Fnv1a sum;
  for (const char byte : bytes) sum.add(static_cast<unsigned char>(byte), 1);
  return sum.value();
}

}  // namespace inbetween
