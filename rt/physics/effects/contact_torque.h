// Effects torsional and rolling: a contact resists turning about its normal, and rolling.
//
// A real contact is no point. Torsional: a disk of radius R with even pressure resists a spin by 2/3 mu N R. Rolling:
// the pressure leads the centre by d, which resists rolling by N d. Each is a row that stops the relative turn and is
// clamped to that torque, N what the contact carried in the step before; without friction there is no torsional one.
// R and d are the larger of the two bodies'. Solved in both sweeps and never against the turn that would leave too
// much: kinetic energy only falls. Only contacts of one point: where there are several, they hold the turn by their
// distance. Units: SI. Thread: construction [setup]; the rest [rt], the owner of the World. Bound: linear in contacts
// of bodies with R or d. Source: Coulomb friction under even pressure; rolling resistance, Johnson, Contact Mechanics.
#pragma once

#include "rt/physics/effects/stage.h"

namespace tactus::physics {

// What a body's surface does to turns.
struct ContactPatch {
  double radius_m{};   // R
  double rolling_m{};  // d
};

class ContactTorque : public Stateless {
 public:
  struct Setup {
    std::span<const ContactPatch> by_id{};  // those beyond the end have none. Must outlive the world
    bool used() const noexcept { return !by_id.empty(); }
  };
  ContactTorque(const Setup& setup, const Capacities& capacities) : by_id_(setup.by_id), rows_(capacities.contacts) {}
  void enter(StageTable& table) noexcept;

 private:
  struct Row {
    std::uint32_t contact{0};
    Vec3d t1, t2;
    double spin_mass{}, roll_mass{};    // kg m^2
    double most_spin{}, most_roll{};    // N m s, in a sub-step
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
