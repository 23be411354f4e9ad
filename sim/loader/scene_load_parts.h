// The parts of a scene file that make bodies: a body's table, a generator's table.
// Thread: [setup]. Mistakes go to the reader's diagnostics; what is wrong reads as a harmless default.
#pragma once

#include "sim/loader/generators.h"
#include "sim/loader/scene_load_hull.h"
#include "sim/loader/scene_load_mesh.h"
#include "sim/loader/scene_load_reader.h"

namespace tactus::sim {

inline constexpr Range kFriction{"a coefficient of friction", 0, 10};

enum class BodyRole { kProxy, kBody };

// A body without an id. The proxy floats: the device carries it.
physics::Body read_body(TableReader& table, BodyRole role, HullReader& hulls, MeshReader& meshes);

// Bodies in the frame of the world, without ids, and what the generator says of them. Nothing is made (and a mistake
// added) beyond `room` bodies.
struct Generated {
  GeneratedPart part;
  Bodies bodies;
};
Generated read_generator(TableReader& table, unsigned room);

}  // namespace tactus::sim
