// Worst-case scene for a declared capacity: a hand stirs the top of a heap of cubes that is larger than the sub-world.
// The sub-world is therefore full, each member is loaded by its neighbours, members change in every cycle, and there
// are always border contacts.
//
// Thread: [setup]. Pure: the same capacity gives the same text.
#pragma once

#include <string>

namespace tactus::timing {

// A scene's TOML text for that many members. Coupling and contacts have the largest stiffness that is stable at this
// rate.
std::string capacity_scene(unsigned members, unsigned sub_steps, unsigned ratio, double rate_Hz);

}  // namespace tactus::timing
