#include <fmt/format.h>

#include "sim/loader/scene_report.h"

namespace tactus::sim {
namespace {

std::string effect_lines(const SceneReport& report) {
  std::string text;
  for (const auto& effect : report.effects) {
    const char* state = !effect.declared ? "not declared: not simulated"
                        : effect.used    ? "used"
                                         : "declared, nothing uses it";
    text += fmt::format("  {:<12}{}{}", effect.name, state, effect.used ? "; costs " + effect.cost : "");
    if (effect.is_measured())
      text += fmt::format("; measured: {:.2g} us of {:.3g} us", effect.added_us, effect.tick_us);
    else if (effect.tick_us > 0)
      text += fmt::format("; measured: below the measurement's spread of {:.2g} us, of {:.3g} us", effect.spread_us,
                          effect.tick_us);
    text += "\n";
  }
  return text;
}

std::string axis_line(const char* name, const haptics::AxisVerdict& axis, const char* unit) {
  return fmt::format("  {:<12}{:g} {} in the scene, stable below {:.4g}, allowed up to {:.4g}: {}\n", name,
                     axis.stiffness, unit, axis.stiffness_limit, axis.stiffness_allowed,
                     axis.accepted ? fmt::format("margin {:.2f}", axis.margin) : "refused");
}

std::string part_line(const GeneratedPart& part) {
  std::string text =
      fmt::format("  {:<12}{} bodies, ids {} to {}", part.kind, part.count, part.first, part.first + part.count - 1);
  if (!part.foot_friction.empty()) {
    text += fmt::format("; stands with friction above {:.3g} between tops and flat cards and, under the feet by level,",
                        part.top_friction);
    for (const double needed : part.foot_friction) text += fmt::format(" {:.3g}", needed);
  }
  return text + "\n";
}

std::string mesh_line(const MeshAccount& mesh) {
  std::string text = fmt::format("  {:<12}{}: {} triangles, {} corners, {} flat patches", "mesh", mesh.file,
                                 mesh.triangles, mesh.corners, mesh.patches);
  const auto add = [&text](unsigned count, const char* what) {
    if (count > 0) text += fmt::format("; {} {}", count, what);
  };
  add(mesh.boundary_edges, "open edges");
  add(mesh.disagreeing_edges, "edges whose triangles do not agree on what is outside");
  add(mesh.welded, "corners merged");
  add(mesh.without_area, "triangles without area left out");
  add(mesh.doubled, "doubled triangles left out");
  return text + "\n";
}

}  // namespace

std::string to_text(const SceneReport& r) {
  std::string text = fmt::format("{}{}{}\n", r.name, r.title.empty() ? "" : ": ", r.title);
  text += fmt::format(
      "bodies\n  {:<12}{}: {} move, {} are fixed; {} boxes, {} spheres, {} capsules, {} hulls, {} planes{}\n", "count",
      r.bodies.total, r.bodies.dynamic, r.bodies.fixed, r.bodies.boxes, r.bodies.spheres, r.bodies.capsules,
      r.bodies.hulls, r.bodies.planes,
      (r.bodies.cylinders > 0 ? fmt::format(", {} cylinders", r.bodies.cylinders) : "") +
          (r.bodies.cones > 0 ? fmt::format(", {} cones", r.bodies.cones) : "") +
          (r.bodies.compounds > 0 ? fmt::format(", {} compounds of {} parts", r.bodies.compounds, r.bodies.parts)
                                  : "") +
          (r.bodies.meshes > 0 ? fmt::format(", {} meshes", r.bodies.meshes) : ""));
  text += fmt::format("  {:<12}{:g} to {:g} kg, ratio {:.3g}\n", "masses", r.lightest_kg, r.heaviest_kg, r.mass_ratio);
  for (const auto& part : r.generated) text += part_line(part);
  for (const auto& mesh : r.meshes) text += mesh_line(mesh);
  text += "effects\n" + effect_lines(r);
  text += fmt::format("contacts\n  {:<12}{:g} Hz, at most {:g} Hz with these sub-steps\n", "frequency",
                      r.contact_hertz_Hz, r.max_contact_hertz_Hz);
  text += fmt::format("  {:<12}{:.3g} m for each N on the proxy, {:.3g} m on the lightest body\n", "sinks",
                      r.penetration.proxy_m_per_N, r.penetration.lightest_m_per_N);
  text += fmt::format("  {:<12}{} contacts with {} points; deepest overlap {:.3g} m\n", "at start", r.start.contacts,
                      r.start.points, r.start.deepest_m);
  text += "coupling\n" + axis_line("translation", r.coupling.translation, "N/m");
  text += axis_line("rotation", r.coupling.rotation, "N m/rad");
  text += fmt::format(
      "hand\n  {:<12}{:g} s, up to {:.3g} m/s of the device's {:g}; {:.3g} m from the middle, of {:g}{}\n", "path",
      r.hand.duration_s, r.hand.max_speed_m_per_s, r.hand.device_max_speed_m_per_s, r.hand.farthest_m,
      r.hand.workspace_radius_m,
      r.hand.file.empty() ? ""
                          : fmt::format("; {}, {} rows, {} in between", r.hand.file, r.hand.points, r.hand.motion));
  text += fmt::format("capacity\n  {:<12}{} of a cap of {}; about {} contacts, by {:.2f} a body at the start\n",
                      "sub-world", r.capacity.members_possible, r.capacity.member_cap, r.capacity.sub_world_contacts,
                      r.capacity.contacts_per_body);
  text += fmt::format("  {:<12}{} sub-steps a step\n", "global", r.capacity.global_sub_steps);
  for (const auto& problem : r.problems) text += "problem: " + problem + "\n";
  return text;
}

}  // namespace tactus::sim
