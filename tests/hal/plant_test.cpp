#include "hal/plant.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr double kStep_s = 2.5e-4;

PlantParameters free_mass() {
  PlantParameters p;
  p.mass_kg = 0.3;
  p.inertia_kg_m2 = 1e-3;
  p.stop_radius_m = 1e6;
  p.max_effort = {100, 100, 100, 100, 100, 100};
  return p;
}

HandParameters no_hand() {
  HandParameters h;
  h.stiffness_N_per_m = h.damping_Ns_per_m = h.mass_kg = 0;
  h.stiffness_Nm_per_rad = h.damping_Nms_per_rad = h.inertia_kg_m2 = 0;
  return h;
}

void run(Plant& plant, double time_s, const AxisVector& effort, const HandTarget& target = {}, bool shorted = false) {
  for (long i = std::lround(time_s / kStep_s); i > 0; --i) plant.step(kStep_s, effort, shorted, target);
}

// Efforts for a constant torque, whatever the wrist does.
void run_torque(Plant& plant, double time_s, const Vec3d& torque) {
  for (long i = std::lround(time_s / kStep_s); i > 0; --i)
    plant.step(kStep_s, CartesianStage().efforts_of(plant.coordinates(), {{}, torque}), false, {});
}

}  // namespace

TEST_CASE("a free mass under a constant force has v = F t / m and x = F t^2 / 2 m") {
  Plant plant(free_mass(), no_hand(), {});
  run(plant, 0.5, {3, 0, -6, 0, 0, 0});
  CHECK(plant.twist().linear.x == Approx(3.0 * 0.5 / 0.3).epsilon(1e-12));
  CHECK(plant.twist().linear.z == Approx(-6.0 * 0.5 / 0.3).epsilon(1e-12));
  // Semi-implicit Euler: x = v (t + h) / 2.
  CHECK(plant.pose().position.x == Approx(0.5 * 3.0 / 0.3 * 0.25).margin(5.0 * kStep_s));
  CHECK(plant.pose().position.x == Approx(0.5 * 3.0 / 0.3 * 0.5 * (0.5 + kStep_s)).epsilon(1e-12));
}

TEST_CASE("a hand that pushes accelerates device and hand by its wrench, and its work is what they have") {
  HandParameters hand;  // with the impedance of a person's, which does not act
  hand.mass_kg = 0.5;
  hand.inertia_kg_m2 = 3e-3;
  Plant plant(free_mass(), hand, {});
  for (int i = 0; i < 2000; ++i) plant.step_pushed(kStep_s, {0, 1, 0, 0, 0, 0}, false, {{3, 0, -6}, {0.001, 0, 0}});
  CHECK(plant.twist().linear.x == Approx(3.0 * 0.5 / 0.8).epsilon(1e-12));
  CHECK(plant.twist().linear.y == Approx(1.0 * 0.5 / 0.8).epsilon(1e-12));
  CHECK(plant.twist().linear.z == Approx(-6.0 * 0.5 / 0.8).epsilon(1e-12));
  CHECK(plant.twist().angular.x == Approx(0.001 * 0.5 / 4e-3).epsilon(1e-12));
  CHECK(plant.hand_wrench().force.z == -6.0);
  CHECK(plant.work().hand + plant.work().motors == Approx(plant.kinetic_energy_J()).epsilon(1e-12));
}

TEST_CASE("the hand's mass is carried along") {
  HandParameters hand = no_hand();
  hand.mass_kg = 0.5;
  hand.inertia_kg_m2 = 3e-3;
  Plant plant(free_mass(), hand, {});
  run(plant, 0.5, {3, 0, 0, 0, 0, 0.001});
  CHECK(plant.twist().linear.x == Approx(3.0 * 0.5 / 0.8).epsilon(1e-12));
  CHECK(plant.twist().angular.x == Approx(0.001 * 0.5 / 4e-3).epsilon(1e-12));
}

