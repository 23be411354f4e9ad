// The kernel of a hull, or a box, against a patch of a mesh, in the mesh's frame.
//
// The contact with the patch's face is the hull's lowest face, clipped to each triangle. At a triangle on the patch's
// rim, the separating axes of triangle and hull first decide what makes the contact: the face, the rim (then the
// triangle is clipped to the hull's face, or two edges cross), or a neighbour.
#include <bit>
#include <limits>

#include "rt/physics/collision/box_triangle.h"
#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/collision/hull_clip.h"
#include "rt/physics/collision/hull_pair.h"
#include "rt/physics/shapes/mesh_region.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// A triangle as a hull without thickness: two faces, the second facing inward.
constexpr HullTopology make_triangle_topology() noexcept {
  HullTopology t;
  t.vertices = 3;
  constexpr std::uint8_t loops[2][3] = {{0, 1, 2}, {0, 2, 1}};
  for (const auto& loop : loops) (void)t.add_face(loop);
  (void)t.close();
  return t;
}
constexpr HullTopology kTriangleTopology = make_triangle_topology();
static_assert(kTriangleTopology.edges == 3 && kTriangleTopology.edge[1].from == 1);

struct RimTriangle {
  Vec3d middle;                  // in the mesh's frame
  std::array<Vec3d, 3> corner;   // axes of the mesh, from the middle
  std::array<Vec3d, 3> in_hull;  // the corners in the frame of the other hull
};

// A triangle as a hull. Frame: axes of the mesh, origin at the triangle's middle.
struct TriangleHull {
  static constexpr int kPadded = kLanes<Register<double>>;
  alignas(32) double x[kPadded], y[kPadded], z[kPadded];
  alignas(32) double nx[kPadded], ny[kPadded], nz[kPadded], offsets[kPadded];  // of two faces
  double edge_secant[3];

  TriangleHull(const RimTriangle& triangle, const Vec3d& normal) noexcept {
    for (std::uint32_t i = 0; i < kPadded; ++i) {
      const Vec3d& p = triangle.corner[i < 3 ? i : 0];
      x[i] = p.x;
      y[i] = p.y;
      z[i] = p.z;
    }
    const auto& c = triangle.corner;
    for (int f = 0; f < kPadded; ++f) {
      const Vec3d n = f == 1 ? -normal : normal;
      nx[f] = n.x;
      ny[f] = n.y;
      nz[f] = n.z;
      offsets[f] = larger(larger(dot(n, c[0]), dot(n, c[1])), dot(n, c[2]));
    }
    for (double& secant : edge_secant) secant = std::numeric_limits<double>::infinity();
  }
  HullView view() const noexcept {
    return {.topology = &kTriangleTopology,
            .x = x,
            .y = y,
            .z = z,
            .nx = nx,
            .ny = ny,
            .nz = nz,
            .offsets = offsets,
            .padded = kPadded,
            .padded_faces = kPadded,
            .edge_secant = edge_secant,
            .largest_secant = edge_secant[0],
            .inner_radius = 0.0,
            .flatness = 0.0};
  }
};

// Adds a point to a list, once per feature, with the lesser separation of both.
void keep_point(HullPolygon& kept, const HullClipPoint& point) noexcept {
  for (std::uint32_t i = 0; i < kept.count; ++i) {
    if (kept.points[i].id != point.id) continue;
    kept.points[i].w = smaller(kept.points[i].w, point.w);
    return;
  }
  if (kept.count == kMaxHullClipPoints) reduce_to_four(kept);
  kept.points[kept.count++] = point;
}

double lowest_of(const HullPolygon& polygon) noexcept {
  double lowest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < polygon.count; ++i) lowest = smaller(lowest, polygon.points[i].w);
  return lowest;
}

// The labels that make up the id of a crossing (hull_clip.h).
struct Crossing {
  std::uint32_t line, side;
  explicit Crossing(std::uint32_t id) noexcept
      : line((id - kFirstHullCrossing) / 256), side((id - kFirstHullCrossing) % 256) {}
  bool of_two_sides() const noexcept { return line >= kFirstHullSide; }
  std::uint32_t first_side() const noexcept { return line - kFirstHullSide; }
};

