// The rows of a file that are wrong, all of them: who corrects a file wants to see them at once.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// Several refusals: what() has a line for each, place() and message() are those of the first.
class WrongRowsError : public InputError {
 public:
  WrongRowsError(const InputError& first, std::string lines) : InputError(first), lines_(std::move(lines)) {}
  [[nodiscard]] const char* what() const noexcept override { return lines_.c_str(); }

 private:
  std::string lines_;
};

/// Collects refusals of rows. More than max_named are counted, up to max_counted, where reading ends.
class WrongRows {
 public:
  static constexpr std::size_t max_named = 20;
  static constexpr std::size_t max_counted = 1'000;

  explicit WrongRows(std::string file) : file_(std::move(file)) {}

  /// Does `read`; where it throws InputError that is kept, and `otherwise` is done.
  template <class Read, class Otherwise>
  void judge(const Read& read, const Otherwise& otherwise) {
    try {
      read();
    } catch (const InputError& error) {
      add(error);
      otherwise();
    }
  }
  /// Throws WrongRowsError at max_counted of them.
  void add(const InputError& error);
  /// Throws what was kept: an InputError if it is one, otherwise WrongRowsError.
  void refuse() const;

 private:
  std::string file_, lines_;
  std::size_t count_ = 0;
  std::optional<InputError> first_;
};

}  // namespace inbetween
