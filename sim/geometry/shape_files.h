// Reads the corners of a solid from a file: Wavefront OBJ, STL in text or binary.
//
// Only positions are read, for a convex hull; for triangles see mesh_files.h. From an OBJ file the lines "v x y z",
// from an STL file the corners of its triangles, each position once, in the order of the file. Why not a library: the
// available readers take an invalid number for zero and do not report the line; here each mistake has its line or its
// triangle. Units: the file's own.
// Thread: [setup]. Bound: kMaxShapeFileBytes; beyond it the file is rejected.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/spatial.h"

namespace tactus::sim {

inline constexpr std::size_t kMaxShapeFileBytes = 64u << 20;

// The name's extension, .obj or .stl, selects the format. Errors are one line: the file, the position in it, what is
// wrong, what is accepted.
Result<std::vector<Vec3d>> read_shape_file(const std::filesystem::path& path);

// The same from the file's content; `name` is for messages.
Result<std::vector<Vec3d>> parse_obj(std::string_view text, std::string_view name);
Result<std::vector<Vec3d>> parse_stl(std::string_view bytes, std::string_view name);

// All corners of all triangles, in the order of the file.
Result<std::vector<Vec3d>> parse_stl_corners(std::string_view bytes, std::string_view name);

struct ShapeFile {
  std::string name, bytes;
  bool is_obj{true};  // false: STL
};
// The file's content, or an error if it cannot be a shape file.
Result<ShapeFile> open_shape_file(const std::filesystem::path& path);

}  // namespace tactus::sim