// The corner of a triangle between two of its sides, given in any order.
constexpr std::uint32_t corner_between(std::uint32_t j, std::uint32_t k) noexcept { return k == (j + 1) % 3 ? k : j; }

class HullOnPatch {
 public:
  HullOnPatch(const PatchView& patch, const HullView& hull) noexcept
      : patch_(patch), hull_(hull), plane_(patch.mesh.patches[patch.mesh.triangles[patch.triangles[0]].patch]) {
    const Axes axes = axes_of(conjugate(patch.pair.world_from_b) * patch.pair.world_from_a);
    column_[0] = axes.x;
    column_[1] = axes.y;
    column_[2] = axes.z;
  }

  // Returns false if no triangle of the patch can be touched.
  bool is_near() const noexcept {
    const double height = dot(plane_.normal, patch_.centre) - plane_.offset;
    const Vec3d down = -to_hull(plane_.normal);
    return height > 0.0 && height - hull_.support_along(down) <= patch_.pair.margin;
  }

  void look_at(std::uint32_t triangle) noexcept {
    const Ruling ruling = patch_.mesh.triangles[triangle].exposed ? judge_rim(triangle) : Ruling::kFace;
    if (ruling == Ruling::kAllowed) return;
    if (incident_.count == 0) find_incident_face(-to_hull(plane_.normal));
    add_face_points(triangle, ruling == Ruling::kDropped);
  }

  void finish(Manifold& manifold) noexcept {
    const bool by_rim = rim_kind_ != Rim::kNone && rim_lowest_ + kFlatTolerance < lowest_of(face_points_);
    if (!by_rim) return add_points(manifold, face_points_, plane_.normal, plane_.offset, along_);
    if (rim_kind_ == Rim::kHullFace) {
      const Vec3d n = to_mesh(hull_.normal(rim_face_));
      const double offset = hull_.offsets[rim_face_] + dot(n, patch_.centre);
      const Tangents<double> in_hull = tangents_of(hull_.normal(rim_face_));
      // rim_points_ are relative to the hull's origin; moves them to the mesh's.
      for (std::uint32_t i = 0; i < rim_points_.count; ++i) {
        rim_points_.points[i].u += dot(to_mesh(in_hull.t1), patch_.centre);
        rim_points_.points[i].v += dot(to_mesh(in_hull.t2), patch_.centre);
      }
      add_points(manifold, rim_points_, n, offset, {to_mesh(in_hull.t1), to_mesh(in_hull.t2)});
      manifold.normal = -manifold.normal;
      return;
    }
    patch_.set_normal(manifold, rim_normal_);
    patch_.add(manifold, rim_point_, rim_lowest_, rim_feature_);
  }

 private:
  enum class Rim { kNone, kHullFace, kEdges };
  // Cosine of 8 degrees: below that angle the hull's face counts as parallel to the patch.
  static constexpr double kParallelCosine = 0.99;

  Vec3d to_mesh(const Vec3d& v) const noexcept { return column_[0] * v.x + column_[1] * v.y + column_[2] * v.z; }
  Vec3d to_hull(const Vec3d& v) const noexcept { return {dot(column_[0], v), dot(column_[1], v), dot(column_[2], v)}; }

  // Adds the polygon's points above the plane n . x = offset with the axes `along`; each contact point is midway to the
  // plane.
  void add_points(Manifold& manifold, HullPolygon& polygon, const Vec3d& n, double offset,
                  const Tangents<double>& along) const noexcept {
    if (polygon.count == 0) return;
    mark_kept(patch_.pair, 0, polygon);  // here the id is the whole feature
    reduce_to_four(polygon);
    patch_.set_normal(manifold, n);
    for (std::uint32_t i = 0; i < polygon.count; ++i) {
      const HullClipPoint& p = polygon.points[i];
      patch_.add(manifold, n * (offset + 0.5 * p.w) + along.t1 * p.u + along.t2 * p.v, p.w, p.id);
    }
  }

