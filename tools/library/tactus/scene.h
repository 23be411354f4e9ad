/// \file
/// A scene: bodies, effects, the proxy, the device's place and the simulated hand, as a TOML file says.
///
/// Thread: one at a time; a const Scene may be read by several. Frame: world, z up. Units: SI, in the names.
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

/// What a body looks like; named as in the text of a scene.
enum class Shape : std::uint32_t {
  kSphere = 0,   ///< `radius_m`
  kCapsule = 1,  ///< `radius_m`, and `half_length_m` from the centre to the centres of its caps, along its own z
  kBox = 2,      ///< `half_extents_m`
  kPlane = 3,    ///< all below its own z = 0 is solid
  kHull = 4,     ///< convex, of Scene::corners; `half_extents_m` of the box that holds it
  kMesh = 5,     ///< triangles, of Scene::corners and Scene::triangles; `half_extents_m` of the box that holds it
};

/// What a body is. Its own frame: origin in the centre of mass, axes along the principal axes of inertia.
struct BodyInfo {
  Shape shape{Shape::kSphere};  ///< which shape; what the next three mean is said there
  double radius_m{0};           ///< m; 0 where the shape has none
  double half_length_m{0};      ///< m; 0 where the shape has none
  Vector3 half_extents_m{};     ///< m; 0 where the shape has none
  bool fixed{false};            ///< never moves
  double mass_kg{0};            ///< kg; 0 for a fixed body
  Vector3 inertia_kg_m2{};      ///< about its own axes; 0 for a fixed body
  double friction{0};           ///< coefficient; a pair has the geometric mean of two
  Vector3 position_m{};         ///< world, at the start
  Quaternion rotation{};        ///< world from body, at the start
};

/// A scene that was read and has no mistake; copies share it. An empty one has no bodies, and no session opens it.
class Scene {
 public:
  /// Empty.
  Scene() = default;

  /// Reads a file. Where it has mistakes this scene stays what it was.
  /// \return kFile: a line for each mistake, with file, line, column, what was found and what is accepted
  Error load(const std::filesystem::path& file);
  /// The same from a text, which has no folder, so it names no files. Messages begin with `name`.
  Error parse(std::string_view text, std::string_view name = "scene");

  /// True before a scene was read.
  bool empty() const noexcept { return scene_ == nullptr; }
  /// Of the file, without folder and extension.
  std::string name() const;
  /// One line for people.
  std::string title() const;
  /// The text that it was read from.
  std::string text() const;
  /// What is odd and does not refuse the scene, one line each.
  const std::vector<std::string>& warnings() const noexcept { return warnings_; }

  /// How many bodies there are, fixed ones included: body numbers are 0 to bodies() - 1.
  std::uint32_t bodies() const noexcept;
  /// What a body is; of a number that is none, a default BodyInfo.
  BodyInfo body(BodyNumber number) const noexcept;
  /// What people call it: the name in the scene's text, `proxy`, or `body 17`. Reads the text again: not for every
  /// tick.
  std::string body_name(BodyNumber number) const;
  /// Corners of a hull or a mesh [m], in the body's own frame; empty for any other shape.
  std::vector<Vector3> corners(BodyNumber number) const;
  /// Triangles of a mesh by their corners, counter-clockwise from outside; empty for any other shape.
  std::vector<std::array<std::uint32_t, 3>> triangles(BodyNumber number) const;
  /// The body that the device holds; 0 for an empty scene.
  BodyNumber proxy() const noexcept;
  /// How long the path of the simulated hand is [s].
  double hand_duration_s() const noexcept;

 private:
  friend struct library::Access;
  std::shared_ptr<const void> scene_;
  std::vector<std::string> warnings_;
  std::filesystem::path file_;  // that it was loaded from; empty: none
};

}  // namespace tactus
