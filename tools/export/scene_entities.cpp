#include "tools/export/scene_entities.h"

#include <array>
#include <nlohmann/json.hpp>

#include "tools/json_text.h"

namespace tactus::exporting {
namespace {

using nlohmann::ordered_json;

// A half space is drawn as a thin plate of this size.
constexpr double kPlateWidth_m = 4, kPlateThickness_m = 1e-3;

using Colour = std::array<double, 3>;
// Of the Okabe-Ito palette: colour-blind people tell them apart.
constexpr Colour kFixedColour{0.60, 0.60, 0.60};
constexpr Colour kProxyColour{0.84, 0.37, 0.00};
constexpr Colour kMemberColour{0.34, 0.71, 0.91};
constexpr Colour kBorderColour{0.90, 0.62, 0.00};

Colour colour_of(MemberRole role) {
  switch (role) {
    case MemberRole::kProxy:
      return kProxyColour;
    case MemberRole::kMember:
      return kMemberColour;
    case MemberRole::kBorder:
      return kBorderColour;
  }
  return kMemberColour;
}

ordered_json vector_json(const Vec3d& v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }
ordered_json pose_json(const Posed& pose) {
  const Quatd& q = pose.rotation;
  return {{"position", vector_json(pose.position)}, {"orientation", {{"x", q.x}, {"y", q.y}, {"z", q.z}, {"w", q.w}}}};
}
ordered_json colour_json(const Colour& c) { return {{"r", c[0]}, {"g", c[1]}, {"b", c[2]}, {"a", 1.0}}; }
ordered_json duration_json(std::uint64_t ns) { return {{"sec", ns / 1'000'000'000u}, {"nsec", ns % 1'000'000'000u}}; }

ordered_json empty_entity(const char* id, std::uint64_t time_ns) {
  ordered_json entity{{"timestamp", duration_json(time_ns)},
                      {"frame_id", "world"},
                      {"id", id},
                      {"lifetime", duration_json(0)},
                      {"frame_locked", false}};
  for (const char* list :
       {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"})
    entity[list] = ordered_json::array();
  return entity;
}

void add_box(ordered_json& entity, const Posed& pose, const Vec3d& size, const Colour& colour) {
  entity["cubes"].push_back(
      ordered_json{{"pose", pose_json(pose)}, {"size", vector_json(size)}, {"color", colour_json(colour)}});
}

void add_sphere(ordered_json& entity, const Posed& pose, double radius, const Colour& colour) {
  const double d = 2 * radius;
  entity["spheres"].push_back(
      ordered_json{{"pose", pose_json(pose)}, {"size", vector_json({d, d, d})}, {"color", colour_json(colour)}});
}

// `top_scale`: 1 for a cylinder, 0 for a cone. `pose`: of its middle.
void add_cylinder(ordered_json& entity, const Posed& pose, const physics::Shape& shape, double top_scale,
                  const Colour& colour) {
  const double d = 2 * shape.radius;
  entity["cylinders"].push_back(ordered_json{{"pose", pose_json(pose)},
                                             {"size", vector_json({d, d, 2 * shape.half_length})},
                                             {"bottom_scale", 1.0},
                                             {"top_scale", top_scale},
                                             {"color", colour_json(colour)}});
}

void add_capsule(ordered_json& entity, const Posed& pose, const physics::Shape& shape, const Colour& colour) {
  for (const double end : {-shape.half_length, shape.half_length})
    add_sphere(entity, {pose * Vec3d{0, 0, end}, pose.rotation}, shape.radius, colour);
  add_cylinder(entity, pose, shape, 1, colour);
}

void add_triangles(ordered_json& entity, const Posed& pose, ordered_json points, ordered_json indices,
                   const Colour& colour) {
  entity["triangles"].push_back(ordered_json{{"pose", pose_json(pose)},
                                             {"points", std::move(points)},
                                             {"color", colour_json(colour)},
                                             {"colors", ordered_json::array()},
                                             {"indices", std::move(indices)}});
}

void add_hull(ordered_json& entity, const Posed& pose, const physics::Hull& hull, const Colour& colour) {
  ordered_json points = ordered_json::array(), indices = ordered_json::array();
  for (std::uint32_t i = 0; i < hull.topology.vertices; ++i) points.push_back(vector_json(hull.vertex(i)));
  for (std::uint32_t face = 0; face < hull.topology.faces; ++face) {
    const auto loop = hull.topology.loop(face);
    for (std::size_t k = 2; k < loop.size(); ++k)
      for (const std::uint8_t corner : {loop[0], loop[k - 1], loop[k]}) indices.push_back(corner);
  }
  add_triangles(entity, pose, std::move(points), std::move(indices), colour);
}

void add_mesh(ordered_json& entity, const Posed& pose, const physics::Mesh& mesh, const Colour& colour) {
  ordered_json points = ordered_json::array(), indices = ordered_json::array();
  for (const Vec3d& corner : mesh.corners) points.push_back(vector_json(corner));
  for (const physics::MeshTriangle& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle.corner) indices.push_back(corner);
  add_triangles(entity, pose, std::move(points), std::move(indices), colour);
}

void add_shape(ordered_json& entity, const sim::Scene& scene, const physics::Shape& shape, const Posed& pose,
               const Colour& colour) {
  switch (shape.kind) {
    case physics::ShapeKind::kSphere:
      return add_sphere(entity, pose, shape.radius, colour);
    case physics::ShapeKind::kCapsule:
      return add_capsule(entity, pose, shape, colour);
    case physics::ShapeKind::kCylinder:
      return add_cylinder(entity, pose, shape, 1, colour);
    case physics::ShapeKind::kCone:
      return add_cylinder(entity, {pose * Vec3d{0, 0, 0.5 * shape.half_length}, pose.rotation}, shape, 0, colour);
    case physics::ShapeKind::kBox:
      return add_box(entity, pose, 2.0 * shape.half_extents, colour);
    case physics::ShapeKind::kPlane:
      return add_box(entity, {pose * Vec3d{0, 0, -0.5 * kPlateThickness_m}, pose.rotation},
                     {kPlateWidth_m, kPlateWidth_m, kPlateThickness_m}, colour);
    case physics::ShapeKind::kHull:
      return add_hull(entity, pose, scene.hulls[shape.index], colour);
    case physics::ShapeKind::kMesh:
      return add_mesh(entity, pose, scene.meshes[shape.index], colour);
    case physics::ShapeKind::kCompound:
      for (const physics::CompoundPart& part : scene.compounds[shape.index].parts)
        add_shape(entity, scene, part.shape, pose * part.body_from_part, colour);
      return;
  }
}

std::string update_json(ordered_json entity) {
  return json_text(
      ordered_json{{"deletions", ordered_json::array()}, {"entities", ordered_json::array({std::move(entity)})}});
}

ordered_json object_schema(const ordered_json& properties) { return {{"type", "object"}, {"properties", properties}}; }
ordered_json list_schema(const ordered_json& items) { return {{"type", "array"}, {"items", items}}; }

ordered_json make_schema() {
  const ordered_json number{{"type", "number"}}, integer{{"type", "integer"}}, text{{"type", "string"}};
  const ordered_json vector = object_schema({{"x", number}, {"y", number}, {"z", number}});
  const ordered_json rotation = object_schema({{"x", number}, {"y", number}, {"z", number}, {"w", number}});
  const ordered_json pose = object_schema({{"position", vector}, {"orientation", rotation}});
  const ordered_json colour = object_schema({{"r", number}, {"g", number}, {"b", number}, {"a", number}});
  const ordered_json time = object_schema({{"sec", integer}, {"nsec", integer}});
  const ordered_json solid = object_schema({{"pose", pose}, {"size", vector}, {"color", colour}});
  const ordered_json cylinder = object_schema(
      {{"pose", pose}, {"size", vector}, {"bottom_scale", number}, {"top_scale", number}, {"color", colour}});
  const ordered_json triangles = object_schema({{"pose", pose},
                                                {"points", list_schema(vector)},
                                                {"color", colour},
                                                {"colors", list_schema(colour)},
                                                {"indices", list_schema(integer)}});
  const ordered_json any = object_schema(ordered_json::object());
  const ordered_json entity = object_schema({{"timestamp", time},
                                             {"frame_id", text},
                                             {"id", text},
                                             {"lifetime", time},
                                             {"frame_locked", {{"type", "boolean"}}},
                                             {"metadata", list_schema(any)},
                                             {"arrows", list_schema(any)},
                                             {"cubes", list_schema(solid)},
                                             {"spheres", list_schema(solid)},
                                             {"cylinders", list_schema(cylinder)},
                                             {"lines", list_schema(any)},
                                             {"triangles", list_schema(triangles)},
                                             {"texts", list_schema(any)},
                                             {"models", list_schema(any)}});
  ordered_json schema = object_schema({{"deletions", list_schema(any)}, {"entities", list_schema(entity)}});
  schema["title"] = "foxglove.SceneUpdate";
  return schema;
}

}  // namespace

const std::string& scene_update_schema() {
  static const std::string text = json_text(make_schema());
  return text;
}

std::string fixed_bodies_json(const sim::Scene& scene, std::uint64_t time_ns) {
  ordered_json entity = empty_entity("fixed", time_ns);
  for (const physics::Body& body : scene.bodies)
    if (body.kind == physics::BodyKind::kFixed) add_shape(entity, scene, body.shape, body.motion.pose, kFixedColour);
  return update_json(std::move(entity));
}

std::string members_json(const sim::Scene& scene, const ExportedFrame& frame, std::uint64_t time_ns) {
  ordered_json entity = empty_entity("sub-world", time_ns);
  for (const ExportedBody& body : frame.bodies)
    add_shape(entity, scene, scene.bodies[body.id].shape, body.pose, colour_of(body.role));
  return update_json(std::move(entity));
}

}  // namespace tactus::exporting
