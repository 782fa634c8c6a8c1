// What the page asks for, read from JSON that anybody may have written.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "host_tools/exchange/import_form.hpp"
#include "host_tools/fit/motion_fit.hpp"
#include "host_tools/move_model/move_rewrite.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {

/// JSON takes two bytes for a line end, a tab, a quotation mark and a backslash, and a move has no other
/// characters to escape: with this, no file that can be read (max_file_bytes) is too large to be edited.
/// Edits themselves have 5 MB at most: 8 tracks of 1000 keys on 16 axes, which the page can solve.
inline constexpr std::size_t max_request_bytes = 2 * max_file_bytes + (std::size_t{8} << 20U);
inline constexpr int max_request_nesting = 8;

/// A request that is refused; what() is one line without a place.
class RequestError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct EditRequest {
  std::optional<std::string> id;  ///< of the file that the page has open
  std::string base;               ///< the text that the edits are meant for
  EditedMove edited;
  /// The revision that the file has, as the page knows; nothing: that of `base`.
  std::optional<std::string> expects;
  /// Whether the page has the text of that revision: it has loaded or written it itself.
  bool own = false;
};

/// Reads one request. Strict: every unknown, missing or ill-typed member is refused by its name. Throws
/// RequestError.
EditRequest parse_edit_request(std::string_view text);

/// A file of another program, which is to become a move beside the one that is edited.
struct ImportRequest {
  std::optional<std::string> id;  ///< of the file that the page has open
  std::string file;               ///< its name, without a folder
  std::string bytes;
  FormAnswers answers;
  bool writes = false;  ///< the move is written where no question is open; otherwise only looked at
};

/// Reads {"id", "file", "bytes": in Base64, "answers": an object of texts, "writes"}, as strictly.
ImportRequest parse_import_request(std::string_view text);

/// Reads {"base": a text}, as strictly.
std::string parse_base(std::string_view text);

/// Reads a motion that was drawn with a pointer, as strictly: "times" in seconds, "positions" time after
/// time, "tolerances" (null: the axis does not count) and "weights" by axis, "frames_per_second". Whether it
/// is a motion, fit_motion says.
SampledMotion parse_drawn_motion(std::string_view text);

}  // namespace inbetween
