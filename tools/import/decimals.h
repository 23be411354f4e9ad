// Numbers as short decimals: digits below the rounding of the computation that made them are not written.
//
// The rule: a number is written as 0 where its amount is below the rounding of its own computation, else as the decimal
// of at most 12 digits that lies within that rounding, the shortest there is; where there is none, as the shortest that
// reads back as the same bits. Units: any. Thread: any normal one. Bound: 12 digits. Errors: none.
#pragma once

#include <string>

namespace tactus::scene_import {

// The rounding of a computation, as a share of the lengths in it. To turn and to shift a vector by a frame takes up to
// eight roundings one after the other (rt/base/math.h); MuJoCo's chain of frames, and the way back into the frame of a
// body, take eight of these here. The rounding of deeper chains stays visible.
inline constexpr double kRounding = 64 * 2.220446049250313e-16;
// The same of meshes, which MuJoCo and assimp hold in single precision: half of its last place.
inline constexpr double kSingleRounding = 5.960464477539063e-08;

// `rounding`: in the number's unit, 0 or more.
std::string decimal(double number, double rounding);
// Of a number that was computed by products and quotients alone.
std::string decimal(double number);

}  // namespace tactus::scene_import
