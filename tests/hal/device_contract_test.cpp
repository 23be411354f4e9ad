// What every device must do, whatever it is made of. To add one: a word in DEVICES, and where it cannot be made
// without arguments, a type that does it. A device that can tell the force at its mechanism does so by force().
#include <catch2/catch.hpp>
#include <limits>

#include "hal/example_device.h"
#include "hal/falcon/simulated_falcon.h"
#include "hal/linked_device.h"
#include "hal/loopback_link.h"
#include "hal/simulated_device.h"
#include "rt/haptics/input_guard.h"
#include "tests/hal/drives/drive_arms.h"
#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"

using namespace tactus;
using namespace tactus::hal;
using haptics::DeviceCommand;
using haptics::DeviceInput;
using haptics::DeviceProperties;
using haptics::DeviceState;
using haptics::ReadStatus;

namespace {

constexpr double kPeriod_s = 1e-3;

Vec3d force_of(const DeviceProfile& profile, const Plant& plant, const firmware::ControllerOutputs& outputs) {
  AxisVector effort{};
  for (unsigned i = 0; i < kAxisCount; ++i) effort[i] = static_cast<double>(outputs.effort[i]);
  return profile.kinematics.wrench_of(plant.coordinates(), effort).force;
}

template <unsigned kProfile>
struct Simulated : SimulatedDevice {
  Simulated() : SimulatedDevice(all_profiles()[kProfile], HandModel(), {}) {}
  Vec3d force() const { return force_of(all_profiles()[kProfile], plant(), motor_outputs()); }
};

template <unsigned kProfile>
struct OnLoopback {
  LoopbackLink link{all_profiles()[kProfile], HandModel(), 1'000'000};
  LinkedDevice<LoopbackLink> device{all_profiles()[kProfile], 1'000'000, link};

  const DeviceProperties& properties() const { return device.properties(); }
  void read(DeviceInput& input) noexcept { device.read(input); }
  void write(const DeviceCommand& command) noexcept { device.write(command); }
  Vec3d force() const { return force_of(all_profiles()[kProfile], link.plant(), link.motor_outputs()); }
};

using SimulatedVirtuose6d = Simulated<0>;
using SimulatedDesk3d = Simulated<1>;
using Virtuose6dOnLoopback = OnLoopback<0>;
using Desk3dOnLoopback = OnLoopback<1>;

template <class Description>
struct OnDrives {
  std::unique_ptr<SimulatedDriveArm> device{test::open_drives(Description::make())};

  const DeviceProperties& properties() const { return device->properties(); }
  void read(DeviceInput& input) noexcept { device->read(input); }
  void write(const DeviceCommand& command) noexcept { device->write(command); }
  Vec3d force() const { return device->world().commanded_wrench().force; }
  double least_force_N() const { return Description::kLeast_N; }
  unsigned start_periods() const { return Description::kStartPeriods; }
};

struct MitPointArm {
  static DeviceDescription make() { return test::point_arm_of(DriveFamily::kDamiao); }
  // An enabled MIT drive has no zero torque: half a quantum of 3 N m / 4095 on each axis, 2:1, 0.16 m.
  static constexpr double kLeast_N = 1.8 * 2 * 3.0 / 4095 / 0.16;
  static constexpr unsigned kStartPeriods = 0;
};
struct MoteusWristedArm {
  static DeviceDescription make() { return test::wristed_arm_of_moteus(); }
  static constexpr double kLeast_N = 0;
  static constexpr unsigned kStartPeriods = 20;  // 12 ms of the drives, and full_effort_s
};
using PointArmOnMitDrives = OnDrives<MitPointArm>;
using WristedArmOnMoteus = OnDrives<MoteusWristedArm>;

struct FalconInProcess : SimulatedFalcon {
  FalconInProcess() : SimulatedFalcon(HandModel(), 1'000'000) {}
};

#define DEVICES                                                                                                     \
  SimulatedVirtuose6d, SimulatedDesk3d, Virtuose6dOnLoopback, Desk3dOnLoopback, ExampleDevice, PointArmOnMitDrives, \
      WristedArmOnMoteus, FalconInProcess

// The force that the mechanism cannot be without while its drives are enabled.
template <class D>
double least_force_N(const D& device) {
  if constexpr (requires { device.least_force_N(); })
    return device.least_force_N();
  else
    return 0.0;
}

// Periods in FORCE before its motors give force, where they have to start.
template <class D>
unsigned start_periods(const D& device) {
  if constexpr (requires { device.start_periods(); })
    return device.start_periods();
  else
    return 0;
}

// A host that speaks to it once a period.
template <haptics::HapticDevice D>
struct Host {
  D device;
  DeviceInput input;
  DeviceCommand command;

