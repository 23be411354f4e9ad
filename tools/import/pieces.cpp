#include "tools/import/pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "sim/geometry/hull_builder.h"
#include "sim/geometry/hull_gap.h"
#include "sim/random.h"
#if TACTUS_HAS_HACD
#include <HACD/hacdHACD.h>

#include <sstream>

#include "tools/import/limited_process.h"
#endif

namespace tactus::scene_import {
std::size_t open_edges(const sim::TriangleSoup& soup) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> seen;  // by lower and higher corner: forth minus back, and all
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (const auto& t : soup.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t from = t[static_cast<std::size_t>(k)], to = t[static_cast<std::size_t>((k + 1) % 3)];
      const std::pair key{std::min(from, to), std::max(from, to)};
      seen[key] += from < to ? 1 : -1;
      ++count[key];
    }
  }
  std::size_t open = 0;
  for (const auto& [edge, times] : count)
    if (seen[edge] != 0 || times % 2 != 0) ++open;
  return open;
}

Result<double> hull_gap(const sim::TriangleSoup& soup, const HullPoints& hull) {
  auto built = sim::build_hull(hull.points);
  if (!built.ok()) return built.status();
  const auto gap = sim::find_hull_gap(soup, built.value().hull, built.value().given_from_body);
  if (!gap.ok()) return gap.status();
  return gap.value().gap_m > sim::kSmallestGap_m ? gap.value().gap_m : 0.0;
}

#if TACTUS_HAS_HACD

namespace {

constexpr Limits kHacdLimits{.wall_s = 240, .cpu_s = 120};
constexpr std::size_t kFinestTriangles = 600;  // more triangles are not subdivided further

// Points spread over a surface, by area, and lifted off it to the outside; the same for the same surface.
std::vector<Vec3d> points_on(const sim::TriangleSoup& soup, double lift_m) {
  std::vector<double> upto;
  double area = 0;
  for (const auto& t : soup.triangles) {
    const Vec3d &a = soup.corners[t[0]], &b = soup.corners[t[1]], &c = soup.corners[t[2]];
    upto.push_back(area += 0.5 * norm(cross(b - a, c - a)));
  }
  std::vector<Vec3d> points;
  sim::Random random(1);
  for (int i = 0; i < kSurfacePoints; ++i) {
    const double sought = area * (i + 0.5) / kSurfacePoints;
    const auto at = std::min<std::size_t>(
        static_cast<std::size_t>(std::lower_bound(upto.begin(), upto.end(), sought) - upto.begin()),
        soup.triangles.size() - 1);
    const auto& t = soup.triangles[at];
    const double r = std::sqrt(random.uniform()), s = random.uniform();
    const Vec3d &a = soup.corners[t[0]], &b = soup.corners[t[1]], &c = soup.corners[t[2]];
    const Vec3d normal = normalized_or(cross(b - a, c - a), Vec3d{});
    points.push_back((1 - r) * a + r * (1 - s) * b + r * s * c + lift_m * normal);
  }
  return points;
}

bool is_within(const sim::TriangleSoup& convex, const Vec3d& p, double tolerance) {
  for (const auto& t : convex.triangles) {
    const Vec3d &a = convex.corners[t[0]], &b = convex.corners[t[1]], &c = convex.corners[t[2]];
    const Vec3d n = cross(b - a, c - a);
    const double size = norm(n);
    if (size > 0 && dot(n, p - a) / size > -tolerance) return false;
  }
  return true;
}

// How far the mesh and the union of the pieces are apart, on points of both surfaces.
double deviation_of(const sim::TriangleSoup& mesh, const std::vector<sim::TriangleSoup>& pieces) {
  double most = 0;
  for (const Vec3d& p : points_on(mesh, 0)) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& piece : pieces) least = std::min(least, distance_to(p, piece));
    most = std::max(most, least);
  }
  const double tolerance = 1e-6 * extent_of(mesh.corners);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    // Points are lifted off the surface, so that where two pieces meet face to face a point of one is inside the other.
    const auto points = points_on(pieces[i], 10 * tolerance);
    for (std::size_t k = 0; k < points.size(); k += pieces.size()) {  // kSurfacePoints of all pieces
      bool covered = false;  // inside of another piece: no part of the union's surface
      for (std::size_t other = 0; other < pieces.size() && !covered; ++other)
        covered = other != i && is_within(pieces[other], points[k], tolerance);
      if (!covered) most = std::max(most, distance_to(points[k], mesh));
    }
  }
  return most;
}

