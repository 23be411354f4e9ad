// Whole runs on the virtual clock: device faults, a stiff hand, the border, a full sub-world, a late world.
// They run at the device's tick, so there is no 10 ms step. The accuracy sets the sub-steps of both worlds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "rt/base/check.h"
#include "rt/base/hash.h"
#include "sim/loader/scene_load.h"
#include "tools/experiment/coupling/scheme.h"
#include "tools/session/virtual_run.h"
#include "tools/validation/case_scene.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

constexpr double kMaxSlew_N = 5;  // a tick

constexpr const char* kHead = R"(
title = "Hard case"
effects = ["gravity", "friction", "gyroscopic"]
[device]
position_m = [{0}, 0, {1}]
[coupling]
stiffness_N_per_m = {2}
damping_Ns_per_m = 5
stiffness_Nm_per_rad = 4
damping_Nms_per_rad = 0.02
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
friction = 0.5
position_m = [{0}, 0, {1}]
[[body]]
shape = "plane"
friction = 0.3
)";

struct Waypoint {
  double time_s;
  Vec3d at;
};

// Proxy and device begin at the first way point; `bodies` is TOML.
sim::Scene make_scene(const Setting& setting, double stiffness, const std::vector<Waypoint>& path,
                      const std::string& bodies, unsigned ratio = 10, unsigned members = 8) {
  std::string text = fmt::format(fmt::runtime(kHead), path.front().at.x, path.front().at.z, stiffness) + bodies;
  text += "[hand]\nrepeat = false\npath = [\n";
  for (const Waypoint& p : path)
    text += fmt::format("{{time_s = {}, position_m = [{}, {}, {}]}},\n", p.time_s, p.at.x, p.at.y, p.at.z);
  text += "]\n";
  sim::Scene scene = case_scene(text, setting, 1000);
  scene.ratio = ratio;
  scene.members = members;
  return scene;
}

std::string cube(const Vec3d& at, double edge, double mass, double friction) {
  return fmt::format(
      "[[body]]\nshape = \"box\"\nsize_m = [{0}, {0}, {0}]\nmass_kg = {1}\nfriction = {2}\nposition_m = [{3}, {4}, "
      "{5}]\n",
      edge, mass, friction, at.x, at.y, at.z);
}

struct Watched {
  std::vector<Vec3d> force;  // commanded, by tick
  std::vector<std::uint32_t> status;
  double most_energy_J{0};  // kinetic, of the members
  bool finite{true}, faulted{false};
  std::unique_ptr<session::Session> session;

  // Mean magnitude of the force over ticks [from, to).
  double mean(std::size_t from, std::size_t to) const {
    double sum = 0;
    for (std::size_t k = from; k < to; ++k) sum += norm(force[k]);
    return sum / static_cast<double>(to - from);
  }
  double deviation(std::size_t from, std::size_t to) const {
    const double middle = mean(from, to);
    double sum = 0;
    for (std::size_t k = from; k < to; ++k) sum += (norm(force[k]) - middle) * (norm(force[k]) - middle);
    return std::sqrt(sum / static_cast<double>(to - from));
  }
  double largest_step() const {
    double most = 0;
    for (std::size_t k = 1; k < force.size(); ++k) most = std::max(most, norm(force[k] - force[k - 1]));
    return most;
  }
  double largest() const {
    double most = 0;
    for (const Vec3d& f : force) most = std::max(most, norm(f));
    return most;
  }
};

// `each`: called after every tick; may be empty.
Watched watch(sim::Scene scene, session::RunOptions options, std::uint64_t ticks,
              const std::function<void(const session::Session&, const loop::TickOutput&)>& each = {}) {
  options.virtual_time = true;
  options.duration_s = 1e-3 * static_cast<double>(ticks);
  auto made = session::Session::create(std::move(scene), options);
  if (!made.ok()) fmt::print(stderr, "{}\n", made.message());
  TACTUS_CHECK(made.ok(), ticks, 0);
  Watched watched;
  watched.session = std::move(made).value();
  watched.force.reserve(ticks);
  watched.status.reserve(ticks);
  const auto summary = session::run_virtual(*watched.session, ticks, [&](const loop::TickOutput& out) {
    watched.force.push_back(out.command.wrench.force);
    watched.status.push_back(out.status);
    watched.finite = watched.finite && is_finite(out.command.wrench);
    watched.faulted = watched.faulted || out.fault != Fault::kNone;
    watched.most_energy_J =
        std::max(watched.most_energy_J, watched.session->loop->sub_world().world().kinetic_energy());
    if (each) each(*watched.session, out);
    return true;
  });
  TACTUS_CHECK(summary.ok(), ticks, 0);
  return watched;
}

