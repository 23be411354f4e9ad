// Checks the depth of a glTF file before assimp reads it: assimp follows nested JSON and nested nodes by recursion.
//
// Thread: any normal one. Bound: kMaxNodeDepth passes over the nodes; the file's size is limited before.
#pragma once

#include <filesystem>
#include <string>

namespace tactus::scene_import {

// Empty, or what is nested too deeply. Checks .gltf and .glb only; a file that is not valid glTF is left to assimp.
std::string gltf_depth_problem(const std::filesystem::path& file);

}  // namespace tactus::scene_import
