// Effects torsional and rolling: a contact resists rotation about its normal, and rolling.
//
// A real contact is a patch, not a point.
// Torsional: a disk of radius R with even pressure resists a spin by 2/3 mu N R.
// Rolling: the pressure acts at a distance d ahead of the centre and resists rolling by N d. Each is a row that
// stops the relative rotation, clamped to that torque, N the normal force in the step before; without friction there is
// no torsional row. R and d are the larger of the two bodies'. Solved in both sweeps, at velocity level, so that
// kinetic energy only falls. The points of a contact resist rotation by their distances from each other. Only if all
// are on one line, as those of a cylinder, is the rotation about that line free: it gets a rolling row, N summed over
// the points. Points within d of the line count as on it, because the pressure may move by d. Units: SI. Thread:
// construction [setup]; the rest [rt], the owner of the World. Bound: linear in contacts of bodies with R or d. Source:
// Coulomb friction under even pressure; rolling resistance, Johnson, Contact Mechanics.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

// Resistance of a body's surface to rotation.
struct ContactPatch {
  double radius_m{};   // R
  double rolling_m{};  // d
};

class ContactTorque : public Stateless {
 public:
  struct Setup {
    std::span<const ContactPatch> by_id{};  // bodies beyond the end have none. Must outlive the world
    bool used() const noexcept { return !by_id.empty(); }
  };
  ContactTorque(const Setup& setup, const Capacities& capacities) : by_id_(setup.by_id), rows_(capacities.contacts) {}
  void register_stages(StageTable& table) noexcept;

 private:
  struct Row {
    std::uint32_t contact{0};
    Vec3d t1, t2;
    double spin_mass{}, roll_mass{};    // kg m^2
    double most_spin{}, most_roll{};    // N m s: limits in a sub-step
    double spin{}, roll_1{}, roll_2{};  // N m s, of this sub-step, on B
  };

  ContactPatch patch_of(BodyId id) const noexcept { return id < by_id_.size() ? by_id_[id] : ContactPatch{}; }
  void list(StageContext& c) noexcept;
  void begin_sub_step(StageContext& c) noexcept;
  void resist(StageContext& c) noexcept;

  std::span<const ContactPatch> by_id_;
  BoundedVector<Row> rows_;
};

}  // namespace tactus::physics
