// The frame of a draft's body, and its mass properties: whole and exact, whatever shapes it has.
//
// A sphere, a capsule, a cylinder or a box of a scene has its centre of mass in its middle and its principal axes along
// its own; a hull has its centre inside. A body that has other mass properties is a compound of one part: its surface
// stays. Units: SI. Frame: as each function says. Thread: any normal one. Bound: linear in the parts; a hull's faces.
// Errors: none.
#pragma once

#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

// Gives the body its parts; their poses are in the world frame. The body's frame becomes the frame of its only part,
// or `world_from_body` if it has several.
void set_parts(std::vector<DraftPart> parts, const Posed& world_from_body, DraftBody& body);

// Call after set_parts. `whole`: in the world frame, and is_a_body.
void set_mass(const MassProperties& whole, DraftBody& body);

}  // namespace tactus::scene_import
