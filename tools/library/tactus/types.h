/// \file
/// Vectors and rotations as plain arrays, so that Eigen, NumPy or a file can use them directly.
///
/// The name or description of each variable gives unit and frame; the default is SI and the world frame. Thread: any.
/// Errors: none.
#pragma once

#include <array>
#include <cstdint>

namespace tactus {

/// x, y, z.
using Vector3 = std::array<double, 3>;
/// A rotation as a unit quaternion: w, x, y, z. Identity: (1, 0, 0, 0).
using Quaternion = std::array<double, 4>;
/// Index of a body in the scene, from 0 without gaps: the proxy, the bodies in the order of the file, then the
/// generated bodies.
using BodyNumber = std::uint32_t;

}  // namespace tactus
