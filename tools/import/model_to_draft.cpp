#include "tools/import/model_to_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "rt/physics/shapes/shape.h"
#include "tools/import/pieces.h"
#include "tools/import/rigid_group.h"

namespace tactus::scene_import {
namespace {

constexpr double kLargestStartError = 1e-3;  // m, rad: of a loop that is closed by an equality
constexpr double kLargestFriction = 10;      // what a scene accepts
constexpr double kNeverReached_m = 1000;     // a distance joint that does nothing but keep its bodies from colliding
constexpr std::size_t kMaxFixedTriangles = 20'000;

std::string label(const Place& place, const char* what, std::size_t number) {
  return place.name.empty() ? fmt::format("{} {}", what, number) : fmt::format("{} \"{}\"", what, place.name);
}

class Translator {
 public:
  Translator(const CompiledModel& model, const PieceOptions& pieces, Account& account)
      : model_(model), options_(pieces), account_(account) {}

  SceneDraft translate() {
    draft_.title = model_.name;
    draft_.gravity = model_.gravity;
    for (std::size_t g = 0; g < model_.geoms.size(); ++g) sort_in(g);
    for (std::size_t b = 1; b < model_.bodies.size(); ++b)
      if (model_.bodies[b].weld == static_cast<int>(b)) add_group(static_cast<int>(b));
    add_fixed();
    for (std::size_t j = 0; j < model_.joints.size(); ++j) add_joint(j);
    if (model_.equality_rows)
      for (std::size_t e = 0; e < model_.equalities.size(); ++e) add_equality(e);
    tell_counts();
    tell_friction();
    return std::move(draft_);
  }

 private:
  void refuse(const Place& place, const char* kind, std::string what, std::string accepted) {
    account_.refuse({kind, place.file, place.line, std::move(what), std::move(accepted)});
  }

  std::string geom_label(std::size_t g) const {
    const ModelGeom& geom = model_.geoms[g];
    if (!geom.name.empty()) return fmt::format("geom \"{}\"", geom.name);
    return fmt::format("the {} of {}", geom.type,
                       label(body_at(geom.body), "body", static_cast<std::size_t>(geom.body)));
  }

  int group_of(int body) const { return model_.bodies[static_cast<std::size_t>(body)].weld; }

  void sort_in(std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    if (geom.touches) {
      touching_[group_of(geom.body)].push_back(g);
      frictions_.insert(geom.condim == 1 ? 0 : geom.friction.x);
    } else {
      ++visual_;
    }
  }

  std::string unique_name(const std::string& wanted) {
    std::string name = wanted.empty() ? "body" : wanted.substr(0, 90);
    if (names_.insert(name).second) return name;
    for (unsigned n = 2;; ++n)
      if (names_.insert(fmt::format("{}_{}", name, n)).second) return fmt::format("{}_{}", name, n);
  }

  // --- shapes

  // The shape, pose and surface of a geom; several bodies for a mesh in pieces. Refusals and changes are said.
  std::vector<DraftBody> shapes_of(std::size_t g, bool fixed) {
    const ModelGeom& geom = model_.geoms[g];
    DraftBody body;
    body.pose = geom.pose;
    body.origin = fmt::format("{}{}", geom_label(g), geom.line > 0 ? fmt::format(", line {}", geom.line) : "");
    set_surface(geom, g, body);
    if (geom.type == "sphere") {
      body.shape = DraftShape::kSphere;
      body.size = {geom.size.x, 0, 0};
    } else if (geom.type == "capsule") {
      body.shape = DraftShape::kCapsule;
      body.size = {geom.size.x, geom.size.y, 0};
    } else if (geom.type == "box") {
      body.shape = DraftShape::kBox;
      body.size = geom.size;
    } else if (geom.type == "cylinder") {
      set_hull(cylinder_hull(geom.size.x, geom.size.y), geom, g, "a prism of 32 sides", body);
    } else if (geom.type == "ellipsoid") {
      set_hull(ellipsoid_hull(geom.size), geom, g, "a hull of 62 vertices", body);
    } else if (geom.type == "plane" && fixed) {
      body.shape = DraftShape::kPlane;
    } else if (geom.type == "mesh") {
      return mesh_shapes(std::move(body), g, fixed);
    } else if (geom.type == "hfield" && fixed) {
      return field_shape(std::move(body), g);
    } else {
      refuse(geom, "", fmt::format("{} is a {} that moves", geom_label(g), geom.type),
             "planes and height fields of the world; a box that moves");
      return {};
    }
    return {std::move(body)};
  }

