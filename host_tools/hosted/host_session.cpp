#include "host_tools/hosted/host_session.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <memory>
#include <numeric>
#include <span>
#include <utility>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t ns_between_words = 100'000'000;

std::vector<std::size_t> all_axes_of(const RigFile& rig) {
  std::vector<std::size_t> axes(rig.axes.size());
  std::iota(axes.begin(), axes.end(), std::size_t{0});
  return axes;
}

void refuse_outside(const RigSession& session) {
  const RigFile& rig = session.rig();
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    const double stands = session.positions()[a];
    if (stands >= axis.min && stands <= axis.max) continue;
    throw InputError(axis.place, fmt::format("{} stands at {:.10g} {}, outside its limits {}; {}",
                                             named(axis), stands, to_string(axis.unit), range_in_words(axis),
                                             remedy_outside(rig, a, stands, session.options().as_arguments)));
  }
}

/// What the host does not see: the keys of the person at the rig.
class HostAttendant {
 public:
  explicit HostAttendant(const HostSessionOptions& options) : options_(options) {}

  /// Until then nobody is served.
  void begin(HostedRig& rig, HostLine& line) {
    rig_ = &rig;
    line_ = &line;
  }
  /// Nothing that was not told yet is lost.
  void end() {
    next_words_ns_ = 0;
    tell();
    line_ = nullptr;
  }

  std::vector<TransportKey> serve() {
    if (line_ == nullptr) return {};
    std::vector<TransportKey> for_loop;
    if (options_.session.audience.keys) keys_.feed(options_.session.audience.keys());
    while (const auto key = keys_.next()) press(*key, for_loop);
    line_->serve(rig_->now_ns());
    tell();
    return for_loop;
  }

 private:
  void press(TransportKey key, std::vector<TransportKey>& for_loop) {
    switch (key) {
      case TransportKey::start:
      case TransportKey::acknowledge:
        return line_->agree();
      case TransportKey::stop:
      case TransportKey::pause:
        return line_->stop(rig_->now_ns());
      case TransportKey::quit:
        line_->stop(rig_->now_ns());
        return for_loop.push_back(key);
      default:
        return;
    }
  }
  void tell() {
    if (!options_.tell) return;
    const std::int64_t now_ns = clock_.now_ns();
    if (next_words_ns_ != 0 && now_ns < next_words_ns_) return;
    next_words_ns_ = now_ns + ns_between_words;
    options_.tell(line_->state_in_words(), line_->take_words());
  }

  const HostSessionOptions& options_;
  HostedRig* rig_ = nullptr;
  HostLine* line_ = nullptr;
  TransportKeys keys_;
  MonotonicClock clock_;
  std::int64_t next_words_ns_ = 0;
};

std::vector<FreeAxis> resting_axes(const RigSession& session, double share) {
  std::vector<FreeAxis> axes;
  for (std::size_t a = 0; a < session.rig().axes.size(); ++a) {
    const RigAxis& axis = session.rig().axes[a];
    axes.push_back(
        free_axis_of(axis, free_limits_of(axis, share), session.positions()[a], session.tick_seconds()));
  }
  return axes;
}

SetupEnd be_hosted(RigSession& session, HostPort& port, RigReference& reference, HostAttendant& attendant,
                   const HostSessionOptions& options) {
  const RigFile& rig = session.rig();
  const std::unique_ptr<LevelOutputs> outputs = LevelOutputs::open(rig, session.hardware());
  if (!session.arm()) return {.reason = reason_of(session, "the drives were not switched on")};
  refuse_outside(session);
  std::vector<AxisLimits> limits;
  for (const RigAxis& axis : rig.axes) limits.push_back(limits_of(slow_enough_everywhere(axis)));
  HostedMotion motion(session.loop(), resting_axes(session, options.share), std::move(limits),
                      session.tick_seconds(), outputs.get());
  HostedRig hosted(
      rig, motion,
      {.share = options.share,
       .about_to_move = [&](std::span<const std::size_t> axes) { reference.about_to_move(axes); },
       .keep = [&](const std::vector<DriveState>& states) { session.keep(states); },
       .rig_has_changed = session.options().audience.rig_has_changed});
  HostLine line(port, options.protocol, rig, hosted, options.consent);
  const DisarmAtEnd disarm(session);
  attendant.begin(hosted, line);
  const ActEnd end = session.perform(motion);
  attendant.end();
  const std::string outputs_trouble = outputs ? outputs->trouble() : "";
  SetupEnd result{.is_done = static_cast<bool>(end.begun)};
  result.reason = end.begun ? reason_of(session, "left; " + line.counts_in_words()) : end.begun.error().what;
  const std::string unreached = session.rest();
  if (!unreached.empty()) result = {.is_done = false, .reason = unreached};
  if (!outputs_trouble.empty()) result.reason += "; " + outputs_trouble;
  result.positions = session.positions();
  return result;
}

}  // namespace

HostSessionEnd give_to_host(const RigFile& rig, HostPort& port, RigReference& reference,
                            const HostSessionOptions& options) {
  reference.refuse_unreferenced(all_axes_of(rig));
  HostAttendant attendant(options);
  SessionOptions session_options = options.session;
  session_options.audience.keys = {};
  session_options.audience.device = [&] { return attendant.serve(); };
  RigSession session(rig, reference, session_options);
  HostSessionEnd end{
      end_of(session, [&] { return be_hosted(session, port, reference, attendant, options); })};
  session.end();
  end.late_ticks = session.late_ticks();
  end.latency = session.latency();
  return end;
}

}  // namespace inbetween