  void tick() {
    device.read(input);
    ++command.sequence;
    device.write(command);
  }
  void ticks(unsigned n) {
    for (unsigned i = 0; i < n; ++i) tick();
  }
  // As long as a command may be on its way, and its answer.
  unsigned patience() const { return 4 + 2 * static_cast<unsigned>(device.properties().delay_s / kPeriod_s); }
  DeviceState state_after(DeviceState wanted) {
    command.wanted = wanted;
    ticks(patience());
    return input.sample.state;
  }
  void rearm() {
    command.wanted = DeviceState::kForce;
    command.rearm = 0;
    ticks(2);
    command.rearm = 1;
    ticks(2);
    command.rearm = 0;
    ticks(patience());
  }
  double some_force_N() const { return 0.5 * device.properties().continuous_force_N; }
};

}  // namespace

TEMPLATE_TEST_CASE("A device: its properties are finite and go together", "", DEVICES) {
  const Host<TestType> host;
  const DeviceProperties& p = host.device.properties();
  for (const double x : {p.workspace_radius_m, p.max_speed_m_per_s, p.max_angular_speed_rad_per_s, p.max_force_N,
                         p.position_quantum_m, p.rotation_quantum_rad, p.mass_kg, p.inertia_kg_m2})
    CHECK((std::isfinite(x) && x > 0.0));
  for (const double x : {p.continuous_force_N, p.max_torque_Nm, p.continuous_torque_Nm, p.damping_Ns_per_m,
                         p.damping_Nms_per_rad, p.delay_s, p.coulomb_friction_N, p.coulomb_friction_Nm})
    CHECK((std::isfinite(x) && x >= 0.0));
  CHECK(p.continuous_force_N <= p.max_force_N);
  CHECK(p.continuous_torque_Nm <= p.max_torque_Nm);
  CHECK((p.max_torque_Nm > 0.0) == p.has_rotation);
  CHECK(p.position_quantum_m < 0.01 * p.workspace_radius_m);
}

TEMPLATE_TEST_CASE("A device: its first sample comes at once, and the input guard accepts all of them", "", DEVICES) {
  Host<TestType> host;
  haptics::InputGuard guard{{.period_s = kPeriod_s, .device = host.device.properties()}, {}};
  host.command.wanted = DeviceState::kForce;
  for (int i = 0; i < 2000; ++i) {
    host.command.wrench.force.x = i % 400 < 200 ? host.some_force_N() : -host.some_force_N();
    host.tick();
    const haptics::GuardedInput guarded = guard.accept(host.input);
    REQUIRE(guarded.fault == Fault::kNone);
    if (i >= 10) REQUIRE(guarded.valid);
  }
}

TEMPLATE_TEST_CASE("A device: sequence and device time rise with every new sample", "", DEVICES) {
  Host<TestType> host;
  std::uint64_t sequence = 0, fresh = 0;
  std::uint64_t time_ns = 0;
  for (int i = 0; i < 1000; ++i) {
    host.tick();
    if (host.input.status != ReadStatus::kFresh) continue;
    if (fresh++ > 0) {
      REQUIRE(host.input.sample.sequence > sequence);
      REQUIRE(host.input.sample.device_time_ns > time_ns);
    }
    sequence = host.input.sample.sequence;
    time_ns = host.input.sample.device_time_ns;
    REQUIRE(norm(host.input.sample.device_from_tool.rotation) == Approx(1.0).epsilon(1e-6));
  }
  CHECK(fresh > 900);
}

TEMPLATE_TEST_CASE("A device: it echoes the command that it has, never one that was not sent", "", DEVICES) {
  Host<TestType> host;
  for (int i = 0; i < 200; ++i) {
    host.device.read(host.input);
    REQUIRE(host.input.sample.echoed_sequence <= host.command.sequence);
    if (i > 20) REQUIRE(host.input.sample.echoed_sequence + host.patience() >= host.command.sequence);
    ++host.command.sequence;
    host.device.write(host.command);
  }
}

TEMPLATE_TEST_CASE("A device: it idles until FORCE is requested, and again when IDLE is requested", "", DEVICES) {
  Host<TestType> host;
  host.tick();
  CHECK((host.input.sample.state == DeviceState::kReset || host.input.sample.state == DeviceState::kIdle));
  CHECK(host.state_after(DeviceState::kIdle) == DeviceState::kIdle);
  CHECK(host.state_after(DeviceState::kForce) == DeviceState::kForce);
  CHECK(host.state_after(DeviceState::kIdle) == DeviceState::kIdle);
  CHECK(host.state_after(DeviceState::kForce) == DeviceState::kForce);
  CHECK(host.input.sample.device_fault == 0);
}

TEMPLATE_TEST_CASE("A device: a brake holds until it is re-armed, by a flag that rises", "", DEVICES) {
  Host<TestType> host;
  REQUIRE(host.state_after(DeviceState::kForce) == DeviceState::kForce);
  CHECK(host.state_after(DeviceState::kBrake) == DeviceState::kBrake);
  CHECK(host.state_after(DeviceState::kIdle) == DeviceState::kBrake);
  CHECK(host.state_after(DeviceState::kForce) == DeviceState::kBrake);
  host.rearm();
  CHECK(host.input.sample.state == DeviceState::kForce);
  host.command.rearm = 1;
  host.ticks(host.patience());  // stuck from here on
  CHECK(host.state_after(DeviceState::kBrake) == DeviceState::kBrake);
  CHECK(host.state_after(DeviceState::kForce) == DeviceState::kBrake);
}

