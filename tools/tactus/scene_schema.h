// The JSON schema (2020-12) of scenes, generated from the loader's own list: types, ranges, allowed and required keys
// of each shape, generator and joint, and keys that depend on each other. Conditions on numbers of several tables are
// checked only by the loader.
// Thread: normal.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "sim/loader/scene_keys.h"

namespace tactus::tools {

nlohmann::ordered_json scene_schema(const std::vector<sim::SceneTable>& language);

}  // namespace tactus::tools
