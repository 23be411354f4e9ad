// A scene before it is text: bodies and joints as an import found them.
//
// Units: SI. Frame: world, unless a field says otherwise. Thread: any normal one. Bound: none. Errors: of files that
// cannot be written.
#pragma once

#include <filesystem>
#include <optional>

#include "rt/base/result.h"
#include "tools/import/account.h"
#include "tools/import/decimals.h"
#include "tools/import/hull_shapes.h"
#include "tools/import/mass_properties.h"

namespace tactus::scene_import {

enum class DraftShape { kSphere, kCapsule, kCylinder, kBox, kPlane, kHull, kMesh };
enum class DraftRole { kMoving, kFixed, kKinematic };

inline constexpr std::size_t kMaxFixedTriangles = 20'000;  // of a mesh that never moves

// One shape of a body. What moves has spheres, capsules, cylinders, boxes and hulls.
struct DraftPart {
  std::string origin;  // for a comment: geom "head", line 42
  DraftShape shape{DraftShape::kBox};
  Vec3d size;                  // box: half lengths; sphere: x is the radius; capsule, cylinder: radius, half length
  std::vector<Vec3d> points;   // of a hull, in the part's frame
  sim::TriangleSoup mesh;      // in the part's frame
  double rounding{kRounding};  // of points and mesh, as a share of the farthest one's distance
  Posed pose;                  // body_from_part
};

struct DraftBody {
  std::string name, origin;  // origin: for a comment
  DraftRole role{DraftRole::kMoving};
  std::vector<DraftPart> parts;  // at least one
  bool compound{false};          // else: one part, in the body's frame
  Posed pose;                    // world_from_body; a frame of the model, not that of the centre of mass
  double mass_kg{0};
  std::optional<SymMat3d> inertia;  // about the centre of mass, along the frame's axes; none: the solid's
  std::optional<Vec3d> centre;      // of mass, in the body's frame; hulls and compounds alone
  Twistd velocity;                  // of the centre of mass
  double friction{0}, contact_radius_m{0}, rolling_friction_m{0};
};

struct DraftJoint {
  std::string kind;              // fixed, ball, hinge, slider
  std::optional<std::size_t> a;  // index of the body; none: the world
  std::size_t b{0};
  std::string origin;
  Vec3d position;
  std::optional<Vec3d> axis;        // hinge, slider
  std::optional<double> low, high;  // rad or m, of the coordinate, which is 0 at the start
  bool bodies_collide{false};
};

struct DraftProxy {
  std::optional<std::size_t> body;  // index of the body that it is; none: a sphere
  double radius_m{0.01}, mass_kg{0.2}, friction{0.5};
  std::optional<Vec3d> position;  // none: above everything that moves
  std::string device{"virtuose6d"};
};

struct SceneDraft {
  std::string title;
  std::vector<std::string> head;  // comment lines
  Vec3d gravity;
  std::vector<DraftBody> bodies;
  std::vector<DraftJoint> joints;
  DraftProxy proxy;
};

// The scene's text, and the shape files that it names, beside it.
struct SceneFiles {
  std::string text;
  std::vector<std::pair<std::string, std::string>> shapes;  // name, content
};
// `stem`: what the shape files' names begin with. What was filled in goes to the account.
SceneFiles write_scene(const SceneDraft& draft, const std::string& stem, Account& account);

// Makes the names those of a scene: not empty, none twice, at most 100 characters.
void make_names_unique(SceneDraft& draft);

}  // namespace tactus::scene_import
