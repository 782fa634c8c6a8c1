// Writes JSON piece by piece: a plan of 100 000 frames has a million numbers, too many for a document in
// memory. A number has the shortest form that reads back exactly; a number that is not finite is null.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <concepts>
#include <cstdio>
#include <iterator>
#include <optional>
#include <string_view>

namespace inbetween {

/// Writes one JSON text to an open file. In an object a value follows key(); in an array it stands alone. The
/// writer adds the commas. A line breaks where line() is called.
class JsonWriter {
 public:
  explicit JsonWriter(std::FILE* file) : file_(file) {}
  ~JsonWriter() { flush(); }
  JsonWriter(const JsonWriter&) = delete;
  JsonWriter& operator=(const JsonWriter&) = delete;

  void begin_object() { open('{'); }
  void end_object() { close('}'); }
  void begin_array() { open('['); }
  void end_array() { close(']'); }

  void key(std::string_view name) {
    separate();
    quoted(name);
    buffer_.push_back(':');
    separated_ = true;
  }
  template <class Value>
  void member(std::string_view name, const Value& item) {
    key(name);
    value(item);
  }

  void value(double number) {
    if (!std::isfinite(number)) {
      null();
      return;
    }
    separate();
    fmt::format_to(std::back_inserter(buffer_), "{}", number);
    // Many readers take -0 for an integer, which has no sign to keep.
    if (number == 0 && std::signbit(number)) append(".0");
    flush_if_large();
  }
  void value(std::integral auto number) {
    separate();
    fmt::format_to(std::back_inserter(buffer_), "{}", number);
  }
  void value(bool truth) {
    separate();
    append(truth ? "true" : "false");
  }
  void value(std::string_view text) {
    separate();
    quoted(text);
  }
  void value(const char* text) { value(std::string_view(text)); }
  /// null without a value.
  template <class Value>
  void value(const std::optional<Value>& item) {
    return item ? value(*item) : null();
  }
  /// An array of numbers or texts, or of such arrays.
  template <class Range>
  requires(requires(const Range& items) { items.begin(); } &&
           !std::convertible_to<Range, std::string_view>) void value(const Range& items) {
    open('[');
    for (const auto& item : items) value(item);
    close(']');
  }
  void null() {
    separate();
    append("null");
  }
  /// An object of this name. `fill` writes its members.
  template <class Fill>
  void object(std::string_view name, const Fill& fill) {
    key(name);
    begin_object();
    fill();
    end_object();
  }
  /// An array of this name. `fill` writes its items.
  template <class Fill>
  void array(std::string_view name, const Fill& fill) {
    key(name);
    begin_array();
    fill();
    end_array();
  }
  /// An array of this name, an object a line. `fill` writes the members for each of the items, which are a
  /// range, or a number of indices.
  template <class Items, class Fill>
  void objects(std::string_view name, const Items& items, const Fill& fill) {
    const auto add = [&](const auto& one) {
      line();
      begin_object();
      fill(one);
      end_object();
    };
    array(name, [&] {
      if constexpr (std::integral<Items>) {
        for (Items index = 0; index < items; ++index) add(index);
      } else {
        for (const auto& one : items) add(one);
      }
    });
  }

  /// A new line before the next item, indented by the depth.
  void line() {
    if (!separated_) {
      buffer_.push_back(',');
      separated_ = true;
    }
    buffer_.push_back('\n');
    for (int i = 0; i < depth_; ++i) buffer_.push_back(' ');
  }
  /// Ends the text with a newline.
  void finish() {
    buffer_.push_back('\n');
    flush();
  }

 private:
  void open(char bracket) {
    separate();
    buffer_.push_back(bracket);
    separated_ = true;
    ++depth_;
  }
  void close(char bracket) {
    buffer_.push_back(bracket);
    separated_ = false;
    --depth_;
  }
  void separate() {
    if (!separated_) buffer_.push_back(',');
    separated_ = false;
  }
  void quoted(std::string_view text);
  void append(std::string_view text) { buffer_.append(text.data(), text.data() + text.size()); }
  void flush_if_large() {
    if (buffer_.size() > 60'000) flush();
  }
  void flush() {
    std::fwrite(buffer_.data(), 1, buffer_.size(), file_);
    buffer_.clear();
  }

  std::FILE* file_;
  fmt::basic_memory_buffer<char, 65'536> buffer_;
  bool separated_ = true;
  int depth_ = 0;
};

}  // namespace inbetween
