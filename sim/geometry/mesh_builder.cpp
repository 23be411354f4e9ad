#include "sim/geometry/mesh_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace tactus::sim {
namespace {

using physics::EdgeKind;
using physics::kNoTriangle;
using physics::MeshTriangle;

// A triangle whose height over its longest edge is below this has no area: 1 nm, or a billionth of that edge.
constexpr double kMinHeight_m = 1e-9, kMinHeightShare = 1e-9;
// A fold of less than 1 mrad is flat: a body that slides over it at 0.1 m/s is lifted at 0.1 mm/s.
constexpr double kFlatSine = 1e-3;
// Max. distance of a patch from the plane of its largest triangle: the solver's slop, which is not corrected anyway.
constexpr double kPatchHeight_m = 1e-5, kPatchSine = 2e-3;
// All pairs of open edges are compared; in a mesh with more open edges none are joined.
constexpr std::size_t kMaxOpenEdges = 4000;

const Vec3d& place(const MeshParts& mesh, const MeshTriangle& t, std::size_t k) { return mesh.corners[t.corner[k]]; }

Vec3d area_vector(const MeshParts& mesh, const MeshTriangle& t) {
  return cross(place(mesh, t, 1) - place(mesh, t, 0), place(mesh, t, 2) - place(mesh, t, 0));
}

double longest_edge(const MeshParts& mesh, const MeshTriangle& t) {
  return std::max({norm(place(mesh, t, 1) - place(mesh, t, 0)), norm(place(mesh, t, 2) - place(mesh, t, 1)),
                   norm(place(mesh, t, 0) - place(mesh, t, 2))});
}

struct ByPlace {
  bool operator()(const Vec3d& a, const Vec3d& b) const {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  }
};

// Copies the triangles, without those of no area and duplicates.
void take_triangles(const TriangleSoup& soup, const Vec3d& middle, MeshParts& mesh, MeshAccount& account) {
  for (const Vec3d& corner : soup.corners) mesh.corners.push_back(corner - middle);
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> seen;  // beginning with the lowest corner
  for (const auto& given : soup.triangles) {
    MeshTriangle t;
    t.corner = given;
    const Vec3d area = area_vector(mesh, t);
    const double longest = longest_edge(mesh, t);
    if (!(norm(area) > std::max(kMinHeight_m, kMinHeightShare * longest) * longest)) {
      ++account.without_area;
      continue;
    }
    auto key = t.corner;
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    if (!seen.try_emplace(key, 0).second) {
      ++account.doubled;
      continue;
    }
    mesh.triangles.push_back(t);
    mesh.normals.push_back(area * (1 / norm(area)));
  }
}

// Sine of the angle between the normals, about the edge; positive: convex.
double fold_sine(const MeshParts& mesh, std::uint32_t s, std::uint32_t k, std::uint32_t t) {
  const MeshTriangle& triangle = mesh.triangles[s];
  const Vec3d along = mesh.corners[triangle.corner[(k + 1) % 3]] - mesh.corners[triangle.corner[k]];
  return dot(cross(mesh.normals[s], mesh.normals[t]), along) / norm(along);
}

EdgeKind judge(const MeshParts& mesh, std::uint32_t s, std::uint32_t k, std::uint32_t t) {
  const double sine = fold_sine(mesh, s, k, t);
  const bool onward = dot(mesh.normals[s], mesh.normals[t]) > 0;
  if (onward && std::abs(sine) <= kFlatSine) return EdgeKind::kFlat;
  return sine >= (onward ? 0 : -kFlatSine) ? EdgeKind::kConvex : EdgeKind::kConcave;
}

void join_neighbours(MeshParts& mesh, MeshAccount& account) {
  struct Half {
    std::uint32_t triangle, k;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<std::vector<Half>, 2>> edges;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    MeshTriangle& t = mesh.triangles[i];
    t.neighbour.fill(kNoTriangle);
    t.edge.fill(EdgeKind::kBoundary);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t.corner[k], to = t.corner[(k + 1) % 3];
      edges[std::minmax(from, to)][from < to ? 0 : 1].push_back({i, k});
    }
  }
  for (auto& [ends, halves] : edges) {
    auto& [there, back] = halves;
    const std::size_t alone = std::max(there.size(), back.size()) - std::min(there.size(), back.size());
    account.boundary_edges += static_cast<unsigned>(alone % 2);
    account.disagreeing_edges += static_cast<unsigned>(alone / 2);
    while (!there.empty() && !back.empty()) {  // one of each, except where several sheets meet
      std::size_t best_there = 0, best_back = 0;
      double flattest = -2;
      for (std::size_t i = 0; i < there.size(); ++i)
        for (std::size_t j = 0; j < back.size(); ++j) {
          const double cosine = dot(mesh.normals[there[i].triangle], mesh.normals[back[j].triangle]);
          if (cosine > flattest) {
            flattest = cosine;
            best_there = i;
            best_back = j;
          }
        }
      const Half s = there[best_there], t = back[best_back];
      mesh.triangles[s.triangle].neighbour[s.k] = t.triangle;
      mesh.triangles[t.triangle].neighbour[t.k] = s.triangle;
      mesh.triangles[s.triangle].edge[s.k] = mesh.triangles[t.triangle].edge[t.k] =
          judge(mesh, s.triangle, s.k, t.triangle);
      there.erase(there.begin() + static_cast<std::ptrdiff_t>(best_there));
      back.erase(back.begin() + static_cast<std::ptrdiff_t>(best_back));
    }
  }
}