  // Finds the hull's face that points down most, as a polygon above the patch's plane.
  void find_incident_face(const Vec3d& down) noexcept {
    const HullTopology& topology = *hull_.topology;
    along_ = tangents_of(plane_.normal);
    const std::uint32_t incident = hull_.face_along(down);
    incident_cosine_ = dot(hull_.normal(incident), down);
    for (std::uint32_t k = topology.loop_start[incident]; k < topology.loop_start[incident + 1]; ++k) {
      const std::uint32_t vertex = topology.loop_vertices[k];
      const Vec3d p = patch_.centre + to_mesh(hull_.vertex(vertex));
      incident_.points[incident_.count++] = {.u = dot(along_.t1, p),
                                             .v = dot(along_.t2, p),
                                             .w = dot(plane_.normal, p) - plane_.offset,
                                             .id = vertex,
                                             .line = topology.loop_edges[k],
                                             .kept = false};
    }
  }

  // Adds the part of the hull's face above the triangle. `others`: a neighbour makes the contact here. Then only points
  // with a positive gap are added, which may come into contact with the face later: vertices of the hull, and if the
  // two faces are parallel, the other points, too. On a tilted face the points at the rim would have the wrong normal.
  void add_face_points(std::uint32_t triangle, bool others) noexcept {
    const Mesh& mesh = patch_.mesh;
    const MeshTriangle& t = mesh.triangles[triangle];
    HullPolygon polygon;
    polygon.count = incident_.count;
    std::copy_n(incident_.points.begin(), incident_.count, polygon.points.begin());
    for (std::uint32_t k = 0; k < 3 && polygon.count > 0; ++k) {
      const Vec3d& from = mesh.corners[t.corner[k]];
      const Vec3d along = mesh.corners[t.corner[(k + 1) % 3]] - from;
      clip_to_edge(polygon, from, along, k);
    }
    for (std::uint32_t i = 0; i < polygon.count; ++i) {
      HullClipPoint p = polygon.points[i];
      if (!(p.w <= patch_.pair.margin)) continue;
      if (others && !(p.w > 0.0 && (p.id < kFirstHullCrossing || incident_cosine_ > kParallelCosine))) continue;
      if (name_face_point(triangle, p)) keep_point(face_points_, p);
    }
  }

  void clip_to_edge(HullPolygon& polygon, const Vec3d& from, const Vec3d& along, std::uint32_t k) const noexcept {
    const double du = dot(along_.t1, along), dv = dot(along_.t2, along);
    const double inverse = 1.0 / std::sqrt(du * du + dv * dv);
    const double nu = dv * inverse, nv = -du * inverse;
    clip_to_side(polygon, nu, nv, nu * dot(along_.t1, from) + nv * dot(along_.t2, from), k);
  }

  // Sets the point's feature. Returns false on a seam inside the patch, where the surface continues.
  bool name_face_point(std::uint32_t triangle, HullClipPoint& p) const noexcept {
    if (p.id < kFirstHullCrossing) return true;  // a vertex of the hull
    const MeshTriangle& t = patch_.mesh.triangles[triangle];
    const Crossing crossing(p.id);
    if (crossing.of_two_sides()) {
      if (patch_.mesh.is_inner_edge(t, crossing.side) && patch_.mesh.is_inner_edge(t, crossing.first_side()))
        return false;
      p.id = kMeshCornerFeature | t.corner[corner_between(crossing.first_side(), crossing.side)];
      return true;
    }
    p.id = kCrossingFeature | crossing.line << 21 | (3 * triangle + crossing.side);
    return !patch_.mesh.is_inner_edge(t, crossing.side);
  }

  // The separating axes of a triangle and the hull.
  struct RimAxes {
    bool apart{true};     // one of them separates by more than the margin; then the others are not known
    double by_face{};     // m: separation along the triangle's normal
    BoxFace hull_face{};  // of the hull
    EdgeAxis edges;       // if better than the faces; in the mesh's frame
  };