  void set_surface(const ModelGeom& geom, std::size_t g, DraftBody& body) {
    body.friction = geom.condim == 1 ? 0 : geom.friction.x;
    if (body.friction > kLargestFriction) {
      account_.change(fmt::format("{}: friction {} is {} here", geom_label(g), body.friction, kLargestFriction));
      body.friction = kLargestFriction;
    }
    // There: the largest torque over N, a length. Here: that of a disk, 2/3 mu R.
    if (geom.condim >= 4 && body.friction > 0) body.contact_radius_m = 1.5 * geom.friction.y / body.friction;
    if (geom.condim >= 6) body.rolling_friction_m = geom.friction.z;
  }

  void set_hull(HullPoints hull, const ModelGeom& geom, std::size_t g, const char* what, DraftBody& body) {
    body.shape = DraftShape::kHull;
    body.points = std::move(hull.points);
    account_.change(fmt::format("{}: the {} is {}, at most {:.3g} mm from its surface", geom_label(g), geom.type, what,
                                1e3 * hull.deviation_m));
  }

  std::vector<DraftBody> mesh_shapes(DraftBody body, std::size_t g, bool fixed) {
    const ModelGeom& geom = model_.geoms[g];
    const ModelMesh& mesh = model_.meshes[static_cast<std::size_t>(geom.mesh)];
    if (fixed) {
      if (mesh.soup.triangles.size() > kMaxFixedTriangles) {
        refuse(geom, "", fmt::format("{} has {} triangles", geom_label(g), mesh.soup.triangles.size()),
               fmt::format("a mesh of at most {} triangles: make it coarser", kMaxFixedTriangles));
        return {};
      }
      body.shape = DraftShape::kMesh;
      body.mesh = mesh.soup;
      account_.change(fmt::format("{}: a fixed mesh is its own surface here, not the convex hull that MuJoCo takes",
                                  geom_label(g)));
      return {std::move(body)};
    }
    auto hull = hull_of(mesh.soup.corners);
    if (!hull.ok()) {
      refuse(geom, "", fmt::format("{}: {}", geom_label(g), hull.message()), "a solid");
      return {};
    }
    if (hull.value().deviation_m > 0)
      account_.change(fmt::format("{}: its hull is thinned to {} vertices, at most {:.3g} mm from it", geom_label(g),
                                  hull.value().points.size(), 1e3 * hull.value().deviation_m));
    body.shape = DraftShape::kHull;
    const auto gap = hull_gap(mesh.soup, hull.value());
    const bool concave = gap.ok() && gap.value() > hull.value().deviation_m + 1e-4;
    if (concave && options_.most > 1) return in_pieces(std::move(body), g, mesh);
    if (concave)
      account_.change(
          fmt::format("{}: concave; its convex hull is taken, as MuJoCo takes it, with gaps of up to {:.3g} mm; "
                      "--pieces N divides it",
                      geom_label(g), 1e3 * gap.value()));
    body.points = std::move(hull.value().points);
    return {std::move(body)};
  }

  std::vector<DraftBody> in_pieces(DraftBody body, std::size_t g, const ModelMesh& mesh) {
    const ModelGeom& geom = model_.geoms[g];
    auto pieces = decompose(mesh.soup, options_.most, options_.deviation_m);
    if (!pieces.ok()) {
      refuse(geom, "", fmt::format("{}: {}", geom_label(g), pieces.message()),
             "more --pieces, a larger --deviation, or a model that is divided already");
      return {};
    }
    account_.change(fmt::format("{}: divided into {} convex pieces, at most {:.3g} mm from its surface", geom_label(g),
                                pieces.value().hulls.size(), 1e3 * pieces.value().deviation_m));
    std::vector<DraftBody> out;
    for (HullPoints& hull : pieces.value().hulls) {
      out.push_back(body);
      out.back().points = std::move(hull.points);
    }
    return out;
  }

  // The upper surface, triangles as MuJoCo's prisms have them.
  std::vector<DraftBody> field_shape(DraftBody body, std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    const HeightField& field = model_.fields[static_cast<std::size_t>(geom.field)];
    const bool is_surface = field.rows > 1 && field.columns > 1;
    const std::size_t triangles = is_surface ? std::size_t{2} * (field.rows - 1) * (field.columns - 1) : 0;
    if (!is_surface || triangles > kMaxFixedTriangles) {
      refuse(geom, "", fmt::format("{} is a height field of {} triangles", geom_label(g), triangles),
             fmt::format("2 to {}: make it coarser", kMaxFixedTriangles));
      return {};
    }
    body.shape = DraftShape::kMesh;
    for (unsigned r = 0; r < field.rows; ++r)
      for (unsigned c = 0; c < field.columns; ++c)
        body.mesh.corners.push_back({field.half_x * (2.0 * c / (field.columns - 1) - 1),
                                     field.half_y * (2.0 * r / (field.rows - 1) - 1),
                                     field.height * field.heights[r * field.columns + c]});
    for (unsigned r = 0; r + 1 < field.rows; ++r)
      for (unsigned c = 0; c + 1 < field.columns; ++c) {
        const std::uint32_t at = r * field.columns + c, above = at + field.columns;
        body.mesh.triangles.push_back({at, at + 1, above + 1});
        body.mesh.triangles.push_back({at, above + 1, above});
      }
    account_.left_out.push_back(fmt::format("the base and the sides of {}", geom_label(g)));
    return {std::move(body)};
  }

