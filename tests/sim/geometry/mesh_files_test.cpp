// Triangles in files: what is read of OBJ and STL, and that no bytes do harm.
#include <cstring>
#include <fstream>

#include "tests/sim/geometry/mesh_support.h"
#include "tests/support/temporary_file.h"

using namespace tactus;
using namespace tactus::sim;
using namespace tactus::sim::support;
using Catch::Matchers::Contains;

namespace {

const std::string kSquare = "# a square\nv 0 0 0\nv 1 0 0\nvn 0 0 1\nv 1 1 0\nv 0 1 0\n";

std::string wrong_obj(const std::string& text) {
  const auto soup = parse_obj_triangles(text, "x.obj");
  REQUIRE_FALSE(soup.ok());
  return soup.message();
}

std::string binary_stl(const TriangleSoup& soup) {
  std::string bytes(80, ' ');
  const auto put = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(soup.triangles.size()));
  for (const auto& t : soup.triangles) {
    for (int i = 0; i < 3; ++i) put(0.0f);
    for (const std::uint32_t c : t)
      for (int i = 0; i < 3; ++i) put(static_cast<float>(soup.corners[c][i]));
    put(std::uint16_t{0});
  }
  return bytes;
}

}  // namespace

TEST_CASE("an OBJ face becomes a fan, whichever way its corners are named") {
  for (const char* face : {"f 1 2 3 4", "f 1/7 2/8/9 3//1 4", "f -4 -3 -2 -1"}) {
    const auto soup = parse_obj_triangles(kSquare + face + "\n", "x.obj");
    INFO(soup.message());
    REQUIRE(soup.ok());
    REQUIRE(soup.value().triangles.size() == 2);
    CHECK(soup.value().triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
    CHECK(soup.value().triangles[1] == std::array<std::uint32_t, 3>{0, 2, 3});
  }
}

TEST_CASE("each mistake in an OBJ file has its line and what is accepted") {
  CHECK_THAT(wrong_obj(kSquare + "f 1 2 9\n"),
             Contains("x.obj:7: \"9\" is none of the 4 corners before it; accepted: f a b c"));
  CHECK_THAT(wrong_obj(kSquare + "f 1 2\n"), Contains("x.obj:7: a face with 2 corners"));
  CHECK_THAT(wrong_obj(kSquare + "f 1 2 x\n"), Contains("\"x\""));
  CHECK_THAT(wrong_obj(kSquare + "f 0 1 2\n"), Contains("\"0\""));
  CHECK_THAT(wrong_obj("v 1 2 nan\n"), Contains("x.obj:1"));
  CHECK_THAT(wrong_obj(kSquare), Contains("holds no triangles"));
  std::string many = kSquare;
  for (std::size_t i = 0; i <= kMaxMeshTriangles; ++i) many += "f 1 2 3\n";
  CHECK_THAT(wrong_obj(many), Contains("more than 20000 triangles; accepted: at most 20000"));
}

TEST_CASE("STL in text and in binary gives the triangles of the grid") {
  const TriangleSoup grid = flat_grid(3, 0.25, 1);
  std::string text = "solid grid\n";
  for (const auto& t : grid.triangles) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const std::uint32_t c : t)
      text += "vertex " + std::to_string(grid.corners[c].x) + " " + std::to_string(grid.corners[c].y) + " 0\n";
    text += "endloop\nendfacet\n";
  }
  for (const std::string& bytes : {text + "endsolid grid\n", binary_stl(grid)}) {
    const auto soup = parse_stl_triangles(bytes, "x.stl");
    INFO(soup.message());
    REQUIRE(soup.ok());
    CHECK(weld(soup.value()).corners.size() == 16);
    CHECK(built(soup.value()).mesh.triangles.size() == 18);
  }
  CHECK_FALSE(parse_stl_triangles("solid x\nvertex 0 0 0\nvertex 1 0 0\n", "x.stl").ok());
}

TEST_CASE("bytes that no program wrote are refused or make a mesh, and never more") {
  Random random(31);
  const TriangleSoup grid = flat_grid(3, 0.25, 1);
  const std::string binary = binary_stl(grid), obj = kSquare + "f 1 2 3\nf 1 3 4\n";
  const std::string letters = "vf /-+.0123456789ein\n\0x";
  int meshes = 0;
  for (int n = 0; n < 4000; ++n) {
    std::string bytes = n % 2 == 0 ? obj : binary;
    for (std::uint32_t i = 0, changes = 1 + random.below(6); i < changes; ++i) {
      const std::size_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
      if (random.below(4) == 0)
        bytes.resize(at);
      else
        bytes[at] = n % 2 == 0 ? letters[random.below(22)] : static_cast<char>(random.below(256));
      if (bytes.empty()) bytes = "v";
    }
    const auto soup = n % 2 == 0 ? parse_obj_triangles(bytes, "x.obj") : parse_stl_triangles(bytes, "x.stl");
    if (!soup.ok()) {
      CHECK_THAT(soup.message(), Contains("accepted"));
      CHECK(soup.message().find('\n') == std::string::npos);
      continue;
    }
    const auto made = build_mesh(weld(soup.value()), physics::kFirstPatchId);
    if (!made.ok()) continue;
    ++meshes;
    for (const auto& normal : made.value().mesh.normals) CHECK(norm(normal) == Approx(1.0));
  }
  CHECK(meshes > 200);
}
