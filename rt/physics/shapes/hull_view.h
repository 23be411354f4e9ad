// A hull, or a box as a hull, in the form that the kernels of narrow phase use. Thread: [any]; pure.
// Frame: the body's. Units: m. Bound: support_along visits every vertex once, several per register.
#pragma once

#include "rt/base/wide.h"
#include "rt/physics/body_frame.h"
#include "rt/physics/shapes/hull.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// A number for each face, in the order of faces.
struct FaceHeights {
  alignas(32) double of[kMaxHullFaces];  // m
};

struct HullView {
  const HullTopology* topology;
  const double *x, *y, *z;               // vertices, padded to whole registers and aligned to them
  const double *nx, *ny, *nz, *offsets;  // face planes, likewise
  std::uint32_t padded, padded_faces;    // number of vertices, of faces, including the padding
  const double* edge_secant;
  double largest_secant, inner_radius, flatness;  // largest_secant: of edge_secant

  Vec3d vertex(std::uint32_t i) const noexcept { return {x[i], y[i], z[i]}; }
  Vec3d normal(std::uint32_t face) const noexcept { return {nx[face], ny[face], nz[face]}; }
  double height(std::uint32_t face, const Vec3d& p) const noexcept { return dot(normal(face), p) - offsets[face]; }

  using V = Register<double>;
  // d.v of the vertices from the i-th on, n.p of the face normals from the i-th on: as many as a register holds.
  TACTUS_INLINE V along(const Vec3<V>& d, std::uint32_t i) const noexcept { return dots(x + i, y + i, z + i, d); }
  TACTUS_INLINE V over_faces(const Vec3<V>& p, std::uint32_t i) const noexcept {
    return dots(nx + i, ny + i, nz + i, p);
  }
  static Vec3<V> spread(const Vec3d& v) noexcept { return {V(v.x), V(v.y), V(v.z)}; }

  // height() of every face, padding included.
  void heights(const Vec3d& p, FaceHeights& out) const noexcept {
    const Vec3<V> point = spread(p);
    for (std::uint32_t f = 0; f < padded_faces; f += kLanes<V>) {
      V offset;
      load(offset, offsets + f);
      store(over_faces(point, f) - offset, out.of + f);
    }
  }

  // Support function: the largest d.v over the vertices.
  double support_along(const Vec3d& d) const noexcept {
    const Vec3<V> direction = spread(d);
    V best = along(direction, 0);
    for (std::uint32_t i = kLanes<V>; i < padded; i += kLanes<V>) best = larger(best, along(direction, i));
    double most = best[0];
    for (int lane = 1; lane < kLanes<V>; ++lane) most = larger(most, best[lane]);
    return most;
  }

  // Index of the first vertex with the largest d.v, of the first face with the largest d.n; 0 if that is NaN.
  std::uint32_t support(const Vec3d& d) const noexcept {
    return first_largest(
        padded, topology->vertices, [&](const Vec3<V>& v, std::uint32_t i) { return along(v, i); }, d);
  }
  std::uint32_t face_along(const Vec3d& d) const noexcept {
    return first_largest(
        padded_faces, topology->faces, [&](const Vec3<V>& v, std::uint32_t i) { return over_faces(v, i); }, d);
  }

 private:
  TACTUS_INLINE static V dots(const double* xs, const double* ys, const double* zs, const Vec3<V>& d) noexcept {
    V vx, vy, vz;
    load(vx, xs);
    load(vy, ys);
    load(vz, zs);
    return d.x * vx + d.y * vy + d.z * vz;
  }
  // The padding repeats number 0.
  template <class Dots>
  TACTUS_INLINE static std::uint32_t first_largest(std::uint32_t padded_count, std::uint32_t count, Dots dots_from,
                                                   const Vec3d& d) noexcept {
    constexpr int lanes = kLanes<V>;
    const Vec3<V> direction = spread(d);
    V best = dots_from(direction, 0), block(0.0);  // block: of the lane's best; its index is block + lane
    for (std::uint32_t i = lanes; i < padded_count; i += lanes) {
      const V values = dots_from(direction, i);
      block = select(values > best, V(static_cast<double>(i)), block);
      best = larger(best, values);
    }
    std::uint32_t first = static_cast<std::uint32_t>(block[0]);
    double most = best[0];
    for (int lane = 1; lane < lanes; ++lane) {
      const std::uint32_t index = static_cast<std::uint32_t>(block[lane]) + static_cast<std::uint32_t>(lane);
      if (!(best[lane] > most) && !(best[lane] == most && index < first)) continue;
      most = best[lane];
      first = index;
    }
    return first < count ? first : 0;
  }
};

