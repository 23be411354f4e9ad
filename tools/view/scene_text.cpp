#include "tools/view/scene_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sim/loader/body_label.h"
#include "sim/model/choice_names.h"
#include "tools/json_text.h"
#include "tools/session/session.h"
#include "tools/view/wire.h"

namespace tactus::view {
namespace {

using nlohmann::ordered_json;

ordered_json list_of(const Vec3d& v) { return {v.x, v.y, v.z}; }
ordered_json list_of(const Quatd& q) { return {q.w, q.x, q.y, q.z}; }

ordered_json hull_json(const physics::Hull& hull) {
  ordered_json points = ordered_json::array(), triangles = ordered_json::array();
  for (std::uint32_t i = 0; i < hull.topology.vertices; ++i)
    for (const double number : {hull.x[i], hull.y[i], hull.z[i]}) points.push_back(number);
  for (std::uint32_t face = 0; face < hull.topology.faces; ++face) {
    const auto loop = hull.topology.loop(face);
    for (std::size_t k = 2; k < loop.size(); ++k)
      for (const std::uint8_t corner : {loop[0], loop[k - 1], loop[k]}) triangles.push_back(corner);
  }
  return {{"kind", "mesh"}, {"points", points}, {"triangles", triangles}};
}

ordered_json mesh_json(const physics::Mesh& mesh) {
  ordered_json points = ordered_json::array(), triangles = ordered_json::array();
  for (const Vec3d& corner : mesh.corners)
    for (const double number : {corner.x, corner.y, corner.z}) points.push_back(number);
  for (const physics::MeshTriangle& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle.corner) triangles.push_back(corner);
  return {{"kind", "mesh"}, {"points", points}, {"triangles", triangles}};
}

ordered_json shape_json(const sim::Scene& scene, const physics::Shape& shape) {
  switch (shape.kind) {
    case physics::ShapeKind::kSphere:
      return {{"kind", "sphere"}, {"radius", shape.radius}};
    case physics::ShapeKind::kCapsule:
      return {{"kind", "capsule"}, {"radius", shape.radius}, {"half_length", shape.half_length}};
    case physics::ShapeKind::kCylinder:
      return {{"kind", "cylinder"}, {"radius", shape.radius}, {"half_length", shape.half_length}};
    case physics::ShapeKind::kCone:
      return {{"kind", "cone"}, {"radius", shape.radius}, {"half_length", shape.half_length}};
    case physics::ShapeKind::kBox:
      return {{"kind", "box"}, {"half", list_of(shape.half_extents)}};
    case physics::ShapeKind::kPlane:
      return {{"kind", "plane"}};
    case physics::ShapeKind::kHull:
      return hull_json(scene.hulls[shape.index]);
    case physics::ShapeKind::kMesh:
      return mesh_json(scene.meshes[shape.index]);
    case physics::ShapeKind::kCompound: {
      ordered_json parts = ordered_json::array();
      for (const physics::CompoundPart& part : scene.compounds[shape.index].parts)
        parts.push_back({{"shape", shape_json(scene, part.shape)},
                         {"position", list_of(part.body_from_part.position)},
                         {"rotation", list_of(part.body_from_part.rotation)}});
      return {{"kind", "compound"}, {"parts", parts}};
    }
  }
  return {};
}

// Distance that the proxy may move before the next members are adopted [m]; with the proxy's own size it is half the
// side of the boundary cube. 0: there is no boundary cube.
double reach_of(const sim::Scene& scene, const session::RunOptions& options) {
  const haptics::CouplingTraits traits = haptics::traits_of(options.coupling);
  if (!traits.global_world || traits.proxy_alone() || !options.taped_device) return 0;
  const sim::ReachSettings reach = session::global_options(scene, options, *options.taped_device).reach;
  return sim::reach_of_proxy_m(reach, physics::bounding_radius(scene.bodies[scene.proxy].shape));
}

}  // namespace

std::string scene_text(const sim::Scene& scene, const session::TapeSettings& settings) {
  ordered_json shapes = ordered_json::array(), bodies = ordered_json::array(), channels = ordered_json::array();
  std::vector<physics::Shape> known;
  for (const physics::Body& body : scene.bodies) {
    auto at = std::find(known.begin(), known.end(), body.shape);
    if (at == known.end()) {
      shapes.push_back(shape_json(scene, body.shape));
      at = known.insert(known.end(), body.shape);
    }
    bodies.push_back(ordered_json{{"shape", at - known.begin()},
                                  {"fixed", body.kind == physics::BodyKind::kFixed},
                                  {"position", list_of(body.motion.pose.position)},
                                  {"rotation", list_of(body.motion.pose.rotation)},
                                  {"label", sim::body_label(scene, body.id)}});
  }
  ordered_json other_proxies = ordered_json::array();
  for (unsigned hand = 1; hand < scene.hands(); ++hand) other_proxies.push_back(scene.more_hands[hand - 1].proxy);
  for (const Channel& channel : kChannels) channels.push_back({{"name", channel.name}, {"unit", channel.unit}});
  const session::RunOptions& o = settings.options;
  const std::string title =
      o.hands == 1
          ? scene.title
          : fmt::format("{}: hand {} of {}", scene.title.empty() ? scene.name : scene.title, o.hand + 1, o.hands);
  return json_text(ordered_json{{"kind", "scene"},
                                {"wire", kWireVersion},
                                {"name", scene.name},
                                {"title", title},
                                {"made_by", settings.made_by},
                                {"device", o.device},
                                {"coupling", sim::name_of(o.coupling)},
                                {"border", sim::name_of(o.border)},
                                {"ratio", o.ratio != 0 ? o.ratio : scene.ratio},
                                {"period_s", o.period_s()},
                                {"virtual_time", o.virtual_time},
                                {"members_cap", o.members != 0 ? o.members : scene.members},
                                {"proxy", scene.proxy},
                                {"other_proxies", other_proxies},
                                {"reach_m", reach_of(scene, o)},
                                {"channels", channels},
                                {"shapes", shapes},
                                {"bodies", bodies}});
}

}  // namespace tactus::view
