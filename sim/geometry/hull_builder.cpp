#include "sim/geometry/hull_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace tactus::sim {
namespace {

using physics::HullFault;
using physics::HullTopology;
using physics::kMaxHullVertices;

// Points closer to a face's plane than this fraction of the size lie on it: about the error of single precision.
constexpr double kFlatShare = 1e-6;
// Maximum number of hulls computed for one set of points: the hull of the points that remain after a merge may merge
// more of them.
constexpr int kMaxRounds = 8;

struct Surface {
  std::vector<std::size_t> vertices;            // indices of points, ascending
  std::vector<std::vector<std::size_t>> loops;  // per face: indices of points, counter-clockwise seen from outside
};

// Owns Qhull's state, and discards what Qhull prints.
class Qhull {
 public:
  Qhull() : silent_(std::fopen("/dev/null", "w")) { qh_zero(&state_, silent_); }
  ~Qhull() {
    qh_freeqhull(&state_, !qh_ALL);
    int blocks = 0, bytes = 0;
    qh_memfreeshort(&state_, &blocks, &bytes);
    if (silent_ != nullptr) (void)std::fclose(silent_);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  // 0, or Qhull's exit code.
  int run(std::vector<double>& coordinates, double tolerance) {
    std::string command = fmt::format("qhull Pp C-{:.17g}", tolerance);
    return qh_new_qhull(&state_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False, command.data(),
                        nullptr, silent_);
  }
  Surface surface() {
    Surface out;
    qhT* const qh = &state_;
    facetT* facet = nullptr;
    vertexT *vertex = nullptr, **vertexp = nullptr;
    FORALLfacets {
      std::vector<std::size_t> loop;
      setT* around = qh_facet3vertex(qh, facet);
      FOREACHvertex_(around) loop.push_back(static_cast<std::size_t>(qh_pointid(qh, vertex->point)));
      qh_settempfree(qh, &around);
      out.vertices.insert(out.vertices.end(), loop.begin(), loop.end());
      out.loops.push_back(std::move(loop));
    }
    std::sort(out.vertices.begin(), out.vertices.end());
    out.vertices.erase(std::unique(out.vertices.begin(), out.vertices.end()), out.vertices.end());
    return out;
  }

 private:
  std::FILE* silent_;
  qhT state_{};
};

struct Extent {
  double size{0}, farthest{0};  // m: the largest side of the box about the points; the largest coordinate
};

Extent extent_of(std::span<const Vec3d> points) {
  Extent extent;
  for (int i = 0; i < 3; ++i) {
    const auto [low, high] =
        std::minmax_element(points.begin(), points.end(), [i](const Vec3d& a, const Vec3d& b) { return a[i] < b[i]; });
    extent.size = std::max(extent.size, (*high)[i] - (*low)[i]);
    extent.farthest = std::max({extent.farthest, std::abs((*low)[i]), std::abs((*high)[i])});
  }
  return extent;
}

// Brings the loops into the topology's form: counter-clockwise seen from outside, starting at the lowest vertex,
// sorted. The orientation of Qhull's loops is determined with the centroid of the points.
void make_canonical(std::span<const Vec3d> points, Surface& surface) {
  Vec3d middle;
  for (const std::size_t i : surface.vertices)
    middle += points[i] * (1.0 / static_cast<double>(surface.vertices.size()));
  for (auto& loop : surface.loops) {
    Vec3d normal;
    for (std::size_t k = 1; k + 1 < loop.size(); ++k)
      normal += cross(points[loop[k]] - points[loop[0]], points[loop[k + 1]] - points[loop[0]]);
    if (!loop.empty() && dot(normal, points[loop[0]] - middle) < 0) std::reverse(loop.begin(), loop.end());
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  }
  std::sort(surface.loops.begin(), surface.loops.end());
}

Status flat(double width) {
  return Status::error(
      fmt::format("the points lie in a plane, or nearly: {:.3g} m thick; accepted: a solid at least {:g} m thick",
                  width, kMinHullWidth_m));
}

Result<Surface> find_surface(std::span<const Vec3d> points) {
  const Extent extent = extent_of(points);
  if (extent.size < kMinHullWidth_m) return flat(extent.size);
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Vec3d& p : points) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  const auto qhull = std::make_unique<Qhull>();
  const int exit_code = qhull->run(coordinates, std::max(kFlatShare * extent.size, 2.5e-7 * extent.farthest));
  if (exit_code == qh_ERRsingular || exit_code == qh_ERRinput) return flat(0);
  if (exit_code != 0)
    return Status::error(
        fmt::format("no hull can be made of the points (Qhull error {}); accepted: the corners of a solid", exit_code));
  Surface surface = qhull->surface();
  make_canonical(points, surface);
  return surface;
}

Result<BuiltHull> finish(std::vector<Vec3d> vertices, const Surface& surface) {
  HullTopology topology;
  topology.vertices = static_cast<std::uint32_t>(vertices.size());
  bool fits = true;
  for (const auto& loop : surface.loops) {
    std::vector<std::uint8_t> around(loop.begin(), loop.end());
    fits = fits && topology.add_face(around);
  }
  BuiltHull built;
  const HullFault fault =
      fits ? physics::make_hull(vertices, topology, built.hull, built.given_from_body) : HullFault::kNotClosed;
  if (fault == HullFault::kFlat) return flat(0);
  if (fault != HullFault::kNone)
    return Status::error(
        "the points are too close to each other to make a closed hull; accepted: points further apart");
  if (built.hull.least_width < kMinHullWidth_m) return flat(built.hull.least_width);
  built.vertices = std::move(vertices);
  return built;
}

}  // namespace

