#include "host_tools/motions/staged_move.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/check/check.hpp"

namespace inbetween {
namespace {

PlannedStops stops_of(const Plan& plan, double rate) {
  PlannedStops stops(plan, rate);
  if (stops.obstacle()) {
    const std::size_t axis = plan.axis_of(static_cast<std::size_t>(stops.obstacle()->axis));
    throw LimitError(
        plan.place_of(axis),
        fmt::format("axis {} could not be stopped at frame {:.2f} from {:g} times the drawn speed; "
                    "use a lower rate",
                    in_quotes(plan.axes()[axis].name), stops.obstacle()->frame, rate));
  }
  return stops;
}

}  // namespace

StagedMove::StagedMove(const Plan& plan, double rate, std::span<const std::string> still)
    : plan_(plan),
      stops_(stops_of(plan, rate)),
      playhead_(plan.played(), *stops_.bounds(), plan.rig()->rate_hz),
      is_still_(std::make_unique<bool[]>(plan.played().axis_count())) {
  for (std::size_t d = 0; d < plan.played().axis_count(); ++d) {
    drive_of_.push_back(plan.axis_of(d));
    is_still_[d] = std::ranges::find(still, plan.axes()[drive_of_[d]].name) != still.end();
  }
  if (!still.empty()) still_ = playhead_;
}

LoopSpec<double> StagedMove::loop_spec() {
  LoopSpec<double> spec{.move = &plan_.played(),
                        .playhead = &playhead_,
                        .drive_of = drive_of_,
                        .limits = plan_.limits(),
                        .tick_seconds = 1.0 / plan_.rig()->rate_hz};
  if (still_) {
    spec.still = &*still_;
    spec.is_still = {is_still_.get(), drive_of_.size()};
  }
  return spec;
}

void StagedMove::set_repeat(Repeat repeat) {
  const Status status = playhead_.set_repeat(repeat);
  if (status) return;
  const std::size_t axis = plan_.axis_of(static_cast<std::size_t>(std::max(status.error().axis, 0)));
  throw LimitError(plan_.place_of(axis), fmt::format("axis {}: {}; {}", in_quotes(plan_.axes()[axis].name),
                                                     status.error().what, status.error().remedy));
}

}  // namespace inbetween
