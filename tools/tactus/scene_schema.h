// The JSON schema (2020-12) of scenes, written from the loader's own list: types, ranges, what each shape, generator
// and joint has and needs, and keys that go together. What is asked of numbers of several tables is the loader's alone.
// Thread: normal.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "sim/loader/scene_keys.h"

namespace tactus::tools {

nlohmann::ordered_json scene_schema(const std::vector<sim::SceneTable>& language);

}  // namespace tactus::tools