Result<BuiltHull> build_hull(std::span<const Vec3d> points) {
  if (points.size() < 4)
    return Status::error(fmt::format("{} points make no solid; accepted: 4 or more", points.size()));
  for (const Vec3d& p : points)
    if (!is_finite(p)) return Status::error("a point is not finite; accepted: finite numbers");
  std::vector<Vec3d> vertices(points.begin(), points.end());
  for (int round = 0; round < kMaxRounds; ++round) {
    auto found = find_surface(vertices);
    if (!found.ok()) return found.status();
    const Surface& surface = found.value();
    const std::size_t count = surface.vertices.size();
    if (count == vertices.size() && count <= kMaxHullVertices) return finish(std::move(vertices), surface);
    if (count > kMaxHullVertices && count == vertices.size()) break;
    std::vector<Vec3d> kept;
    for (const std::size_t i : surface.vertices) kept.push_back(vertices[i]);
    vertices = std::move(kept);
  }
  if (vertices.size() <= kMaxHullVertices)
    return Status::error("the points make no stable hull; accepted: points further apart, or fewer");
  return Status::error(
      fmt::format("the hull has {} vertices; accepted: at most {}: make the solid coarser in the program it "
                  "comes from, or build it from several bodies",
                  vertices.size(), kMaxHullVertices));
}

Result<TriangleSoup> hull_surface(std::span<const Vec3d> points) {
  if (points.size() < 4)
    return Status::error(fmt::format("{} points make no solid; accepted: 4 or more", points.size()));
  auto found = find_surface(points);
  if (!found.ok()) return found.status();
  const Surface& surface = found.value();
  TriangleSoup soup;
  for (const std::size_t i : surface.vertices) soup.corners.push_back(points[i]);
  const auto corner = [&](std::size_t point) {
    return static_cast<std::uint32_t>(std::lower_bound(surface.vertices.begin(), surface.vertices.end(), point) -
                                      surface.vertices.begin());
  };
  for (const auto& loop : surface.loops)
    for (std::size_t k = 1; k + 1 < loop.size(); ++k)
      soup.triangles.push_back({corner(loop[0]), corner(loop[k]), corner(loop[k + 1])});
  return soup;
}

}  // namespace tactus::sim
