#include "host_tools/edit/edit_session.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/edit/edit_document.hpp"
#include "host_tools/fit/fewest_fit.hpp"
#include "host_tools/fit/speed_fit.hpp"
#include "host_tools/move_model/speed_rewrite.hpp"
#include "host_tools/text/text_file.hpp"
#include "inbetween/base/hash.hpp"

namespace inbetween {
namespace {

/// A person waits for it before a page.
constexpr std::int64_t max_fit_ns = 60'000'000'000;

/// An answer other than 200, on its way out.
struct Refused {
  int status;
  std::string what;
};

std::string error_json(std::string_view what) {
  return nlohmann::json{{"error", what}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string reason_of(int error) {
  return std::generic_category().message(error);
}

void refuse_if(const FileFailure& failure) {
  if (failure)
    throw Refused{500, fmt::format("{} {}: {}", failure.path, failure.what, reason_of(failure.error))};
}

std::string revision_of_file(const std::optional<std::string>& text) {
  return text ? revision_of(*text) : "gone";
}

}  // namespace

std::string revision_of(std::string_view text) {
  Fnv1a hash;
  for (const char byte : text) hash.add(static_cast<unsigned char>(byte), 1);
  return fmt::format("{}-{:016x}", text.size(), hash.value());
}

EditSession::EditSession(FileLayer files, std::string name, std::optional<std::string> rig, std::string id)
    : files_(std::move(files)), name_(std::move(name)), rig_(std::move(rig)), id_(std::move(id)) {}

template <class Action>
EditAnswer EditSession::guarded(const Action& action) {
  try {
    return action();
  } catch (const Refused& refused) {
    return {refused.status, error_json(refused.what)};
  } catch (const InputError& error) {
    return {422, error_json(error.what())};
  } catch (const std::invalid_argument& error) {
    return {400, error_json(error.what())};
  } catch (const std::exception& error) {
    return {500, error_json(error.what())};
  }
}

/// Nothing where the file is gone.
std::optional<std::string> EditSession::read() const {
  std::string text;
  const int error = files_.read(name_, max_file_bytes, text);
  if (error == ENOENT) return std::nullopt;
  if (error != 0) throw Refused{500, fmt::format("{} cannot be read: {}", name_, reason_of(error))};
  return text;
}

std::string EditSession::edited_text(const EditRequest& request) const {
  if (request.id && *request.id != id_)
    throw Refused{403, fmt::format("the program edits {} now, and the page another file", name_)};
  return with_edits(request.base, name_, request.edited);
}

Plan EditSession::plan_of(const std::string& text, const EditedRig::State& rig) const {
  return {parse_move(text, name_), rig.file, {.kinematics = rig.kinematics}};
}

EditAnswer EditSession::document(const std::string& text, bool with_text) {
  const EditedRig::State rig = rig_.now();
  const Plan plan = plan_of(text, rig);
  return {200, document_of(plan, {.file = name_,
                                  .id = id_,
                                  .revision = revision_of(text),
                                  .rig_revision = rig.revision,
                                  .text = text,
                                  .with_text = with_text})};
}

EditAnswer EditSession::open() {
  return guarded([&] {
    const std::optional<std::string> text = read();
    if (!text) throw Refused{404, fmt::format("{} is gone; somebody has moved it", name_)};
    return document(*text, true);
  });
}

EditAnswer EditSession::document_of_base(const std::string& base) {
  return guarded([&] { return document(base); });
}

EditAnswer EditSession::revision() {
  return guarded([&]() -> EditAnswer {
    const EditedRig::State rig = rig_.now();
    const auto or_null = [](const std::string& text) {
      return text.empty() ? nlohmann::json() : nlohmann::json(text);
    };
    return {200, nlohmann::json{{"revision", revision_of_file(read())},
                                {"id", id_},
                                {"rig", or_null(rig.revision)},
                                {"rig_error", or_null(rig.error)}}
                     .dump()};
  });
}

EditAnswer EditSession::resolve(const EditRequest& request) {
  return guarded([&] { return document(edited_text(request)); });
}

EditAnswer EditSession::fit(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    std::string text = edited_text(request);
    const Plan plan = plan_of(text, rig_.now());
    if (!plan.rig()) throw Refused{422, "there are no limits without a rig; open the move with --rig"};
    const std::int64_t last_ns = MonotonicClock().now_ns() + max_fit_ns;
    const SpeedFit found =
        fit_speed(plan, check(plan), {.is_over = [=] { return MonotonicClock().now_ns() >= last_ns; }});
    if (!found.found) {
      throw Refused{422, fmt::format("no speed curve was found for {}: {}",
                                     counted(plan.move().frames, "frame"), found.reason)};
    }
    for (const TrackFit& track : found.tracks) text = with_speed(text, name_, track.track, track.speed);
    return document(text);
  });
}

EditAnswer EditSession::fewest(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    const std::string text = edited_text(request);
    const Plan plan = plan_of(text, rig_.now());
    if (!plan.rig()) throw Refused{422, "there are no limits without a rig; open the move with --rig"};
    const SmallestFrames smallest = smallest_frames(plan, check(plan), {});
    if (!smallest.frames) throw Refused{422, "no number of frames would do: " + smallest.reason};
    const MoveFile move = with_frames(parse_move(text, name_), *smallest.frames);
    return document(with_frames_of(text, name_, move));
  });
}

