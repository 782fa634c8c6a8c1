#include "tests/support/fitting_move.hpp"

#include <rapidcheck.h>

#include <utility>

#include "tests/support/random_move.hpp"
#include "tests/support/rig_near.hpp"

namespace inbetween {

std::optional<FittingMove> fitting_move(int max_percent, bool with_parts) {
  const std::optional<MoveFile> move = for_a_rig(*regular_move());
  if (!move) return std::nullopt;
  const std::optional<RigFile> rig =
      rig_near(*move, {.share = [=] { return *rc::gen::inRange(102, max_percent) / 100.0; },
                       .limits_jerk = *rc::gen::arbitrary<bool>(),
                       .allows_steps = *rc::gen::arbitrary<bool>(),
                       .rate_hz = *rc::gen::element(100, 250, 1000)});
  if (!rig) return std::nullopt;
  FrameRange frames;
  if (with_parts && move->frames > 1 && *rc::gen::arbitrary<bool>()) {
    const auto frame = [](int from, int below) {
      return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(from, below));
    };
    frames.first = frame(0, move->frames);
    frames.last = frame(*frames.first + 1, move->frames + 1);
  }
  Plan plan(*move, rig, {.frames = frames});
  CheckReport report = check(plan);
  if (!report.fits()) return std::nullopt;
  return FittingMove{std::move(plan), std::move(report)};
}

Plan without_stop_limits(const Plan& plan) {
  RigFile rig = *plan.rig();
  for (RigAxis& axis : rig.axes) {
    axis.stop_acceleration = axis.max_acceleration;
    axis.stop_jerk = axis.max_jerk;
  }
  return {plan.move(), rig, {.frames = {plan.part().first, plan.part().last}}};
}

}  // namespace inbetween
