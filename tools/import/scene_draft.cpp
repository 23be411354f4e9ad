#include "tools/import/scene_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "rt/base/rotation_vector.h"

namespace tactus::scene_import {
namespace {

constexpr std::size_t kLongestName = 100;
constexpr double kAboveEverything_m = 0.01;

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 32 || c == 127 ? ' ' : c;
  }
  return out + "\"";
}

std::string comment(const std::string& text) {
  std::string out = text;
  std::replace_if(
      out.begin(), out.end(), [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }, ' ');
  return "# " + out + "\n";
}

std::string shown(const Vec3d& v, double rounding) {
  return fmt::format("[{}, {}, {}]", decimal(v.x, rounding), decimal(v.y, rounding), decimal(v.z, rounding));
}

// Each number by its own amount.
std::string shown(const Vec3d& v) { return fmt::format("[{}, {}, {}]", decimal(v.x), decimal(v.y), decimal(v.z)); }

std::string shown(const SymMat3d& m, double rounding) {
  const std::string moments = shown(Vec3d{m.xx, m.yy, m.zz}, rounding);
  const std::string products = shown(Vec3d{m.xy, m.xz, m.yz}, rounding);
  if (products == "[0, 0, 0]") return moments;
  return moments.substr(0, moments.size() - 1) + ", " + products.substr(1);
}

double farthest(const std::vector<Vec3d>& points) {
  double most = 0;
  for (const Vec3d& p : points) most = std::max(most, norm(p));
  return most;
}

