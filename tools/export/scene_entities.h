// Bodies as Foxglove's SceneUpdate messages in JSON, which Foxglove and Lichtblick draw: one entity for what never
// moves, one for the bodies of the sub-world.
//
// Thread: any normal one. Frame: world, as frame id "world". Units: m. Bound: linear in the bodies and the corners of
// their hulls and meshes. Source: Foxglove's published JSON schema of foxglove.SceneUpdate.
#pragma once

#include <cstdint>
#include <string>

#include "sim/model/scene.h"
#include "tools/export/sink.h"

namespace tactus::exporting {

// JSON Schema of the messages.
const std::string& scene_update_schema();

// The fixed bodies, once.
std::string fixed_bodies_json(const sim::Scene& scene, std::uint64_t time_ns);
// The sub-world's bodies; the message replaces the one before.
std::string members_json(const sim::Scene& scene, const ExportedFrame& frame, std::uint64_t time_ns);

}  // namespace tactus::exporting
