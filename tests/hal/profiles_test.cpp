#include "hal/profiles.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "hal/device_file.h"
#include "hal/plant.h"
#include "rt/text/read_file.h"
#include "rt/text/toml.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr double kStep_s = 2.5e-4;

// A profile's mechanics without a hand, pushed from rest at the centre by a constant wrench.
Plant driven(const DeviceProfile& profile, const Wrenchd& wrench, double time_s) {
  HandParameters no_hand;
  no_hand.stiffness_N_per_m = no_hand.damping_Ns_per_m = no_hand.mass_kg = 0;
  no_hand.stiffness_Nm_per_rad = no_hand.damping_Nms_per_rad = no_hand.inertia_kg_m2 = 0;
  Plant plant(profile.plant, no_hand, {}, profile.kinematics);
  for (long i = std::lround(time_s / kStep_s); i > 0; --i)
    plant.step(kStep_s, profile.kinematics.efforts_of(plant.coordinates(), wrench), false, {});
  return plant;
}

// m dv/dt = F - b v from rest, in semi-implicit sub-steps: b acts on the speed at the end of each.
double speed_after(double time_s, double force, double damping, double mass) {
  return force / damping * (1 - std::pow(1 + kStep_s * damping / mass, -std::round(time_s / kStep_s)));
}

}  // namespace

TEST_CASE("profiles are found by name, and an unknown name is none") {
  REQUIRE(find_profile("virtuose6d") != nullptr);
  CHECK(find_profile("virtuose6d")->properties.has_rotation);
  REQUIRE(find_profile("desk3d") != nullptr);
  CHECK_FALSE(find_profile("desk3d")->properties.has_rotation);
  CHECK(find_profile("desk") == nullptr);
  CHECK(find_profile("") == nullptr);
}

TEST_CASE("a profile's properties give the motion of its simulated mechanics") {
  for (const DeviceProfile& p : all_profiles()) {
    CAPTURE(p.name);
    const haptics::DeviceProperties& is = p.properties;
    const double force_N = is.max_force_N / 2, torque_Nm = is.max_torque_Nm / 2;
    const Plant pushed = driven(p, {{force_N, 0, 0}, {}}, 0.02);
    CHECK(pushed.twist().linear.x ==
          Approx(speed_after(0.02, force_N - is.coulomb_friction_N, is.damping_Ns_per_m, is.mass_kg)).epsilon(1e-9));
    CHECK(norm(driven(p, {{force_N, 0, 0}, {}}, 2).pose().position) == Approx(is.workspace_radius_m).epsilon(1e-3));
    for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, 1}})
      CHECK(norm(driven(p, {is.max_force_N * direction, {}}, kStep_s).motor_wrench().force) == Approx(is.max_force_N));
    CHECK(is.has_rotation == p.plant.has_rotation);
    if (!is.has_rotation) continue;
    const Plant turned = driven(p, {{}, {torque_Nm, 0, 0}}, 5e-3);
    CHECK(turned.twist().angular.x ==
          Approx(speed_after(5e-3, torque_Nm - is.coulomb_friction_Nm, is.damping_Nms_per_rad, is.inertia_kg_m2))
              .epsilon(1e-9));
  }
}

TEST_CASE("a built-in profile has the name and the figures of its file in hal/devices, and no mistake") {
  using haptics::DeviceProperties;
  struct {
    const char *table, *key;
    double DeviceProperties::*property;
    bool of_rotation{false};
  } const figures[] = {
      {"workspace", "radius_m", &DeviceProperties::workspace_radius_m},
      {"workspace", "max_speed_m_per_s", &DeviceProperties::max_speed_m_per_s},
      {"workspace", "max_angular_speed_rad_per_s", &DeviceProperties::max_angular_speed_rad_per_s, true},
      {"limits", "peak_force_N", &DeviceProperties::max_force_N},
      {"limits", "peak_torque_Nm", &DeviceProperties::max_torque_Nm, true},
      {"limits", "continuous_force_N", &DeviceProperties::continuous_force_N},
      {"limits", "continuous_torque_Nm", &DeviceProperties::continuous_torque_Nm, true},
      {"mechanics", "mass_kg", &DeviceProperties::mass_kg},
      {"mechanics", "inertia_kg_m2", &DeviceProperties::inertia_kg_m2, true},
      {"mechanics", "damping_Ns_per_m", &DeviceProperties::damping_Ns_per_m},
      {"mechanics", "damping_Nms_per_rad", &DeviceProperties::damping_Nms_per_rad, true},
      {"mechanics", "coulomb_friction_N", &DeviceProperties::coulomb_friction_N},
      {"mechanics", "coulomb_friction_Nm", &DeviceProperties::coulomb_friction_Nm, true}};
  for (const DeviceProfile& p : all_profiles()) {
    CAPTURE(p.name);
    const auto file = text::read_file(TACTUS_SOURCE_DIR "/hal/devices/" + p.name + ".toml", kMaxDeviceFileBytes);
    REQUIRE(file.has_value());
    text::TomlNode root;
    text::Diagnostics mistakes;
    REQUIRE(text::read_toml(*file, root, mistakes));
    CHECK(root.find("name")->text == p.name);
    for (const auto& figure : figures) {
      if (figure.of_rotation && !p.properties.has_rotation) continue;
      CAPTURE(figure.key);
      const text::TomlNode* value = root.find(figure.table)->find(figure.key);
      REQUIRE(value != nullptr);
      CHECK(p.properties.*figure.property == value->number);
    }
    CHECK(find_mistake(p.description).table == nullptr);
  }
}

