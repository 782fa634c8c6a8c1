// A move as the page of the editor gets it.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// Where a document comes from.
struct DocumentSource {
  std::string file;  ///< its name, without the folder
  std::string id;    ///< which file of this machine it is
  std::string revision;
  std::string rig_revision;
  std::string_view text;
  bool with_text = false;  ///< whether the document has the text in it
};

/// Throws InputError at a table that is too long for the page.
void refuse_what_is_not_shown(const Plan& plan);

/// JSON: the move as the core takes it (docs/editor.md lists the members). Of every track it says whether the
/// page can solve it by itself after every edit ("live"), and if keys or curve cannot be edited there, why.
/// Throws InputError where a table is longer than the page can show.
std::string document_of(const Plan& plan, const DocumentSource& source);

}  // namespace inbetween
