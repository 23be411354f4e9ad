// Reads the tables of a scene file that make many bodies.
// Thread: [setup]. Mistakes go to the reader's diagnostics; a wrong value is replaced by a harmless default.
#pragma once

#include <string_view>
#include <vector>

#include "rt/text/table_reader.h"
#include "sim/loader/generators.h"
#include "sim/loader/scene_load.h"

namespace tactus::sim {

// Bodies in the world frame, without ids, and the generator's results. If the part has more than `capacity` bodies,
// none is made and a mistake is added.
struct Generated {
  GeneratedPart part;
  Bodies bodies;
};
Generated read_generator(text::TableReader& table, unsigned capacity);

// The words for [[generate]] kind.
std::vector<std::string_view> generator_names();

}  // namespace tactus::sim
