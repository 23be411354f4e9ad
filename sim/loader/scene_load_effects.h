// Reads the keys of effects in a scene file: the list, the effects' own tables, the keys of a body, joints.
//
// A key or table of an effect that is not declared is a mistake that names the effect; an effect that is declared but
// not used is a warning.
// Thread: [setup]. Mistakes go to the reader's diagnostics.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>

#include "rt/text/table_reader.h"
#include "sim/model/scene.h"

namespace tactus::sim {

inline constexpr std::size_t kMaxSceneJoints = 10'000;
inline constexpr std::size_t kMaxPathKeys = 1'000;
// The words for [[joint]] kind, by JointKind.
inline constexpr std::array<std::string_view, 5> kJointKinds{"fixed", "ball", "hinge", "slider", "distance"};

class EffectReader {
 public:
  EffectReader(Scene& scene, text::Diagnostics& diagnostics) : scene_(scene), diagnostics_(diagnostics) {}

  void read_list(text::TableReader& root);    // before all others
  void read_tables(text::TableReader& root);  // [damping], [drag]
  // Surface properties in a table, for the bodies that it makes.
  struct Surface {
    double restitution{0};
    physics::ContactPatch patch;
    double attraction_weight{0};
    physics::Grain grain;
    physics::Ringing ringing;
  };
  Surface read_surface(text::TableReader& table);
  void set_surface(BodyId id, const Surface& surface);
  // Keys of a single body: its name for joints, its script.
  void read_body(text::TableReader& table, physics::Body& body);
  void set_name(const std::string& name, BodyId id) { ids_[name] = id; }
  // Call after all bodies, since these tables refer to them.
  void read_joints(text::TableReader& root);
  void read_attraction(text::TableReader& root);
  // Call last: computes derived data and warns of effects that are declared but not used.
  void finish(text::TableReader& root);

 private:
  bool needs(text::TableReader& table, const char* key, bool DeclaredEffects::*effect);
  void read_feel(text::TableReader& table, Surface& surface);
  void read_script(text::TableReader& table, physics::Body& body);
  void read_joint(text::TableReader& table);
  BodyId read_end(text::TableReader& table, const char* key);
  void read_limits(text::TableReader& table, physics::Joint& joint, double at_start);
  void read_motor(text::TableReader& table, physics::Joint& joint);
  void find_drag();

  Scene& scene_;
  text::Diagnostics& diagnostics_;
  double density_kg_per_m3_{0}, drag_coefficient_{0};
  std::map<std::string, BodyId> ids_;  // by name
};

}  // namespace tactus::sim
