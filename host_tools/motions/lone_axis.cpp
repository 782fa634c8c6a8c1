#include "host_tools/motions/lone_axis.hpp"

#include <string>
#include <utility>
#include <vector>

namespace inbetween {

RigFile lone_axis(const RigFile& rig, std::size_t axis) {
  RigFile one = rig;
  one.axes = {rig.axes[axis]};
  one.start_trigger.reset();
  one.camera.reset();
  one.outputs.clear();
  one.kinematics.reset();
  one.dragonframe.reset();
  return one;
}

SessionOptions lone_axis_options(const SessionOptions& options, const RigFile& rig, std::size_t axis,
                                 const RigReference& reference) {
  SessionOptions one = options;
  const std::string& name = rig.axes[axis].name;
  const auto truly = options.standing.find(name);
  one.standing.clear();
  if (truly != options.standing.end()) {
    one.standing[name] = truly->second;
  } else if (const auto known = reference.position(axis)) {
    one.standing[name] = *known;
  }
  one.faults.faults.clear();
  for (ScriptedFault fault : options.faults.faults) {
    if (fault.axis != axis) continue;
    fault.axis = 0;
    one.faults.faults.push_back(std::move(fault));
  }
  return one;
}

SetupEnd use_alone(const RigFile& rig, std::size_t axis, const RigReference& reference,
                   const SessionOptions& options,
                   const std::function<SetupEnd(RigSession&, RigReference&)>& task) {
  const RigFile one = lone_axis(rig, axis);
  RigReference unknown(one);
  unknown.is_lost(0, "nobody has said it");
  RigSession session(one, unknown, lone_axis_options(options, rig, axis, reference));
  SetupEnd end = end_of(session, [&] { return task(session, unknown); });
  if (end.positions.empty()) return end;
  std::vector<double> positions(rig.axes.size());
  positions[axis] = end.positions.front();
  end.positions = std::move(positions);
  return end;
}

}  // namespace inbetween
