// Mass, centre of mass and moments of inertia of bodies and of their parts, and their sums.
//
// Units: kg, m, kg m^2. Frame: as each function says; the inertia is about the centre of mass, along the frame's axes.
// Thread: any. Bound: linear in the triangles. Errors: none; a solid without volume has none.
#pragma once

#include "rt/base/spatial.h"
#include "sim/geometry/mesh_files.h"

namespace tactus::scene_import {

struct MassProperties {
  double mass{0};
  Vec3d centre;
  SymMat3d inertia;
};

// R m R^T: a symmetric matrix in the frame that `rotation` leads to.
SymMat3d rotated(const SymMat3d& m, const Quatd& rotation);

// The matrix of v's parallel-axis term: |v|^2 1 - v v^T.
SymMat3d parallel_axis(const Vec3d& v);

inline SymMat3d scaled(double s, const SymMat3d& m) {
  return {s * m.xx, s * m.yy, s * m.zz, s * m.xy, s * m.xz, s * m.yz};
}
inline double trace(const SymMat3d& m) { return m.xx + m.yy + m.zz; }
// The largest entry, by amount, of a - b.
double largest_difference(const SymMat3d& a, const SymMat3d& b);

MassProperties principal_mass(double mass, const Vec3d& centre, const Quatd& axes, const Vec3d& moments);
MassProperties in_frame(const MassProperties& world, const Posed& world_from_frame);
MassProperties in_world(const MassProperties& own, const Posed& world_from_frame);

MassProperties operator+(const MassProperties& a, const MassProperties& b);

// Exact properties of a solid of 1 kg/m^3 with this surface: its mass is its volume. Frame: that of the corners.
MassProperties solid_of(const sim::TriangleSoup& soup);

// True for properties that a rigid body can have: mass and moments above 0, no moment above the sum of the other two.
bool is_a_body(const MassProperties& properties);

}  // namespace tactus::scene_import
