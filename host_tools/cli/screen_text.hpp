// What a terminal shows while a rig moves, as lines of text.
#pragma once

#include <string>
#include <vector>

#include "host_tools/loop/run_snapshot.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The lines of a screen of so many columns and lines, none longer and no more of them: what happens, every
/// axis, and at the bottom the keys. Where there is no room the title and the bar go first, then the last
/// axes, with a line that says how many; what happens and the keys stay. Notes stand below what happens,
/// wrapped, the more important first: the others go before the title does.
std::vector<std::string> screen_text(const std::string& title, const RigFile& rig,
                                     const RunSnapshot& snapshot, int columns, int lines,
                                     const std::vector<std::string>& notes = {});

}  // namespace inbetween
