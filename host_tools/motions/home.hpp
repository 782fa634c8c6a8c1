// Axes of a rig find out where they are, by their switches or their drives.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host_tools/loop/rig_session.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The named axes, or without names all that have a `home`, in the order of the rig. Throws InputError for an
/// axis that the rig has not, or that has no `home`, and for a rig in which none has.
std::vector<std::size_t> home_axes(const RigFile& rig, const std::vector<std::string>& names);

/// Switches the rig on, homes the axes together, and switches it off. Where all are home, those that have a
/// `park` go there, slowly and together (go_to.hpp), which a failure to home keeps from beginning. What an
/// axis knew of its position is forgotten when it begins; if one fails all stop, and what has not been
/// referenced by then is unreferenced. SetupEnd::positions are those of the new reference.
///
/// Throws InputError where the rig file has changed since it was read, or, without real-time rights, an axis
/// is to home faster than at a tenth of its velocity; and what RigSession and RigReference throw.
SetupEnd home(const RigFile& rig, const std::vector<std::size_t>& axes, RigReference& reference,
              const SessionOptions& options);

/// Lets the drive of an axis with a `drive_home` home it, in a session in which the rig has this axis alone:
/// no other drive is spoken to, and this one takes no targets from when it is set up until it is off again.
/// So nothing can be left to jump to. The emergency stop, the switches of the axis, the operator and every
/// fault that is found in motion halt it. At the end the reference has the position that the drive tells, or
/// that it is lost.
///
/// Throws what RigSession throws.
SetupEnd home_by_drive(const RigFile& rig, std::size_t axis, RigReference& reference,
                       const SessionOptions& options);

}  // namespace inbetween