// T-junctions: an open edge is closed if other open edges cover its whole length, flat and within the slop.
void join_along_edges(MeshParts& mesh, MeshAccount& account) {
  struct Open {
    std::uint32_t triangle, k;
    Vec3d from, along;
    double length, covered;
    std::uint32_t neighbour;
  };
  std::vector<Open> open;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const MeshTriangle& t = mesh.triangles[i];
      if (t.edge[k] != EdgeKind::kBoundary) continue;
      const Vec3d from = place(mesh, t, k), edge = place(mesh, t, (k + 1) % 3) - from;
      open.push_back({.triangle = i,
                      .k = k,
                      .from = from,
                      .along = edge * (1 / norm(edge)),
                      .length = norm(edge),
                      .covered = 0,
                      .neighbour = kNoTriangle});
    }
  if (open.size() > kMaxOpenEdges) return;
  for (Open& s : open)
    for (const Open& t : open) {
      if (dot(s.along, t.along) > 0 || dot(mesh.normals[s.triangle], mesh.normals[t.triangle]) <= 0) continue;
      const Vec3d to = t.from + t.along * t.length - s.from, from = t.from - s.from;  // t runs the other way
      const double begin = dot(s.along, to), end = dot(s.along, from);
      const double overlap = std::min(end, s.length) - std::max(begin, 0.0);
      if (!(overlap > kPatchHeight_m) || norm(to - s.along * begin) > kPatchHeight_m ||
          norm(from - s.along * end) > kPatchHeight_m || judge(mesh, s.triangle, s.k, t.triangle) != EdgeKind::kFlat)
        continue;
      s.covered += overlap;
      s.neighbour = std::min(s.neighbour, t.triangle);
    }
  for (const Open& s : open) {
    if (s.neighbour == kNoTriangle || !(s.covered > s.length - 2 * kPatchHeight_m)) continue;
    mesh.triangles[s.triangle].edge[s.k] = EdgeKind::kFlat;
    mesh.triangles[s.triangle].neighbour[s.k] = s.neighbour;
    if (account.boundary_edges > 0) --account.boundary_edges;
  }
}

// Gathers patches, from the largest triangle down: triangles connected by flat edges, near the first one's plane.
void gather_patches(MeshParts& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<std::uint32_t> seeds(count), waiting;
  std::iota(seeds.begin(), seeds.end(), 0u);
  std::vector<double> area(count);
  for (std::uint32_t i = 0; i < count; ++i) area[i] = norm(area_vector(mesh, mesh.triangles[i]));
  std::stable_sort(seeds.begin(), seeds.end(), [&](auto s, auto t) { return area[s] > area[t]; });
  constexpr std::uint32_t none = 0xffffffffu;
  for (MeshTriangle& t : mesh.triangles) t.patch = none;
  for (const std::uint32_t seed : seeds) {
    if (mesh.triangles[seed].patch != none) continue;
    const auto patch = static_cast<std::uint32_t>(mesh.patches.size());
    const Vec3d n = mesh.normals[seed];
    const double offset = dot(n, place(mesh, mesh.triangles[seed], 0));
    mesh.patches.push_back({n, offset});
    const auto belongs = [&](const MeshTriangle& t, std::uint32_t i) {
      bool near = dot(n, mesh.normals[i]) > 0 && norm(cross(n, mesh.normals[i])) <= kPatchSine;
      for (std::size_t k = 0; k < 3; ++k) near = near && std::abs(dot(n, place(mesh, t, k)) - offset) <= kPatchHeight_m;
      return near;
    };
    mesh.triangles[seed].patch = patch;
    waiting.assign(1, seed);
    while (!waiting.empty()) {
      const MeshTriangle t = mesh.triangles[waiting.back()];
      waiting.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        if (t.edge[k] != EdgeKind::kFlat) continue;
        MeshTriangle& next = mesh.triangles[t.neighbour[k]];
        if (next.patch != none || !belongs(next, t.neighbour[k])) continue;
        next.patch = patch;
        waiting.push_back(t.neighbour[k]);
      }
    }
  }
}