  // --- bodies

  void add_fixed() {
    for (const std::size_t g : touching_[0])
      for (DraftBody& body : shapes_of(g, true)) {
        const ModelGeom& geom = model_.geoms[g];
        body.role = DraftRole::kFixed;
        body.name = unique_name(!geom.name.empty() ? geom.name : geom.body > 0 ? body_at(geom.body).name : "fixed");
        draft_.bodies.push_back(std::move(body));
      }
  }

  const ModelBody& body_at(int index) const { return model_.bodies[static_cast<std::size_t>(index)]; }

  void add_group(int group) {
    const ModelBody& head = body_at(group);
    RigidGroup made;
    made.kinematic = head.mocap;
    made.label = label(head, "body", static_cast<std::size_t>(group));
    bool explicit_inertia = true;
    for (const ModelBody& body : model_.bodies)
      if (body.weld == group) {
        made.whole = made.whole + body.mass;
        explicit_inertia = explicit_inertia && (body.explicit_inertia || body.mass.mass == 0);
      }
    bool complete = true;
    for (const std::size_t g : touching_[group]) {
      if (!explicit_inertia) complete = check_closed(g) && complete;
      auto shapes = shapes_of(g, false);
      complete = complete && !shapes.empty();
      for (DraftBody& shape : shapes) {
        shape.name = unique_name(head.name.empty() ? fmt::format("body_{}", group) : head.name);
        made.parts.push_back({std::move(shape), weight_of(model_.geoms[g], shapes.size())});
      }
    }
    if (made.parts.empty() && complete) {
      refuse(head, "shapeless", fmt::format("{} has no shape that touches", made.label),
             "a shape of its own, or one body with what it is attached to");
      return;
    }
    if (!complete) return;
    if (const std::string problem = made.settle(account_); !problem.empty()) {
      refuse(head, "", fmt::format("{}: {}", made.label, problem), "an <inertial> that fits the shapes");
      return;
    }
    made.set_velocity(head.velocity, head.mass.centre);
    made.add_to(draft_, collision_guards_);
    groups_[group] = made.names();
  }

  // Mass by the file's mass, else by density and volume; for the share of the group's mass alone.
  double weight_of(const ModelGeom& geom, std::size_t pieces) const {
    if (geom.mass > 0) return geom.mass / static_cast<double>(pieces);
    return -geom.density;  // of its volume, which the group knows
  }

  bool check_closed(std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    if (geom.type != "mesh") return true;
    const std::size_t open = open_edges(model_.meshes[static_cast<std::size_t>(geom.mesh)].soup);
    if (open == 0) return true;
    refuse(geom, "",
           fmt::format("{}: its mesh is open at {} edges, and its mass comes from its volume", geom_label(g), open),
           "a closed surface, or an <inertial> of the body");
    return false;
  }

  // --- joints

  bool collide(int a, int b, bool otherwise) const {
    const auto same = [&](const std::pair<int, int>& pair) {
      const int p = group_of(pair.first), q = group_of(pair.second);
      return (p == a && q == b) || (p == b && q == a);
    };
    if (std::any_of(model_.excluded.begin(), model_.excluded.end(), same)) return false;
    return otherwise;
  }

  // The body that stands for a group in joints; empty: the world. False where the group was refused.
  bool end_of(int group, std::string& name) const {
    name.clear();
    if (group == 0) return true;
    const auto found = groups_.find(group);
    if (found == groups_.end()) return false;
    name = found->second.front();
    return true;
  }

  void add_joint(std::size_t j) {
    const ModelJoint& joint = model_.joints[j];
    if (joint.type == "free") return;
    DraftJoint out;
    const int a = group_of(joint.parent), b = group_of(joint.body);
    if (!end_of(a, out.a) || !end_of(b, out.b)) return;
    out.kind = joint.type == "slide" ? "slider" : joint.type;
    out.origin =
        fmt::format("{}{}", label(joint, "joint", j), joint.line > 0 ? fmt::format(", line {}", joint.line) : "");
    out.position = joint.anchor;
    if (joint.type != "ball") out.axis = joint.axis;
    out.bodies_collide = collide(a, b, !model_.parents_filtered || a == 0);
    if (joint.limited && joint.type != "ball" && model_.limits && !set_limits(joint, j, out)) return;
    const bool guarded = !out.bodies_collide && a != 0;
    draft_.joints.push_back(std::move(out));
    ++joints_[joint.type];
    if (guarded) guard(a, b);
  }