inline HullView view_of(const Hull& hull) noexcept {
  constexpr std::uint32_t lanes = kLanes<Register<double>>;
  return {.topology = &hull.topology,
          .x = hull.x.data(),
          .y = hull.y.data(),
          .z = hull.z.data(),
          .nx = hull.nx.data(),
          .ny = hull.ny.data(),
          .nz = hull.nz.data(),
          .offsets = hull.offsets.data(),
          .padded = (hull.topology.vertices + lanes - 1) / lanes * lanes,
          .padded_faces = (hull.topology.faces + lanes - 1) / lanes * lanes,
          .edge_secant = hull.edge_secant.data(),
          .largest_secant = hull.largest_secant,
          .inner_radius = hull.inner_radius,
          .flatness = hull.flatness};
}

// The smallest and the largest d.v over the vertices.
struct Extent {
  double low, high;
};
inline Extent extent_along(const HullView& hull, const Vec3d& d) noexcept {
  using V = HullView::V;
  const Vec3<V> direction = HullView::spread(d);
  V low = hull.along(direction, 0), high = low;
  for (std::uint32_t i = kLanes<V>; i < hull.padded; i += kLanes<V>) {
    const V values = hull.along(direction, i);
    low = smaller(low, values);
    high = larger(high, values);
  }
  Extent extent{low[0], high[0]};
  for (int lane = 1; lane < kLanes<V>; ++lane)
    extent = {smaller(extent.low, low[lane]), larger(extent.high, high[lane])};
  return extent;
}

// As bounds_of in shape.h, but of a hull the smallest box that encloses its vertices. `hulls`: the list to which hull
// shapes refer.
inline Aabb bounds_of(const Shape& shape, const Posed& world_from_body, double margin, Hulls hulls) noexcept {
  if (shape.kind != ShapeKind::kHull) return bounds_of(shape, world_from_body, margin);
  const HullView hull = view_of(hulls[shape.index]);
  const Axes axes = axes_of(world_from_body.rotation);
  Aabb box{world_from_body.position, world_from_body.position};
  for (int i = 0; i < 3; ++i) {
    const Extent extent = extent_along(hull, {axes.x[i], axes.y[i], axes.z[i]});
    box.lower[i] += extent.low - margin;
    box.upper[i] += extent.high + margin;
  }
  return box;
}

// Corner k of a box has bit i of k set if its coordinate i is positive. Face 2 i + s has its normal along axis i, in
// the positive direction if s is 1.
constexpr HullTopology make_box_topology() noexcept {
  HullTopology t;
  t.vertices = 8;
  constexpr std::uint8_t loops[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& loop : loops) (void)t.add_face(loop);
  (void)t.close();
  return t;
}
inline constexpr HullTopology kBoxTopology = make_box_topology();
static_assert(kBoxTopology.faces == 6 && kBoxTopology.edges == 12);

// Storage for the view of a box as a hull; must outlive the view.
struct BoxHull {
  alignas(32) double x[8], y[8], z[8], offsets[8];
  double inner_radius;

  explicit BoxHull(const Vec3d& h) noexcept : inner_radius(smaller(h.x, smaller(h.y, h.z))) {
    for (unsigned k = 0; k < 8; ++k) {
      x[k] = (k & 1u) != 0 ? h.x : -h.x;
      y[k] = (k & 2u) != 0 ? h.y : -h.y;
      z[k] = (k & 4u) != 0 ? h.z : -h.z;
    }
    for (int f = 0; f < 8; ++f) offsets[f] = h[f % 6 / 2];
  }
  HullView view() const noexcept {
    alignas(32) static constexpr double nx[8] = {-1.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 1.0},
                                        ny[8] = {0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0},
                                        nz[8] = {0.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0};
    constexpr double k = 1.41421356237309504880;
    static constexpr double secants[12] = {k, k, k, k, k, k, k, k, k, k, k, k};
    return {.topology = &kBoxTopology,
            .x = x,
            .y = y,
            .z = z,
            .nx = nx,
            .ny = ny,
            .nz = nz,
            .offsets = offsets,
            .padded = 8,
            .padded_faces = 8,
            .edge_secant = secants,
            .largest_secant = k,
            .inner_radius = inner_radius,
            .flatness = 0.0};
  }
};

}  // namespace tactus::physics
