#include "host_tools/scene/usda_words.hpp"

#include <fmt/format.h>

#include "host_tools/scene/scene_bounds.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {
namespace {

constexpr std::string_view signs = "(){}[]=,:.";

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
/// Of a name: "xformOp:translate.timeSamples" is one, and so is a letter beyond ASCII.
bool begins_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         (static_cast<unsigned char>(c) & 0x80U) != 0;
}
bool goes_on_name(char c) {
  return begins_name(c) || is_digit(c) || c == ':' || c == '.' || c == '|';
}

}  // namespace

UsdaWords::UsdaWords(std::string_view text, const std::string& file) : text_(text), file_(file) {
  if (text_.starts_with(byte_order_mark)) at_ = byte_order_mark.size();
  next_ = read();
}

UsdaWord UsdaWords::take() {
  const UsdaWord word = next_;
  next_ = read();
  return word;
}

bool UsdaWords::take_if(std::string_view letters) {
  const bool is_it =
      (next_.kind == UsdaKind::sign || next_.kind == UsdaKind::name) && next_.letters == letters;
  if (is_it) next_ = read();
  return is_it;
}

void UsdaWords::require(std::string_view sign) {
  if (take_if(sign)) return;
  if (next_.kind == UsdaKind::end)
    refuse(next_, fmt::format("the text ends where {} is missing; write the file again", in_quotes(sign)));
  refuse(next_, fmt::format("here {} stands, where {} is missing; write it", in_quotes(next_.letters),
                            in_quotes(sign)));
}

void UsdaWords::skip_value() {
  std::string open;  // the brackets that are missing
  do {
    const UsdaWord word = take();
    if (word.kind == UsdaKind::end) refuse(word, "the text ends within a value; write the file again");
    // The prim of another file is one value: @file@</prim>.
    if (word.kind == UsdaKind::asset && next_.kind == UsdaKind::path) take();
    if (word.kind != UsdaKind::sign) continue;
    const char sign = word.letters.front();
    if (sign == '(') open += ')';
    if (sign == '[') open += ']';
    if (sign == '{') open += '}';
    if (open.size() > max_scene_depth)
      refuse(word, fmt::format("this nests deeper than {}; write it flatter", max_scene_depth));
    if (sign != ')' && sign != ']' && sign != '}') continue;
    if (open.empty() || open.back() != sign)
      refuse(word, fmt::format("no bracket is open that {} closes; remove it", in_quotes(word.letters)));
    open.pop_back();
  } while (!open.empty());
}

Place UsdaWords::place_of(const UsdaWord& word) const {
  Place place{file_, 1, 1};
  for (std::size_t i = text_.starts_with(byte_order_mark) ? byte_order_mark.size() : 0; i < word.offset;
       ++i) {
    if ((static_cast<unsigned char>(text_[i]) & 0xc0U) != 0x80U) ++place.column;
    if (text_[i] != '\n') continue;
    ++place.line;
    place.column = 1;
  }
  return place;
}

void UsdaWords::refuse(const UsdaWord& word, const std::string& message) const {
  throw InputError(place_of(word), message);
}

void UsdaWords::pass_blanks() {
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == '#') {
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    } else if (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ';') {
      ++at_;
    } else {
      return;
    }
  }
}

UsdaWord UsdaWords::read_between(char end, UsdaKind kind) {
  const std::size_t begin = at_ + 1;
  const std::size_t close = text_.find(end, begin);
  UsdaWord word{.kind = kind, .letters = {}, .offset = at_};
  if (close == std::string_view::npos)
    refuse(word, fmt::format("no {} ends what begins here; write it", in_quotes(std::string(1, end))));
  word.letters = text_.substr(begin, close - begin);
  at_ = close + 1;
  return word;
}

/// With one quote of either kind at each end, or with three, between which lines may end.
UsdaWord UsdaWords::read_quoted() {
  UsdaWord word{.kind = UsdaKind::text, .letters = {}, .offset = at_};
  const char quote = text_[at_];
  const std::string three(3, quote);
  const bool is_long = text_.substr(at_).starts_with(three);
  const std::size_t begin = at_ + (is_long ? 3 : 1);
  for (std::size_t i = begin; i < text_.size(); ++i) {
    if (text_[i] == '\\') {
      ++i;
    } else if (text_[i] == quote && (!is_long || text_.substr(i).starts_with(three))) {
      word.letters = text_.substr(begin, i - begin);
      at_ = i + (is_long ? 3 : 1);
      return word;
    } else if (text_[i] == '\n' && !is_long) {
      break;
    }
  }
  refuse(word, "no quote ends this text; write one");
}

UsdaWord UsdaWords::read() {
  pass_blanks();
  UsdaWord word{.kind = UsdaKind::end, .letters = {}, .offset = at_};
  if (at_ >= text_.size()) return word;
  const char c = text_[at_];
  if (c == '"' || c == '\'') return read_quoted();
  if (c == '<') return read_between('>', UsdaKind::path);
  if (c == '@') {
    const bool is_long = text_.substr(at_).starts_with("@@@");
    if (!is_long) return read_between('@', UsdaKind::asset);
    const std::size_t close = text_.find("@@@", at_ + 3);
    if (close == std::string_view::npos) refuse(word, "no \"@@@\" ends what begins here; write it");
    word = {UsdaKind::asset, text_.substr(at_ + 3, close - at_ - 3), at_};
    at_ = close + 3;
    return word;
  }
  std::size_t end = at_ + 1;
  const bool is_signed = (c == '-' || c == '+') && end < text_.size();
  const bool is_number = is_digit(c) || (c == '.' && end < text_.size() && is_digit(text_[end])) ||
                         (is_signed && (is_digit(text_[end]) || text_[end] == '.' || text_[end] == 'i'));
  if (is_number) {
    while (end < text_.size() &&
           (is_digit(text_[end]) || begins_name(text_[end]) || text_[end] == '.' ||
            ((text_[end] == '-' || text_[end] == '+') && (text_[end - 1] == 'e' || text_[end - 1] == 'E'))))
      ++end;
    word.kind = UsdaKind::number;
  } else if (begins_name(c)) {
    while (end < text_.size() && goes_on_name(text_[end])) ++end;
    word.kind = UsdaKind::name;
  } else if (signs.find(c) != std::string_view::npos) {
    word.kind = UsdaKind::sign;
  } else {
    refuse(word, "this is no sign of USD; correct it, or write the file again as .usda");
  }
  word.letters = text_.substr(at_, end - at_);
  at_ = end;
  return word;
}

}  // namespace inbetween
