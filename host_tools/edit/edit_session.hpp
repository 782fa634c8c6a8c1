// One move file, edited: what the page may ask, without the network.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "host_tools/edit/edit_import.hpp"
#include "host_tools/edit/edit_request.hpp"
#include "host_tools/edit/edited_rig.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/text/file_layer.hpp"

namespace inbetween {

/// An answer to the page: a status of HTTP and JSON.
struct EditAnswer {
  int status = 200;
  std::string json;
};

/// Every answer that refuses is {"error": "one line"}. Thread-safe.
///
/// The session remembers no text: edits come with the text that they are meant for, so that they can be saved
/// however old they are, and by a program that has been started anew. A revision names the bytes of a file;
/// that of a file that is gone is "gone".
class EditSession {
 public:
  /// `name` is the move's name in the folder of `files`, `rig` the path of its rig; `id` tells the move from
  /// every other file of this machine.
  EditSession(FileLayer files, std::string name, std::optional<std::string> rig, std::string id = "");

  /// The file as it is now: document_of with the text, or 422 where it is no move that can be solved; 404
  /// where it is gone.
  EditAnswer open();
  /// The same of a text that the page has had from open() before.
  EditAnswer document_of_base(const std::string& base);
  /// {"revision": of the file as it is now, "id", "rig": the revision of the rig that counts, "rig_error":
  /// why its file of today does not}; null where there is none.
  EditAnswer revision();
  /// The move with the edits, solved; nothing is written.
  EditAnswer resolve(const EditRequest& request);
  /// The same, its curves fitted to the limits of the rig (`check --fit`); 422 with the reason where none is
  /// found.
  EditAnswer fit(const EditRequest& request);
  /// The same in the fewest frames in which its curves as they are fit.
  EditAnswer fewest(const EditRequest& request);
  /// {"text": the file as the edits would make it}, whether it can be solved or not.
  EditAnswer text(const EditRequest& request);
  /// Writes the edits into the file, durably, and answers {"revision", "kept"}. It answers 422 where they
  /// make a move that cannot be solved, and 409 with the revision that is there where it is not the one that
  /// the request expects, also where it comes in the very moment (replace_expected); then it writes nothing.
  /// A text that somebody else wrote is kept before it is replaced: "kept" names the file beside the move.
  EditAnswer save(const EditRequest& request);
  /// Writes the edits into a new file beside the move's, and answers {"kept": its name}; null where the file
  /// has that text.
  EditAnswer keep(const EditRequest& request);
  /// A file of another program as a move of its rows: import_document with the questions that are open, in
  /// the words of `inbetween import`, or the lines for which the file is refused. Where `writes` is said and
  /// nothing is open, the rows and then the move are written beside this move; a name that a file has is a
  /// mistake of its question, and nothing is written over. 422 without a rig.
  EditAnswer import_motion(const ImportRequest& request);
  /// How a move that was imported is opened: its file to the address of its page. Throws std::runtime_error,
  /// one line. Without it none is opened. Said before anything is asked.
  void open_imports_with(std::function<std::string(const std::string& move)> open);

 private:
  template <class Action>
  EditAnswer guarded(const Action& action);
  [[nodiscard]] std::optional<std::string> read() const;
  [[nodiscard]] std::string edited_text(const EditRequest& request) const;
  [[nodiscard]] Plan plan_of(const std::string& text, const EditedRig::State& rig) const;
  [[nodiscard]] EditAnswer document(const std::string& text, bool with_text = false);
  [[nodiscard]] std::string keep_copy(const std::string& text, const char* what) const;
  void replace(const std::optional<std::string>& there, const std::string& text) const;
  bool write_import(const RowsMove& move, FormQuestion& name) const;
  void expect_shown(const std::string& move, const EditedRig::State& rig) const;
  [[nodiscard]] WrittenImport opened_import(const ImportedNames& names, const EditedRig::State& rig) const;

  std::mutex writing_;
  FileLayer files_;
  std::string name_;
  EditedRig rig_;
  std::string id_;
  std::function<std::string(const std::string& move)> open_import_;
};

/// The keys and the speed curve of a motion that was drawn (fit_motion): {"frames", "keys", "speed", "noise",
/// "deviation", "lag"}. 422 with the reason where it is no motion.
EditAnswer answer_to_drawn(const SampledMotion& sampled);

/// The revision of a text: its size and a hash of its bytes.
std::string revision_of(std::string_view text);

}  // namespace inbetween
