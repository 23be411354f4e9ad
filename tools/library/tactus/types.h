/// \file
/// Vectors and rotations as plain arrays, so that Eigen, NumPy or a file take them as they are.
///
/// Units and frame are in the name or the description of whatever has such a type; SI and the world's frame unless that
/// says otherwise. Thread: any. Errors: none.
#pragma once

#include <array>
#include <cstdint>

namespace tactus {

/// x, y, z.
using Vector3 = std::array<double, 3>;
/// A rotation as a unit quaternion: w, x, y, z. (1, 0, 0, 0) turns nothing.
using Quaternion = std::array<double, 4>;
/// A body's number: its place in the scene, from 0 without gaps, in the order of the file, generated ones at the end.
using BodyNumber = std::uint32_t;

}  // namespace tactus
