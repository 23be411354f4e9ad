#include "tools/import/model_to_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>

#include "rt/base/ids.h"
#include "tools/import/body_mass.h"

namespace tactus::scene_import {
namespace {

constexpr double kLargestStartError = 1e-3;  // m, rad: of a loop that is closed by an equality
constexpr double kLargestFriction = 10;      // what a scene accepts

std::string label(const Place& place, const char* what, std::size_t number) {
  return place.name.empty() ? fmt::format("{} {}", what, number) : fmt::format("{} \"{}\"", what, place.name);
}

std::string with_line(const std::string& text, const Place& place) {
  return place.line > 0 ? fmt::format("{}, line {}", text, place.line) : text;
}

// Sliding [1], torsional [m] and rolling friction [m]; 0 for those that the geom's condim leaves out.
Vec3d friction_of(const ModelGeom& geom) {
  return {geom.condim == 1 ? 0 : geom.friction.x, geom.condim >= 4 ? geom.friction.y : 0,
          geom.condim >= 6 ? geom.friction.z : 0};
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
    account_.refuse({.kind = kind,
                     .file = place.file,
                     .line = place.line,
                     .what = std::move(what),
                     .accepted = std::move(accepted)});
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
    if (geom.touches)
      touching_[group_of(geom.body)].push_back(g);
    else
      ++visual_;
  }

  // --- shapes

  // The shape of a geom, several of a mesh in pieces; its pose is in the world. Refusals and changes are said.
  std::vector<DraftPart> parts_of(std::size_t g, bool fixed) {
    const ModelGeom& geom = model_.geoms[g];
    DraftPart part;
    part.pose = geom.pose;
    part.origin = with_line(geom_label(g), geom);
    if (geom.type == "sphere") {
      part.shape = DraftShape::kSphere;
      part.size = {geom.size.x, 0, 0};
    } else if (geom.type == "capsule") {
      part.shape = DraftShape::kCapsule;
      part.size = {geom.size.x, geom.size.y, 0};
    } else if (geom.type == "box") {
      part.shape = DraftShape::kBox;
      part.size = geom.size;
    } else if (geom.type == "cylinder") {
      part.shape = DraftShape::kCylinder;
      part.size = {geom.size.x, geom.size.y, 0};
    } else if (geom.type == "ellipsoid") {
      HullPoints hull = ellipsoid_hull(geom.size);
      account_.change(fmt::format("{}: the ellipsoid is a hull of 62 vertices, at most {:.3g} mm from its surface",
                                  geom_label(g), 1e3 * hull.deviation_m));
      part.shape = DraftShape::kHull;
      part.points = std::move(hull.points);
    } else if (geom.type == "plane" && fixed) {
      part.shape = DraftShape::kPlane;
    } else if (geom.type == "mesh") {
      return fixed ? fixed_mesh(std::move(part), g) : moving_mesh(part, g);
    } else if (geom.type == "hfield" && fixed) {
      return field_part(std::move(part), g);
    } else {
      refuse(geom, "", fmt::format("{} is a {} that moves", geom_label(g), geom.type),
             "planes and height fields of the world; a box that moves");
      return {};
    }
    return {std::move(part)};
  }

  // The largest friction of each kind among the geoms, as MuJoCo's pair takes the larger; says so where they differ.
  void set_friction(const std::vector<std::size_t>& geoms, const std::string& name, DraftBody& body) {
    Vec3d least = friction_of(model_.geoms[geoms.front()]), most = least;
    for (const std::size_t g : geoms)
      for (int k = 0; k < 3; ++k) {
        least[k] = std::min(least[k], friction_of(model_.geoms[g])[k]);
        most[k] = std::max(most[k], friction_of(model_.geoms[g])[k]);
      }
    const char* const kinds[] = {"sliding", "torsional [m]", "rolling [m]"};
    std::string differ;
    for (int k = 0; k < 3; ++k)
      if (least[k] != most[k])
        differ += fmt::format("{}{} {:.4g} to {:.4g}", differ.empty() ? "" : ", ", kinds[k], least[k], most[k]);
    if (!differ.empty())
      account_.change(
          fmt::format("{}: its shapes have friction of their own, the compound the largest: {}", name, differ));
    body.friction = most.x;
    if (body.friction > kLargestFriction) {
      account_.change(fmt::format("{}: friction {} is {} here", name, body.friction, kLargestFriction));
      body.friction = kLargestFriction;
    }
    // Torsional friction y [m]. MuJoCo: torque <= y N. A scene's contact disk of radius R: torque <= 2/3 mu R N.
    if (body.friction > 0) body.contact_radius_m = 1.5 * most.y / body.friction;
    body.rolling_friction_m = most.z;
  }