TEMPLATE_TEST_CASE("A device: force appears at the mechanism as it was sent, in FORCE alone", "", DEVICES) {
  Host<TestType> host;
  const double force_N = host.some_force_N();
  for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{-0.6, 0, 0.8}}) {
    host.command.wrench.force = direction * force_N;
    host.state_after(DeviceState::kIdle);
    CHECK(norm(host.device.force()) == 0.0);
    CHECK(host.state_after(DeviceState::kForce) == DeviceState::kForce);
    host.ticks(start_periods(host.device));
    CHECK(norm(host.device.force() - host.command.wrench.force) < 0.02 * force_N);
    host.state_after(DeviceState::kBrake);
    CHECK(norm(host.device.force()) <= least_force_N(host.device));
    host.rearm();
  }
}

TEMPLATE_TEST_CASE("A device: the tool gives way along the force", "", DEVICES) {
  for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{0, -1, 0}}) {
    Host<TestType> host;
    host.state_after(DeviceState::kForce);
    const Vec3d before = host.input.sample.device_from_tool.position;
    host.command.wrench.force = direction * host.some_force_N();
    host.ticks(300);
    const Vec3d way = host.input.sample.device_from_tool.position - before;
    CHECK(dot(way, direction) > 10 * host.device.properties().position_quantum_m);
    CHECK(dot(way, direction) > 0.95 * norm(way));
  }
}

TEMPLATE_TEST_CASE("A device: when commands stop, the force is gone in ten periods and stays away", "", DEVICES) {
  Host<TestType> host;
  host.state_after(DeviceState::kForce);
  host.command.wrench.force.x = host.some_force_N();
  host.ticks(20);
  double before = norm(host.device.force());
  REQUIRE(before > 0.9 * host.some_force_N());
  const unsigned on_their_way = host.patience();
  for (unsigned i = 1; i <= 30; ++i) {
    host.device.read(host.input);
    const double now = norm(host.device.force());
    REQUIRE(now <= before * 1.01 + 2 * least_force_N(host.device));
    if (i >= 10 + on_their_way) REQUIRE(now <= least_force_N(host.device));
    before = now;
  }
  CHECK(host.input.sample.state == DeviceState::kBrake);
  CHECK(host.input.sample.device_fault != 0);
  host.ticks(20);  // the host is back, and asks for nothing new
  CHECK(norm(host.device.force()) <= least_force_N(host.device));
  host.rearm();
  CHECK(host.input.sample.state == DeviceState::kForce);
  host.ticks(start_periods(host.device));
  CHECK(norm(host.device.force()) > 0.9 * host.some_force_N());
}

TEMPLATE_TEST_CASE("A device: a few commands that go missing are no reason to brake", "", DEVICES) {
  Host<TestType> host;
  host.state_after(DeviceState::kForce);
  for (int i = 0; i < 5; ++i) {
    for (int missing = 0; missing < 5; ++missing) host.device.read(host.input);
    host.ticks(5);
    CHECK(host.input.sample.state == DeviceState::kForce);
  }
}

TEMPLATE_TEST_CASE("A device: a value that is not finite never reaches the mechanism, and the device reports it", "",
                   DEVICES) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {kNan, kInfinity, -kInfinity}) {
    Host<TestType> host;
    host.state_after(DeviceState::kForce);
    host.command.wrench.force = {1, wrong, 1};
    for (unsigned i = 0; i < host.patience(); ++i) {
      host.tick();
      REQUIRE(is_finite(host.device.force()));
    }
    host.command.wrench = {};
    host.ticks(host.patience());
    CHECK(host.input.sample.state == DeviceState::kBrake);
    CHECK(host.input.sample.device_fault != 0);
  }
}

TEMPLATE_TEST_CASE("A device: a force far beyond its peak is cut", "", DEVICES) {
  Host<TestType> host;
  host.state_after(DeviceState::kForce);
  const double peak_N = host.device.properties().max_force_N;
  for (const double times : {10.0, 1e3, 1e30}) {
    host.command.wrench.force = {times * peak_N, -times * peak_N, 0};
    for (unsigned i = 0; i < host.patience(); ++i) {
      host.tick();
      REQUIRE(norm(host.device.force()) <= 3.0 * peak_N);  // a device that knows its axes alone cuts there
    }
  }
}

TEMPLATE_TEST_CASE("A device: reading and writing neither allocate nor lock", "[no-asan][no-tsan]", DEVICES) {
  Host<TestType> host;
  host.command.wanted = DeviceState::kForce;
  host.command.wrench.force.x = host.some_force_N();
  host.ticks(10);
  TACTUS_NEEDS(test::RtGuard::available(), "counting allocations needs a build without a sanitizer");
  const test::RtGuard guard;
  host.ticks(2000);
  CHECK(guard.allocations() == 0);
  CHECK(guard.frees() == 0);
  CHECK(guard.locks() == 0);
}
