// The lines that a reader prints about a file. Each names the place, the mistake and the remedy.
//
// Every diagnostic is one line. Control characters from the file appear as \xNN, so that no file can break
// the line or steer a terminal.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "inbetween/base/result.hpp"

namespace inbetween {

/// A place in a text file. Lines and columns count from 1, columns in Unicode code points; line 0 is the
/// file as a whole, column 0 the line as a whole.
struct Place {
  std::string file;
  std::uint32_t line = 0;
  std::uint32_t column = 0;

  bool operator==(const Place&) const = default;
};

/// "file:line:column", "file:line" for a whole line, or "file" for the file as a whole.
std::string to_string(const Place& place);

/// Input that is refused. what() is "file:line:column: error: message", without a newline.
class InputError : public std::runtime_error {
 public:
  /// `message` names the mistake and, after a semicolon, the remedy.
  InputError(Place place, std::string message);

  const Place& place() const { return place_; }
  const std::string& message() const { return message_; }

 private:
  Place place_;
  std::string message_;
};

/// Throws InputError: "who: what; remedy". `refusal` has a `what` and a `remedy`, as Error and Refusal do.
template <class Refusal>
[[noreturn]] void refuse_at(const Place& place, const Refusal& refusal, const std::string& who = "") {
  throw InputError(place, (who.empty() ? who : who + ": ") + refusal.what + "; " + refusal.remedy);
}

/// The value of a result. Throws as refuse_at does if it is an error.
template <class T>
const T& value_or_refuse(const Result<T>& result, const Place& place, const std::string& who = "") {
  if (!result) refuse_at(place, result.error(), who);
  return *result;
}

/// A line about accepted input that its author should know.
struct Warning {
  Place place;
  std::string message;
};

/// "file:line:column: warning: message".
std::string to_string(const Warning& warning);

/// `text` as a diagnostic shows it: in double quotes, control characters as \xNN, and at most 60 bytes, the
/// rest as "..." (a character is never cut in two).
std::string in_quotes(std::string_view text);

/// Two numbers with at least so many decimals or significant digits, and with as many as show which is which:
/// "10.0005" and "10.0010".
enum class Digits { decimals, significant };
struct TwoNumbers {
  std::string first, second;
};
TwoNumbers told_apart(double first, double second, Digits kind, int at_least);

/// "1 frame", "2 frames".
std::string counted(std::int64_t count, std::string_view what);

/// "a", "a and b", "a, b and c".
std::string listed_with_and(const std::vector<std::string>& words);

/// "a, b, c".
template <typename Words>
std::string comma_separated(const Words& words) {
  std::string list;
  for (const auto& word : words) {
    if (!list.empty()) list += ", ";
    list += word;
  }
  return list;
}

}  // namespace inbetween