  RimTriangle place(std::uint32_t triangle) const noexcept {
    const MeshTriangle& t = patch_.mesh.triangles[triangle];
    RimTriangle out;
    out.middle = (patch_.mesh.place(t, 0) + patch_.mesh.place(t, 1) + patch_.mesh.place(t, 2)) * (1.0 / 3.0);
    for (std::uint32_t i = 0; i < 3; ++i) {
      const Vec3d& p = patch_.mesh.corners[t.corner[i]];
      out.corner[i] = p - out.middle;
      out.in_hull[i] = to_hull(p - patch_.centre);
    }
    return out;
  }

  RimAxes box_axes(const RimTriangle& at, const Vec3d& normal) const noexcept {
    const double margin = patch_.pair.margin;
    const BoxTriangle pair{
        {hull_.offsets[1], hull_.offsets[3], hull_.offsets[5]}, at.in_hull, to_hull(at.middle - patch_.centre)};
    RimAxes axes;
    const Vec3d n = to_hull(normal);
    axes.by_face =
        -larger(larger(dot(n, at.in_hull[0]), dot(n, at.in_hull[1])), dot(n, at.in_hull[2])) - dot(pair.half, abs(n));
    if (!(axes.by_face <= margin)) return axes;
    axes.hull_face = best_box_face(pair);
    if (!(axes.hull_face.separation <= margin)) return axes;
    axes.edges = best_box_edges(pair, larger(axes.by_face, axes.hull_face.separation));
    axes.edges.normal = to_mesh(axes.edges.normal);
    axes.apart = axes.edges.separation > margin;
    return axes;
  }

  RimAxes hull_axes(const RimTriangle& at, const Vec3d& normal) const noexcept {
    const double margin = patch_.pair.margin;
    const TriangleHull shape(at, normal);
    const RelativeHulls ab{.ref = shape.view(),
                           .other = hull_,
                           .column = {column_[0], column_[1], column_[2]},
                           .centre = patch_.centre - at.middle};
    RimAxes axes;
    FaceSearch of_hull, of_triangle;
    hold_face(ab, 0, margin, of_triangle);
    ab.ref.heights(ab.centre, of_triangle.centre);
    axes.by_face = of_triangle.separation;
    if (!(axes.by_face <= margin)) return axes;
    find_best_face(ab.reversed(), margin, -std::numeric_limits<double>::infinity(), kMaxHullFaces, of_hull);
    axes.hull_face = {of_hull.face, of_hull.separation};
    if (!(of_hull.separation <= margin)) return axes;
    axes.edges = best_edges(ab, margin, larger(axes.by_face, of_hull.separation), of_triangle, of_hull);
    axes.apart = axes.edges.separation > margin;
    return axes;
  }

  // For a triangle at a rim: kFace if its face makes the contact, kDropped if a neighbour does. kAllowed: its rim does,
  // whose contact has been noted, or nothing, because it is too far.
  Ruling judge_rim(std::uint32_t triangle) noexcept {
    const RimTriangle at = place(triangle);
    const Vec3d& normal = patch_.mesh.normals[triangle];
    const RimAxes axes = hull_.topology == &kBoxTopology ? box_axes(at, normal) : hull_axes(at, normal);
    if (axes.apart) return Ruling::kAllowed;
    const auto& [face, by_hull_face] = axes.hull_face;
    const auto preferred = [](double separation) noexcept { return separation + axis_preference(separation); };
    if (axes.edges.found && axes.edges.separation > preferred(larger(axes.by_face, by_hull_face))) {
      const Ruling ruling = rule_edge_axis(patch_.mesh, triangle, axes.edges.edge, axes.edges.normal);
      if (ruling == Ruling::kAllowed) note_edges(triangle, at, axes.edges);
      return ruling;
    }
    const bool by_hull = by_hull_face > preferred(axes.by_face), flush = by_hull_face > -kFlush;
    if (!by_hull && !flush) return Ruling::kFace;
    const HullPolygon below = clip_below(at, face);
    const Vec3d up = -to_mesh(hull_.normal(face));
    Ruling ruling = rule_lowest(triangle, at, below, up);
    if (flush && ruling != Ruling::kAllowed) ruling = rule_support(triangle, at, up);  // the part the hull passes over
    if (ruling == Ruling::kAllowed) note_hull_face(triangle, below, face);
    if (by_hull) return ruling;
    return ruling == Ruling::kFace ? Ruling::kFace : Ruling::kAllowed;  // a neighbour's rim: no point for this face
  }