// The corners of each cluster's hull: how many, then their coordinates. `share`: largest concavity of a cluster, as a
// share of the mesh's size.
std::string clusters_of(const sim::TriangleSoup& soup, double share) {
  std::vector<HACD::Vec3<HACD::Real>> points;
  std::vector<HACD::Vec3<long>> triangles;
  for (const Vec3d& c : soup.corners) points.emplace_back(c.x, c.y, c.z);
  for (const auto& t : soup.triangles)
    triangles.emplace_back(static_cast<long>(t[0]), static_cast<long>(t[1]), static_cast<long>(t[2]));
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(1e-4);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(1);
  hacd.SetNVerticesPerCH(physics::kMaxHullVertices);
  hacd.SetConcavity(1000 * share);  // it scales the mesh to a size of 1000
  // Without these points HACD misses a concavity between few large triangles: an L of 20 triangles stays one piece.
  hacd.SetAddExtraDistPoints(true);
  hacd.SetAddNeighboursDistPoints(true);
  hacd.SetAddFacesPoints(true);
  if (!hacd.Compute()) return {};
  hacd.DenormalizeData();
  std::string text;
  for (std::size_t i = 0; i < hacd.GetNClusters(); ++i) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(i));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(i));
    hacd.GetCH(i, corners.data(), faces.data());
    text += fmt::format("{}\n", corners.size());
    for (const auto& c : corners) text += fmt::format("{} {} {}\n", c.X(), c.Y(), c.Z());
  }
  return text;
}

std::vector<std::vector<Vec3d>> read_clusters(const std::string& text) {
  std::vector<std::vector<Vec3d>> clusters;
  std::istringstream in(text);
  for (std::size_t count = 0; in >> count;) {
    clusters.emplace_back();
    for (Vec3d v; clusters.back().size() < count && in >> v.x >> v.y >> v.z;) clusters.back().push_back(v);
  }
  return clusters;
}

}  // namespace

namespace {

// Divides each triangle into four. HACD clusters triangles, and finer triangles give other clusters.
sim::TriangleSoup finer(const sim::TriangleSoup& soup) {
  sim::TriangleSoup out{soup.corners, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] =
        middles.emplace(std::pair{std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(out.corners.size()));
    if (is_new) out.corners.push_back(0.5 * (out.corners[a] + out.corners[b]));
    return at->second;
  };
  for (const auto& [a, b, c] : soup.triangles) {
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    out.triangles.insert(out.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return out;
}

// One run of HACD on `divided`, which has the surface of `mesh`. `share`: largest concavity of a piece, as a share of
// the mesh's size.
Result<Pieces> divide(const sim::TriangleSoup& mesh, const sim::TriangleSoup& divided, unsigned most, double share) {
  const auto text = run_apart([&] { return clusters_of(divided, share); }, kHacdLimits);
  if (!text.ok()) return Status::error("HACD: the mesh " + text.message());
  const std::vector<std::vector<Vec3d>> clusters = read_clusters(text.value());
  Pieces pieces;
  std::vector<sim::TriangleSoup> surfaces;
  for (const std::vector<Vec3d>& given : clusters) {
    auto hull = hull_of(given);
    if (!hull.ok()) continue;  // flat: it has no volume
    auto surface = surface_of(hull.value().points);
    if (!surface.ok()) continue;
    pieces.hulls.push_back(std::move(hull).value());
    surfaces.push_back(std::move(surface).value());
  }
  if (pieces.hulls.empty()) return Status::error("HACD divides it into nothing that is solid");
  if (pieces.hulls.size() > most)
    return Status::error(fmt::format("takes {} pieces, more than {}", pieces.hulls.size(), most));
  pieces.deviation_m = deviation_of(mesh, surfaces);
  return pieces;
}

}  // namespace

Result<Pieces> decompose(const sim::TriangleSoup& soup, unsigned most, double deviation_m) {
  if (soup.triangles.size() > kMaxPieceTriangles)
    return Status::error(
        fmt::format("{} triangles are too many to divide, at most {}", soup.triangles.size(), kMaxPieceTriangles));
  std::string problem;
  double best = std::numeric_limits<double>::infinity();
  std::size_t best_count = 0;
  // HACD's result depends strongly on the triangles and on the limit: tries several and takes the first that is near
  // enough. Its time grows faster than the square of the number of triangles.
  sim::TriangleSoup divided = soup;
  do {
    for (const double part : {1.0, 0.3, 3.0, 0.1}) {
      auto pieces = divide(soup, divided, most, part * deviation_m / extent_of(soup.corners));
      if (!pieces.ok()) {
        problem = pieces.message();
        continue;
      }
      if (pieces.value().deviation_m <= deviation_m) return pieces;
      if (pieces.value().deviation_m >= best) continue;
      best = pieces.value().deviation_m;
      best_count = pieces.value().hulls.size();
    }
    divided = finer(divided);
  } while (divided.triangles.size() <= kFinestTriangles);
  if (best_count == 0) return Status::error(problem);
  return Status::error(fmt::format("its {} pieces are {:.3g} mm from its surface, more than {:.3g} mm", best_count,
                                   1e3 * best, 1e3 * deviation_m));
}

#else

Result<Pieces> decompose(const sim::TriangleSoup&, unsigned, double) {
  return Status::error("this build cannot divide meshes: Bullet's HACD was missing (Debian: libbullet-extras-dev)");
}

#endif

}  // namespace tactus::scene_import
