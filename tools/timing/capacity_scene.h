// The worst that a loop may be asked to do at a declared capacity: a hand stirs the top of a heap of cubes that is
// larger than the sub-world, so that as many bodies as it may have are members, each pressed upon by its neighbours,
// members come and go in every cycle, and the border is always at work.
//
// Thread: [setup]. Pure: the same capacity gives the same text.
#pragma once

#include <string>

namespace tactus::timing {

// A scene's TOML text for that many members. Coupling and contacts are as stiff as the rate bears.
std::string capacity_scene(unsigned members, unsigned sub_steps, unsigned ratio, double rate_Hz);

}  // namespace tactus::timing
