// The corners of a solid in a file: Wavefront OBJ, STL in text or binary.
//
// Only places are read: what a convex hull is made of; for triangles see mesh_files.h. Of an OBJ file the lines "v x y
// z", of an STL file the corners of its triangles, each place once, in the order of the file. Why not a library: the
// readers at hand take a number that is none for zero and do not say in which line; here each mistake is named with its
// line, or its triangle. Units: the file's own. Thread: [setup]. Bound: kMaxShapeFileBytes; beyond it the file is
// refused.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/spatial.h"

namespace tactus::sim {

inline constexpr std::size_t kMaxShapeFileBytes = 64u << 20;

// By the name's ending: .obj or .stl. Errors are one line: the file, the place, what is wrong, what is accepted.
Result<std::vector<Vec3d>> read_shape_file(const std::filesystem::path& path);

// The same from what is in the file; `name` is for messages.
Result<std::vector<Vec3d>> parse_obj(std::string_view text, std::string_view name);
Result<std::vector<Vec3d>> parse_stl(std::string_view bytes, std::string_view name);

// All corners of all triangles, in the order of the file.
Result<std::vector<Vec3d>> parse_stl_corners(std::string_view bytes, std::string_view name);

struct ShapeFile {
  std::string name, bytes;
  bool is_obj{true};  // or STL
};
// What is in the file, if it is one that may be a shape.
Result<ShapeFile> open_shape_file(const std::filesystem::path& path);

}  // namespace tactus::sim