TEST_CASE("a damped mass approaches F / b along its exponential") {
  PlantParameters p = free_mass();
  p.damping_Ns_per_m = 2.0;
  p.damping_Nms_per_rad = 0.01;
  Plant plant(p, no_hand(), {});
  run(plant, 0.15, {3, 0, 0, 0, 0, 0.02});  // one time constant m / b; 1.5 of the inertia's
  CHECK(plant.twist().linear.x == Approx(1.5 * (1.0 - std::exp(-1.0))).epsilon(1e-3));
  CHECK(plant.twist().angular.x == Approx(2.0 * (1.0 - std::exp(-1.5))).epsilon(2e-3));
  run(plant, 6.0, {3, 0, 0, 0, 0, 0.02});
  CHECK(plant.twist().linear.x == Approx(1.5).epsilon(1e-12));
  CHECK(plant.twist().angular.x == Approx(2.0).epsilon(1e-12));
}

TEST_CASE("shorted motors brake: no effort, and their damping on top") {
  PlantParameters p = free_mass();
  p.damping_Ns_per_m = 0.5;
  p.brake_damping_Ns_per_m = 2.5;
  Plant plant(p, no_hand(), {});
  run(plant, 0.1, {3, 0, 0, 0, 0, 0});
  const double speed = plant.twist().linear.x;
  run(plant, 0.1, {50, 0, 0, 0, 0, 0}, {}, true);  // one time constant 0.3 / 3
  CHECK(plant.twist().linear.x == Approx(speed * std::exp(-1.0)).epsilon(2e-3));
  CHECK(plant.motor_wrench().force == Vec3d{});
}

TEST_CASE("Coulomb friction holds up to its force, exactly, and slips beyond it") {
  PlantParameters p = free_mass();
  p.coulomb_force_N = 0.5;
  Plant held(p, no_hand(), {});
  run(held, 1.0, {0.3, 0.3999, 0, 0, 0, 0});  // norm 0.49992
  CHECK(held.pose().position == Vec3d{});
  CHECK(held.twist() == Twistd{});
  Plant slips(p, no_hand(), {});
  run(slips, 1.0, {0.3, 0.4001, 0, 0, 0, 0});
  const double force = std::hypot(0.3, 0.4001);
  CHECK(norm(slips.twist().linear) == Approx((force - 0.5) * 1.0 / 0.3).epsilon(1e-9));
  CHECK(slips.twist().linear.x / slips.twist().linear.y == Approx(0.3 / 0.4001));
}

TEST_CASE("a mass that slides stops after m v / f and then stays, without a tremor") {
  PlantParameters p = free_mass();
  p.coulomb_force_N = 0.5;
  p.coulomb_torque_Nm = 0.002;
  Plant plant(p, no_hand(), {});
  run(plant, 0.2, {2.0, 0, 0, 0, 0, 0.01});
  const double speed = 1.5 * 0.2 / 0.3, start = plant.pose().position.x;
  REQUIRE(plant.twist().linear.x == Approx(speed).epsilon(1e-12));
  REQUIRE(plant.twist().angular.x == Approx(0.008 * 0.2 / 1e-3).epsilon(1e-12));
  run(plant, 0.3 * speed / 0.5 - 2 * kStep_s, {});
  CHECK(plant.twist().linear.x > 0.0);
  run(plant, 4 * kStep_s, {});
  CHECK(plant.twist().linear.x == 0.0);
  CHECK(plant.pose().position.x - start == Approx(0.3 * speed * speed / (2 * 0.5)).margin(speed * kStep_s));
  run(plant, 0.4, {});  // the rotation stops after 1e-3 x 1.6 / 0.002 = 0.8 s in all
  const AxisVector rest = plant.coordinates();
  CHECK(plant.twist() == Twistd{});
  for (int i = 0; i < 10000; ++i) {
    plant.step(kStep_s, {}, false, {});
    REQUIRE(plant.coordinates() == rest);
  }
}

