// The triangles in a file: Wavefront OBJ, STL in text or binary.
//
// Of an OBJ file the lines "v x y z" and "f a b c ...", where a face of more corners is cut into a fan; of an STL file
// its triangles. Normals, textures and names are not used: the order of the corners says what is outside. Units: the
// file's own. Thread: [setup]. Bound: kMaxMeshCorners, kMaxMeshTriangles; beyond them the file is refused.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/spatial.h"

namespace tactus::sim {

// Of a scene in all: the tape carries them as text (4 MB at most), and a haptic tick must find them in its caches.
inline constexpr std::size_t kMaxMeshTriangles = 20'000;
inline constexpr std::size_t kMaxMeshCorners = 20'000;

struct TriangleSoup {
  std::vector<Vec3d> corners;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

// Errors are one line: the file, the place, what is wrong, what is accepted.
Result<TriangleSoup> read_triangle_file(const std::filesystem::path& path);

// The same from what is in the file; `name` is for messages.
Result<TriangleSoup> parse_obj_triangles(std::string_view text, std::string_view name);
Result<TriangleSoup> parse_stl_triangles(std::string_view bytes, std::string_view name);

}  // namespace tactus::sim