  std::vector<DraftPart> fixed_mesh(DraftPart part, std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    const sim::TriangleSoup& soup = soup_of(geom);
    if (soup.triangles.size() > kMaxFixedTriangles) {
      refuse(geom, "", fmt::format("{} has {} triangles", geom_label(g), soup.triangles.size()),
             fmt::format("a mesh of at most {} triangles: make it coarser", kMaxFixedTriangles));
      return {};
    }
    part.shape = DraftShape::kMesh;
    part.mesh = soup;
    part.rounding = kSingleRounding;
    account_.change(
        fmt::format("{}: a fixed mesh is its own surface here, not the convex hull that MuJoCo takes", geom_label(g)));
    return {std::move(part)};
  }

  std::vector<DraftPart> moving_mesh(const DraftPart& part, std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    return mesh_parts(soup_of(geom), options_, part, geom_label(g),
                      {.kind = "", .file = geom.file, .line = geom.line, .what = "", .accepted = ""}, account_);
  }

  const sim::TriangleSoup& soup_of(const ModelGeom& geom) const {
    return model_.meshes[static_cast<std::size_t>(geom.mesh)].soup;
  }

  // The upper surface, triangles as MuJoCo's prisms have them.
  std::vector<DraftPart> field_part(DraftPart part, std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    const HeightField& field = model_.fields[static_cast<std::size_t>(geom.field)];
    const bool is_surface = field.rows > 1 && field.columns > 1;
    const std::size_t triangles = is_surface ? std::size_t{2} * (field.rows - 1) * (field.columns - 1) : 0;
    if (!is_surface || triangles > kMaxFixedTriangles) {
      refuse(geom, "", fmt::format("{} is a height field of {} triangles", geom_label(g), triangles),
             fmt::format("2 to {}: make it coarser", kMaxFixedTriangles));
      return {};
    }
    part.shape = DraftShape::kMesh;
    part.rounding = kSingleRounding;  // the heights are of single precision
    for (unsigned r = 0; r < field.rows; ++r)
      for (unsigned c = 0; c < field.columns; ++c)
        part.mesh.corners.push_back({field.half_x * (2.0 * c / (field.columns - 1) - 1),
                                     field.half_y * (2.0 * r / (field.rows - 1) - 1),
                                     field.height * field.heights[r * field.columns + c]});
    for (unsigned r = 0; r + 1 < field.rows; ++r)
      for (unsigned c = 0; c + 1 < field.columns; ++c) {
        const std::uint32_t at = r * field.columns + c, above = at + field.columns;
        part.mesh.triangles.push_back({at, at + 1, above + 1});
        part.mesh.triangles.push_back({at, above + 1, above});
      }
    account_.left_out.push_back(fmt::format("the base and the sides of {}", geom_label(g)));
    return {std::move(part)};
  }

  // --- bodies

  // Adds the shapes that never move. The convex shapes of one body with equal friction become one compound; each shape
  // of the world itself becomes a body of its own.
  void add_fixed() {
    std::vector<std::vector<std::size_t>> together;
    for (const std::size_t g : touching_[0]) {
      const auto fits = [&](const std::vector<std::size_t>& others) {
        const ModelGeom &geom = model_.geoms[g], &other = model_.geoms[others.front()];
        return is_part(geom) && is_part(other) && geom.body == other.body && friction_of(geom) == friction_of(other) &&
               others.size() < kMaxParts;
      };
      const auto found = std::ranges::find_if(together, fits);
      if (found == together.end())
        together.push_back({g});
      else
        found->push_back(g);
    }
    for (const auto& geoms : together) add_fixed(geoms);
  }

  static bool is_part(const ModelGeom& geom) {
    return geom.body > 0 && geom.type != "plane" && geom.type != "mesh" && geom.type != "hfield";
  }

  void add_fixed(const std::vector<std::size_t>& geoms) {
    const ModelGeom& first = model_.geoms[geoms.front()];
    const ModelBody& head = body_at(first.body);
    DraftBody body;
    body.role = DraftRole::kFixed;
    std::vector<DraftPart> parts;
    for (const std::size_t g : geoms) {
      auto made = parts_of(g, true);
      if (made.empty()) return;  // refused
      std::ranges::move(made, std::back_inserter(parts));
    }
    std::string name = geom_label(geoms.front());
    if (parts.size() > 1) {
      name = label(head, "body", static_cast<std::size_t>(first.body));
      account_.change(fmt::format("{}: {} shapes that never move, one fixed compound body", name, parts.size()));
      body.name = head.name.empty() ? fmt::format("body_{}", first.body) : head.name;
      body.origin = with_line(name, head);
    } else {
      body.name = !first.name.empty() ? first.name : first.body > 0 ? head.name : "fixed";
      body.origin = std::move(parts[0].origin);
    }
    set_parts(std::move(parts), head.pose, body);
    set_friction(geoms, name, body);
    draft_.bodies.push_back(std::move(body));
  }

  const ModelBody& body_at(int index) const { return model_.bodies[static_cast<std::size_t>(index)]; }

