// Demands of a scene on the machine, the device and the solver, computed before a run for `tactus scene check`.
//
// Everything here follows from the scene and the device's description by formulas; nothing is simulated.
// Thread: [setup]. Units: SI, in the names.
#pragma once

#include <string>
#include <vector>

#include "rt/haptics/coupling_limits.h"
#include "rt/haptics/device.h"
#include "sim/loader/scene_load.h"

namespace tactus::sim {

struct BodyCounts {
  unsigned total{0}, dynamic{0}, fixed{0};
  unsigned boxes{0}, spheres{0}, capsules{0}, planes{0}, hulls{0}, meshes{0}, compounds{0}, cylinders{0}, cones{0};
  unsigned parts{0};  // of the compounds
};

struct EffectReport {
  std::string name;
  bool declared{false}, used{false};
  std::string cost;                // added computation in a tick
  double added_us{0}, tick_us{0};  // measured on this machine, in a tick of all bodies; tick_us 0: not measured
  double spread_us{0};             // of the measurement; a smaller added_us is not significant

  bool is_measured() const noexcept { return tick_us > 0 && added_us > spread_us; }
};

// Contacts of the scene as it stands before the first tick.
struct StartContacts {
  unsigned contacts{0}, points{0};  // pairs of bodies no further apart than the solver's margin
  double deepest_m{0};              // largest overlap; 0: none
  BodyId deepest_a{kNoBody}, deepest_b{kNoBody};
  unsigned most{0};  // contacts of the pair that has the most: of parts, if it has a compound
  BodyId most_a{kNoBody}, most_b{kNoBody};
  // Triangles of a mesh that a body can touch beyond kMaxBodyTriangles, of the body and the mesh with the most; an
  // upper bound of their number.
  unsigned triangles_left_out{0};
  BodyId fine_body{kNoBody}, fine_mesh{kNoBody};
};

// Static penetration of a contact with effective mass m under a load F: F / (m w^2), w = 2 pi x the contact frequency.
struct PenetrationReport {
  double proxy_m_per_N{0};     // of the proxy on fixed ground
  double lightest_m_per_N{0};  // of the lightest body on fixed ground
};

struct HandReport {
  double duration_s{0};
  std::string file;             // of a recorded motion; empty: a path in the scene
  std::string motion;           // between its way points or rows: "smooth step", "linear", "cubic"
  std::size_t points{0};        // way points or rows
  double max_speed_m_per_s{0};  // of the device's tool on the scripted path; 15/8 of the mean on a smooth step
  double device_max_speed_m_per_s{0};
  double max_angular_speed_rad_per_s{0}, device_max_angular_speed_rad_per_s{0};
  std::size_t fastest{0}, fastest_turn{0},
      farthest{0};       // way point or row, from 0: the end of the fastest leg; the farthest point
  double farthest_m{0};  // distance of the path from the centre of the device's workspace, in the device's metres
  double workspace_radius_m{0};
};

// Sizes that determine the capacities of the haptic thread.
struct CapacityEstimate {
  unsigned member_cap{0}, members_possible{0};  // members_possible: dynamic bodies, at most the cap
  double contacts_per_body{0};                  // at the start
  unsigned sub_world_contacts{0};               // members_possible x contacts_per_body, rounded up: an estimate
  unsigned global_contacts{0};                  // the global world's capacity for contacts
  unsigned global_sub_steps{0};                 // of one global step
};

struct SceneReport {
  std::string name, title;
  BodyCounts bodies;
  std::vector<EffectReport> effects;                     // all effects of sim/model/scene_effects.cpp
  double lightest_kg{0}, heaviest_kg{0}, mass_ratio{1};  // dynamic bodies that follow no script
  double contact_hertz_Hz{0}, max_contact_hertz_Hz{0};
  PenetrationReport penetration;
  haptics::CouplingVerdict coupling;  // at the hand: stiffness and damping of translation x motion scale squared
  std::vector<GeneratedPart> generated;
  std::vector<MeshAccount> meshes;
  StartContacts start;
  HandReport hand;
  CapacityEstimate capacity;
  std::vector<std::string> problems;  // reasons why the scene will not run well; empty: good

  // One of the rules of tools/session/verdict.h, from which every verdict follows.
  bool good() const noexcept { return problems.empty(); }
};

// `scripted`: the scene's hand moves the device; else a person does, and the hand's path is not checked.
SceneReport report_on(const Scene& scene, const haptics::DeviceProperties& device, double tick_s, bool scripted = true);

// For people: a dozen lines.
std::string to_text(const SceneReport& report);

}  // namespace tactus::sim
