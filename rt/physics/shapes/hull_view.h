// A hull, or a box as a hull, in the form that the kernels of narrow phase use. Thread: [any]; pure.
// Frame: the body's. Units: m. Bound: reach_along visits every vertex once, several per register.
#pragma once

#include "rt/base/wide.h"
#include "rt/physics/shapes/hull.h"

namespace tactus::physics {

struct HullView {
  const HullTopology* topology;
  const double *x, *y, *z;  // vertices, padded to whole registers and aligned to them
  std::uint32_t padded;     // number of vertices including the padding
  const Vec3d* normals;
  const double* offsets;
  const double* edge_reach;
  double inner_radius, flatness;

  Vec3d vertex(std::uint32_t i) const noexcept { return {x[i], y[i], z[i]}; }

  // Support function: the largest d.v over the vertices.
  double reach_along(const Vec3d& d) const noexcept {
    using V = Register<double>;
    const V dx(d.x), dy(d.y), dz(d.z);
    const auto at = [&](std::uint32_t i) noexcept {
      V vx, vy, vz;
      load(vx, x + i), load(vy, y + i), load(vz, z + i);
      return dx * vx + dy * vy + dz * vz;
    };
    V best = at(0);
    for (std::uint32_t i = kLanes<V>; i < padded; i += kLanes<V>) best = larger(best, at(i));
    double reach = best[0];
    for (int lane = 1; lane < kLanes<V>; ++lane) reach = larger(reach, best[lane]);
    return reach;
  }

  // Index of the first vertex with the largest d.v; 0 if that is NaN.
  std::uint32_t support(const Vec3d& d) const noexcept {
    const double reach = reach_along(d);
    for (std::uint32_t i = 0; i < topology->vertices; ++i)
      if (d.x * x[i] + d.y * y[i] + d.z * z[i] == reach) return i;
    return 0;
  }
};

inline HullView view_of(const Hull& hull) noexcept {
  constexpr std::uint32_t lanes = kLanes<Register<double>>;
  return {&hull.topology,
          hull.x.data(),
          hull.y.data(),
          hull.z.data(),
          (hull.topology.vertices + lanes - 1) / lanes * lanes,
          hull.normals.data(),
          hull.offsets.data(),
          hull.edge_reach.data(),
          hull.inner_radius,
          hull.flatness};
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
  alignas(32) double x[8], y[8], z[8];
  double offsets[6];
  double inner_radius;

  explicit BoxHull(const Vec3d& h) noexcept : inner_radius(smaller(h.x, smaller(h.y, h.z))) {
    for (unsigned k = 0; k < 8; ++k)
      x[k] = (k & 1u) != 0 ? h.x : -h.x, y[k] = (k & 2u) != 0 ? h.y : -h.y, z[k] = (k & 4u) != 0 ? h.z : -h.z;
    for (int f = 0; f < 6; ++f) offsets[f] = h[f / 2];
  }
  HullView view() const noexcept {
    static constexpr Vec3d normals[6] = {{-1.0, 0.0, 0.0}, {1.0, 0.0, 0.0},  {0.0, -1.0, 0.0},
                                         {0.0, 1.0, 0.0},  {0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}};
    constexpr double k = 1.41421356237309504880;
    static constexpr double reach[12] = {k, k, k, k, k, k, k, k, k, k, k, k};
    return {&kBoxTopology, x, y, z, 8, normals, offsets, reach, inner_radius, 0.0};
  }
};

}  // namespace tactus::physics
