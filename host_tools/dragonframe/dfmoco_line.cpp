#include "host_tools/dragonframe/dfmoco_line.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

namespace inbetween::dragonframe {
namespace {

using LineKind = DfmocoLine::Kind;

constexpr std::array<std::pair<std::string_view, DfmocoCommand>, 13> command_letters{{
    {"hi", DfmocoCommand::hi},
    {"ms", DfmocoCommand::ms},
    {"mm", DfmocoCommand::mm},
    {"mp", DfmocoCommand::mp},
    {"sm", DfmocoCommand::sm},
    {"sa", DfmocoCommand::sa},
    {"jm", DfmocoCommand::jm},
    {"im", DfmocoCommand::im},
    {"pr", DfmocoCommand::pr},
    {"zm", DfmocoCommand::zm},
    {"np", DfmocoCommand::np},
    {"bf", DfmocoCommand::bf},
    {"go", DfmocoCommand::go},
}};

/// The sketch reads nothing behind these; for `go`, which moves, that is too little.
bool ignores_numbers(DfmocoCommand command) {
  return command == DfmocoCommand::hi || command == DfmocoCommand::ms || command == DfmocoCommand::sa;
}

}  // namespace

DfmocoLine read_dfmoco_line(std::string_view text) {
  DfmocoLine line;
  const auto* const found = std::find_if(command_letters.begin(), command_letters.end(),
                                         [&](const auto& row) { return row.first == text.substr(0, 2); });
  if (found == command_letters.end() || (text.size() > 2 && text[2] != ' ')) return line;
  line.kind = LineKind::command;
  line.command = found->second;
  if (ignores_numbers(line.command)) return line;
  text.remove_prefix(2);
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (text.empty()) return line;
    // A number that goes on in other letters, as 1.5 and 70000000000 do, moves nothing.
    std::int32_t number = 0;
    const auto [behind, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
    text.remove_prefix(static_cast<std::size_t>(behind - text.data()));
    if (fault != std::errc{} || (!text.empty() && text.front() != ' ')) {
      line.kind = LineKind::malformed;
      return line;
    }
    if (line.numbers.size() == max_dfmoco_numbers) {
      line.kind = LineKind::too_many_numbers;
      return line;
    }
    line.numbers.push_back(number);
  }
}

std::optional<DfmocoLine> DfmocoDecoder::next(std::span<const std::uint8_t>& bytes) {
  while (!bytes.empty()) {
    const char letter = static_cast<char>(bytes.front());
    bytes = bytes.subspan(1);
    if (letter != '\r' && letter != '\n') {
      if (size_ == buffer_.size()) is_too_long_ = true;
      if (is_too_long_) {
        ++counters_.abandoned_bytes;
      } else {
        buffer_.at(size_++) = letter;
      }
      continue;
    }
    if (size_ == 0) continue;
    DfmocoLine line = read_dfmoco_line({buffer_.data(), size_});
    if (is_too_long_ && line.kind != LineKind::unknown) line.kind = LineKind::too_many_numbers;
    ++(line.kind == LineKind::unknown ? counters_.unknown : counters_.lines);
    size_ = 0;
    is_too_long_ = false;
    return line;
  }
  return {};
}

void DfmocoDecoder::clear() {
  counters_.abandoned_bytes += size_;
  size_ = 0;
  is_too_long_ = false;
}

}  // namespace inbetween::dragonframe
