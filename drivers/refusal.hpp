#pragma once

#include <string>

namespace inbetween {

/// Why the machine does not give what was asked for, for people.
struct Refusal {
  std::string what;    ///< one clause, no full stop, that names the thing
  std::string remedy;  ///< what to do about it
};

}  // namespace inbetween
