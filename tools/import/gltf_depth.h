// Looks at a glTF file before assimp does, whose reader follows nested JSON and nested nodes by recursion.
//
// Thread: any normal one. Bound: kMaxNodeDepth passes over the nodes; the file's size is limited before.
#pragma once

#include <filesystem>
#include <string>

namespace tactus::scene_import {

// Empty, or what is nested too deeply; .gltf and .glb alone. What is no glTF, assimp says.
std::string gltf_depth_problem(const std::filesystem::path& file);

}  // namespace tactus::scene_import
