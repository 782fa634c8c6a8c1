// Whatever fields of moves and rigs stand beside each other: planned, checked and played, or refused in one
// line.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <random>
#include <string>

#include "host_tools/check/check.hpp"
#include "host_tools/motions/run.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/plan.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_files.hpp"

namespace inbetween {
namespace any_files_property_test {

/// Ends the process where a case takes longer than any may: it is the end that is missing, and no limit of
/// speed.
class Bound {
 public:
  explicit Bound(const std::string& text) {
    text_ = text;
    std::signal(SIGALRM, [](int) {
      std::fprintf(stderr, "this move has no end:\n%s\n", text_.c_str());
      std::_Exit(3);
    });
    ::alarm(120);
  }
  ~Bound() { ::alarm(0); }
  Bound(const Bound&) = delete;
  Bound& operator=(const Bound&) = delete;

 private:
  static inline std::string text_;
};

struct Outcome {
  std::string what;
  std::string message;
};

Outcome use(const RandomFiles& files, bool plays) {
  try {
    const std::optional<RigFile> rig = rig_of(files);
    const Plan plan(parse_move(files.move, "move.toml"), rig, {.kinematics = joints_of(files, rig)});
    if (!rig) return {"planned", ""};
    const CheckReport report = check(plan);
    if (!report.fits()) return {"does not fit", report.refusals.front().message()};
    if (!plays) return {"fits", ""};
    const RunReport played = run(plan, {.simulated = true, .fast = true});
    return {played.ending == Ending::finished ? "played" : "not finished", played.reason};
  } catch (const InputError& refused) {
    return {"refused", refused.what()};
  }
}

TEST(AnyFilesProperty, ArePlannedCheckedAndPlayedOrRefusedInOneLine) {
  std::map<std::string, int> outcomes;
  check_property(20'000, [&] {
    std::mt19937 random(*rc::gen::arbitrary<std::uint32_t>());
    const RandomFiles files = random_files(random);
    const Bound bound(files.rig + files.rig_folder + "\n" + files.move);
    const Outcome outcome = use(files, random() % 8 == 0);
    ++outcomes[outcome.what];
    RC_LOG() << files.rig << files.rig_folder << "\n"
             << files.move << outcome.what << ": " << outcome.message;
    RC_ASSERT(outcome.what != "not finished");
    RC_ASSERT(std::ranges::count(outcome.message, '\n') == 0);
    RC_ASSERT(outcome.message.find("internal") == std::string::npos);
    RC_ASSERT(outcome.message.find("nan") == std::string::npos);
  });
  for (const auto& [what, count] : outcomes) std::printf("%s: %d\n", what.c_str(), count);
}

}  // namespace any_files_property_test
}  // namespace inbetween
