// The haptic thread on a device through a maker's library (hal/sdk), by the stand-ins for them: what it asks of the
// kernel while the library answers, blocks, refuses, reports a fault or is gone, and while it comes back.
#include <dlfcn.h>

#include <functional>

#include "tests/hal/sdk/stand_in/dhd.h"
#include "tests/hal/sdk/stand_in/hd.h"
#include "tests/system/haptic_thread/trial.h"

using namespace tactus;
using namespace tactus::test;

namespace {

// The proxy begins just above the ground, onto which the hand then pushes it.
const char* const kScene = R"(
effects = ["gravity", "friction"]
[simulation]
ratio = 10
members = 4
[device]
position_m = [0, 0, 0.011]
[coupling]
stiffness_N_per_m = 100
damping_Ns_per_m = 0.2
stiffness_Nm_per_rad = 0.05
damping_Nms_per_rad = 0.0002
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
position_m = [0, 0, 0.011]
[[body]]
shape = "plane"
friction = 0.5
[[body]]
shape = "box"
size_m = [0.02, 0.02, 0.02]
mass_kg = 0.1
position_m = [0.05, 0, 0.01]
)";

constexpr std::uint64_t kHeld = 300;         // ticks in a row in FORCE, before a fault and after it
constexpr double kLeast_N = 0.05;            // before it
constexpr std::uint64_t kPatience = 60'000;  // ticks, beyond all that a loaded machine does

// The state of a library's stand-in, found in the child process by the stand-in's function.
template <class StandIn>
StandIn& truth_of(const char* path, const char* function) {
  void* const handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  REQUIRE(handle != nullptr);
  const auto found = reinterpret_cast<StandIn* (*)()>(dlsym(handle, function));
  REQUIRE(found != nullptr);
  return *found();
}

void move_hand(StandIn& device, double up_m) noexcept { device.hand_z_m = up_m; }
void move_hand(HdStandIn& device, double up_m) noexcept { device.hand_y_mm = 1e3 * up_m; }

// Phases: the hand pushes; the library has a fault until the loop latches one; FORCE again.
template <class StandIn>
class FaultOfLibrary : public RtScript {
 public:
  using Switch = void (*)(StandIn&, bool on);

  FaultOfLibrary(const char* path, const char* function, Switch make_it, Switch fault)
      : path_(path), function_(function), make_it_(make_it), fault_(fault) {}

  void begin() override {
    truth_ = &truth_of<StandIn>(path_, function_);
    if (make_it_ != nullptr) make_it_(*truth_, true);
  }
  unsigned step(const session::Session& session) noexcept override {
    const loop::TickOutput& out = session.driver->output();
    const bool in_force = out.fault == Fault::kNone && session.driver->sample().state == haptics::DeviceState::kForce;
    // If a loaded machine caused a fault before the library's, the hand goes back: after a re-arm the coupling starts
    // at the tool's pose, so its force is zero until the hand pushes again.
    if (in_force) move_hand(*truth_, -0.01);
    if (!in_force && phase_ == 0) move_hand(*truth_, 0);
    held_ = in_force && (phase_ != 0 || out.command.wrench.force.z > kLeast_N) ? held_ + 1 : 0;
    if (phase_ == 0 && held_ == kHeld) {
      phase_ = fault_ != nullptr ? 1 : kOver;
      faults_before_ = session.stats.fault_count;
      if (fault_ != nullptr) fault_(*truth_, true);
    } else if (phase_ == 1 && session.stats.fault_count > faults_before_) {
      phase_ = 2;
      fault_(*truth_, false);
      held_ = 0;
    } else if (phase_ == 2 && held_ == kHeld) {
      phase_ = kOver;
    }
    return phase_;
  }

 private:
  const char *path_, *function_;
  Switch make_it_, fault_;
  StandIn* truth_{nullptr};
  unsigned phase_{0};
  std::uint64_t held_{0}, faults_before_{0};
};

