// Bodies from files of shapes: glTF, OBJ, STL, by assimp. A node with triangles is a body.
//
// Units: SI; the file's unit is the caller's. Frame: world, z up (glTF's y becomes z). The file is read in a process of
// its own. Thread: any normal one. Bound: kMaxShapeNodes, kMaxShapeTriangles, depth of nodes, time, memory; no file
// outside of the file's folder is read. Errors: one line; what a scene cannot have goes to the account.
#pragma once

#include <filesystem>

#include "tools/import/mesh_parts.h"

namespace tactus::scene_import {

inline constexpr std::size_t kMaxShapeNodes = 1'000, kMaxShapeTriangles = 1'000'000;
inline constexpr unsigned kMaxNodeDepth = 100;
inline constexpr std::size_t kMaxFileBytes = 64u << 20;  // of each file

struct ShapeOptions {
  double unit_m{1};                // the length that the file calls 1
  double density_kg_per_m3{1000};  // of bodies without such a property
  bool fixed{false};               // true: bodies without such a property never move
  double friction{0.5};
};

Result<SceneDraft> read_shapes(const std::filesystem::path& file, const ShapeOptions& options,
                               const PieceOptions& pieces, Account& account);

}  // namespace tactus::scene_import