  // Rules on the part of the triangle that is highest along u: a corner, an edge or the whole triangle.
  Ruling rule_support(std::uint32_t triangle, const RimTriangle& at, const Vec3d& u) const noexcept {
    const double height[3] = {dot(u, at.corner[0]), dot(u, at.corner[1]), dot(u, at.corner[2])};
    std::uint32_t top = 0;
    for (std::uint32_t i = 1; i < 3; ++i)
      if (height[i] > height[top]) top = i;
    const std::uint32_t next = (top + 1) % 3, before = (top + 2) % 3;
    const bool with_next = height[next] > height[top] - kFlatTolerance,
               with_before = height[before] > height[top] - kFlatTolerance;
    if (with_next && with_before) return Ruling::kFace;
    if (with_next) return rule_edge_axis(patch_.mesh, triangle, top, u);
    if (with_before) return rule_edge_axis(patch_.mesh, triangle, before, u);
    return rule_corner_axis(patch_.mesh, triangle, patch_.mesh.triangles[triangle].corner[top], u);
  }

  // The part of the triangle below the hull's face, in the hull's frame; w: the gap between them.
  HullPolygon clip_below(const RimTriangle& at, std::uint32_t face) const noexcept {
    const HullTopology& sides = *hull_.topology;
    const Vec3d n = hull_.normal(face);
    const Tangents<double> along = tangents_of(n);
    HullPolygon polygon;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const Vec3d& p = at.in_hull[i];
      polygon.points[polygon.count++] = {.u = dot(along.t1, p),
                                         .v = dot(along.t2, p),
                                         .w = dot(n, p) - hull_.offsets[face],
                                         .id = i,
                                         .line = i,
                                         .kept = false};
    }
    const std::uint32_t start = sides.loop_start[face], end = sides.loop_start[face + 1];
    for (std::uint32_t k = start; k < end && polygon.count > 0; ++k) {
      const Vec3d from = hull_.vertex(sides.loop_vertices[k]),
                  to = hull_.vertex(sides.loop_vertices[k + 1 == end ? start : k + 1]);
      const double du = dot(along.t1, to - from), dv = dot(along.t2, to - from);
      const double inverse = 1.0 / std::sqrt(du * du + dv * dv);
      const double nu = dv * inverse, nv = -du * inverse;
      clip_to_side(polygon, nu, nv, nu * dot(along.t1, from) + nv * dot(along.t2, from), sides.loop_edges[k]);
    }
    return polygon;
  }

  // Rules on what carries the hull's face: the lowest points of `below` are a corner, on an edge, or in the triangle.
  // The triangle's own highest corner may be far from the hull.
  Ruling rule_lowest(std::uint32_t triangle, const RimTriangle& at, const HullPolygon& below,
                     const Vec3d& u) const noexcept {
    if (below.count == 0) return rule_support(triangle, at, u);
    const double level = lowest_of(below) + kFlatTolerance;
    std::uint32_t common = 7, corner = 0;  // common: bit k if all of the lowest are on edge k
    for (std::uint32_t i = 0; i < below.count; ++i) {
      if (!(below.points[i].w <= level)) continue;
      const std::uint32_t id = below.points[i].id;
      if (id < kFirstHullCrossing) {
        corner = id;
        common &= 1u << id | 1u << (id + 2) % 3;
      } else {
        const Crossing crossing(id);
        common &= crossing.of_two_sides() ? 0u : 1u << crossing.line;
      }
    }
    if (common == 0) return Ruling::kFace;
    if ((common & (common - 1)) != 0)  // on two edges: a corner
      return rule_corner_axis(patch_.mesh, triangle, patch_.mesh.triangles[triangle].corner[corner], u);
    return rule_edge_axis(patch_.mesh, triangle, static_cast<std::uint32_t>(std::countr_zero(common)), u);
  }

  // Notes the part of the triangle below the hull's face; the points of triangles under the same face are collected.
  void note_hull_face(std::uint32_t triangle, const HullPolygon& polygon, std::uint32_t face) noexcept {
    const double lowest = lowest_of(polygon);
    if (!(lowest <= patch_.pair.margin)) return;
    const bool same = rim_kind_ == Rim::kHullFace && rim_face_ == face;
    if (!same && rim_kind_ != Rim::kNone && !(lowest < rim_lowest_)) return;
    if (!same) {
      rim_kind_ = Rim::kHullFace;
      rim_face_ = face;
      rim_points_.count = 0;
      rim_lowest_ = lowest;
    }
    rim_lowest_ = smaller(rim_lowest_, lowest);
    for (std::uint32_t i = 0; i < polygon.count; ++i) {
      HullClipPoint p = polygon.points[i];
      if (!(p.w <= patch_.pair.margin)) continue;
      name_rim_point(triangle, p);
      keep_point(rim_points_, p);
    }
  }

  void name_rim_point(std::uint32_t triangle, HullClipPoint& p) const noexcept {
    if (p.id < kFirstHullCrossing) {
      p.id = kMeshCornerFeature | patch_.mesh.triangles[triangle].corner[p.id];
      return;
    }
    const Crossing crossing(p.id);
    p.id = crossing.of_two_sides() ? kBodyFeature | 1u << 16 | crossing.first_side() << 8 | crossing.side
                                   : kMeshEdgeFeature | crossing.side << 21 | (3 * triangle + crossing.line);
  }

  void note_edges(std::uint32_t triangle, const RimTriangle& at, const EdgeAxis& axis) noexcept {
    if (rim_kind_ != Rim::kNone && !(axis.separation < rim_lowest_)) return;
    const HullEdge& b = hull_.topology->edge[axis.other_edge];
    const Vec3d &a0 = at.corner[axis.edge], &a1 = at.corner[(axis.edge + 1) % 3];
    const Vec3d offset = patch_.centre - at.middle;
    const Vec3d b0 = offset + to_mesh(hull_.vertex(b.from)), b1 = offset + to_mesh(hull_.vertex(b.to));
    const Vec3d half_a = 0.5 * (a1 - a0), half_b = 0.5 * (b1 - b0);
    const Vec3d middle_a = 0.5 * (a0 + a1), middle_b = 0.5 * (b0 + b1);
    const auto [s, t] = closest_on_segments(half_a, half_b, middle_b - middle_a);
    rim_kind_ = Rim::kEdges;
    rim_lowest_ = axis.separation;
    rim_normal_ = axis.normal;
    rim_point_ = at.middle + 0.5 * (middle_a + half_a * s + middle_b + half_b * t);
    rim_feature_ = kEdgePairFeature | axis.other_edge << 18 | (3 * triangle + axis.edge);
  }

  const PatchView& patch_;
  const HullView hull_;
  const MeshPatch& plane_;
  Tangents<double> along_;  // of the patch's plane, with incident_
  Vec3d column_[3];         // the hull's axes in the mesh's frame
  HullPolygon incident_, face_points_;
  double incident_cosine_{};  // of the angle between the hull's face and the patch

  Rim rim_kind_{Rim::kNone};
  double rim_lowest_{};
  std::uint32_t rim_face_{0};  // of the hull
  HullPolygon rim_points_;     // in the hull's frame
  Vec3d rim_normal_, rim_point_;
  std::uint32_t rim_feature_{0};
};

}  // namespace

void collide_hull_patch(const PatchView& patch, const HullView& hull, Manifold& manifold) noexcept {
  if (patch.triangles.empty()) return;
  HullOnPatch contact(patch, hull);
  if (!contact.is_near()) return;
  for (const std::uint32_t triangle : patch.triangles) contact.look_at(triangle);
  contact.finish(manifold);
}

}  // namespace tactus::physics