EditAnswer EditSession::text(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    return {200, nlohmann::json{{"text", edited_text(request)}}.dump()};
  });
}

std::string EditSession::keep_copy(const std::string& text, const char* what) const {
  constexpr int max_copies = 1000;
  const std::string stem = name_.ends_with(".toml") ? name_.substr(0, name_.size() - 5) : name_;
  for (int number = 1; number < max_copies; ++number) {
    std::string name = fmt::format("{}.{}-{}.toml", stem, what, number);
    std::string there;
    const int error = files_.read(name, max_file_bytes, there);
    if (error == 0 && there == text) return name;
    if (error != ENOENT) continue;
    const FileFailure failure = replace_expected(files_, name, std::nullopt, text);
    if (failure.error == ESTALE) continue;
    refuse_if(failure);
    return name;
  }
  throw Refused{500, fmt::format("there are {} copies beside {} already; remove some", max_copies, name_)};
}

/// Puts `text` into the place of `there`, which is nothing or what the file had when it was read.
void EditSession::replace(const std::optional<std::string>& there, const std::string& text) const {
  std::string left;
  // An interrupted save may have left the only copy of an outside version there.
  if (files_.read(part_of(name_), max_file_bytes, left) == 0 && !left.empty() && left != text &&
      left != there)
    (void)keep_copy(left, "interrupted");
  const FileFailure failure = replace_expected(files_, name_, there, text);
  if (failure.error == ESTALE)
    throw Refused{409, fmt::format("{} has been changed outside the editor", name_)};
  refuse_if(failure);
}

EditAnswer EditSession::save(const EditRequest& request) {
  const std::lock_guard lock(writing_);
  return guarded([&]() -> EditAnswer {
    const std::string text = edited_text(request);
    // A file that cannot be solved can be opened neither by the page nor by `plan`: it is not written.
    (void)plan_of(text, rig_.now());
    const std::optional<std::string> there = read();
    nlohmann::json answer{{"revision", revision_of(text)}, {"kept", nullptr}};
    if (there == text) return {200, answer.dump()};  // an answer that was lost, and the same request again
    const std::string revision = revision_of_file(there);
    if (revision != request.expects.value_or(revision_of(request.base)))
      return {409, nlohmann::json{{"error", fmt::format("{} has been changed outside the editor", name_)},
                                  {"revision", revision}}
                       .dump()};
    if (there && !request.own && there != request.base) answer["kept"] = keep_copy(*there, "outside");
    replace(there, text);
    return {200, answer.dump()};
  });
}

