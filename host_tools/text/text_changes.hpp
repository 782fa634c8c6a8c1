// Changes of a text, collected in any order and made at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace inbetween {

/// Bytes [begin, end) of a text.
struct Extent {
  std::size_t begin = 0;
  std::size_t end = 0;
};

class TextChanges {
 public:
  explicit TextChanges(std::string_view text) : text_(text) {}

  void replace(const Extent& extent, std::string by) { changes_.push_back({extent, std::move(by)}); }
  void insert(std::size_t at, std::string what) { replace({at, at}, std::move(what)); }

  /// The part of the text with the changes that lie within it; two insertions in one place in their order.
  /// Throws std::logic_error where two changes meet.
  [[nodiscard]] std::string apply(const Extent& part) const {
    std::vector<Change> sorted;
    for (const Change& change : changes_) {
      if (change.extent.begin >= part.begin && change.extent.end <= part.end) sorted.push_back(change);
    }
    std::ranges::stable_sort(sorted, {}, [](const Change& change) { return change.extent.begin; });
    std::string result;
    std::size_t copied = part.begin;
    for (const Change& change : sorted) {
      if (change.extent.begin < copied) throw std::logic_error("two changes of a text meet");
      result += text_.substr(copied, change.extent.begin - copied);
      result += change.by;
      copied = change.extent.end;
    }
    return result += text_.substr(copied, part.end - copied);
  }
  [[nodiscard]] std::string apply() const { return apply({0, text_.size()}); }

 private:
  struct Change {
    Extent extent;
    std::string by;
  };

  std::string_view text_;
  std::vector<Change> changes_;
};

}  // namespace inbetween
