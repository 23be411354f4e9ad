// Meshes from loose triangles: what is merged and left out, who is whose neighbour, which edges are flat, the tree.
#include "tests/sim/geometry/mesh_support.h"

using namespace tactus;
using namespace tactus::sim;
using namespace tactus::sim::support;
using physics::EdgeKind;
using physics::Mesh;

namespace {

unsigned edges_of(const Mesh& mesh, EdgeKind kind) {
  unsigned count = 0;
  for (const auto& t : mesh.triangles) count += static_cast<unsigned>(std::count(t.edge.begin(), t.edge.end(), kind));
  return count;
}

void check_neighbours(const Mesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t n = mesh.triangles[i].neighbour[k];
      CHECK((n == physics::kNoTriangle) == (mesh.triangles[i].edge[k] == EdgeKind::kBoundary));
      if (n == physics::kNoTriangle) continue;
      const auto& back = mesh.triangles[n].neighbour;
      const auto at = std::find(back.begin(), back.end(), i);
      REQUIRE(at != back.end());
      CHECK(mesh.triangles[n].edge[static_cast<std::size_t>(at - back.begin())] == mesh.triangles[i].edge[k]);
    }
}

}  // namespace

TEST_CASE("a box of twelve triangles has six patches, twelve convex edges and six flat ones") {
  const BuiltMesh made = built(box_soup({0.1, 0.2, 0.3}));
  CHECK(made.mesh.patches.size() == 6);
  CHECK(edges_of(made.mesh, EdgeKind::kConvex) == 24);  // from both sides
  CHECK(edges_of(made.mesh, EdgeKind::kFlat) == 12);
  CHECK(made.account.boundary_edges == 0);
  CHECK(norm(made.mesh.half_extents - Vec3d{0.1, 0.2, 0.3}) < 1e-15);
  check_neighbours(made.mesh);
  for (const auto& t : made.mesh.triangles) CHECK(t.exposed);
}

TEST_CASE("a box inside out is a room: its edges are concave") {
  TriangleSoup soup = box_soup({0.1, 0.2, 0.3});
  for (auto& t : soup.triangles) std::swap(t[1], t[2]);
  const BuiltMesh made = built(soup);
  CHECK(edges_of(made.mesh, EdgeKind::kConcave) == 24);
  CHECK(edges_of(made.mesh, EdgeKind::kConvex) == 0);
  for (const auto& t : made.mesh.triangles) CHECK_FALSE(t.exposed);
}

TEST_CASE("a flat grid is one patch whose inner triangles can be touched at their faces only") {
  const BuiltMesh made = built(flat_grid(10, 0.05, 1));
  CHECK(made.mesh.triangles.size() == 200);
  CHECK(made.mesh.patches.size() == 1);
  CHECK(made.account.boundary_edges == 40);
  CHECK(edges_of(made.mesh, EdgeKind::kBoundary) == 40);
  unsigned inner = 0;
  for (const auto& t : made.mesh.triangles) inner += t.exposed ? 0 : 1;
  CHECK(inner >= 2 * 8 * 8 - 4 * 8);
  check_neighbours(made.mesh);
}

TEST_CASE("loose corners are welded, doubles and triangles without area left out and counted") {
  TriangleSoup soup = flat_grid(2, 0.1, 1);
  TriangleSoup loose;
  for (const auto& t : soup.triangles)
    for (const std::uint32_t c : t) loose.corners.push_back(soup.corners[c]);
  for (std::uint32_t i = 0; i < loose.corners.size(); i += 3) loose.triangles.push_back({i, i + 1, i + 2});
  loose.triangles.push_back({1, 2, 0});  // the first again
  loose.triangles.push_back({0, 0, 1});  // an edge
  const TriangleSoup welded = weld(loose);
  CHECK(welded.corners.size() == 9);
  const BuiltMesh made = built(loose);
  CHECK(made.mesh.triangles.size() == 8);
  CHECK(made.account.doubled == 1);
  CHECK(made.account.without_area == 1);
  CHECK(made.mesh.patches.size() == 1);
}

TEST_CASE("a sheet with two sides joins each side to itself") {
  TriangleSoup soup = flat_grid(4, 0.1, 1);
  const auto count = soup.triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    auto t = soup.triangles[i];
    std::swap(t[1], t[2]);
    soup.triangles.push_back(t);
  }
  const BuiltMesh made = built(soup);
  CHECK(made.mesh.patches.size() == 2);
  CHECK(edges_of(made.mesh, EdgeKind::kBoundary) == 0);
  CHECK(edges_of(made.mesh, EdgeKind::kConvex) == 32);  // the rim, a fold of half a turn
  check_neighbours(made.mesh);
}

TEST_CASE("triangles of opposite orientation are reported, and joined to none") {
  TriangleSoup soup = flat_grid(3, 0.1, 1);
  std::swap(soup.triangles[8][1], soup.triangles[8][2]);  // of the middle cell: three neighbours
  const BuiltMesh made = built(soup);
  CHECK(made.account.disagreeing_edges == 3);
  CHECK(made.account.boundary_edges == 12);
  CHECK(edges_of(made.mesh, EdgeKind::kBoundary) == 12 + 6);
  check_neighbours(made.mesh);
}

