// A scene: the bodies, the effects it calls for, the proxy, the device's place in it and what the simulated hand does.
//
// A plain value, loaded once from TOML (sim/scenes/*.toml) by load_scene. Frame: world, z up. Units: SI.
// Thread: [setup], normal threads.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "rt/haptics/coupling/coupling_gains.h"
#include "rt/physics/body.h"
#include "rt/physics/effects/effects.h"
#include "rt/physics/shapes/mesh.h"
#include "rt/physics/step.h"

namespace tactus::sim {

// What a scene calls for. One that is not declared is not simulated. What each is: sim/model/scene_effects.cpp.
struct Effects {
  bool gravity{false}, friction{false}, gyroscopic{false}, sleeping{false};
  bool damping{false}, drag{false}, kinematic{false}, joints{false};
  bool torsional{false}, rolling{false}, restitution{false}, attraction{false};
  bool ccd{false}, texture{false}, transients{false};
};

// What the effects act on. Lists by body id are empty where no body needs them, else one entry for each body.
struct EffectData {
  physics::Damping::Setup damping;
  std::vector<double> drag_per_m;                 // by body id
  Vec3d flow_m_per_s;                             // of the fluid
  std::vector<physics::KinematicScript> scripts;  // by body id
  std::vector<physics::PathKey> path_keys;
  std::vector<physics::Joint> joints;
  std::vector<double> restitution;             // by body id
  std::vector<physics::ContactPatch> patches;  // by body id
  FixedVector<physics::AttractionSource, physics::kMaxAttractionSources> attraction{};
  std::vector<double> attraction_weight;  // by body id
  std::vector<physics::Grain> grain;      // by body id
  std::vector<physics::Ringing> ringing;  // by body id
};

// When what rests in the global world falls asleep, with the effect sleeping.
struct SleepingChoice {
  double max_speed_m_per_s{0.01};  // of a body's surface: below, it counts as at rest
  double after_s{0.5};             // at rest for as long as that: it may sleep
  bool from_start{false};          // what does not move at the start sleeps until something comes near
};

// Where the device's frame is in the scene, and how much larger its motion is there. Power is conserved: the force on
// the hand is motion_scale times the force in the scene.
struct DevicePlacement {
  Posed world_from_device;
  double motion_scale{1};
  std::string profile{"virtuose6d"};  // a simulated device: virtuose6d or desk3d
};

// The hand's scripted target at a time, world frame.
struct HandWaypoint {
  double time_s{0};
  Vec3d position_m;
  Vec3d rotation_vector_rad;                               // of the tool, about the world's axes
  Vec3d velocity_m_per_s{}, angular_velocity_rad_per_s{};  // of the target there; for kCubic alone
};

// Between way points: a smooth step (C2, at rest at each), a straight line, or a cubic through all (C1).
enum class HandMotion { kSmoothStep, kLinear, kCubic };

// A simulated hand: an arm's impedance that follows way points. Stiffness and damping are those of a human arm.
struct HandScript {
  std::vector<HandWaypoint> path;  // times ascending, from 0
  HandMotion motion{HandMotion::kSmoothStep};
  std::string file;   // a recorded motion's, as the scene names it; way point i is in its line i + kFirstMotionLine
  bool repeat{true};  // the path starts again at its end; its last pose is then its first
  double stiffness_N_per_m{400}, damping_Ns_per_m{12}, mass_kg{0.5};
  double stiffness_Nm_per_rad{4}, damping_Nms_per_rad{0.1};
};

inline constexpr unsigned kFirstMotionLine = 2;  // of the file: the first has the names of the columns

struct SolverChoice {
  double contact_hertz{250}, contact_damping_ratio{10};
  unsigned sub_steps{4}, relax_sweeps{1};  // haptic side
  physics::FrictionSweeps friction_sweeps{physics::FrictionSweeps::kAuto};
  double global_sub_steps_per_tick{1};  // global side: sub-steps of a global step = this x ratio, rounded up
  double far_sub_steps_per_tick{0};     // same, of what does not hang together with a sub-world; 0: as many

  // Of a global step of `ratio` ticks.
  unsigned global_sub_steps(unsigned ratio) const noexcept { return sub_steps_in(global_sub_steps_per_tick, ratio); }
  unsigned far_sub_steps(unsigned ratio) const noexcept { return sub_steps_in(far_sub_steps_per_tick, ratio); }

 private:
  static unsigned sub_steps_in(double per_tick, unsigned ratio) noexcept {
    constexpr double kRounding = 1e-9;  // 0.1 x 10 is 1
    return static_cast<unsigned>(std::ceil(per_tick * ratio - kRounding));
  }
};

// What a generator made, and what it says of its own work.
struct GeneratedPart {
  std::string kind;       // wall, pile, tower, card_house, domino_row
  BodyId first{kNoBody};  // ids first .. first + count - 1
  unsigned count{0};
  double friction{0};                 // of its bodies
  std::vector<double> foot_friction;  // card house, by level from the ground: least coefficient under its cards' feet
  double top_friction{0};  // card house: least coefficient between a top and the flat card on it; 0 otherwise
};

// What became of the triangles of a file.
struct MeshAccount {
  std::string file;
  BodyId body{kNoBody};
  unsigned corners{0}, triangles{0}, patches{0};  // that the mesh has
  unsigned welded{0};                             // corners of the file that were there already, or not used
  unsigned without_area{0}, doubled{0};           // triangles left out
  unsigned disagreeing_edges{0};                  // whose two triangles do not agree on what is outside
  unsigned boundary_edges{0};                     // of one triangle only: there the mesh is open
};

struct Scene {
  std::string name;   // file stem
  std::string title;  // one line for people
  Effects effects;
  EffectData effect_data;  // worlds look into it
  Vec3d gravity_m_per_s2{0, 0, -9.81};
  std::vector<physics::Body> bodies;                    // bodies[i].id == i
  std::vector<physics::Hull> hulls;                     // what the bodies' hull shapes refer to; worlds look into it
  std::vector<physics::Mesh> meshes;                    // same; one for each body that has one
  std::vector<std::shared_ptr<const void>> mesh_parts;  // what the meshes look into: copies of a scene share it
  std::vector<MeshAccount> mesh_accounts;               // of each mesh
  BodyId proxy{kNoBody};
  DevicePlacement device;
  haptics::CouplingGains coupling;  // of device and proxy, world units
  HandScript hand;
  SolverChoice solver;
  SleepingChoice sleeping;
  unsigned members{64};  // cap of the sub-world, the proxy included
  unsigned ratio{10};
  std::vector<GeneratedPart> generated;  // in the order of the file
  std::string source;                    // the text it was loaded from: the tape carries it
};

}  // namespace tactus::sim