TEST_CASE("a tool that the hand holds sags by F / k") {
  PlantParameters p = free_mass();
  HandParameters hand;
  Plant plant(p, hand, {});
  run(plant, 4.0, {4, 0, -8, 0, 0, 0.1});
  CHECK(plant.pose().position.x == Approx(4.0 / 400).epsilon(1e-9));
  CHECK(plant.pose().position.z == Approx(-8.0 / 400).epsilon(1e-9));
  CHECK(plant.coordinates()[5] == Approx(2 * std::asin(0.5 * 0.1 / 4)).epsilon(1e-9));
  CHECK(plant.hand_wrench().force.x == Approx(-4.0).epsilon(1e-9));
  CHECK(plant.hand_wrench().torque.x == Approx(-0.1).epsilon(1e-9));
}

TEST_CASE("a hand far stiffer than the sub-step can follow still does not shake the tool") {
  HandParameters hand;
  hand.stiffness_N_per_m = 1e9;
  hand.stiffness_Nm_per_rad = 1e6;
  Plant plant(free_mass(), hand, {});
  HandTarget target;
  target.pose = {{0.1, 0, 0}, quat_from_rotation_vector(Vec3d{0.2, 0.1, 0})};
  run(plant, 1.0, {}, target);
  CHECK(norm(plant.pose().position - target.pose.position) < 1e-9);
  CHECK(norm(small_rotation_vector(plant.pose().rotation * conjugate(target.pose.rotation))) < 1e-9);
  CHECK(plant.kinetic_energy_J() < 1e-12);
}

TEST_CASE("the hand brings the tool to its way points, to within what friction holds") {
  PlantParameters p = free_mass();
  p.damping_Ns_per_m = 0.5;
  p.coulomb_force_N = 0.2;
  p.damping_Nms_per_rad = 2e-3;
  p.coulomb_torque_Nm = 5e-3;
  const std::vector<HandWaypoint> path{{0, {}, {}}, {1, {0.1, -0.05, 0.02}, {0.4, -0.7, 0.9}}};
  const HandModel hand({}, path);
  Plant plant(p, hand.parameters(), {});
  for (int i = 0; i < 12000; ++i) plant.step(kStep_s, {}, false, hand.target_at((i + 1) * kStep_s));
  const HandTarget t = hand.target_at(3.0);
  CHECK(norm(plant.pose().position - t.pose.position) <= 0.2 / 400);
  CHECK(norm(rotation_vector_of(plant.pose().rotation * conjugate(t.pose.rotation))) <= 2 * std::asin(0.5 * 5e-3 / 4));
  CHECK(norm(plant.pose().position) > 0.1);
}

TEST_CASE("a constant torque about any axis turns the tool about it by M t^2 / 2 I") {
  std::mt19937_64 random(1);
  std::normal_distribution<double> gauss;
  for (int i = 0; i < 20; ++i) {
    const Vec3d axis = normalized_or(Vec3d{gauss(random), gauss(random), gauss(random)}, Vec3d{1, 0, 0});
    Plant plant(free_mass(), no_hand(), {});
    run_torque(plant, 0.5, axis * 0.008);  // 8 rad/s^2: 1 rad, inside the pitch limit for every axis
    CHECK(norm(plant.twist().angular - axis * 4.0) < 1e-10);
    const Vec3d turned = rotation_vector_of(plant.pose().rotation);
    CHECK(norm(turned - axis * 1.0) < 2e-3);  // first order in the sub-step
  }
}

TEST_CASE("amplifiers saturate at their limits") {
  PlantParameters p = free_mass();
  p.max_effort = {1, 2, 3, 0.001, 0.002, 0.003};
  Plant plant(p, no_hand(), {});
  run(plant, 0.1, {50, -50, 50, 0, 0, 50});
  CHECK(norm(plant.twist().linear - Vec3d{1, -2, 3} * (0.1 / 0.3)) < 1e-12);
  CHECK(plant.twist().angular.x == Approx(0.003 * 0.1 / 1e-3));
}

