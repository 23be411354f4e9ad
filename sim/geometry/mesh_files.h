// Reads the triangles of a file: Wavefront OBJ, STL in text or binary.
//
// From an OBJ file the lines "v x y z" and "f a b c ...", where a face of more corners is divided into a fan; from an
// STL file its triangles. Normals, textures and names are not used: the order of the corners defines the outside.
// Units: the file's own.
// Thread: [setup]. Bound: kMaxMeshCorners, kMaxMeshTriangles; beyond them the file is rejected.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/spatial.h"

namespace tactus::sim {

// Totals of a scene: the tape stores them as text (4 MB at most), and they must fit the caches in a haptic tick.
inline constexpr std::size_t kMaxMeshTriangles = 20'000;
inline constexpr std::size_t kMaxMeshCorners = 20'000;

struct TriangleSoup {
  std::vector<Vec3d> corners;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

// Errors are one line: the file, the position in it, what is wrong, what is accepted.
Result<TriangleSoup> read_triangle_file(const std::filesystem::path& path);

// The same from the file's content; `name` is for messages.
Result<TriangleSoup> parse_obj_triangles(std::string_view text, std::string_view name);
Result<TriangleSoup> parse_stl_triangles(std::string_view bytes, std::string_view name);

}  // namespace tactus::sim