// Sorts the triangles by patch, patches in the order of their first triangles.
void sort_by_patch(MeshParts& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<std::uint32_t> place_of_patch(mesh.patches.size(), kNoTriangle), order(count), place(count);
  std::vector<physics::MeshPatch> patches;
  for (MeshTriangle& t : mesh.triangles) {
    std::uint32_t& at = place_of_patch[t.patch];
    if (at == kNoTriangle) {
      at = static_cast<std::uint32_t>(patches.size());
      patches.push_back(mesh.patches[t.patch]);
    }
    t.patch = at;
  }
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](auto s, auto t) { return mesh.triangles[s].patch < mesh.triangles[t].patch; });
  for (std::uint32_t i = 0; i < count; ++i) place[order[i]] = i;
  std::vector<MeshTriangle> triangles;
  std::vector<Vec3d> normals;
  for (const std::uint32_t i : order) {
    triangles.push_back(mesh.triangles[i]);
    normals.push_back(mesh.normals[i]);
    for (std::uint32_t& n : triangles.back().neighbour)
      if (n != kNoTriangle) n = place[n];
  }
  mesh.triangles = std::move(triangles);
  mesh.normals = std::move(normals);
  mesh.patches = std::move(patches);
}

// Lists the triangles around each corner, and marks triangles with a corner on a convex or boundary edge as exposed.
// Returns the largest number of triangles at one corner.
std::uint32_t find_corners(MeshParts& mesh) {
  mesh.around_start.assign(mesh.corners.size() + 1, 0);
  std::vector<bool> exposed(mesh.corners.size(), false);
  for (const MeshTriangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      ++mesh.around_start[t.corner[k] + 1];
      if (t.edge[k] == EdgeKind::kConvex || t.edge[k] == EdgeKind::kBoundary)
        exposed[t.corner[k]] = exposed[t.corner[(k + 1) % 3]] = true;
    }
  const std::uint32_t most = *std::max_element(mesh.around_start.begin(), mesh.around_start.end());
  std::partial_sum(mesh.around_start.begin(), mesh.around_start.end(), mesh.around_start.begin());
  mesh.around.resize(mesh.around_start.back());
  std::vector<std::uint32_t> next(mesh.around_start.begin(), mesh.around_start.end() - 1);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    MeshTriangle& t = mesh.triangles[i];
    for (const std::uint32_t c : t.corner) mesh.around[next[c]++] = i;
    t.exposed = exposed[t.corner[0]] || exposed[t.corner[1]] || exposed[t.corner[2]];
  }
  return most;
}

}  // namespace

TriangleSoup weld(const TriangleSoup& soup) {
  TriangleSoup welded;
  std::map<Vec3d, std::uint32_t, ByPlace> known;
  for (const auto& given : soup.triangles) {
    auto& triangle = welded.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d place = soup.corners[given[k]] + Vec3d{};  // adding 0 removes negative zeros
      const auto [at, is_new] = known.try_emplace(place, static_cast<std::uint32_t>(welded.corners.size()));
      if (is_new) welded.corners.push_back(place);
      triangle[k] = at->second;
    }
  }
  return welded;
}

Result<BuiltMesh> build_mesh(const TriangleSoup& soup, BodyId first_patch_id) {
  physics::Aabb box{soup.corners.front(), soup.corners.front()};
  for (const Vec3d& corner : soup.corners)
    for (int i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], corner[i]);
      box.upper[i] = std::max(box.upper[i], corner[i]);
    }
  BuiltMesh built;
  const auto parts = std::make_shared<MeshParts>();
  MeshParts& mesh = *parts;
  built.given_from_body.position = 0.5 * (box.lower + box.upper);
  take_triangles(soup, built.given_from_body.position, mesh, built.account);
  if (mesh.triangles.empty())
    return Status::error("holds no triangle with an area; accepted: one or more, at least 1 nm high");
  join_neighbours(mesh, built.account);
  join_along_edges(mesh, built.account);
  gather_patches(mesh);
  sort_by_patch(mesh);
  if (const std::uint32_t most = find_corners(mesh); most > physics::kMaxCornerTriangles)
    return Status::error(
        fmt::format("has a corner where {} triangles meet; accepted: at most {}", most, physics::kMaxCornerTriangles));
  for (const Vec3d& corner : mesh.corners)
    for (int i = 0; i < 3; ++i) mesh.half_extents[i] = std::max(mesh.half_extents[i], std::abs(corner[i]));
  mesh.first_patch_id = first_patch_id;
  build_tree(mesh);
  built.parts = parts;
  built.mesh = parts->view();
  built.account.corners = static_cast<unsigned>(mesh.corners.size());
  built.account.triangles = static_cast<unsigned>(mesh.triangles.size());
  built.account.patches = static_cast<unsigned>(mesh.patches.size());
  return built;
}

}  // namespace tactus::sim