void check(const char* device, RtScript& script, bool faulty) {
  Counts counts;
  // Without a fault of the library only a loaded machine can latch one: then the trial is repeated.
  for (int i = 0; i < 5; ++i) {
    counts = run_trial({.ticks = kPatience, .scene_of_test = kScene, .device = device, .script = &script});
    if (faulty || counts.latched == 0) break;
  }
  CHECK(counts.phase == RtScript::kOver);
  check_clean(counts, counts.ticks);
  CHECK(counts.ticks >= kHeld);
  CHECK((counts.latched > 0) == faulty);
}

}  // namespace

TEST_CASE("nor on a device of Force Dimension's library, whole or with faults", "[no-asan][no-tsan]") {
  struct Case {
    const char* what;
    FaultOfLibrary<StandIn>::Switch make_it, fault;
  };
  const auto omega = [](StandIn&, bool) {};
  const Case one = GENERATE_COPY(values<Case>({
      {"three axes", omega, nullptr},
      {"six axes",
       [](StandIn& d, bool) {
         d.type = 104;
         d.wrist = true;
       },
       nullptr},
      {"the old sample again", omega, [](StandIn& d, bool on) { d.result = on ? 1 : 0; }},
      {"readings refused", omega, [](StandIn& d, bool on) { d.result = on ? -1 : 0; }},
      {"blocks", omega, [](StandIn& d, bool on) { d.blocks_us = on ? 50'000 : 0; }},
      {"does not return", omega, [](StandIn& d, bool on) { d.hangs = on; }},
      {"gone", omega, [](StandIn& d, bool on) { d.gone = on; }},
      {"forces off", omega,
       [](StandIn& d, bool on) {
         d.refuses_force = on;
         d.forces_on = !on;
       }},
  }));
  INFO(one.what);
  FaultOfLibrary<StandIn> script(TACTUS_STAND_IN_DHD, "stand_in", one.make_it, one.fault);
  check("dhd:" TACTUS_STAND_IN_DHD, script, one.fault != nullptr);
}

TEST_CASE("nor on a device of 3D Systems' library, whole or with faults", "[no-asan][no-tsan]") {
  struct Case {
    const char* what;
    FaultOfLibrary<HdStandIn>::Switch make_it, fault;
  };
  const auto touch = [](HdStandIn&, bool) {};
  const Case one = GENERATE_COPY(values<Case>({
      {"three axes", touch, nullptr},
      {"six axes", [](HdStandIn& d, bool) { d.output_dof = 6; }, nullptr},
      {"arm too fast", touch, [](HdStandIn& d, bool on) { d.error = on ? 0x0203 : 0; }},
      {"connection lost", touch, [](HdStandIn& d, bool on) { d.error = on ? 0x0302 : 0; }},
      {"an error that loses samples", touch, [](HdStandIn& d, bool on) { d.error = on ? 0x0101 : 0; }},
      {"wants to be calibrated", touch, [](HdStandIn& d, bool on) { d.calibration = on ? 0x5002 : 0x5000; }},
      {"blocks", touch, [](HdStandIn& d, bool on) { d.blocks_us = on ? 50'000 : 0; }},
      {"calls no more", touch, [](HdStandIn& d, bool on) { d.calls = !on; }},
      {"time goes back", touch, [](HdStandIn& d, bool on) { d.backwards = on; }},
      {"no pose", touch, [](HdStandIn& d, bool on) { d.broken_matrix = on; }},
      {"forces off", touch,
       [](HdStandIn& d, bool on) {
         d.refuses_force = on;
         d.forces_on = !on;
       }},
  }));
  INFO(one.what);
  FaultOfLibrary<HdStandIn> script(TACTUS_STAND_IN_HD, "hd_stand_in", one.make_it, one.fault);
  check("openhaptics:" TACTUS_STAND_IN_HD, script, one.fault != nullptr);
}