TEST_CASE("stops end the motion outwards, leave that along them, and give no energy back") {
  PlantParameters p = free_mass();
  p.stop_radius_m = 0.1;
  Plant plant(p, no_hand(), {});
  for (int i = 0; i < 8000; ++i) {
    plant.step(kStep_s, {5, 1, 0, 0, -0.01, 0}, false, {});
    REQUIRE(norm(plant.pose().position) <= 0.1 * (1 + 1e-12));
    REQUIRE(std::abs(plant.coordinates()[4]) <= kPitchLimit_rad);
  }
  CHECK(plant.coordinates()[4] == -kPitchLimit_rad);
  CHECK(std::abs(plant.twist().angular.y) < 1e-12);
  CHECK(plant.work().stops < 0.0);
  run(plant, 0.05, {-5, 0, 0, 0, 0.01, 0});
  CHECK(norm(plant.pose().position) < 0.099);
  CHECK(plant.coordinates()[4] > -kPitchLimit_rad);
}

TEST_CASE("kinetic energy is the sum of the works, and friction only takes") {
  PlantParameters p = free_mass();
  p.stop_radius_m = 0.08;
  p.damping_Ns_per_m = 0.5;
  p.coulomb_force_N = 0.3;
  p.damping_Nms_per_rad = 2e-3;
  p.coulomb_torque_Nm = 5e-3;
  p.brake_damping_Ns_per_m = 20;
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> effort(-12.0, 12.0), place(-0.1, 0.1), angle(-1.0, 1.0);
  Plant plant(p, {}, {});
  HandTarget target;
  AxisVector e{};
  for (int i = 0; i < 40000; ++i) {
    if (i % 100 == 0) {
      e = {effort(random),      effort(random),      effort(random),
           0.1 * angle(random), 0.1 * angle(random), 0.1 * angle(random)};
      target.pose = {{place(random), place(random), place(random)},
                     quat_from_rotation_vector(Vec3d{angle(random), angle(random), angle(random)})};
      target.twist = {{angle(random), 0, 0}, {0, angle(random), 0}};
    }
    plant.step(kStep_s, e, i % 1000 > 900, target);
    const PlantWork& b = plant.work();
    const double sum = b.motors + b.hand + b.viscous + b.coulomb + b.stops;
    REQUIRE(plant.kinetic_energy_J() == Approx(sum).margin(1e-9));
  }
  CHECK(plant.work().viscous < 0.0);
  CHECK(plant.work().coulomb < 0.0);
  CHECK(plant.work().stops < 0.0);
  CHECK(plant.work().hand > 0.0);
}

TEST_CASE("an arm's tool moves as the forces say, not as its joints bend") {
  const WristedArm arm({0.45, 0.45});
  Plant plant(free_mass(), no_hand(), {}, arm);
  const Wrenchd wrench{{0.3, -0.4, 0.2}, {0.001, 0.002, -0.001}};
  const double time_s = 0.4;
  for (long i = std::lround(time_s / kStep_s); i > 0; --i)
    plant.step(kStep_s, arm.efforts_of(plant.coordinates(), wrench), false, {});
  CHECK(norm(plant.twist().linear - wrench.force * (time_s / 0.3)) < 1e-10);
  CHECK(norm(plant.twist().angular - wrench.torque * (time_s / 1e-3)) < 1e-10);
  // x = F t (t + h) / 2 m; what the path's bend adds in a step is of third order in the step's length.
  CHECK(norm(plant.pose().position - wrench.force * (0.5 * time_s * (time_s + kStep_s) / 0.3)) < 1e-8);
  const Vec3d turned = rotation_vector_of(plant.pose().rotation);
  CHECK(norm(turned - wrench.torque * (0.5 * time_s * (time_s + kStep_s) / 1e-3)) < 1e-7);
}

