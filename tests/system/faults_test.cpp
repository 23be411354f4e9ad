// Every fault that can be injected, and a late world: the force stays within its limits in every tick, goes to zero in
// time where the rule says zero, latches or recovers as the rules say, and a re-arm brings it back without a restart.
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr std::uint64_t kFaultTick = 1500, kTicks = 5000;

struct FaultCase {
  const char* script;
  bool latches;
  std::vector<Fault> faults;  // that may be named; empty where none latches
};

struct Observed {
  double most_force_N{0}, most_torque_Nm{0}, most_step_N{0};
  bool finite{true};
  std::uint64_t first_sign{0};  // first tick at or after kFaultTick with a sign of trouble
  std::uint64_t zero_from{0};   // first tick from then on with zero force
  std::uint64_t latched_at{0}, cleared_at{0};
  Fault fault{Fault::kNone};
  double force_before_N{0}, force_at_end_N{0};
  std::uint64_t nonzero_while_latched{0};
};

Observed observe(const std::string& script, bool rearm) {
  session::RunOptions options = virtual_options();
  options.inject = script;
  options.rearm = rearm;
  auto session = make_session(scene_text(kPressScene), options);
  Observed o;
  Vec3d last;
  run(*session, kTicks, [&](const loop::TickOutput& out) {
    const Vec3d& force = out.command.wrench.force;
    const double size = norm(force);
    o.finite = o.finite && is_finite(out.command.wrench);
    o.most_force_N = std::max(o.most_force_N, size);
    o.most_torque_Nm = std::max(o.most_torque_Nm, norm(out.command.wrench.torque));
    if (out.tick > 0) o.most_step_N = std::max(o.most_step_N, norm(force - last));
    last = force;
    if (out.tick == kFaultTick - 1) o.force_before_N = size;
    const bool sign = (out.status & (kFrameMissing | kInputRejected)) != 0 || out.fault != Fault::kNone;
    if (out.tick >= kFaultTick && sign && o.first_sign == 0) o.first_sign = out.tick;
    if (o.first_sign != 0 && size == 0 && o.zero_from == 0) o.zero_from = out.tick;
    if (out.fault != Fault::kNone && o.latched_at == 0) {
      o.latched_at = out.tick;
      o.fault = out.fault;
    }
    if (o.latched_at != 0 && out.fault == Fault::kNone && o.cleared_at == 0) o.cleared_at = out.tick;
    if (out.fault != Fault::kNone && out.tick > o.latched_at + 10 && size > 0) ++o.nonzero_while_latched;
    o.force_at_end_N = size;
    return true;
  });
  return o;
}

}  // namespace

