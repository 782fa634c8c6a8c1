// What the page asks for, read from JSON that anybody may have written.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "host_tools/files/move_rewrite.hpp"
#include "host_tools/fit/motion_fit.hpp"

namespace inbetween {

inline constexpr std::size_t max_request_bytes = std::size_t{4} << 20U;
inline constexpr int max_request_nesting = 8;

/// A request that is refused; what() is one line without a place.
class RequestError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct EditRequest {
  std::string revision;  ///< the text that the edits are meant for
  EditedMove edited;
  std::optional<std::string>
      expects;  ///< the revision that the file has, as the page knows; nothing: `revision`
};

/// Reads one request. Strict: every unknown, missing or ill-typed member is refused by its name. Throws
/// RequestError.
EditRequest parse_edit_request(std::string_view text);

/// Reads a motion that was drawn with a pointer, as strictly: "times" in seconds, "positions" time after
/// time, "tolerances" (null: the axis does not count) and "weights" by axis, "frames_per_second". Whether it
/// is a motion, fit_motion says.
SampledMotion parse_drawn_motion(std::string_view text);

}  // namespace inbetween