// Adds the gates of a run (finite values, force within its limits) and its hash to the outcome.
void gate(const Watched& watched, Outcome& outcome) {
  outcome.gate("finite", watched.finite);
  outcome.gate("force within its limit", watched.largest() <= kMaxForce_N * (1 + 1e-9));
  outcome.gate("no fault", !watched.faulted);
  outcome.gate("nothing left out", watched.session->stats.capacity_bits == 0);
  Fnv1a hash;
  hash.add(outcome.hash);
  hash.add(watched.session->loop->state_hash());
  for (const Vec3d& f : watched.force) {
    hash.add(f.x);
    hash.add(f.y);
    hash.add(f.z);
  }
  outcome.hash = hash.value();
}

// A hand presses on a cube of 1 kg with about 2 N from 0.6 s on.
sim::Scene press_scene(const Setting& setting, double stiffness) {
  return make_scene(setting, stiffness, {{0, {0, 0, 0.115}}, {0.5, {0, 0, 0.104}}, {0.6, {0, 0, 0.104}}},
                    cube({0, 0, 0.05}, 0.1, 1, 0.5));
}

// --- 18, 31, 37, 38

Outcome bad_samples(const Setting& setting) {
  session::RunOptions options;
  options.inject =
      "nan@1500+2,wild@2000+2,frozen@2500+5,lost/state@3000+5,corrupted/state@3500+5:3,"
      "teleport@4000+2:0.1,teleport@4500+2:-0.05";
  const Watched watched = watch(press_scene(setting, 1500), options, 5500);
  Outcome outcome;
  gate(watched, outcome);
  const double held = watched.mean(1300, 1500);
  double slowest = 0;
  for (const std::size_t at : {1500u, 2000u, 2500u, 3000u, 3500u, 4000u, 4500u}) {
    std::size_t last_off = at;
    for (std::size_t k = at; k < at + 400; ++k)
      if (std::abs(norm(watched.force[k]) / norm(watched.force[at + 399]) - 1) > 0.05) last_off = k + 1;
    slowest = std::max(slowest, 1e-3 * static_cast<double>(last_off - at));
  }
  outcome.holds("presses, and does so in the end", held > 1 && watched.mean(5400, 5500) > 0.5 * held);
  outcome.at_most("largest step of the force, N", watched.largest_step(), kMaxSlew_N * (1 + 1e-9));
  outcome.at_most("whole again after, s", slowest, 0.1);
  return outcome;
}

