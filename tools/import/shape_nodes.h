// The nodes of a file of shapes, as assimp reads them; internal to shape_source. Where assimp was missing, an error.
// Units: the file's. Frame: the file's, z up. Thread: any normal one. Bound: see shape_source.h. Errors: one line.
#pragma once

#include <filesystem>
#include <map>

#include "tools/import/account.h"
#include "tools/import/mass_properties.h"

namespace tactus::scene_import {

struct ShapeNode {
  std::string name;
  Vec3d position;                       // of the node's origin
  sim::TriangleSoup soup;               // from there, welded
  std::map<std::string, double> extra;  // custom properties of the node; NaN: one that is no number and no flag
};

struct ShapeNodes {
  std::vector<ShapeNode> nodes;
  std::vector<std::string> left_out;
  std::vector<Refusal> refused;
};

Result<ShapeNodes> read_nodes(const std::filesystem::path& file);

}  // namespace tactus::scene_import