  bool set_limits(const ModelJoint& joint, std::size_t j, DraftJoint& out) {
    out.low = joint.low - joint.coordinate;
    out.high = joint.high - joint.coordinate;
    if (joint.type != "hinge") return true;
    constexpr double pi = std::numbers::pi;
    if (*out.low >= -pi && *out.high <= pi) return true;
    if (*out.low <= -pi && *out.high >= pi) {
      out.low.reset();
      out.high.reset();
      account_.change(
          fmt::format("{}: its limits are a turn apart or more, and it turns freely", label(joint, "joint", j)));
      return true;
    }
    refuse(joint, "limits",
           fmt::format("{} has limits {:.4g} and {:.4g} rad from its start", label(joint, "joint", j), *out.low,
                       *out.high),
           "limits within half a turn of the start: begin nearer to their middle, by a keyframe");
    return false;
  }

  // The other pairs of two groups' bodies, which do not collide either.
  void guard(int a, int b) {
    const auto& as = groups_.at(a);
    const auto& bs = groups_.at(b);
    for (std::size_t i = 0; i < as.size(); ++i)
      for (std::size_t k = 0; k < bs.size(); ++k)
        if (i + k > 0) add_guard(as[i], bs[k]);
  }

  void add_guard(const std::string& a, const std::string& b) {
    DraftJoint rope;
    rope.kind = "distance";
    rope.a = a;
    rope.b = b;
    rope.origin = "keeps them from colliding, nothing else";
    rope.low = 0;
    rope.high = kNeverReached_m;
    draft_.joints.push_back(std::move(rope));
    ++collision_guards_;
  }

  void add_equality(std::size_t e) {
    const ModelEquality& equality = model_.equalities[e];
    if (!equality.active || equality.body_a < 0) return;
    int a = group_of(equality.body_a), b = group_of(equality.body_b);
    if (a == b) return;
    if (b == 0 || body_at(b).mocap) std::swap(a, b);  // b is the one that moves
    if (b == 0 || body_at(b).mocap) return;
    DraftJoint out;
    if (!end_of(a, out.a) || !end_of(b, out.b)) return;
    const std::string name = label(equality, equality.type.c_str(), e);
    if (equality.error > kLargestStartError) {
      refuse(equality, "",
             fmt::format("{} is {:.3g} m or rad from what it asks for at the start", name, equality.error),
             "a start that satisfies it: the joints' ref, or a keyframe");
      return;
    }
    if (equality.error > 1e-9)
      account_.change(
          fmt::format("{}: holds what the start has, {:.3g} m or rad from what it asks for", name, equality.error));
    out.kind = equality.type == "weld" ? "fixed" : "ball";
    out.position = equality.anchor;
    out.origin = name;
    const bool filtered = is_parent(a, b) || is_parent(b, a);
    out.bodies_collide = collide(a, b, !filtered);
    draft_.joints.push_back(std::move(out));
    ++joints_[equality.type];
  }

  bool is_parent(int a, int b) const { return model_.parents_filtered && a != 0 && group_of(body_at(b).parent) == a; }

  // --- what is said

  void tell_counts() {
    std::map<std::string, unsigned> shapes;
    for (const ModelGeom& geom : model_.geoms)
      if (geom.touches) ++shapes[geom.type];
    for (const auto& [type, count] : shapes) account_.taken_over.push_back(fmt::format("{}: {}", type, count));
    for (const auto& [type, count] : joints_) account_.taken_over.push_back(fmt::format("{}: {}", type, count));
    if (visual_ > 0) account_.left_out.push_back(fmt::format("shapes that touch nothing (visual): {}", visual_));
    if (collision_guards_ > 0)
      account_.change(fmt::format("{} pairs of bodies are kept from colliding by distance joints that do nothing else",
                                  collision_guards_));
  }

  void tell_friction() {
    if (frictions_.size() < 2) return;
    const double low = *frictions_.begin(), high = *frictions_.rbegin();
    account_.change(
        fmt::format("friction of a pair is the larger one there and the geometric mean here: {:.4g} between "
                    "{:.4g} and {:.4g}, not {:.4g}",
                    std::sqrt(low * high), low, high, high));
  }

  const CompiledModel& model_;
  const PieceOptions& options_;
  Account& account_;
  SceneDraft draft_;
  std::map<int, std::vector<std::size_t>> touching_;  // by group
  std::map<int, std::vector<std::string>> groups_;    // the names of its bodies, the heaviest first
  std::map<std::string, unsigned> joints_;
  std::set<std::string> names_{"proxy"};
  std::set<double> frictions_;
  unsigned visual_{0}, collision_guards_{0};
};

}  // namespace

SceneDraft draft_of(const CompiledModel& model, const PieceOptions& pieces, Account& account) {
  return Translator(model, pieces, account).translate();
}

}  // namespace tactus::scene_import