TEST_CASE("each injected fault ends in a safe force, latches or recovers by the rule, and a re-arm brings it back") {
  const auto c = GENERATE(values<FaultCase>({
      {"lost@1500", false, {}},
      {"lost/state@1500+5", false, {}},
      {"lost/state@1500+30", true, {Fault::kLinkLost}},
      {"lost/command@1500+2", false, {}},
      {"lost/command@1500+30", true, {Fault::kDeviceBrake, Fault::kDeviceFault}},
      {"late/state@1500+5:3", false, {}},
      {"late/state@1500+60:40", true, {Fault::kLinkLost, Fault::kInputStale}},
      {"duplicated/state@1500+4", false, {}},
      {"duplicated/state@1500+40", true, {Fault::kInputStale}},
      {"corrupted/state@1500+5:3", false, {}},
      {"corrupted/state@1500+40:3", true, {Fault::kLinkLost}},
      {"corrupted/command@1500+40:3", true, {Fault::kDeviceBrake, Fault::kDeviceFault}},
      {"nan@1500", false, {}},
      {"nan@1500+20", true, {Fault::kInputNotFinite}},
      {"nan/command@1500", true, {Fault::kDeviceFault, Fault::kDeviceBrake}},
      {"wild@1500+20", true, {Fault::kInputWorkspace, Fault::kInputJump, Fault::kInputRotation}},
      {"teleport@1500+1000:0.1", true, {Fault::kInputJump}},
      {"frozen@1500+200", true, {Fault::kInputStale, Fault::kLinkLost}},
      {"unplugged@1500+300", true, {Fault::kDeviceUnplugged}},
      {"estop@1500+300", true, {Fault::kEmergencyStop}},
  }));
  INFO(c.script);
  const Observed held = observe(c.script, false);
  CHECK(held.force_before_N > 1.0);  // it did press when the fault came
  CHECK(held.finite);
  CHECK(held.most_force_N <= 30.0 * 1.2);
  CHECK((held.latched_at != 0) == c.latches);
  if (!c.latches) {
    CHECK(held.force_at_end_N > 1.0);  // recovered by itself
    return;
  }
  INFO("fault " << describe(held.fault) << ", first sign at " << held.first_sign << ", latched at " << held.latched_at
                << ", zero from " << held.zero_from);
  CHECK(std::find(c.faults.begin(), c.faults.end(), held.fault) != c.faults.end());
  CHECK(held.zero_from <= held.first_sign + 10);
  CHECK(held.nonzero_while_latched == 0);
  CHECK(held.force_at_end_N == 0);  // latched: nothing comes back by itself
  CHECK(held.cleared_at == 0);

  const Observed rearmed = observe(c.script, true);
  CHECK(rearmed.cleared_at > rearmed.latched_at);
  CHECK(rearmed.finite);
  CHECK(rearmed.most_force_N <= 30.0 * 1.2);
  CHECK(rearmed.zero_from <= rearmed.first_sign + 10);
}

TEST_CASE("a late world: the cycle is longer, the border fades and freezes, the force fades, all of it recovers") {
  const std::uint64_t stall_ticks = GENERATE(10u, 20u, 50u, 100u, 1000u);
  INFO("stalled for " << stall_ticks << " ticks");
  session::RunOptions options = virtual_options();
  options.inject = "stall@1500+" + std::to_string(stall_ticks);
  auto session = make_session(scene_text(kPressScene), options);
  double most_force_N = 0, force_at_end_N = 0, most_step_N = 0;
  std::uint64_t late = 0, frozen = 0, fade_at = 0, zero_at = 0, nonzero_faded = 0;
  Vec3d last;
  bool faulted = false;
  run(*session, kTicks, [&](const loop::TickOutput& out) {
    const double size = norm(out.command.wrench.force);
    most_force_N = std::max(most_force_N, size);
    if (out.tick > 0) most_step_N = std::max(most_step_N, norm(out.command.wrench.force - last));
    last = out.command.wrench.force;
    late += (out.status & kWorldLate) != 0;
    frozen += (out.status & kBorderFrozen) != 0;
    if ((out.status & kWorldFade) != 0 && fade_at == 0) fade_at = out.tick;
    if (fade_at != 0 && zero_at == 0 && size == 0) zero_at = out.tick;
    if ((out.status & kWorldFade) != 0 && out.tick >= fade_at + 10 && size > 0) ++nonzero_faded;
    faulted = faulted || out.fault != Fault::kNone;
    force_at_end_N = size;
    return true;
  });
  CHECK_FALSE(faulted);  // a late world is a condition, not a fault
  CHECK(most_force_N <= 30.0 * 1.2);
  CHECK(most_step_N <= 5.0 + 1e-9);
  CHECK(late >= (stall_ticks > 10 ? stall_ticks - 10 : 0));
  // The stall begins when the report is there, a tick into the cycle: the cycle is then late by the stall less r - 1.
  CHECK((frozen > 0) == (stall_ticks >= 50));  // more than 4 r = 40 ticks late
  CHECK((fade_at != 0) == (stall_ticks > 110));
  if (fade_at != 0) {
    CHECK(zero_at <= fade_at + 10);
    CHECK(nonzero_faded == 0);
  }
  CHECK(force_at_end_N > 1.0);  // recovered by itself
}
