// Corners of solids from files: each kind of file, and every mistake with its place.
#include "sim/geometry/shape_files.h"

#include <catch2/catch.hpp>
#include <cstring>

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;

namespace {

std::string binary_stl(const std::vector<std::array<float, 9>>& triangles, std::string header = "made here") {
  header.resize(80);
  std::string bytes = header;
  const auto count = static_cast<std::uint32_t>(triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& t : triangles) {
    const float normal[3] = {0, 0, 1};
    bytes.append(reinterpret_cast<const char*>(normal), 12);
    bytes.append(reinterpret_cast<const char*>(t.data()), 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace

TEST_CASE("An OBJ file gives the places of its vertices, each once, whatever else it holds") {
  const auto read =
      parse_obj("# a solid\no x\r\nv 1 2 3 1.0\nvn 0 0 1\nv +1.5e-1\t-2 0\n\nv 1 2 3\nf 1/2/3 2 3\n", "x.obj");
  REQUIRE(read.ok());
  REQUIRE(read.value() == std::vector<Vec3d>{{1, 2, 3}, {0.15, -2, 0}});
}

TEST_CASE("An STL file in text and one in binary give the corners of their triangles, each once") {
  const std::string text =
      "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  endloop\n"
      " endfacet\n facet normal 0 0 1\n outer loop\n vertex 1 0 0 vertex 0 1 0 vertex 1 1 0\n "
      "endloop\nendfacet\nendsolid";
  const std::vector<Vec3d> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const auto from_text = parse_stl(text, "x.stl");
  REQUIRE(from_text.ok());
  REQUIRE(from_text.value() == corners);
  for (const char* header : {"made here", "solid but binary"}) {
    const auto binary =
        parse_stl(binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 1, 0, 1, 1, 0}}, header), "x.stl");
    REQUIRE(binary.ok());
    REQUIRE(binary.value() == corners);
  }
}

TEST_CASE("Each mistake in a file is reported with its place") {
  const auto wrong = [](const Result<std::vector<Vec3d>>& result) {
    REQUIRE_FALSE(result.ok());
    return result.message();
  };
  CHECK_THAT(wrong(parse_obj("v 0 0 0\nv 1 nan 0\n", "x.obj")),
             Contains("x.obj:2: \"nan\" in y is not a finite number"));
  CHECK_THAT(wrong(parse_obj("v 0 0\n", "x.obj")), Contains("x.obj:1: nothing in z"));
  CHECK_THAT(wrong(parse_obj("v 0 0 1e999\n", "x.obj")), Contains("in z is not a finite"));
  CHECK_THAT(wrong(parse_obj("v 0 0 1,5\n", "x.obj")), Contains("\"1,5\" in z"));
  CHECK_THAT(wrong(parse_obj("f 1 2 3\n", "x.obj")), Contains("holds no corners"));
  CHECK_THAT(wrong(parse_stl("solid\nvertex 0 0 inf\n", "x.stl")), Contains("x.stl:2: \"inf\" in z"));
  CHECK_THAT(wrong(parse_stl("", "x.stl")), Contains("is no STL file"));
  CHECK_THAT(wrong(parse_stl(binary_stl({{0, 0, 0, 1, 0, 0, 0, 1, 0}}).substr(0, 120), "x.stl")),
             Contains("120 bytes, but its header announces 1 triangles, 134 bytes"));
  const float bad = std::numeric_limits<float>::infinity();
  CHECK_THAT(wrong(parse_stl(binary_stl({{0, 0, 0, 1, 0, bad, 0, 1, 0}}), "x.stl")),
             Contains("triangle 1 has a corner"));
  CHECK_THAT(wrong(read_shape_file("/nowhere/x.obj")), Contains("/nowhere/x.obj: there is no such file"));
  CHECK_THAT(wrong(read_shape_file("/nowhere/x.step")), Contains("accepted: a name that ends in .obj or .stl"));
}