  void add_group(int group) {
    const ModelBody& head = body_at(group);
    const std::string name = label(head, "body", static_cast<std::size_t>(group));
    MassProperties whole;
    bool explicit_inertia = true;
    for (const ModelBody& body : model_.bodies)
      if (body.weld == group) {
        whole = whole + body.mass;
        explicit_inertia = explicit_inertia && (body.explicit_inertia || body.mass.mass == 0);
      }
    const std::vector<std::size_t>& geoms = touching_[group];
    if (geoms.empty())
      return refuse(head, "shapeless", fmt::format("{} has no shape that touches", name),
                    "a shape of its own, or one body with what it is attached to");
    bool complete = true;
    std::vector<DraftPart> parts;
    for (const std::size_t g : geoms) {
      if (!explicit_inertia) complete = check_closed(g) && complete;
      auto made = parts_of(g, false);
      complete = complete && !made.empty();
      std::ranges::move(made, std::back_inserter(parts));
    }
    if (!complete) return;
    if (parts.size() > kMaxParts)
      return refuse(head, "", fmt::format("{} has {} shapes", name, parts.size()),
                    fmt::format("at most {} in one body: fewer shapes, or fewer --pieces", kMaxParts));
    if (!head.mocap && !is_a_body(whole))
      return refuse(head, "", fmt::format("{}: no rigid body has {:g} kg and its moments", name, whole.mass),
                    "an <inertial> that fits the shapes");
    add_body(group, name, whole, std::move(parts));
  }

  void add_body(int group, const std::string& name, const MassProperties& whole, std::vector<DraftPart> parts) {
    const ModelBody& head = body_at(group);
    const std::size_t count = parts.size();
    DraftBody body;
    body.name = head.name.empty() ? fmt::format("body_{}", group) : head.name;
    body.origin = count > 1 ? with_line(name, head) : std::move(parts[0].origin);
    if (count > 1)
      account_.change(fmt::format("{}: {} shapes, one compound body{}", name, count,
                                  head.mocap ? "" : "; mass, centre and moments exact"));
    set_parts(std::move(parts), head.pose, body);
    set_friction(touching_[group], name, body);
    if (head.mocap) {
      body.role = DraftRole::kKinematic;
    } else {
      set_mass(whole, body);
      const Twistd& twist = head.velocity;
      body.velocity = {twist.linear + cross(twist.angular, whole.centre - head.mass.centre), twist.angular};
    }
    groups_[group] = draft_.bodies.size();
    draft_.bodies.push_back(std::move(body));
  }

  bool check_closed(std::size_t g) {
    const ModelGeom& geom = model_.geoms[g];
    if (geom.type != "mesh") return true;
    const std::size_t open = open_edges(soup_of(geom));
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

  // Sets the two bodies of the joint from their groups. Only the first may be the world, group 0. False if one was
  // refused.
  bool set_ends(int a, int b, DraftJoint& joint) const {
    const auto first = groups_.find(a), second = groups_.find(b);
    if ((a != 0 && first == groups_.end()) || second == groups_.end()) return false;
    if (a != 0) joint.a = first->second;
    joint.b = second->second;
    return true;
  }

  void add_joint(std::size_t j) {
    const ModelJoint& joint = model_.joints[j];
    if (joint.type == "free") return;
    DraftJoint out;
    const int a = group_of(joint.parent), b = group_of(joint.body);
    if (!set_ends(a, b, out)) return;
    out.kind = joint.type == "slide" ? "slider" : joint.type;
    out.origin = with_line(label(joint, "joint", j), joint);
    out.position = joint.anchor;
    if (joint.type != "ball") out.axis = joint.axis;
    out.bodies_collide = collide(a, b, !model_.parents_filtered || a == 0);
    if (joint.limited && joint.type != "ball" && model_.limits && !set_limits(joint, j, out)) return;
    draft_.joints.push_back(std::move(out));
    ++joints_[joint.type];
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

  void add_equality(std::size_t e) {
    const ModelEquality& equality = model_.equalities[e];
    if (!equality.active || equality.body_a < 0) return;
    int a = group_of(equality.body_a), b = group_of(equality.body_b);
    if (a == b) return;
    if (b == 0 || body_at(b).mocap) std::swap(a, b);  // b is the one that moves
    if (b == 0 || body_at(b).mocap) return;
    DraftJoint out;
    if (!set_ends(a, b, out)) return;
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
  }

  void tell_friction() {
    if (draft_.bodies.empty()) return;
    const auto [least, most] = std::ranges::minmax_element(draft_.bodies, {}, &DraftBody::friction);
    const double low = least->friction, high = most->friction;
    if (low == high) return;
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
  std::map<int, std::size_t> groups_;                 // index of the body of each group
  std::map<std::string, unsigned> joints_;
  unsigned visual_{0};
};

}  // namespace

SceneDraft draft_of(const CompiledModel& model, const PieceOptions& pieces, Account& account) {
  return Translator(model, pieces, account).translate();
}

}  // namespace tactus::scene_import
