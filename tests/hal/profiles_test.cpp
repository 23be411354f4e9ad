#include "hal/profiles.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace tactus;
using namespace tactus::hal;

TEST_CASE("profiles are found by name, and an unknown name is none") {
  REQUIRE(find_profile("virtuose6d") != nullptr);
  CHECK(find_profile("virtuose6d")->properties.has_rotation);
  REQUIRE(find_profile("desk3d") != nullptr);
  CHECK_FALSE(find_profile("desk3d")->properties.has_rotation);
  CHECK(find_profile("desk") == nullptr);
  CHECK(find_profile("") == nullptr);
}

TEST_CASE("what a profile promises is what its mechanics are") {
  for (const DeviceProfile& p : all_profiles()) {
    CAPTURE(std::string(p.name));
    CHECK(p.properties.mass_kg == p.plant.mass_kg);
    CHECK(p.properties.damping_Ns_per_m == p.plant.damping_Ns_per_m);
    CHECK(p.properties.inertia_kg_m2 == p.plant.inertia_kg_m2);
    CHECK(p.properties.damping_Nms_per_rad == p.plant.damping_Nms_per_rad);
    CHECK(p.properties.has_rotation == p.plant.has_rotation);
    CHECK(p.plant.stop_radius_m <= p.properties.workspace_radius_m);
    CHECK(p.properties.continuous_force_N <= p.properties.max_force_N);
    for (unsigned i = 0; i < 3; ++i) {
      CHECK(p.quantum[i] == p.properties.position_quantum_m);
      CHECK(p.quantum[i + 3] == p.properties.rotation_quantum_rad);
      CHECK(p.plant.max_effort[i] == p.properties.max_force_N);
      CHECK(p.plant.max_effort[i + 3] == p.properties.max_torque_Nm);
    }
  }
}

TEST_CASE("the firmware is configured validly at every rate, and lets the host's limit through") {
  for (const DeviceProfile& p : all_profiles())
    for (const std::uint32_t period_us : {100u, 250u, 500u, 1000u, 10000u}) {
      const firmware::Config c = firmware_config(p, period_us);
      CHECK(firmware::is_valid(c));
      CHECK(c.period_us == period_us);
      CHECK(static_cast<double>(c.max_force_N) > p.properties.max_force_N);
      // The worst wrist: a torque M halfway between yaw and roll at the pitch limit has axis efforts M sqrt(1 + sin).
      CHECK(static_cast<double>(c.max_torque_Nm) >=
            p.properties.max_torque_Nm * std::sqrt(1.0 + std::sin(kPitchLimit_rad)));
      CHECK(static_cast<double>(c.max_speed[0]) > 1.5 * p.properties.max_speed_m_per_s);
    }
}
