// The kinds of shapes, and what the parts of the program that do not compute with a shape have to know of each.
//
// The compiler names an enumerator without traits. Thread: [any], constexpr.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "rt/base/choice.h"

namespace tactus::physics {

enum class ShapeKind : std::uint32_t {
  kSphere = 0,
  kCapsule = 1,
  kBox = 2,
  kPlane = 3,
  kHull = 4,
  kMesh = 5,
  kCompound = 6,
  kCylinder = 7,
  kCone = 8,
};

struct ShapeTraits {
  std::string_view name;  // in scene files, JSON and tables
  bool moves{true};       // false: of fixed bodies only
  bool is_part{true};     // a compound may have it as a part: it is convex
  bool is_listed{false};  // a shape refers to a list of the world by its index
  bool rolls{false};      // on its side: a point of contact moves along a round surface
  bool has_faces{true};   // flat ones, of a limited size
};

// The name is empty for a number that is no kind.
constexpr ShapeTraits traits_of(ShapeKind kind) noexcept {
  using enum ShapeKind;
  switch (kind) {
    case kSphere:
      return {.name = "sphere", .rolls = true, .has_faces = false};
    case kCapsule:
      return {.name = "capsule", .rolls = true, .has_faces = false};
    case kBox:
      return {.name = "box"};
    case kPlane:
      return {.name = "plane", .moves = false, .is_part = false, .has_faces = false};
    case kHull:
      return {.name = "hull", .is_listed = true};
    case kMesh:
      return {.name = "mesh", .moves = false, .is_part = false, .is_listed = true};
    case kCompound:
      return {.name = "compound", .is_part = false, .is_listed = true};
    case kCylinder:
      return {.name = "cylinder", .rolls = true};
    case kCone:
      return {.name = "cone", .rolls = true};
  }
  return {};
}

// In the order of help texts and tables.
inline constexpr std::array kShapeKinds{ShapeKind::kBox,      ShapeKind::kSphere, ShapeKind::kCapsule,
                                        ShapeKind::kCylinder, ShapeKind::kCone,   ShapeKind::kHull,
                                        ShapeKind::kCompound, ShapeKind::kPlane,  ShapeKind::kMesh};
static_assert(lists_every_choice(kShapeKinds), "a kind of shape that has traits is not in the list, or twice");

}  // namespace tactus::physics