TEST_CASE("a fold counts as flat below a milliradian, and what bends away by more than the slop is another patch") {
  const auto folded = [](double angle) {
    TriangleSoup soup;
    const double z = -0.1 * std::sin(angle), x = 0.1 * std::cos(angle);
    soup.corners = {{-0.1, 0, 0}, {0, 0, 0}, {0, 0.1, 0}, {x, 0.05, z}};
    soup.triangles = {{0, 1, 2}, {1, 3, 2}};
    return built(soup);
  };
  CHECK(folded(0.9e-3).mesh.triangles[0].edge[1] == EdgeKind::kFlat);
  CHECK(folded(1.1e-3).mesh.triangles[0].edge[1] == EdgeKind::kConvex);
  CHECK(folded(-1.1e-3).mesh.triangles[0].edge[1] == EdgeKind::kConcave);
  CHECK(folded(0.9e-4).mesh.patches.size() == 1);  // 9 um deep
  CHECK(folded(1.2e-4).mesh.patches.size() == 2);  // 12 um
}

TEST_CASE("an open edge shorter than what counts as flat is open: a needle alone is a mesh") {
  TriangleSoup soup;
  soup.corners = {{0, 0, 0}, {15e-6, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  const BuiltMesh made = built(soup);
  CHECK(edges_of(made.mesh, EdgeKind::kBoundary) == 3);
  CHECK(made.account.boundary_edges == 3);
  check_neighbours(made.mesh);
}

TEST_CASE("the same triangles give the same mesh, and a corner with too many is refused") {
  CHECK(built(flat_grid(7, 0.1, 5)).parts->triangles == built(flat_grid(7, 0.1, 5)).parts->triangles);
  TriangleSoup fan;
  fan.corners.push_back({});
  const std::uint32_t blades = physics::kMaxCornerTriangles + 1;
  for (std::uint32_t i = 0; i <= blades; ++i)
    fan.corners.push_back({std::cos(6.0 * i / blades), std::sin(6.0 * i / blades), 0.0});
  for (std::uint32_t i = 1; i <= blades; ++i) fan.triangles.push_back({0, i, i + 1});
  const auto refused = build_mesh(weld(fan), physics::kFirstPatchId);
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(refused.message(), Catch::Matchers::Contains("accepted: at most 256"));
  fan.triangles.pop_back();
  CHECK(build_mesh(weld(fan), physics::kFirstPatchId).ok());
}

TEST_CASE("the tree finds what brute force finds, in boxes of any size") {
  Random random(21);
  TriangleSoup soup;
  for (int n = 0; n < 3000; ++n) {
    const Vec3d at = random.vector(1);
    const double size = random.log_uniform(1e-3, 0.2);
    for (int k = 0; k < 3; ++k) soup.corners.push_back(at + random.vector(size));
    const auto first = static_cast<std::uint32_t>(3 * n);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const BuiltMesh made = built(soup);
  const Mesh& mesh = made.mesh;
  int whole = 0, cut = 0;
  for (int n = 0; n < 4000; ++n) {
    const Vec3d at = random.vector(1.2), half = Vec3d{1, 1, 1} * random.log_uniform(1e-3, 0.6);
    const physics::Aabb box{at - half, at + half};
    std::vector<std::uint32_t> expected;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (mesh.box_of(t).overlaps(box)) expected.push_back(t);
    physics::TriangleList found;
    find_triangles(mesh, box, found);
    const std::vector<std::uint32_t> got(found.triangles.begin(), found.triangles.end());
    if (found.left_out == 0) {
      CHECK(got == expected);
      ++whole;
      continue;
    }
    ++cut;
    REQUIRE(got.size() <= physics::kMaxBodyTriangles);
    CHECK(std::is_sorted(got.begin(), got.end()));
    CHECK(std::includes(expected.begin(), expected.end(), got.begin(), got.end()));
    CHECK(got.size() + found.left_out >= expected.size());
  }
  CHECK(whole > 2000);
  CHECK(cut > 30);
}

TEST_CASE("where there are too many triangles the nearest stay") {
  const BuiltMesh made = built(flat_grid(40, 0.01, 3));
  const Mesh& mesh = made.mesh;
  const physics::Aabb box{{-0.15, -0.15, -0.01}, {0.15, 0.15, 0.01}};
  physics::TriangleList found;
  find_triangles(mesh, box, found);
  REQUIRE(found.left_out > 0);
  REQUIRE(found.triangles.size() == physics::kMaxBodyTriangles);
  // 256 triangles of half a square centimetre: a disc of 6.4 cm about the middle, and none beyond.
  for (const std::uint32_t t : found.triangles) {
    const auto b = mesh.box_of(t);
    const double dx = std::max({0.0, b.lower.x, -b.upper.x}), dy = std::max({0.0, b.lower.y, -b.upper.y});
    CHECK(std::sqrt(dx * dx + dy * dy) < 0.07);
  }
}