std::string obj_text(const DraftPart& part) {
  std::string text = "# written by tactus import, in metres\n";
  const double rounding = part.rounding * farthest(part.mesh.corners);
  for (const Vec3d& v : part.mesh.corners)
    text += fmt::format("v {} {} {}\n", decimal(v.x, rounding), decimal(v.y, rounding), decimal(v.z, rounding));
  for (const auto& t : part.mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

bool moves(const DraftBody& body) { return body.role != DraftRole::kFixed; }

class Writer {
 public:
  Writer(const SceneDraft& draft, const std::string& stem) : draft_(draft), stem_(stem) {
    const auto include = [this](const Vec3d& place) { farthest_m_ = std::max(farthest_m_, norm(place)); };
    for (const DraftBody& body : draft_.bodies) {
      include(body.pose.position);
      for (const DraftPart& part : body.parts) include((body.pose * part.pose).position);
    }
    for (const DraftJoint& joint : draft_.joints) include(joint.position);
  }

  SceneFiles write(Account& account) {
    for (const std::string& line : draft_.head) files_.text += comment(line);
    files_.text += fmt::format("title = {}\neffects = [{}]\n", quoted(draft_.title.substr(0, 200)), effects());
    if (norm(draft_.gravity) > 0) files_.text += fmt::format("gravity_m_per_s2 = {}\n", shown(draft_.gravity));
    write_simulation(account);
    write_proxy(account);
    for (std::size_t i = 0; i < draft_.bodies.size(); ++i)
      if (draft_.proxy.body != i) write_body(draft_.bodies[i], "body");
    for (const DraftJoint& joint : draft_.joints) write_joint(joint);
    return std::move(files_);
  }

 private:
  std::string effects() const {
    const auto any = [this](auto holds) { return std::any_of(draft_.bodies.begin(), draft_.bodies.end(), holds); };
    std::string list;
    const auto add = [&list](bool used, const char* name) {
      if (used) list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", name);
    };
    add(norm(draft_.gravity) > 0, "gravity");
    add(any([](const DraftBody& b) { return b.friction > 0; }), "friction");
    add(any([](const DraftBody& b) {
          return b.role == DraftRole::kMoving && (b.compound || b.parts[0].shape != DraftShape::kSphere);
        }),
        "gyroscopic");
    add(any([](const DraftBody& b) { return b.role == DraftRole::kKinematic; }), "kinematic");
    add(!draft_.joints.empty(), "joints");
    add(any([](const DraftBody& b) { return b.contact_radius_m > 0; }), "torsional");
    add(any([](const DraftBody& b) { return b.rolling_friction_m > 0; }), "rolling");
    return list;
  }

  void line(const char* key, const std::string& value) { files_.text += fmt::format("{} = {}\n", key, value); }
  void line_unless_zero(const char* key, const std::string& value) {
    if (value != "[0, 0, 0]") line(key, value);
  }

  void write_shape(const DraftPart& part) {
    switch (part.shape) {
      case DraftShape::kSphere:
        line("shape", "\"sphere\"");
        line("radius_m", decimal(part.size.x));
        break;
      case DraftShape::kCapsule:
        line("shape", "\"capsule\"");
        line("radius_m", decimal(part.size.x));
        line("length_m", decimal(2 * part.size.y));
        break;
      case DraftShape::kCylinder:
        line("shape", "\"cylinder\"");
        line("radius_m", decimal(part.size.x));
        line("length_m", decimal(2 * part.size.y));
        break;
      case DraftShape::kBox:
        line("shape", "\"box\"");
        line("size_m", shown(2 * part.size));
        break;
      case DraftShape::kPlane:
        line("shape", "\"plane\"");
        break;
      case DraftShape::kHull:
        line("shape", "\"hull\"");
        files_.text += "points_m = [\n";
        for (const Vec3d& p : part.points)
          files_.text += fmt::format("  {},\n", shown(p, part.rounding * farthest(part.points)));
        files_.text += "]\n";
        break;
      case DraftShape::kMesh:
        line("shape", "\"mesh\"");
        line("file", quoted(file_of(part)));
        break;
    }
  }

  // Bodies of the same mesh share its file.
  std::string file_of(const DraftPart& part) {
    const std::string content = obj_text(part);
    for (const auto& [name, known] : files_.shapes)
      if (known == content) return name;
    files_.shapes.emplace_back(fmt::format("{}_{}.obj", stem_, files_.shapes.size() + 1), content);
    return files_.shapes.back().first;
  }

  // A table's first line and where it comes from.
  void write_head(const std::string& head, const std::string& origin) {
    files_.text += fmt::format("{}{}", head, origin.empty() ? "\n" : "  " + comment(origin));
  }

  // `table`: body or proxy.
  void write_body(const DraftBody& body, const std::string& table) {
    const bool is_proxy = table == "proxy";
    files_.text += '\n';
    write_head(is_proxy ? "[proxy]" : "[[body]]", body.origin);
    if (!is_proxy) line("name", quoted(body.name));
    if (body.compound)
      line("shape", "\"compound\"");
    else
      write_shape(body.parts[0]);
    const DraftShape shape = body.parts[0].shape;
    const bool always_fixed = shape == DraftShape::kPlane || shape == DraftShape::kMesh;
    if (body.role == DraftRole::kFixed && !always_fixed) line("fixed", "true");
    if (body.role == DraftRole::kKinematic) line("kinematic", "true");
    if (body.role == DraftRole::kMoving) {
      line("mass_kg", decimal(body.mass_kg));
      if (body.inertia) line("inertia_kg_m2", shown(*body.inertia, inertia_rounding(body)));
      if (body.centre) line("centre_of_mass_m", shown(*body.centre, length_rounding()));
      const double turn = norm(body.velocity.angular), speed = norm(body.velocity.linear) + turn * farthest_m_;
      line_unless_zero("velocity_m_per_s", shown(body.velocity.linear, kRounding * speed));
      line_unless_zero("angular_velocity_rad_per_s", shown(body.velocity.angular, kRounding * turn));
    }
    if (body.friction > 0) line("friction", decimal(body.friction));
    if (body.contact_radius_m > 0) line("contact_radius_m", decimal(body.contact_radius_m));
    if (body.rolling_friction_m > 0) line("rolling_friction_m", decimal(body.rolling_friction_m));
    write_pose(body.pose);
    if (!body.compound) return;
    for (const DraftPart& part : body.parts) {
      write_head(fmt::format("[[{}.parts]]", table), part.origin);
      write_shape(part);
      write_pose(part.pose);
    }
  }

  void write_pose(const Posed& pose) {
    line_unless_zero("position_m", shown(pose.position, length_rounding()));
    line_unless_zero("rotation_vector_rad", shown(rotation_vector_of(pose.rotation), kRounding));
  }

  // Rounding of a position [m]: it is a sum of lengths of up to farthest_m_.
  double length_rounding() const { return kRounding * farthest_m_; }

  // Rounding of a moment of inertia [kg m^2]. A centre of mass that is wrong by d changes a moment by 2 m l d,
  // and m l^2 is at most the trace: by at most 2 d sqrt(m trace).
  double inertia_rounding(const DraftBody& body) const {
    const double sum = trace(*body.inertia);
    return kRounding * sum + 2 * std::sqrt(body.mass_kg * sum) * length_rounding();
  }

  std::string end_name(std::size_t body) const {
    return quoted(draft_.proxy.body == body ? "proxy" : draft_.bodies[body].name);
  }

  void write_joint(const DraftJoint& joint) {
    files_.text += '\n';
    write_head("[[joint]]", joint.origin);
    line("kind", quoted(joint.kind));
    if (joint.a) line("a", end_name(*joint.a));
    line("b", end_name(joint.b));
    line("position_m", shown(joint.position, length_rounding()));
    if (joint.axis) line("axis", shown(*joint.axis, kRounding));
    const bool turns = joint.kind == "hinge";
    const double rounding = turns ? kRounding : length_rounding();
    if (joint.low) line(turns ? "low_rad" : "low_m", decimal(*joint.low, rounding));
    if (joint.high) line(turns ? "high_rad" : "high_m", decimal(*joint.high, rounding));
    if (joint.bodies_collide) line("bodies_collide", "true");
  }

  // A joint deflects by its load / (m w^2), and the motion of a mechanism has the error of a sub-step: both require
  // short sub-steps.
  void write_simulation(Account& account) {
    if (draft_.joints.empty()) return;
    files_.text += "\n[simulation]\ncontact_hertz_Hz = 1000\nglobal_sub_steps_per_tick = 4\n";
    account.change(
        "filled in: [simulation] with contacts and joints of 1000 Hz and four sub-steps a tick, as there are joints");
    if (has_loop())
      account.change(
          "a closed loop of joints moves with an error that falls with the sub-step: a four-bar linkage is 6 % off "
          "MuJoCo's path over 2 s at --rate 1000, 0.7 % at --rate 8000");
  }

  // Does a joint join bodies that others join already? The world is number 0.
  bool has_loop() const {
    std::vector<std::size_t> group(draft_.bodies.size() + 1);
    std::iota(group.begin(), group.end(), std::size_t{0});
    for (const DraftJoint& joint : draft_.joints) {
      const std::size_t a = group[joint.a ? *joint.a + 1 : 0], b = group[joint.b + 1];
      if (a == b) return true;
      std::ranges::replace(group, b, a);
    }
    return false;
  }

  void write_device(const Vec3d& position) {
    files_.text += "\n[device]\n";
    line("profile", quoted(draft_.proxy.device));
    line("position_m", shown(position, length_rounding()));
  }

  void write_proxy(Account& account) {
    const DraftProxy& proxy = draft_.proxy;
    if (proxy.body) {
      const DraftBody& body = draft_.bodies[*proxy.body];
      write_body(body, "proxy");
      write_device(body.pose.position + rotate(body.pose.rotation, body.centre.value_or(Vec3d{})));
      account.change(
          fmt::format("\"{}\" is the proxy: the device holds it, and gravity does not act on it", body.name));
      return;
    }
    const Vec3d position = proxy.position.value_or(above_everything());
    files_.text += "\n[proxy]\nshape = \"sphere\"\n";
    line("radius_m", decimal(proxy.radius_m));
    line("mass_kg", decimal(proxy.mass_kg));
    if (effects().find("friction") != std::string::npos) line("friction", decimal(proxy.friction));
    line("position_m", shown(position, length_rounding()));
    write_device(position);
    account.change(
        fmt::format("filled in: a proxy of radius {} m and {} kg at [{:.3g}, {:.3g}, {:.3g}] m, the device {} there",
                    proxy.radius_m, proxy.mass_kg, position.x, position.y, position.z, proxy.device));
  }

  // Where the proxy touches nothing at the start: over the middle of what moves, above the highest point.
  Vec3d above_everything() const {
    Vec3d middle;
    double count = 0, top = 0;
    for (const DraftBody& body : draft_.bodies) {
      if (moves(body)) {
        middle += body.pose.position;
        ++count;
      }
      for (const DraftPart& part : body.parts) top = std::max(top, top_of(part, body.pose * part.pose));
    }
    if (count > 0) middle = middle * (1 / count);
    return {middle.x, middle.y, top + draft_.proxy.radius_m + kAboveEverything_m};
  }

  static double top_of(const DraftPart& part, const Posed& pose) {
    const Vec3d up = rotate_inverse(pose.rotation, Vec3d{0, 0, 1});
    double highest = -std::numeric_limits<double>::infinity();
    switch (part.shape) {
      case DraftShape::kSphere:
        return pose.position.z + part.size.x;
      case DraftShape::kCapsule:
        return pose.position.z + part.size.x + part.size.y * std::abs(up.z);
      case DraftShape::kCylinder:
        return pose.position.z + part.size.y * std::abs(up.z) + part.size.x * std::hypot(up.x, up.y);
      case DraftShape::kBox:
        return pose.position.z + dot(part.size, abs(up));
      case DraftShape::kPlane:
        return pose.position.z;
      case DraftShape::kHull:
        for (const Vec3d& p : part.points) highest = std::max(highest, dot(p, up));
        break;
      case DraftShape::kMesh:
        for (const Vec3d& p : part.mesh.corners) highest = std::max(highest, dot(p, up));
        break;
    }
    return pose.position.z + highest;
  }

  const SceneDraft& draft_;
  const std::string& stem_;
  SceneFiles files_;
  double farthest_m_{0};  // the farthest place from the world's origin
};

}  // namespace

SceneFiles write_scene(const SceneDraft& draft, const std::string& stem, Account& account) {
  account.joints = static_cast<unsigned>(draft.joints.size());
  account.bodies = static_cast<unsigned>(draft.bodies.size() - (draft.proxy.body ? 1 : 0));
  return Writer(draft, stem).write(account);
}

void make_names_unique(SceneDraft& draft) {
  std::set<std::string> used{"proxy"};
  for (DraftBody& body : draft.bodies) {
    const std::string wanted = body.name.empty() ? "body" : body.name.substr(0, kLongestName - 8);
    body.name = wanted;
    for (unsigned n = 2; !used.insert(body.name).second; ++n) body.name = fmt::format("{}_{}", wanted, n);
  }
}

}  // namespace tactus::scene_import
