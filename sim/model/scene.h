// A scene: bodies, effects, the proxy, the placement of the device and the script of the simulated hand.
//
// A plain value, loaded once from TOML (sim/scenes/*.toml) by load_scene. Frame: world, z up. Units: SI.
// Thread: [setup], normal threads.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "rt/haptics/coupling/coupling_gains.h"
#include "rt/haptics/hand_motion.h"
#include "rt/physics/body.h"
#include "rt/physics/effects/effects.h"
#include "rt/physics/pose_spring.h"
#include "rt/physics/shapes/shape_lists.h"
#include "rt/physics/step.h"

namespace tactus::sim {

// The effects that a scene declares; others are not simulated. Their meaning: sim/model/scene_effects.cpp.
struct DeclaredEffects {
  bool gravity{false}, friction{false}, gyroscopic{false}, sleeping{false};
  bool damping{false}, drag{false}, kinematic{false}, joints{false};
  bool torsional{false}, rolling{false}, restitution{false}, attraction{false};
  bool ccd{false}, texture{false}, transients{false};
};

// Parameters of the effects. A list by body id has one entry for each body, or is empty if no body needs it.
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

// When resting islands of the global world fall asleep, with the effect sleeping.
struct SleepingChoice {
  double max_speed_m_per_s{0.01};  // of a body's surface: below, the body counts as at rest
  double after_s{0.5};             // time at rest before it may sleep
  bool from_start{false};          // bodies at rest at the start sleep until something comes near
};

// Pose of the device's frame in the scene, and the scale of its motion there. Power is conserved: the force on the hand
// is motion_scale times the force in the scene.
struct SceneDevice {
  Posed world_from_device;
  double motion_scale{1};
  std::string profile{"virtuose6d"};  // a simulated device: virtuose6d or desk3d
};

// The hand's scripted target at a time, world frame.
struct ScriptWaypoint {
  double time_s{0};
  Vec3d position_m;
  Vec3d rotation_vector_rad;                               // of the tool, about the world's axes
  Vec3d velocity_m_per_s{}, angular_velocity_rad_per_s{};  // of the target there; for kCubic only
};

// A simulated hand: an arm's impedance that follows way points. Stiffness and damping are those of a human arm.
struct HandScript {
  std::vector<ScriptWaypoint> path;  // times ascending, from 0
  haptics::HandMotion motion{haptics::HandMotion::kSmoothStep};
  std::string file;   // of a recorded motion, as named in the scene; way point i is in its line i + kFirstMotionLine
  bool repeat{true};  // the path repeats; its last pose is then its first
  double stiffness_N_per_m{400}, damping_Ns_per_m{12}, mass_kg{0.5};
  double stiffness_Nm_per_rad{4}, damping_Nms_per_rad{0.1};
};

inline constexpr unsigned kFirstMotionLine = 2;  // line of the first row; line 1 has the names of the columns

struct SolverChoice {
  double contact_hertz{250}, contact_damping_ratio{10};
  unsigned sub_steps{4}, relax_sweeps{1};  // haptic side
  physics::FrictionSweeps friction_sweeps{physics::FrictionSweeps::kAuto};
  double global_sub_steps_per_tick{1};  // global side: sub-steps of a global step = this x ratio, rounded up
  double far_sub_steps_per_tick{0};     // same, for islands without a member of a sub-world; 0: as many

  // Sub-steps in a global step of `ratio` ticks.
  unsigned global_sub_steps(unsigned ratio) const noexcept { return sub_steps_in(global_sub_steps_per_tick, ratio); }
  unsigned far_sub_steps(unsigned ratio) const noexcept { return sub_steps_in(far_sub_steps_per_tick, ratio); }

 private:
  static unsigned sub_steps_in(double per_tick, unsigned ratio) noexcept {
    constexpr double kRounding = 1e-9;  // so that 0.1 x 10 gives 1
    return static_cast<unsigned>(std::ceil(per_tick * ratio - kRounding));
  }
};

// The bodies that a generator made, and its own results.
struct GeneratedPart {
  std::string kind;       // wall, pile, tower, card_house, domino_row
  BodyId first{kNoBody};  // ids first .. first + count - 1
  unsigned count{0};
  unsigned line{0};                   // of its table in the file
  double friction{0};                 // of its bodies
  std::vector<double> foot_friction;  // card house, by level from the ground: min. coefficient under its cards' feet
  double top_friction{0};             // card house: min. coefficient between a top and the flat card on it; 0 otherwise
};

// Name and place of a body in the scene file.
struct ListedBody {
  std::string name;         // empty: none
  unsigned line{0};         // of its table
  Posed given_from_body{};  // of the body's frame in that of the keys position_m and rotation: see given_pose.h
};

// Counts of the conversion of a triangle file into a mesh.
struct MeshAccount {
  std::string file;
  BodyId body{kNoBody};
  unsigned corners{0}, triangles{0}, patches{0};  // of the mesh
  unsigned welded{0};                             // corners of the file that are duplicates or unused
  unsigned without_area{0}, doubled{0};           // triangles left out
  unsigned disagreeing_edges{0};                  // edges whose two triangles have opposite orientations
  unsigned boundary_edges{0};                     // edges of one triangle only: the mesh is open there
};

// One hand of a scene: its proxy, the placement of its device, its coupling and its script.
struct HandPart {
  BodyId proxy{kNoBody};
  SceneDevice device;
  haptics::CouplingGains coupling;  // of device and proxy, world units
  HandScript hand;
};

inline constexpr unsigned kMaxHands = physics::kMaxSprings;  // of a scene

struct Scene {
  std::string name;   // file stem
  std::string title;  // one line for people
  DeclaredEffects effects;
  EffectData effect_data;  // worlds refer to it
  Vec3d gravity_m_per_s2{0, 0, -9.81};
  std::vector<physics::Body> bodies;                    // bodies[i].id == i
  std::vector<physics::Hull> hulls;                     // of the bodies' hull shapes; worlds refer to it
  std::vector<physics::Mesh> meshes;                    // same for meshes; one for each body that has one
  std::vector<physics::Compound> compounds;             // same for compounds
  std::vector<std::shared_ptr<const void>> shape_data;  // owns what meshes and compounds refer to; copies share it
  std::vector<MeshAccount> mesh_accounts;               // of each mesh
  BodyId proxy{kNoBody};
  SceneDevice device;
  haptics::CouplingGains coupling;  // of device and proxy, world units
  HandScript hand;
  std::vector<HandPart> more_hands;  // beside the one above; at most kMaxHands - 1
  SolverChoice solver;
  SleepingChoice sleeping;
  unsigned members{64};  // cap of the sub-world, the proxy included
  unsigned ratio{10};
  std::vector<ListedBody> listed;        // by body id: the proxies, then the bodies in the order of the file
  std::vector<GeneratedPart> generated;  // the ids behind them, in the order of the file
  std::string source;                    // the text that it was loaded from, with its files' data; stored in the tape

  // Refers to this scene's lists, which must stay unchanged as long as it is used.
  physics::ShapeLists shapes() const noexcept { return {hulls, meshes, compounds}; }

  unsigned hands() const noexcept { return 1 + static_cast<unsigned>(more_hands.size()); }
  unsigned moving_bodies() const noexcept;  // not fixed; the proxies included
};

// Returns the scene with the chosen hand as its first: `proxy`, `device`, `coupling` and `hand` are that hand's, and
// `more_hands` has the others. So code that handles one hand can be used for each of several. `hand`: 0 to hands() - 1;
// for 0 the scene is unchanged.
Scene scene_of_hand(Scene scene, unsigned hand);

}  // namespace tactus::sim
