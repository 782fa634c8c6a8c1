// What the doctor has found: one line about one thing, and what to do about it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

enum class Verdict {
  fine,
  note,     ///< it runs, but could be better
  problem,  ///< run refuses it, or does not work
};

struct Finding {
  std::string of;  ///< "kernel", "bus can0", "axis pan"
  Verdict verdict = Verdict::fine;
  std::string what{};    ///< one clause, no full stop
  std::string remedy{};  ///< what to do; "" where nothing is to be done
};

using Findings = std::vector<Finding>;

constexpr std::string_view word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::fine:
      return "fine";
    case Verdict::note:
      return "note";
    case Verdict::problem:
      break;
  }
  return "problem";
}

}  // namespace inbetween
