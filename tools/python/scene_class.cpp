// The checked scene behind tactus.Scene, whose keys Python holds.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "tactus/scene.h"
#include "tools/python/classes.h"
#include "tools/python/errors.h"

namespace py = pybind11;

namespace tactus::python {
namespace {

std::string_view name_of(Shape shape) {
  switch (shape) {
    case Shape::kSphere:
      return "sphere";
    case Shape::kCapsule:
      return "capsule";
    case Shape::kBox:
      return "box";
    case Shape::kPlane:
      return "plane";
    case Shape::kHull:
      return "hull";
    case Shape::kMesh:
      return "mesh";
    case Shape::kCompound:
      return "compound";
    case Shape::kCylinder:
      return "cylinder";
    case Shape::kCone:
      return "cone";
  }
  return "";
}

BodyNumber checked(const Scene& scene, std::int64_t number) {
  if (number < 0 || number >= static_cast<std::int64_t>(scene.bodies()))
    throw py::index_error("Scene.body: " + std::to_string(number) + " is no body; accepted: 0 to " +
                          std::to_string(scene.bodies() - 1));
  return static_cast<BodyNumber>(number);
}

py::dict body(const Scene& scene, std::int64_t index) {
  const BodyNumber number = checked(scene, index);
  const BodyInfo info = scene.body(number);
  py::dict body;
  body["name"] = scene.body_name(number);
  body["shape"] = name_of(info.shape);
  body["radius_m"] = info.radius_m;
  body["half_length_m"] = info.half_length_m;
  body["half_extents_m"] = info.half_extents_m;
  body["fixed"] = info.fixed;
  body["mass_kg"] = info.mass_kg;
  body["centre_of_mass_m"] = info.centre_of_mass_m;
  body["principal_axes"] = info.principal_axes;
  body["inertia_kg_m2"] = info.inertia_kg_m2;
  body["friction"] = info.friction;
  body["position_m"] = info.position_m;
  body["rotation"] = info.rotation;
  return body;
}

template <class Row>
py::array rows_of(const std::vector<Row>& rows) {
  using Number = typename Row::value_type;
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(rows.size()), 3};
  return py::array_t<Number>(shape, rows.empty() ? nullptr : rows.front().data());
}

py::list parts(const Scene& scene, std::int64_t index) {
  py::list list;
  for (const PartInfo& info : scene.parts(checked(scene, index))) {
    py::dict part;
    part["shape"] = name_of(info.shape);
    part["radius_m"] = info.radius_m;
    part["half_length_m"] = info.half_length_m;
    part["half_extents_m"] = info.half_extents_m;
    part["position_m"] = info.position_m;
    part["rotation"] = info.rotation;
    part["corners"] = rows_of(info.corners);
    list.append(part);
  }
  return list;
}

std::vector<BodyNumber> proxies(const Scene& scene) {
  std::vector<BodyNumber> proxies;
  for (unsigned hand = 0; hand < scene.hands(); ++hand) proxies.push_back(scene.proxy(hand));
  return proxies;
}

Scene load(const py::object& file) {
  Scene scene;
  raise_if(scene.load(path_of(file, "Scene")));
  return scene;
}

Scene parse(const std::string& text, const std::string& name) {
  Scene scene;
  raise_if(scene.parse(text, name));
  return scene;
}

}  // namespace

void add_scene(py::module_& module) {
  py::class_<Scene>(module, "CheckedScene", "A scene that the loader accepts.")
      .def_static("load", &load)
      .def_static("parse", &parse)
      .def_property_readonly("name", &Scene::name)
      .def_property_readonly("title", &Scene::title)
      .def_property_readonly("text", &Scene::text)
      .def_property_readonly("warnings", &Scene::warnings)
      .def_property_readonly("bodies", &Scene::bodies)
      .def_property_readonly("proxy", [](const Scene& scene) { return scene.proxy(); })
      .def_property_readonly("proxies", &proxies)
      .def_property_readonly("hand_duration_s", [](const Scene& scene) { return scene.hand_duration_s(); })
      .def("body", &body, py::arg("number"))
      .def("parts", &parts, py::arg("number"))
      .def(
          "corners",
          [](const Scene& scene, std::int64_t number) { return rows_of(scene.corners(checked(scene, number))); },
          py::arg("number"))
      .def(
          "triangles",
          [](const Scene& scene, std::int64_t number) { return rows_of(scene.triangles(checked(scene, number))); },
          py::arg("number"));
}

}  // namespace tactus::python
