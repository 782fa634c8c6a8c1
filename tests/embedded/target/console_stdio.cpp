#include <cstdio>

#include "tests/embedded/target/console.hpp"

namespace inbetween::embedded {

void print(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void print(long long number) {
  std::printf("%lld", number);
}

}  // namespace inbetween::embedded

int main() {
  return inbetween::embedded::run() ? 0 : 1;
}
