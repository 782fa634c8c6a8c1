#include "host_tools/edit/edit_session.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/edit/edit_document.hpp"
#include "host_tools/files/speed_rewrite.hpp"
#include "host_tools/files/toml_source.hpp"
#include "host_tools/fit/fewest_fit.hpp"
#include "host_tools/fit/speed_fit.hpp"
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

}  // namespace

std::string revision_of(std::string_view text) {
  Fnv1a hash;
  for (const char byte : text) hash.add(static_cast<unsigned char>(byte), 1);
  return fmt::format("{}-{:016x}", text.size(), hash.value());
}

EditSession::EditSession(FileLayer files, std::string name, std::optional<RigFile> rig,
                         std::shared_ptr<const Kinematics> kinematics)
    : files_(std::move(files)),
      name_(std::move(name)),
      rig_(std::move(rig)),
      kinematics_(std::move(kinematics)) {}

template <class Action>
EditAnswer EditSession::guarded(const Action& action) {
  const std::lock_guard lock(mutex_);
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

std::string EditSession::read() const {
  std::string text;
  const int error = files_.read(name_, max_file_bytes, text);
  if (error == ENOENT) throw Refused{404, fmt::format("{} is gone; somebody has moved it", name_)};
  if (error != 0) throw Refused{500, fmt::format("{} cannot be read: {}", name_, reason_of(error))};
  return text;
}

const std::string& EditSession::remember(const std::string& text) {
  const auto [found, is_new] = texts_.emplace(revision_of(text), text);
  if (is_new) {
    order_.push_back(found->first);
    if (order_.size() > max_texts) {
      texts_.erase(order_.front());
      order_.erase(order_.begin());
    }
  }
  return found->first;
}

std::string EditSession::edited_text(const EditRequest& request) const {
  const auto found = texts_.find(request.revision);
  if (found == texts_.end()) throw Refused{410, "the page is too old; load it again"};
  return with_edits(found->second, name_, request.edited);
}

Plan EditSession::plan_of(const std::string& text) const {
  return {parse_move(text, name_), rig_, {.kinematics = kinematics_}};
}

EditAnswer EditSession::document(const std::string& text, const std::string& revision) const {
  return {200, document_of(plan_of(text), {name_, revision, text})};
}

EditAnswer EditSession::open() {
  return guarded([&] {
    const std::string text = read();
    return document(text, remember(text));
  });
}

EditAnswer EditSession::revision() {
  return guarded([&]() -> EditAnswer {
    return {200, nlohmann::json{{"revision", revision_of(read())}}.dump()};
  });
}

EditAnswer EditSession::resolve(const EditRequest& request) {
  return guarded([&] { return document(edited_text(request), request.revision); });
}

EditAnswer EditSession::fit(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    std::string text = edited_text(request);
    const Plan plan = plan_of(text);
    if (!plan.rig()) throw Refused{422, "there are no limits without a rig; open the move with --rig"};
    const std::int64_t last_ns = MonotonicClock().now_ns() + max_fit_ns;
    const SpeedFit found =
        fit_speed(plan, check(plan), {.is_over = [=] { return MonotonicClock().now_ns() >= last_ns; }});
    if (!found.found) {
      throw Refused{422, fmt::format("no speed curve was found for {}: {}",
                                     counted(plan.move().frames, "frame"), found.reason)};
    }
    for (const TrackFit& track : found.tracks) text = with_speed(text, name_, track.track, track.speed);
    return document(text, request.revision);
  });
}

EditAnswer EditSession::fewest(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    const std::string text = edited_text(request);
    const Plan plan = plan_of(text);
    if (!plan.rig()) throw Refused{422, "there are no limits without a rig; open the move with --rig"};
    const SmallestFrames smallest = smallest_frames(plan, check(plan), {});
    if (!smallest.frames) throw Refused{422, "no number of frames would do: " + smallest.reason};
    const MoveFile move = with_frames(parse_move(text, name_), *smallest.frames);
    return document(with_frames_of(text, name_, move), request.revision);
  });
}

void EditSession::write(const std::string& name, const std::string& text) const {
  const FileFailure failure = replace_durably(files_, name, text);
  if (failure)
    throw Refused{500, fmt::format("{} {}: {}", failure.path, failure.what, reason_of(failure.error))};
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
    write(name, text);
    return name;
  }
  throw Refused{500, fmt::format("there are {} copies beside {} already; remove some", max_copies, name_)};
}

EditAnswer EditSession::save(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    const std::string text = edited_text(request);
    const std::string there = read();
    const std::string revision = revision_of(there);
    if (revision != request.expects.value_or(request.revision)) {
      return {409, nlohmann::json{{"error", fmt::format("{} has been changed outside the editor", name_)},
                                  {"revision", revision}}
                       .dump()};
    }
    nlohmann::json answer{{"kept", nullptr}};
    if (!texts_.contains(revision)) answer["kept"] = keep_copy(there, "outside");
    write(name_, text);
    answer["revision"] = remember(text);
    return {200, answer.dump()};
  });
}

EditAnswer EditSession::keep(const EditRequest& request) {
  return guarded([&]() -> EditAnswer {
    return {200, nlohmann::json{{"kept", keep_copy(edited_text(request), "mine")}}.dump()};
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
