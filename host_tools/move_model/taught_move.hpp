// A move whose keys are stored where a rig stands.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/file_layer.hpp"

namespace inbetween {

/// Where every axis of a rig stands, in its unit; nothing for one that does not know.
using StandingAxes = std::vector<std::optional<double>>;

/// Each change is written at once, whole and durably, and what is written is a move that its reader accepts:
/// whether it fits the rig, and whether its keys can be passed, `check` says. Comments, order and all else in
/// the file stay (with_edits). A file that somebody else has changed is read again and not written.
///
/// The axis that is moved decides which track is meant. A key takes the positions of all axes of its track,
/// in their order and units, as the nearest numbers with one decimal more than the counts of the drives need.
/// A step that does nothing says why in words() and does not throw. One that would store a place where the
/// key before it or behind it stands already (nearer than near_share on every axis) asks first: between such
/// keys a path turns on the spot. The same step at the same place once more stores it.
class TaughtMove {
 public:
  /// Of the range between the limits of an axis.
  static constexpr double near_share = 1e-3;

  /// The move at `path`, or one that its first key makes, with a track of these axes of the rig. Refers to
  /// the rig. Throws InputError where what is there is no move, or one of its axes is none of the rig.
  TaughtMove(FileLayer files, const std::string& path, const RigFile& rig,
             std::vector<std::size_t> axes_of_new);

  /// The key before the chosen one (-1) or behind it (1), of the track that has the axis.
  void choose(std::size_t axis, int by);
  /// A new key before the chosen one, which stays chosen.
  void insert(std::size_t axis, const StandingAxes& standing);
  /// In place of the chosen one; what the key says besides its position stays.
  void replace(std::size_t axis, const StandingAxes& standing);
  /// A new key behind all others, which is chosen then.
  void append(std::size_t axis, const StandingAxes& standing);
  /// Takes back the last key that was stored and is not taken back.
  void undo();

  /// What the last step did, or why it did nothing.
  [[nodiscard]] const std::string& words() const { return words_; }
  /// The keys that were stored and not taken back.
  [[nodiscard]] std::size_t stored() const { return stored_; }
  /// For a screen: which key of which track is chosen, what the last step did, and the keys around the chosen
  /// one in at most `max_rows` lines.
  [[nodiscard]] std::vector<std::string> shown(std::size_t axis, std::size_t max_rows) const;

 private:
  enum class Where { before_chosen, in_place, behind_all };
  struct Undo {
    std::string text;
    std::vector<std::size_t> chosen;
    bool has_made = false;  ///< there was no file
  };

  /// What was asked and has not been answered.
  struct Asked {
    std::size_t track = 0;
    std::size_t index = 0;
    Where where = Where::behind_all;
    std::vector<double> at;
    bool operator==(const Asked&) const = default;
  };

  template <class Action>
  void guarded(const Action& action);
  void store(std::size_t axis, const StandingAxes& standing, Where where);
  void make(const StandingAxes& standing);
  /// Throws the question, unless it was asked already.
  void ask_if_near(std::size_t track, std::size_t index, Where where, const std::vector<double>& at);
  void refuse_changed_file();
  void write(const std::string& text);
  void take(std::string text);
  [[nodiscard]] std::optional<std::size_t> track_of(std::size_t axis) const;
  [[nodiscard]] std::size_t known_track_of(std::size_t axis) const;
  [[nodiscard]] const RigAxis& rig_axis(const std::string& name) const;
  [[nodiscard]] std::vector<double> position_of(const MoveTrack& track, const StandingAxes& standing) const;
  [[nodiscard]] std::string key_words(const MoveTrack& track, std::size_t key) const;

  FileLayer files_;
  std::string name_;    ///< as it is called
  std::string target_;  ///< behind symbolic links
  const RigFile& rig_;
  std::vector<std::size_t> axes_of_new_;
  std::optional<std::string> text_;  ///< of the file; nothing: it is not there
  MoveFile move_;
  std::vector<std::size_t> chosen_;  ///< by track
  std::vector<Undo> undos_;
  std::optional<Asked> asked_;
  std::size_t stored_ = 0;
  std::string words_;
};

}  // namespace inbetween
