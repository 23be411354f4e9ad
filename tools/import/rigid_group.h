// Shapes that are one rigid body in a model, as one body of the scene or as several that fixed joints hold.
//
// Units: SI. Frame: world, unless a field says otherwise. Thread: any normal one. Bound: quadratic in the parts.
// Errors: a line that says what does not fit.
#pragma once

#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

// Where the parts cannot have the whole's centre and moments exactly, they may be wrong by this share of size and
// moments.
inline constexpr double kMostMassError = 0.05;

struct RigidPart {
  DraftBody body;
  double weight{0};  // kg; below 0: minus the density, in kg/m^3. Only the shares count
};

struct RigidGroup {
  std::string label;
  bool kinematic{false};
  MassProperties whole;
  std::vector<RigidPart> parts;

  // Gives the parts their mass properties; the heaviest becomes the first. Returns what does not fit, or nothing.
  std::string settle(Account& account);
  // From the twist of a point of the body.
  void set_velocity(const Twistd& twist, const Vec3d& at);
  std::vector<std::string> names() const;
  // Adds the bodies, the joints that hold them, and for those that might touch each other one that keeps them from it,
  // which `guards` counts.
  void add_to(SceneDraft& draft, unsigned& guards) const;

 private:
  std::string settle_several(Account& account);
};

// Mass properties of the solid, in the body's frame, for the mass.
MassProperties solid_body(const DraftBody& body, double mass);
double volume_of(const DraftBody& body);

// Gives a body these mass properties, in its own frame. Where its shape cannot have them it becomes a hull. Returns
// what does not fit, or nothing.
std::string set_mass(const MassProperties& own, DraftBody& body, Account& account);

}  // namespace tactus::scene_import