TEST_CASE("the built-in encoders give about 10 and 20 micrometres at the centre") {
  const auto at_centre = [](const char* name, unsigned axis) {
    const DeviceProfile& p = *find_profile(name);
    const Twistd column = p.kinematics.twist_of({}, unit_axis(axis));
    return p.quantum[axis] * (axis < 3 ? norm(column.linear) : norm(column.angular));
  };
  for (unsigned i = 0; i < 3; ++i) {
    CHECK(at_centre("virtuose6d", i) == Approx(1e-5).epsilon(0.1));
    CHECK(at_centre("virtuose6d", i + 3) == Approx(1e-4).epsilon(0.1));
    CHECK(at_centre("desk3d", i) == Approx(2e-5).epsilon(0.1));
  }
}

TEST_CASE("a stage's profile has the quanta and the limits of its axes") {
  DeviceDescription d = find_profile("virtuose6d")->description;
  d.kind = KinematicsKind::kStage;
  d.counts_per_m = {1e5, 1e5, 1e5, 0, 0, 0};
  d.counts_per_turn = {0, 0, 0, 62832, 62832, 62832};
  const DeviceProfile p = make_profile(d);
  CHECK(p.quantum[0] == Approx(1e-5));
  CHECK(p.quantum[3] == Approx(2 * 3.14159265358979 / 62832));
  CHECK(p.properties.position_quantum_m == Approx(1e-5 * kSpreadMargin));
  CHECK(p.plant.max_effort[2] == Approx(35.0 * kSpreadMargin));
  CHECK(p.plant.max_effort[5] == Approx(3.0 * kSpreadMargin));
}

TEST_CASE("the firmware is configured validly at every rate, and lets the host's limit through") {
  for (const DeviceProfile& p : all_profiles())
    for (const std::uint32_t period_us : {100u, 250u, 500u, 1000u, 10000u}) {
      const firmware::Config c = firmware_config(p, period_us);
      CHECK(firmware::is_valid(c));
      CHECK(c.period_us == period_us);
      CHECK(static_cast<double>(c.max_force_N) > p.bounds.arm_effort_norm);
      // The worst wrist: a torque M halfway between yaw and roll at the pitch limit has axis efforts M sqrt(1 + sin).
      CHECK(static_cast<double>(c.max_torque_Nm) >=
            p.properties.max_torque_Nm * std::sqrt(1.0 + std::sin(kPitchLimit_rad)));
      for (unsigned i = 0; i < kAxisCount; ++i) {
        CHECK(static_cast<double>(c.max_effort[i]) >= p.plant.max_effort[i]);
        CHECK(static_cast<double>(c.max_speed[i]) > 1.5 * p.bounds.rate[i]);
      }
    }
}

TEST_CASE("figures of a description that cannot hold together are found, with what is accepted") {
  const auto mistake = [](auto&& spoil) {
    DeviceDescription d = find_profile("virtuose6d")->description;
    spoil(d);
    return find_mistake(d);
  };
  const auto key = [&](auto&& spoil) { return std::string(mistake(spoil).key); };
  CHECK(key([](DeviceDescription& d) { d.workspace_radius_m = 0.4; }) == "radius_m");
  CHECK(mistake([](DeviceDescription& d) { d.workspace_radius_m = 0.4; }).accepted.find("at most 0.2") == 0);
  CHECK(key([](DeviceDescription& d) { d.continuous_force_N = 36; }) == "continuous_force_N");
  CHECK(key([](DeviceDescription& d) { d.continuous_torque_Nm = 4; }) == "continuous_torque_Nm");
  CHECK(key([](DeviceDescription& d) { d.kind = KinematicsKind::kPointArm; }) == "peak_torque_Nm");
  CHECK(mistake([](DeviceDescription& d) {
          d.kind = KinematicsKind::kStage;
          d.workspace_radius_m = 2;
        }).key == nullptr);
}