EditAnswer EditSession::keep(const EditRequest& request) {
  const std::lock_guard lock(writing_);
  return guarded([&]() -> EditAnswer {
    const std::string text = edited_text(request);
    nlohmann::json answer{{"kept", nullptr}};
    if (read() != text) answer["kept"] = keep_copy(text, "mine");
    return {200, answer.dump()};
  });
}

void EditSession::open_imports_with(std::function<std::string(const std::string& move)> open) {
  open_import_ = std::move(open);
}

/// Rows first: no move names rows that are not there. False where a name was taken in the very moment.
bool EditSession::write_import(const RowsMove& move, FormQuestion& name) const {
  const ImportedNames names = imported_names(name);
  const auto is_new = [&](const std::string& file, const std::string& text) {
    const FileFailure failure = replace_expected(files_, file, std::nullopt, text);
    if (failure.error != ESTALE) refuse_if(failure);
    if (failure) name.mistake = fmt::format("{} is there already; write another name", file);
    return !failure;
  };
  if (!is_new(names.rows, rows_text_of(move, names.rows))) return false;
  bool is_written = false;
  try {
    is_written = is_new(names.move, move_text_of(move, names.rows));
  } catch (const Refused&) {
    std::string there;  // after a failure the move may be there all the same, and names the rows
    if (files_.read(names.move, max_file_bytes, there) == ENOENT) (void)files_.remove(names.rows);
    throw;
  }
  if (!is_written) (void)files_.remove(names.rows);
  return is_written;
}

/// Throws InputError where the page would not show the move.
void EditSession::expect_shown(const std::string& move, const EditedRig::State& rig) const {
  const TextReader read = [&](const std::filesystem::path& path, std::size_t max_bytes) {
    std::string text;
    if (const int error = files_.read(path.string(), max_bytes, text))
      throw InputError({path.string()}, fmt::format("cannot be read: {}", reason_of(error)));
    return text;
  };
  const std::string text = read(move, max_file_bytes);
  refuse_what_is_not_shown({parse_move_beside(read, text, move), rig.file, {.kinematics = rig.kinematics}});
}

WrittenImport EditSession::opened_import(const ImportedNames& names, const EditedRig::State& rig) const {
  WrittenImport written{.move = names.move, .rows = names.rows};
  try {
    expect_shown(names.move, rig);
    if (open_import_) written.address = open_import_(names.move);
  } catch (const std::runtime_error& error) {
    written.why_not = error.what();
  }
  return written;
}

EditAnswer EditSession::import_motion(const ImportRequest& request) {
  const std::lock_guard lock(writing_);
  return guarded([&]() -> EditAnswer {
    if (request.id && *request.id != id_)
      throw Refused{403, fmt::format("the program edits {} now, and the page another file", name_)};
    const EditedRig::State rig = rig_.now();
    if (!rig.file) throw Refused{422, "a motion is imported for the axes of a rig; open the move with --rig"};
    const auto said = request.answers.find("name");
    FormQuestion name = name_question(files_, request.file,
                                      said == request.answers.end() ? std::string_view() : said->second);
    ImportForm form = import_form(request.file, request.bytes, *rig.file, request.answers, name.answer);
    const bool is_said = form.move && !name.answer.empty() && name.mistake.empty();
    std::optional<WrittenImport> written;
    if (request.writes && is_said && write_import(*form.move, name))
      written = opened_import(imported_names(name), rig);
    form.questions.push_back(std::move(name));
    return {200, import_document(form, written)};
  });
}

EditAnswer answer_to_drawn(const SampledMotion& sampled) {
  try {
    const MotionFit fit = fit_motion(sampled);
    return {200, nlohmann::json{{"frames", fit.frames},
                                {"keys", fit.keys},
                                {"speed", fit.speed},
                                {"noise", fit.noise},
                                {"deviation", fit.deviation},
                                {"lag", fit.lag}}
                     .dump()};
  } catch (const std::invalid_argument& error) {
    return {422, error_json(error.what())};
  }
}

}  // namespace inbetween
