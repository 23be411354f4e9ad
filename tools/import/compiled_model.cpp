#include "tools/import/compiled_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "rt/base/rotation_axes.h"
#include "sim/geometry/mesh_builder.h"
#include "tools/import/limited_process.h"

namespace tactus::scene_import {
namespace {

using nlohmann::json;

constexpr const char* kHeap = "--max-old-space-size=1024";  // MB, of JavaScript; that of WebAssembly is the limits'

Vec3d vector_of(const json& list) { return {list.at(0), list.at(1), list.at(2)}; }

// Rows of the rotation matrix.
Quatd rotation_of(const json& m) {
  return quat_from_axes({m.at(0), m.at(3), m.at(6)}, {m.at(1), m.at(4), m.at(7)}, {m.at(2), m.at(5), m.at(8)});
}

template <class T>
T placed(const json& object) {
  T thing;
  thing.name = object.at("name");
  thing.file = object.at("file");
  thing.line = object.at("line");
  return thing;
}

ModelBody body_of(const json& object) {
  auto body = placed<ModelBody>(object);
  body.parent = object.at("parent");
  body.weld = object.at("weld");
  body.mocap = object.at("mocap");
  body.explicit_inertia = object.at("explicit_inertia");
  body.pose = {vector_of(object.at("position")), rotation_of(object.at("frame"))};
  body.mass = principal_mass(object.at("mass"), vector_of(object.at("centre")), rotation_of(object.at("axes")),
                             vector_of(object.at("inertia")));
  body.velocity = {vector_of(object.at("velocity")), vector_of(object.at("angular_velocity"))};
  return body;
}

ModelGeom geom_of(const json& object) {
  auto geom = placed<ModelGeom>(object);
  geom.body = object.at("body");
  geom.type = object.at("type");
  geom.size = vector_of(object.at("size"));
  geom.pose = {vector_of(object.at("position")), rotation_of(object.at("axes"))};
  geom.touches = object.at("contype") != 0 || object.at("conaffinity") != 0;
  geom.condim = object.at("condim");
  geom.friction = vector_of(object.at("friction"));
  geom.mesh = object.at("mesh");
  geom.field = object.at("field");
  return geom;
}

ModelJoint joint_of(const json& object) {
  auto joint = placed<ModelJoint>(object);
  joint.type = object.at("type");
  joint.body = object.at("body");
  joint.parent = object.at("parent");
  joint.anchor = vector_of(object.at("anchor"));
  joint.axis = vector_of(object.at("axis"));
  joint.limited = object.at("limited");
  joint.low = object.at("range").at(0);
  joint.high = object.at("range").at(1);
  joint.coordinate = object.at("coordinate");
  return joint;
}

ModelEquality equality_of(const json& object) {
  auto equality = placed<ModelEquality>(object);
  equality.type = object.at("type");
  equality.active = object.at("active");
  equality.body_a = object.at("body_a");
  equality.body_b = object.at("body_b");
  equality.anchor = vector_of(object.at("anchor"));
  equality.error = object.at("error");
  return equality;
}

ModelMesh mesh_of(const json& object) {
  auto mesh = placed<ModelMesh>(object);
  const auto corners = object.at("corners").get<std::vector<double>>();
  const auto triangles = object.at("triangles").get<std::vector<std::uint32_t>>();
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    mesh.soup.corners.push_back({corners[i], corners[i + 1], corners[i + 2]});
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
    mesh.soup.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
  return mesh;
}

HeightField field_of(const json& object) {
  const auto& size = object.at("size");
  return {.name = object.at("name"),
          .rows = object.at("rows"),
          .columns = object.at("columns"),
          .half_x = size.at(0),
          .half_y = size.at(1),
          .height = size.at(2),
          .heights = object.at("heights")};
}

template <class T>
void read_list(const json& model, const char* key, T (*read)(const json&), std::vector<T>& list) {
  for (const json& object : model.at(key)) list.push_back(read(object));
}

CompiledModel model_of(const json& object) {
  CompiledModel model;
  model.urdf = object.at("urdf");
  model.name = object.at("name");
  read_list(object, "bodies", body_of, model.bodies);
  read_list(object, "geoms", geom_of, model.geoms);
  read_list(object, "joints", joint_of, model.joints);
  read_list(object, "equalities", equality_of, model.equalities);
  read_list(object, "meshes", mesh_of, model.meshes);
  read_list(object, "fields", field_of, model.fields);
  for (const json& pair : object.at("excluded")) model.excluded.emplace_back(pair.at(0), pair.at(1));
  model.gravity = vector_of(object.at("gravity"));
  model.parents_filtered = object.at("parents_filtered");
  model.limits = object.at("limits");
  model.equality_rows = object.at("equality_rows");
  return model;
}

// True if every index refers to an existing element. The answer comes from another process and is not trusted.
bool is_whole(const CompiledModel& model) {
  const auto in = [](auto index, std::size_t count) { return index >= 0 && static_cast<std::size_t>(index) < count; };
  const auto is_body = [&](int index) { return in(index, model.bodies.size()); };
  const auto geom_is_whole = [&](const ModelGeom& geom) {
    return is_body(geom.body) && (geom.type != "mesh" || in(geom.mesh, model.meshes.size())) &&
           (geom.type != "hfield" || in(geom.field, model.fields.size()));
  };
  const auto mesh_is_whole = [](const ModelMesh& mesh) {
    return std::ranges::all_of(mesh.soup.triangles, [&](const auto& triangle) {
      return std::ranges::all_of(triangle, [&](std::uint32_t corner) { return corner < mesh.soup.corners.size(); });
    });
  };
  const auto field_is_whole = [](const HeightField& field) {
    return field.rows >= 2 && field.columns >= 2 && field.heights.size() / field.rows == field.columns &&
           field.heights.size() % field.rows == 0;
  };
  const auto equality_is_whole = [&](const ModelEquality& equality) {
    return (equality.type != "connect" && equality.type != "weld") ||
           (is_body(equality.body_a) && is_body(equality.body_b));
  };
  using std::ranges::all_of;
  return all_of(model.bodies, [&](const ModelBody& b) { return is_body(b.parent) && is_body(b.weld); }) &&
         all_of(model.geoms, geom_is_whole) && all_of(model.meshes, mesh_is_whole) &&
         all_of(model.fields, field_is_whole) &&
         all_of(model.joints, [&](const ModelJoint& j) { return is_body(j.body) && is_body(j.parent); }) &&
         all_of(model.equalities, equality_is_whole) &&
         all_of(model.excluded, [&](const auto& pair) { return is_body(pair.first) && is_body(pair.second); });
}

void read_account(const json& answer, Account& account) {
  for (const json& r : answer.at("refused"))
    account.refuse({.kind = r.at("kind"),
                    .file = r.at("file"),
                    .line = r.at("line"),
                    .what = r.at("what"),
                    .accepted = r.at("cure")});
  for (const json& text : answer.at("left_out")) account.left_out.push_back(text);
}

}  // namespace

Result<CompiledModel> compile_model(const std::filesystem::path& program, const std::filesystem::path& file,
                                    const Limits& limits, Account& account) {
  auto text = run_program({"node", kHeap, program.string(), file.string()}, limits);
  if (!text.ok()) return Status::error(fmt::format("{}: {}", file.filename().string(), text.message()));
  try {
    const json answer = json::parse(text.value());
    read_account(answer, account);
    if (answer.contains("mistake")) return Status::error(answer.at("mistake").get<std::string>());
    if (answer.contains("error"))
      return Status::error(fmt::format("{}: MuJoCo: {}; accepted: a model that MuJoCo compiles",
                                       file.filename().string(), answer.at("error").get<std::string>()));
    CompiledModel model = model_of(answer.at("model"));
    if (is_whole(model)) {
      for (ModelMesh& mesh : model.meshes) mesh.soup = sim::weld(mesh.soup);
      return model;
    }
  } catch (const json::exception&) {
    // reported below, as for an incomplete model
  }
  return Status::error(
      fmt::format("{}: the compiler gives no model; accepted: a model that MuJoCo compiles", file.filename().string()));
}

}  // namespace tactus::scene_import