Outcome stiff_wall(const Setting& setting) {
  const haptics::DeviceProperties device;
  const haptics::AxisLimits axis{.period_s = 1e-3,
                                 .delay_s = device.delay_s,
                                 .mass = device.mass_kg,
                                 .damping = device.damping_Ns_per_m,
                                 .coulomb_friction = 0,
                                 .quantum = 0};
  const double allowed = haptics::kAllowedStiffnessShare * haptics::uncoupled_stiffness_limit(axis, 5);
  const sim::Scene scene =
      make_scene(setting, 0.999 * allowed, {{0, {0, 0, 0.02}}, {0.5, {0, 0, 0.002}}, {0.6, {0, 0, 0.002}}}, "");
  const Watched watched = watch(scene, {}, 30'000);
  Outcome outcome;
  gate(watched, outcome);
  outcome.holds("presses", watched.mean(20'000, 30'000) > 1);
  outcome.at_most("ripple of the force, N", watched.deviation(5'000, 30'000), 0.05);
  return outcome;
}

Outcome late_world(const Setting& setting) {
  Outcome outcome;
  double back = 0, most = 0, rise = 0;
  for (const unsigned ticks : {10u, 100u, 1000u}) {
    session::RunOptions options;
    options.inject = fmt::format("stall@1500+{}", ticks);
    const Watched watched = watch(press_scene(setting, 1500), options, 4000);
    gate(watched, outcome);
    most = std::max(most, watched.largest_step());
    double least = norm(watched.force[1500]);
    for (std::size_t k = 1500; k < watched.force.size(); ++k) {
      const bool late = (watched.status[k] & kWorldLate) != 0, was_late = (watched.status[k - 1] & kWorldLate) != 0;
      if (was_late && !late) back = std::max(back, norm(watched.force[k] - watched.force[k - 1]));
      if (late) {
        least = std::min(least, norm(watched.force[k]));
        rise = std::max(rise, norm(watched.force[k]) - least);
      }
    }
    const auto seen = [&](StatusBit bit) {
      return std::any_of(watched.status.begin(), watched.status.end(), [bit](auto s) { return (s & bit) != 0; });
    };
    outcome.holds(fmt::format("border at rest while {} ticks late, from 4 cycles on", ticks),
                  seen(kBorderFrozen) == (ticks >= 100));
    outcome.holds(fmt::format("the force fades while {} ticks late, from 0.1 s on", ticks),
                  seen(kWorldFade) == (ticks > 100));
    outcome.holds(fmt::format("presses again after {} late ticks", ticks), watched.mean(3800, 4000) > 1);
  }
  outcome.at_most("largest step of the force, N", most, kMaxSlew_N * (1 + 1e-9));
  outcome.at_most("step when the world is back, N", back, 0.1);
  outcome.at_most("rise of the force while the world is late, N", rise, 1e-12);  // rounding alone
  return outcome;
}

// Scene reset at 1.5 s: with the hand on a cube, and with the hand at the initial position of a cube that it has pushed
// away.
Outcome reset_in_contact(const Setting& setting) {
  const std::string pressed_cube = cube({0, 0, 0.05}, 0.1, 1, 0.5);
  const std::vector<Waypoint> press{{0, {0, 0, 0.115}},   {0.5, {0, 0, 0.104}}, {2.2, {0, 0, 0.104}},
                                    {2.5, {0, 0, 0.115}}, {3.0, {0, 0, 0.098}}, {3.1, {0, 0, 0.098}}};
  const std::vector<Waypoint> push{{0, {-0.065, 0, 0.05}}, {0.1, {-0.065, 0, 0.05}}, {1.4, {0.01, 0, 0.05}}};
  Outcome outcome;
  double most = 0, back = 0, rise = 0, off = 0;
  for (const bool presses : {true, false}) {
    session::RunOptions options;
    options.inject = "reset@1500";
    bool begun = false;
    const Watched watched = watch(
        make_scene(setting, 1500, presses ? press : push, pressed_cube), options, 4000,
        [&](const session::Session& session, const loop::TickOutput&) {
          if (begun || session.loop->sub_world().epoch() == 0) return;
          begun = true;
          for (const auto& body : session.global->bodies())
            if (body.id != session.scene.proxy)
              off = std::max(off, norm(body.motion.pose.position - session.scene.bodies[body.id].motion.pose.position));
        });
    gate(watched, outcome);
    outcome.holds("is reset", begun);
    most = std::max(most, watched.largest_step());
    double least = norm(watched.force[1500]);
    outcome.holds("the hand is in contact", least > 1);
    for (std::size_t k = 1500; k < watched.force.size(); ++k) {
      const bool resets = (watched.status[k] & kSceneReset) != 0, did = (watched.status[k - 1] & kSceneReset) != 0;
      if (did && !resets) back = std::max(back, norm(watched.force[k] - watched.force[k - 1]));
      if (resets) {
        least = std::min(least, norm(watched.force[k]));
        rise = std::max(rise, norm(watched.force[k]) - least);
      }
    }
    if (presses) outcome.holds("presses again", watched.mean(3800, 4000) > 1);
  }
  outcome.at_most("largest step of the force, N", most, kMaxSlew_N * (1 + 1e-9));
  outcome.at_most("step when the force comes back, N", back, 0.1);
  outcome.at_most("rise of the force while the scene is reset, N", rise, 1e-3);
  outcome.at_most("off the scene's places, m", off, 1e-12);
  return outcome;
}

// --- 32, 35, 36: the border

// A hand at rest on a stack whose lower bodies are outside bodies.
Outcome stack_border(const Setting& setting) {
  Outcome outcome;
  for (const unsigned layers : {12u, 24u}) {
    std::string bodies;
    for (unsigned k = 0; k < layers; ++k) bodies += cube({0, 0, 0.05 * (k + 0.5)}, 0.05, 0.1, 0.6);
    const double top = 0.05 * layers;
    const std::vector<Waypoint> path{{0, {0, 0, top + 0.012}}, {1, {0, 0, top + 0.002}}, {1.1, {0, 0, top + 0.002}}};
    session::RunOptions direct;
    direct.coupling = experiment::kDirectScheme.coupling;
    const Watched reference = watch(make_scene(setting, 1500, path, bodies, 8, layers + 1), direct, 12'000);
    const Watched cut = watch(make_scene(setting, 1500, path, bodies, 8, layers / 2), {}, 12'000);
    gate(reference, outcome);
    gate(cut, outcome);
    outcome.holds("there is a border", cut.session->stats.border_max > 0);
    outcome.relative(fmt::format("force on {}, N", layers), cut.mean(11'000, 12'000), reference.mean(11'000, 12'000),
                     0.02);
    outcome.at_most(fmt::format("ripple on {}, N", layers), cut.deviation(11'000, 12'000), 1e-3);
  }
  return outcome;
}

// The hand presses on a bar and goes to and fro on it, four times a second: the cubes beside the bar repeatedly enter
// and leave the sub-world, which must not change their motion or the force on the hand.
Outcome thrash(const Setting& setting) {
  std::string bodies =
      "[[body]]\nshape = \"box\"\nsize_m = [0.4, 0.02, 0.05]\nmass_kg = 2\nfriction = 0.5\nposition_m = [0, 0, "
      "0.025]\n";
  constexpr double x = 0.041;  // 16 mm to the near faces
  for (const double y : {-0.0385, 0.0385})
    bodies += cube({x, y, 0.025}, 0.05, 0.05, 0.5) + cube({-x, y, 0.025}, 0.05, 0.05, 0.5);
  constexpr double kTop = 0.06, kDither_m = 0.01, kEvery_s = 0.125, kPress_m = 0.01;
  constexpr std::size_t kSettled = 1500, kTicks = 10'000;
  std::vector<Waypoint> path{{0, {0, 0, kTop + 0.002}}, {0.5, {0, 0, kTop - kPress_m}}};
  for (int k = 0; k <= 76; ++k)
    path.push_back({0.6 + kEvery_s * k, {k % 2 == 0 ? -kDither_m : kDither_m, 0, kTop - kPress_m}});
  double energy = 0;
  const Watched watched = watch(make_scene(setting, 1500, path, bodies, 8, 4), {}, kTicks,
                                [&](const session::Session& session, const loop::TickOutput& out) {
                                  if (out.tick < kSettled) return;
                                  double all = 0;
                                  for (const auto& body : session.global->bodies())
                                    if (body.mass < 0.1) all += kinetic_energy(body);
                                  energy = std::max(energy, all);
                                });
  Outcome outcome;
  gate(watched, outcome);
  const double joins = static_cast<double>(watched.session->global->statistics().joins);
  outcome.holds("bodies come and go", joins > 50);
  const double held = watched.mean(kSettled, kTicks);
  outcome.holds("the hand presses", held > 1);
  double step = 0;
  for (std::size_t k = kSettled; k < kTicks; ++k) step = std::max(step, norm(watched.force[k] - watched.force[k - 1]));
  outcome.at_most("largest step of the force, share", step / held, 0.07);
  outcome.at_most("kinetic energy of the cubes at any time, J", energy, 1e-6);
  return outcome;
}

// A hand taps on a stack that sleeps: it must be awake before the contact and react in the tick of the contact.
Outcome tap_on_sleepers(const Setting& setting) {
  std::string bodies;
  for (unsigned k = 0; k < 5; ++k) bodies += cube({0, 0, 0.05 * (k + 0.5)}, 0.05, 0.2, 0.5);
  const double top = 0.25;
  sim::Scene scene =
      make_scene(setting, 1500, {{0, {0, 0, top + 0.1}}, {1, {0, 0, top + 0.005}}, {1.2, {0, 0, top + 0.005}}}, bodies);
  scene.effects.sleeping = true;
  scene.sleeping.from_start = true;
  BodyId hit = kNoBody;
  for (const auto& body : scene.bodies)
    if (body.kind == physics::BodyKind::kDynamic && body.id != scene.proxy)
      hit = std::max(hit == kNoBody ? 0 : hit, body.id);
  std::uint64_t touched = 0, answered = 0, asleep = 0;
  const Watched watched =
      watch(std::move(scene), {}, 2000, [&](const session::Session& s, const loop::TickOutput& out) {
        if (out.tick == 100) asleep = s.global->statistics().asleep;
        const auto& members = s.loop->sub_world().world();
        const bool contact = (out.status & kProxyContact) != 0;
        if (contact && touched == 0) touched = out.tick;
        if (touched != 0 && answered == 0 && members.find(hit) != nullptr &&
            members.find(hit)->motion.velocity != Twistd{})
          answered = out.tick;
      });
  Outcome outcome;
  gate(watched, outcome);
  outcome.relative("asleep before the tap", static_cast<double>(asleep), 5, 0);
  outcome.holds("touched and answered", touched > 0 && answered >= touched);
  outcome.at_most("ticks from touch to answer", static_cast<double>(answered) - static_cast<double>(touched), 1);
  return outcome;
}

// A heap connected by contacts, larger than the cap of 64 members.
Outcome full_sub_world(const Setting& setting) {
  auto loaded = sim::parse_scene(R"(
title = "A hand in a heap larger than the sub-world"
effects = ["gravity", "friction", "gyroscopic"]
[device]
position_m = [0, 0, 0.42]
[coupling]
stiffness_N_per_m = 1500
damping_Ns_per_m = 5
stiffness_Nm_per_rad = 4
damping_Nms_per_rad = 0.02
[proxy]
shape = "sphere"
radius_m = 0.015
mass_kg = 0.2
friction = 0.5
position_m = [0, 0, 0.42]
[[body]]
shape = "plane"
friction = 0.5
[[generate]]
kind = "pile"
count = 512
layers = 8
cube_m = 0.05
mass_kg = 0.075
friction = 0.5
[hand]
repeat = false
path = [
  {time_s = 0.0, position_m = [0, 0, 0.42]},
  {time_s = 0.5, position_m = [0, 0, 0.40]},
  {time_s = 1.2, position_m = [0.01, 0, 0.40]},
  {time_s = 1.3, position_m = [0.01, 0, 0.40]},
]
)",
                                 "heap");
  TACTUS_CHECK(loaded.ok(), 0, 0);
  sim::Scene scene = std::move(loaded).value();
  const auto settings = settings_of(setting, 250);
  scene.solver.sub_steps = settings.sub_steps;
  scene.solver.relax_sweeps = settings.relax_sweeps;
  const Watched watched = watch(std::move(scene), {}, 1500);
  Outcome outcome;
  gate(watched, outcome);
  outcome.at_most("members", watched.session->stats.members_max, 64);
  outcome.holds("more hang together", watched.session->global->statistics().most_component > 64);
  outcome.at_most("largest step of the force, N", watched.largest_step(), kMaxSlew_N * (1 + 1e-9));
  // The cubes may settle but not be ejected. Bound: the energy of all members falling by a cube's edge.
  outcome.at_most("kinetic energy of the members, J", watched.most_energy_J, 64 * 0.075 * kGravity * 0.05);
  return outcome;
}

}  // namespace

std::vector<HardCase> session_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms.
  return {
      {18, "samples that cannot be", false, bad_samples},
      {31, "stiffest coupling on a wall for 30 s", false, stiff_wall},
      {32, "stack with a border through it", false, stack_border},
      {35, "members come and go", false, thrash},
      {36, "heap larger than the sub-world", false, full_sub_world},
      {37, "late global world", false, late_world},
      {38, "scene is reset in mid-contact", false, reset_in_contact},
      {41, "tap on a stack that sleeps", false, tap_on_sleepers},
  };
}

}  // namespace tactus::hard_cases
