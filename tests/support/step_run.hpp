#pragma once

#include <cstdint>
#include <ostream>
#include <span>
#include <vector>

#include "inbetween/steps/step_generator.hpp"

/// A step generator that is run, and everything that it puts out.

namespace inbetween {

/// For GoogleTest.
inline void PrintTo(const StepEdge& edge, std::ostream* out) {
  *out << (edge.line == StepLine::step ? "STEP " : "DIR ") << edge.level << " at " << edge.at_ns << " ns";
}

/// Times from the first tick on.
struct PutStep {
  std::int64_t rise_ns = 0;
  bool up = false;
  std::int64_t fall_before_ns = 0;  ///< of STEP; long ago if there was none
  std::int64_t dir_change_ns = 0;   ///< the last one before, likewise
  std::int64_t dir_before_ns = 0;   ///< the one before that
};

class StepRun {
 public:
  static constexpr std::int64_t long_ago_ns = -1'000'000'000'000;

  explicit StepRun(const StepSpec& spec) : StepRun(StepGenerator::make(spec).value()) {}

  Result<std::size_t> tick(const Setpoint& end) {
    const Result<std::size_t> size = generator.advance(end, memory_);
    if (!size) return size;
    last_tick = std::span<const StepEdge>(memory_).first(*size);
    for (StepEdge edge : last_tick) {
      edge.at_ns += start_ns;
      take(edge);
    }
    start_ns += generator.spec().tick_ns;
    return size;
  }

  StepGenerator generator;
  std::int64_t start_ns = 0;            ///< of the next tick
  std::span<const StepEdge> last_tick;  ///< from its own start
  std::vector<StepEdge> edges;
  std::vector<PutStep> steps;

 private:
  explicit StepRun(const StepGenerator& made) : generator(made), memory_(made.max_edges()) {}

  void take(const StepEdge& edge) {
    edges.push_back(edge);
    if (edge.line == StepLine::dir) {
      dir_before_ns_ = dir_ns_;
      dir_ns_ = edge.at_ns;
      dir_ = edge.level;
    } else if (edge.level) {
      steps.push_back({edge.at_ns, dir_, fall_ns_, dir_ns_, dir_before_ns_});
    } else {
      fall_ns_ = edge.at_ns;
    }
  }

  std::vector<StepEdge> memory_;
  bool dir_ = false;
  std::int64_t fall_ns_ = long_ago_ns;
  std::int64_t dir_ns_ = long_ago_ns;
  std::int64_t dir_before_ns_ = long_ago_ns;
};

}  // namespace inbetween
