// Reads the tables of a scene file that make bodies: a body's table, a generator's table.
// Thread: [setup]. Mistakes go to the reader's diagnostics; a wrong value is replaced by a harmless default.
#pragma once

#include "rt/text/table_reader.h"
#include "sim/loader/generators.h"
#include "sim/loader/scene_load.h"
#include "sim/loader/scene_load_hull.h"
#include "sim/loader/scene_load_mesh.h"

namespace tactus::sim {

inline constexpr text::Range kFriction{"a coefficient of friction", 0, 10};

enum class BodyRole { kProxy, kBody };

// Returns a body without an id. Gravity does not act on the proxy: the device holds it.
physics::Body read_body(text::TableReader& table, BodyRole role, HullReader& hulls, MeshReader& meshes);

// Bodies in the world frame, without ids, and the generator's results. If the part has more than `capacity` bodies,
// none is made and a mistake is added.
struct Generated {
  GeneratedPart part;
  Bodies bodies;
};
Generated read_generator(text::TableReader& table, unsigned capacity);

}  // namespace tactus::sim
