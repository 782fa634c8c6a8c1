#pragma once

namespace inbetween::embedded {

/// Prints a line: hashes of sines, and of the poses, Jacobians and motion of a crane.
void report_joints();

}  // namespace inbetween::embedded
