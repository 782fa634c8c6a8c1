#include "host_tools/reference/position_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "inbetween/base/hash.hpp"

namespace inbetween {
namespace {

constexpr std::string_view title = "inbetween positions ";
constexpr std::string_view version = "2";

std::string sum_line(std::string_view bytes) {
  Fnv1a sum;
  for (const char byte : bytes) sum.add(static_cast<unsigned char>(byte), 1);
  return fmt::format("sum {:016x}\n", sum.value());
}

/// The words of a line, the last of which may have spaces.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next() {
    const std::size_t space = std::min(rest_.find(' '), rest_.size());
    const std::string_view word = rest_.substr(0, space);
    rest_.remove_prefix(std::min(space + 1, rest_.size()));
    return word;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

template <typename Number, typename... Format>
std::optional<Number> number_of(std::string_view word, Format... format) {
  Number number = 0;
  const char* end = word.data() + word.size();
  const auto [stopped, error] = std::from_chars(word.data(), end, number, format...);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return number;
}

bool read_rig(std::string_view line, KeptPositions& positions) {
  Words words(line);
  if (words.next() != "rig") return false;
  const auto identity = number_of<std::uint64_t>(words.next(), 16);
  if (!identity) return false;
  positions.identity = *identity;
  positions.rig = words.rest();
  return true;
}

bool read_axis(std::string_view line, KeptPositions& positions) {
  Words words(line);
  KeptAxis axis;
  const std::string_view rest = words.next();
  if (rest == "at") {
    const auto position = number_of<double>(words.next());
    if (!position || !std::isfinite(*position)) return false;
    axis.rest = AxisRest::at;
    axis.position = *position;
  } else if (rest == "moving") {
    axis.rest = AxisRest::moving;
  } else if (rest != "unreferenced") {
    return false;
  }
  axis.name = words.rest();
  positions.axes.push_back(axis);
  return true;
}

/// Belongs to the axis of the line before.
bool read_zeros(std::string_view line, KeptPositions& positions) {
  if (positions.axes.empty()) return false;
  KeptAxis& axis = positions.axes.back();
  if (axis.rest != AxisRest::at || !axis.zeros.empty()) return false;
  Words words(line);
  words.next();
  while (!words.rest().empty()) {
    const auto zero = number_of<double>(words.next());
    if (!zero || !std::isfinite(*zero)) return false;
    axis.zeros.push_back(*zero);
  }
  return !axis.zeros.empty();
}

}  // namespace

std::string to_text(const KeptPositions& positions) {
  std::string text = fmt::format("{}{}\nrig {:016x} {}\n", title, version, positions.identity, positions.rig);
  for (const KeptAxis& axis : positions.axes) {
    std::string rest = axis.rest == AxisRest::moving ? "moving" : "unreferenced";
    if (axis.rest == AxisRest::at) rest = fmt::format("at {}", axis.position);
    text += fmt::format("{} {}\n", rest, axis.name);
    if (!axis.zeros.empty()) text += fmt::format("zero {}\n", fmt::join(axis.zeros, " "));
  }
  return text + sum_line(text);
}

std::variant<KeptPositions, std::string> parse_positions(std::string_view text) {
  if (!text.starts_with(title)) return text.empty() ? "is empty" : "is no position file";
  const std::string_view first = text.substr(title.size(), text.find('\n') - title.size());
  if (first != version) return "is of another version of this program";

  const std::size_t sum = text.rfind("sum ");
  if (sum == text.npos || text[sum - 1] != '\n' || text.substr(sum) != sum_line(text.substr(0, sum))) {
    return "is damaged: its check sum is not that of its text";
  }
  KeptPositions positions;
  std::size_t line_number = 0;
  for (std::string_view rest = text.substr(0, sum); !rest.empty();) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    ++line_number;
    const auto read = line_number == 2 ? read_rig : line.starts_with("zero ") ? read_zeros : read_axis;
    const bool is_read = line_number == 1 || read(line, positions);
    if (!is_read) return fmt::format("is damaged in line {}", line_number);
  }
  // There is one way to write the text. A text that the lenient reader above accepts in another form differs
  // here.
  if (to_text(positions) != text) return "is damaged: this program would have written it otherwise";
  return positions;
}

}  // namespace inbetween
