#include "host_tools/text/spelling.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace inbetween {
namespace {

/// How many single-character edits turn `a` into `b`, of which one swaps two neighbours (Levenshtein and
/// Damerau, optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::vector<std::size_t> before;
  std::vector<std::size_t> two_before;
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    two_before = std::exchange(before, row);
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({substituted, row[j] + 1, row[j - 1] + 1}));
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], two_before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

std::optional<std::string_view> probably_meant(std::string_view word,
                                               std::span<const std::string_view> words) {
  std::optional<std::string_view> best;
  std::size_t best_distance = 3;
  for (const std::string_view candidate : words) {
    if (word.size() > candidate.size() + 2) continue;
    const std::size_t distance = edit_distance(word, candidate);
    // "att" for "at"; but x2 is not x1 written wrong.
    const bool is_longer_by_one = distance == 1 && candidate.size() == 2 && word.size() == 3;
    if (distance < best_distance && (2 * distance < candidate.size() || is_longer_by_one)) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace inbetween