TEST_CASE("an arm's efforts act on the tool by the transposed Jacobian, its amplifiers saturate axis by axis") {
  const PointArm arm({0.2, 0.1});
  PlantParameters p = free_mass();
  p.has_rotation = false;
  p.max_effort = {0.05, 0.1, 0.02, 0, 0, 0};
  Plant plant(p, no_hand(), {}, arm);
  plant.step(kStep_s, {9, -9, 9, 9, 9, 9}, false, {});
  // At rest axis 0 drives y over 0.1 m, axis 1 x over 0.2 m, axis 2 z over 0.1 m.
  CHECK(norm(plant.motor_wrench().force - Vec3d{-0.5, 0.5, 0.2}) < 1e-14);
  CHECK(plant.motor_wrench().torque == Vec3d{});
}

TEST_CASE("an arm's stops end the motion outwards, leave that along them, and give no energy back") {
  const WristedArm arm({0.45, 0.45});
  PlantParameters p = free_mass();
  p.stop_radius_m = 0.2;
  Plant plant(p, no_hand(), {}, arm);
  double highest_stops = 0;
  for (int i = 0; i < 12000; ++i) {
    const Wrenchd push{{i % 4000 < 2000 ? 5.0 : -5.0, 1, 2}, {0.001, i % 3000 < 1500 ? -0.01 : 0.01, 0}};
    plant.step(kStep_s, arm.efforts_of(plant.coordinates(), push), false, {});
    REQUIRE(norm(plant.pose().position) <= 0.2 * (1 + 1e-9));
    REQUIRE(std::abs(plant.coordinates()[4]) <= kPitchLimit_rad);
    REQUIRE(plant.work().stops <= highest_stops);
    highest_stops = plant.work().stops;
    const PlantWork& b = plant.work();
    REQUIRE(plant.kinetic_energy_J() == Approx(b.motors + b.stops).margin(1e-9));
  }
  CHECK(highest_stops < -0.1);
}

TEST_CASE("a wrist at its stop lets the pitch axis turn no further, and the arm moves on") {
  const WristedArm arm({0.45, 0.45});
  Plant plant(free_mass(), no_hand(), arm.pose_of({0, 0, 0, 0, kPitchLimit_rad - 1e-6, 0}), arm);
  const Wrenchd push{{0, 0.5, 0}, {0, 0.01, 0.003}};
  for (int i = 0; i < 400; ++i) plant.step(kStep_s, arm.efforts_of(plant.coordinates(), push), false, {});
  const AxisVector rate = arm.rates_of(plant.coordinates(), plant.twist());
  CHECK(plant.coordinates()[4] == kPitchLimit_rad);
  CHECK(rate[4] <= 1e-12);
  CHECK(rate[0] > 0.1);
}

TEST_CASE("without rotation the tool keeps its orientation") {
  PlantParameters p = free_mass();
  p.has_rotation = false;
  HandTarget target;
  target.pose.rotation = quat_from_rotation_vector(Vec3d{0.5, 0.2, 0.1});
  Plant plant(p, {}, target.pose);
  run(plant, 0.5, {0, 0, 0, 1, 1, 1}, target);
  CHECK(plant.pose().rotation == Quatd{});
  CHECK(plant.twist().angular == Vec3d{});
}

TEST_CASE("the tool starts in the pose that is asked for, moved inside the stops") {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> angle(-1.3, 1.3);
  for (int i = 0; i < 200; ++i) {
    const AxisVector q{0.01, -0.02, 0.03, 2 * angle(random), angle(random), 2 * angle(random)};
    const Posed pose = CartesianStage().pose_of(q);
    const Plant plant(free_mass(), {}, pose);
    REQUIRE(norm(plant.pose().position - pose.position) < 1e-15);
    REQUIRE(norm(small_rotation_vector(plant.pose().rotation * conjugate(pose.rotation))) < 1e-12);
  }
  PlantParameters p = free_mass();
  p.stop_radius_m = 0.1;
  CHECK(norm(Plant(p, {}, {{1, 2, 3}, {}}).pose().position) == Approx(0.1));
}
