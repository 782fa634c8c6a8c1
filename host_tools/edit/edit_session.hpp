// One move file, edited: what the page may ask, without the network.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "host_tools/edit/edit_request.hpp"
#include "host_tools/files/file_layer.hpp"
#include "host_tools/files/rig_file.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// An answer to the page: a status of HTTP and JSON.
struct EditAnswer {
  int status = 200;
  std::string json;
};

/// Every answer that refuses is {"error": "one line"}. Thread-safe: one request after the other.
///
/// A revision names the bytes of a file. The session remembers the texts that it has given out or written,
/// the last max_texts of them; edits say which one they are meant for.
class EditSession {
 public:
  static constexpr std::size_t max_texts = 64;

  /// `name` is the move's name in the folder of `files`.
  EditSession(FileLayer files, std::string name, std::optional<RigFile> rig,
              std::shared_ptr<const Kinematics> kinematics);

  /// The file as it is now: document_of, or 422 where it is no move that can be solved.
  EditAnswer open();
  /// {"revision": of the file as it is now}; 404 where it is gone.
  EditAnswer revision();
  /// The move with the edits, solved; nothing is written.
  EditAnswer resolve(const EditRequest& request);
  /// The same, its curves fitted to the limits of the rig (`check --fit`); 422 with the reason where none is
  /// found.
  EditAnswer fit(const EditRequest& request);
  /// The same in the fewest frames in which its curves as they are fit.
  EditAnswer fewest(const EditRequest& request);
  /// Writes the edits into the file, durably, and answers {"revision", "kept"}. Where the file has another
  /// revision than the request expects, it answers 409 with the one that is there, and writes nothing. A text
  /// that the session has neither given out nor written is kept beside it before it is replaced, in the file
  /// that "kept" names.
  EditAnswer save(const EditRequest& request);
  /// Writes the edits into a new file beside the move's, and answers {"kept": its name}.
  EditAnswer keep(const EditRequest& request);

 private:
  template <class Action>
  EditAnswer guarded(const Action& action);
  [[nodiscard]] std::string read() const;
  const std::string& remember(const std::string& text);
  [[nodiscard]] std::string edited_text(const EditRequest& request) const;
  [[nodiscard]] Plan plan_of(const std::string& text) const;
  [[nodiscard]] EditAnswer document(const std::string& text, const std::string& revision) const;
  std::string keep_copy(const std::string& text, const char* what) const;
  void write(const std::string& name, const std::string& text) const;

  std::mutex mutex_;
  FileLayer files_;
  std::string name_;
  std::optional<RigFile> rig_;
  std::shared_ptr<const Kinematics> kinematics_;
  std::map<std::string, std::string> texts_;  ///< by revision
  std::vector<std::string> order_;            ///< of revisions, the oldest first
};

/// The keys and the speed curve of a motion that was drawn (fit_motion): {"frames", "keys", "speed", "noise",
/// "deviation", "lag"}. 422 with the reason where it is no motion.
EditAnswer answer_to_drawn(const SampledMotion& sampled);

/// The revision of a text: its size and a hash of its bytes.
std::string revision_of(std::string_view text);

}  // namespace inbetween
