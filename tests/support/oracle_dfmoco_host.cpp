#include "tests/support/oracle_dfmoco_host.hpp"

#include <sstream>
#include <stdexcept>
#include <utility>

namespace inbetween::oracle {

std::vector<std::uint8_t> dfmoco_bytes(const std::string& line) {
  std::vector<std::uint8_t> bytes(line.begin(), line.end());
  bytes.push_back(13);
  bytes.push_back(10);
  return bytes;
}

void DfmocoHost::hear(const std::string& text) {
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = text.find("\r\n", begin);
    if (end == std::string::npos) throw std::runtime_error("a line of the device has no end");
    const std::string line = text.substr(begin, end - begin);
    if (line.find_first_of("\r\n") != std::string::npos) throw std::runtime_error("a line ends twice");
    std::istringstream words(line);
    std::string letters;
    std::size_t motor = 0;
    long position = 0;
    if (words >> letters >> motor >> position && letters == "mp") {
      if (positions_.size() <= motor) positions_.resize(motor + 1);
      positions_[motor].push_back(position);
    }
    lines_.push_back(line);
    begin = end + 2;
  }
}

std::vector<std::string> DfmocoHost::take_lines() {
  return std::exchange(lines_, {});
}

long DfmocoHost::position(std::size_t motor) const {
  const std::vector<long>& told = positions_.at(motor);
  return told.at(told.size() - 1);
}

}  // namespace inbetween::oracle
