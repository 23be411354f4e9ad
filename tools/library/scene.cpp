#include "tactus/scene.h"

#include <fmt/format.h>

#include "sim/loader/scene_load.h"
#include "sim/model/given_pose.h"
#include "tools/library/access.h"
#include "tools/library/values.h"

namespace tactus {
namespace {

using library::Access;
using library::to_public;

// Begins each line of a message with the scene's name.
Error take(Result<sim::Scene> read, const text::Diagnostics& said, std::shared_ptr<const void>& scene,
           std::vector<std::string>& warnings) {
  if (!read.ok()) return {Error::Kind::kFile, read.message()};
  scene = std::make_shared<const sim::Scene>(std::move(read).value());
  warnings.clear();
  const std::string lines = said.warning_message();
  for (std::size_t from = 0; from < lines.size();) {
    const std::size_t end = std::min(lines.find('\n', from), lines.size());
    if (end > from) warnings.push_back(lines.substr(from, end - from));
    from = end + 1;
  }
  return {};
}

const physics::Body* body_of(const sim::Scene* scene, BodyNumber number) noexcept {
  return scene != nullptr && number < scene->bodies.size() ? &scene->bodies[number] : nullptr;
}

// The public kind of a shape; the compiler names a kind that it lacks.
constexpr Shape public_kind(physics::ShapeKind kind) noexcept {
  using enum physics::ShapeKind;
  switch (kind) {
    case kSphere:
      return Shape::kSphere;
    case kCapsule:
      return Shape::kCapsule;
    case kBox:
      return Shape::kBox;
    case kPlane:
      return Shape::kPlane;
    case kHull:
      return Shape::kHull;
    case kMesh:
      return Shape::kMesh;
    case kCompound:
      return Shape::kCompound;
    case kCylinder:
      return Shape::kCylinder;
    case kCone:
      return Shape::kCone;
  }
  return Shape::kSphere;
}

// Fills the kind and the sizes that such a shape has; `Info`: BodyInfo or PartInfo.
template <class Info>
void fill_shape(const physics::Shape& shape, Info& info) noexcept {
  info.shape = public_kind(shape.kind);
  const bool has_length = info.shape == Shape::kCapsule || info.shape == Shape::kCylinder || info.shape == Shape::kCone;
  if (info.shape == Shape::kSphere || has_length) info.radius_m = shape.radius;
  if (has_length) info.half_length_m = shape.half_length;
  info.half_extents_m = to_public(shape.half_extents);
}

std::vector<Vector3> corners_of(const physics::Hull& hull, const Posed& from_hull) {
  std::vector<Vector3> corners;
  for (std::uint32_t i = 0; i < hull.topology.vertices; ++i) corners.push_back(to_public(from_hull * hull.vertex(i)));
  return corners;
}

}  // namespace

const sim::Scene& library::Access::scene(const Scene& scene) {
  return *static_cast<const sim::Scene*>(scene.scene_.get());
}

const std::filesystem::path& library::Access::file(const Scene& scene) { return scene.file_; }

Error Scene::load(const std::filesystem::path& file) {
  text::Diagnostics said;
  Error error = take(sim::load_scene(file, &said), said, scene_, warnings_);
  if (!error) file_ = file;
  return error;
}

Error Scene::parse(std::string_view text, std::string_view name) {
  text::Diagnostics said;
  Error error = take(sim::parse_scene(text, name, &said), said, scene_, warnings_);
  if (!error) file_.clear();
  return error;
}

std::string Scene::name() const { return empty() ? std::string() : Access::scene(*this).name; }
std::string Scene::title() const { return empty() ? std::string() : Access::scene(*this).title; }
std::string Scene::text() const { return empty() ? std::string() : Access::scene(*this).source; }
unsigned Scene::hands() const noexcept { return empty() ? 0 : Access::scene(*this).hands(); }

BodyNumber Scene::proxy(unsigned hand) const noexcept {
  if (hand >= hands()) return 0;
  const sim::Scene& scene = Access::scene(*this);
  return hand == 0 ? scene.proxy : scene.more_hands[hand - 1].proxy;
}

std::uint32_t Scene::bodies() const noexcept {
  return empty() ? 0 : static_cast<std::uint32_t>(Access::scene(*this).bodies.size());
}

double Scene::hand_duration_s(unsigned hand) const noexcept {
  if (hand >= hands()) return 0.0;
  const sim::Scene& scene = Access::scene(*this);
  const auto& path = hand == 0 ? scene.hand.path : scene.more_hands[hand - 1].hand.path;
  return path.empty() ? 0.0 : path.back().time_s;
}

BodyInfo Scene::body(BodyNumber number) const noexcept {
  const physics::Body* body = body_of(static_cast<const sim::Scene*>(scene_.get()), number);
  if (body == nullptr) return {};
  BodyInfo info;
  fill_shape(body->shape, info);
  info.fixed = body->kind == physics::BodyKind::kFixed;
  info.mass_kg = body->mass;
  const sim::Scene& scene = Access::scene(*this);
  const Posed given_from_body = sim::given_from_body(scene, number);
  const Posed world_from_given = sim::given_pose(scene, number, body->motion.pose);
  info.centre_of_mass_m = to_public(given_from_body.position);
  info.principal_axes = to_public(given_from_body.rotation);
  info.inertia_kg_m2 = to_public(body->inertia);
  info.friction = body->friction;
  info.position_m = to_public(world_from_given.position);
  info.rotation = to_public(world_from_given.rotation);
  return info;
}

std::string Scene::body_name(BodyNumber number) const {
  if (body_of(static_cast<const sim::Scene*>(scene_.get()), number) == nullptr) return {};
  for (unsigned hand = 0; hand < hands(); ++hand)
    if (number == proxy(hand)) return hand == 0 ? "proxy" : fmt::format("proxy{}", hand + 1);
  const auto& listed = Access::scene(*this).listed;
  if (number < listed.size() && !listed[number].name.empty()) return listed[number].name;
  return fmt::format("body {}", number);
}

std::vector<Vector3> Scene::corners(BodyNumber number) const {
  std::vector<Vector3> corners;
  const physics::Body* body = body_of(static_cast<const sim::Scene*>(scene_.get()), number);
  if (body == nullptr) return corners;
  const sim::Scene& scene = Access::scene(*this);
  const Posed given_from_body = sim::given_from_body(scene, number);
  if (body->shape.kind == physics::ShapeKind::kHull) {
    corners = corners_of(scene.hulls[body->shape.index], given_from_body);
  } else if (body->shape.kind == physics::ShapeKind::kMesh) {
    for (const Vec3d& corner : scene.meshes[body->shape.index].corners)
      corners.push_back(to_public(given_from_body * corner));
  }
  return corners;
}

std::vector<PartInfo> Scene::parts(BodyNumber number) const {
  std::vector<PartInfo> parts;
  const physics::Body* body = body_of(static_cast<const sim::Scene*>(scene_.get()), number);
  if (body == nullptr || body->shape.kind != physics::ShapeKind::kCompound) return parts;
  const sim::Scene& scene = Access::scene(*this);
  for (const physics::CompoundPart& part : scene.compounds[body->shape.index].parts) {
    PartInfo& info = parts.emplace_back();
    fill_shape(part.shape, info);
    Posed given_from_part = sim::given_from_body(scene, number) * part.body_from_part;
    if (info.shape == Shape::kCone)
      given_from_part = given_from_part * Posed{{0, 0, -0.5 * part.shape.half_length}, {}};
    info.position_m = to_public(given_from_part.position);
    info.rotation = to_public(given_from_part.rotation);
    if (part.shape.kind == physics::ShapeKind::kHull) info.corners = corners_of(scene.hulls[part.shape.index], {});
  }
  return parts;
}

std::vector<std::array<std::uint32_t, 3>> Scene::triangles(BodyNumber number) const {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const physics::Body* body = body_of(static_cast<const sim::Scene*>(scene_.get()), number);
  if (body == nullptr || body->shape.kind != physics::ShapeKind::kMesh) return triangles;
  for (const physics::MeshTriangle& triangle : Access::scene(*this).meshes[body->shape.index].triangles)
    triangles.push_back(triangle.corner);
  return triangles;
}

}  // namespace tactus
