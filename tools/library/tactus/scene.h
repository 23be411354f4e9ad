/// \file
/// A scene, read from TOML: bodies, effects, the proxy, the device's placement and the simulated hand.
///
/// Thread: one thread at a time; several may read a const Scene. Frame: world, z up. Units: SI, in the names.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tactus/error.h"
#include "tactus/types.h"

namespace tactus {

namespace library {
struct Access;
}

/// Shape of a body; named as in the text of a scene.
enum class Shape : std::uint32_t {
  kSphere = 0,    ///< `radius_m`
  kCapsule = 1,   ///< `radius_m`, and `half_length_m` from the centre to the centres of its caps, along its own z
  kBox = 2,       ///< `half_extents_m`
  kPlane = 3,     ///< half space below its own z = 0
  kHull = 4,      ///< convex hull of Scene::corners; `half_extents_m` of its bounding box
  kMesh = 5,      ///< triangle mesh of Scene::corners and Scene::triangles; `half_extents_m` of its bounding box
  kCompound = 6,  ///< several shapes, Scene::parts; `half_extents_m` of its bounding box
  kCylinder = 7,  ///< `radius_m`, and `half_length_m` from the centre to its ends, along its own z
  kCone = 8,      ///< `radius_m` of its base, `half_length_m` half its height; base at own z = 0
};

/// Properties of a body. Body frame: the frame that `position_m` and the rotation of the body's table in the scene
/// place, in which its points, parts or triangles are given.
struct BodyInfo {
  Shape shape{Shape::kSphere};  ///< determines the meaning of the next three fields
  double radius_m{0};           ///< m; 0 where the shape has none
  double half_length_m{0};      ///< m; 0 where the shape has none
  Vector3 half_extents_m{};     ///< m; 0 where the shape has none
  bool fixed{false};            ///< never moves
  double mass_kg{0};            ///< kg; 0 for a fixed body
  Vector3 centre_of_mass_m{};   ///< body frame; of a fixed hull or compound that of the solid
  Quaternion principal_axes{};  ///< body from principal axes of inertia
  Vector3 inertia_kg_m2{};      ///< moments about the centre of mass, along the principal axes; 0 for a fixed body
  double friction{0};           ///< Coulomb coefficient; a pair uses the geometric mean of the two
  Vector3 position_m{};         ///< world, at the start
  Quaternion rotation{};        ///< world from body, at the start
};

/// A part of a compound.
struct PartInfo {
  Shape shape{Shape::kSphere};   ///< sphere, capsule, box or hull; determines the meaning of the next three fields
  double radius_m{0};            ///< m; 0 where the shape has none
  double half_length_m{0};       ///< m; 0 where the shape has none
  Vector3 half_extents_m{};      ///< m; 0 where the shape has none
  Vector3 position_m{};          ///< of its own frame, in the body's frame
  Quaternion rotation{};         ///< body from part
  std::vector<Vector3> corners;  ///< of a hull, m, in the part's own frame
};

/// A valid scene; copies share its data. An empty scene has no bodies and cannot be opened by a session.
class Scene {
 public:
  /// Empty.
  Scene() = default;

  /// Reads a file. If it has mistakes, this scene is unchanged.
  /// \return kFile: a line for each mistake, with file, line, column, what was found and what is accepted
  Error load(const std::filesystem::path& file);
  /// Reads a scene from a text. It cannot refer to other files, because it has no folder. Messages begin with `name`.
  Error parse(std::string_view text, std::string_view name = "scene");

  /// True before a scene was read.
  bool empty() const noexcept { return scene_ == nullptr; }
  /// Name of the file, without folder and extension.
  std::string name() const;
  /// Title of the scene, one line.
  std::string title() const;
  /// The text that it was read from.
  std::string text() const;
  /// Warnings: suspicious entries that do not make the scene invalid, one line each.
  const std::vector<std::string>& warnings() const noexcept { return warnings_; }

  /// Number of bodies, fixed ones included. Body numbers are 0 to bodies() - 1.
  std::uint32_t bodies() const noexcept;
  /// Properties of a body; a default BodyInfo for an invalid number.
  BodyInfo body(BodyNumber number) const noexcept;
  /// Display name of a body: the name in the scene's text, `proxy`, of a second hand `proxy2`, or `body 17`. Parses the
  /// text again: do not call it every tick.
  std::string body_name(BodyNumber number) const;
  /// Corners of a hull or a mesh [m], body frame; empty for any other shape.
  std::vector<Vector3> corners(BodyNumber number) const;
  /// Parts of a compound; empty for any other shape.
  std::vector<PartInfo> parts(BodyNumber number) const;
  /// Triangles of a mesh by their corners, counter-clockwise from outside; empty for any other shape.
  std::vector<std::array<std::uint32_t, 3>> triangles(BodyNumber number) const;
  /// Number of hands: of [[proxy]] in the scene; 0 for an empty scene. Hands are numbered from 0, in the order of the
  /// file.
  unsigned hands() const noexcept;
  /// The body that the device of this hand holds; 0 for an empty scene or an invalid hand.
  BodyNumber proxy(unsigned hand = 0) const noexcept;
  /// Duration of the simulated hand's path [s]; 0 for an empty scene or an invalid hand.
  double hand_duration_s(unsigned hand = 0) const noexcept;

 private:
  friend struct library::Access;
  std::shared_ptr<const void> scene_;
  std::vector<std::string> warnings_;
  std::filesystem::path file_;  // file that it was loaded from; empty: none
};

}  // namespace tactus
