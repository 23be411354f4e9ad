// Whole runs on the virtual clock: device faults, a stiff hand, the border, a full sub-world, a late world.
// They have the tick of the device, so no 10 ms step, and the accuracy sets the sub-steps of both worlds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "rt/base/check.h"
#include "rt/base/hash.h"
#include "sim/loader/scene_load.h"
#include "tools/experiment/hard_cases/case_world.h"
#include "tools/experiment/hard_cases/cases.h"
#include "tools/session/virtual_run.h"

namespace tactus::hard_cases {
namespace {

constexpr double kMostForce_N = 30;
constexpr double kMostSlew_N = 5;  // a tick

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
  auto parsed = sim::parse_scene(text, "hard-case");
  if (!parsed.ok()) fmt::print(stderr, "{}\n", parsed.message());
  TACTUS_CHECK(parsed.ok(), bodies.size(), path.size());
  sim::Scene scene = std::move(parsed).value();
  scene.ratio = ratio, scene.members = members;
  const auto settings = settings_of(setting, 1000);
  scene.solver.sub_steps = settings.sub_steps, scene.solver.relax_sweeps = settings.relax_sweeps;
  scene.solver.global_sub_steps_per_tick = scene.solver.far_sub_steps_per_tick = settings.sub_steps;
  scene.solver.contact_hertz = settings.contact_hertz;
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

  // Of the force's size over ticks [from, to).
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
  watched.force.reserve(ticks), watched.status.reserve(ticks);
  const auto summary = session::run_virtual(*watched.session, ticks, [&](const loop::TickOutput& out) {
    watched.force.push_back(out.command.wrench.force), watched.status.push_back(out.status);
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

// The gates of a run: finite, within the force's limits; and its hash into the outcome's.
void gate(const Watched& watched, Outcome& outcome) {
  outcome.gate("finite", watched.finite);
  outcome.gate("force within its limit", watched.largest() <= kMostForce_N * (1 + 1e-9));
  outcome.gate("no fault", !watched.faulted);
  outcome.gate("nothing left out", watched.session->stats.capacity_bits == 0);
  Fnv1a hash;
  hash.add(outcome.hash), hash.add(watched.session->loop->state_hash());
  for (const Vec3d& f : watched.force) hash.add(f.x), hash.add(f.y), hash.add(f.z);
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
  outcome.at_most("largest step of the force, N", watched.largest_step(), kMostSlew_N * (1 + 1e-9));
  outcome.at_most("whole again after, s", slowest, 0.1);
  return outcome;
}

Outcome stiff_wall(const Setting& setting) {
  const haptics::DeviceProperties device;
  const haptics::AxisLimits axis{1e-3, device.delay_s, device.mass_kg, device.damping_Ns_per_m, 0, 0};
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
      if (late) least = std::min(least, norm(watched.force[k])), rise = std::max(rise, norm(watched.force[k]) - least);
    }
    outcome.holds(fmt::format("presses again after {} late ticks", ticks), watched.mean(3800, 4000) > 1);
  }
  outcome.at_most("largest step of the force, N", most, kMostSlew_N * (1 + 1e-9));
  outcome.at_most("step when the world is back, N", back, 0.1);
  outcome.at_most("rise of the force while the world is late, N", rise, 1e-3);
  return outcome;
}

// The scene begins anew at 1.5 s: with the hand on a cube, and with the hand where the cube began that it has pushed
// away.
Outcome begins_anew(const Setting& setting) {
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
    outcome.holds("begins anew", begun);
    most = std::max(most, watched.largest_step());
    double least = norm(watched.force[1500]);
    outcome.holds("the hand is in contact", least > 1);
    for (std::size_t k = 1500; k < watched.force.size(); ++k) {
      const bool resets = (watched.status[k] & kSceneReset) != 0, did = (watched.status[k - 1] & kSceneReset) != 0;
      if (did && !resets) back = std::max(back, norm(watched.force[k] - watched.force[k - 1]));
      if (resets)
        least = std::min(least, norm(watched.force[k])), rise = std::max(rise, norm(watched.force[k]) - least);
    }
    if (presses) outcome.holds("presses again", watched.mean(3800, 4000) > 1);
  }
  outcome.at_most("largest step of the force, N", most, kMostSlew_N * (1 + 1e-9));
  outcome.at_most("step when the force comes back, N", back, 0.1);
  outcome.at_most("rise of the force while the scene begins anew, N", rise, 1e-3);
  outcome.at_most("off the scene's places, m", off, 1e-12);
  return outcome;
}

// --- 32 to 36: the border

// A hand that rests on a stack whose lower part is outside.
Outcome stack_border(const Setting& setting) {
  Outcome outcome;
  for (const unsigned layers : {12u, 24u}) {
    std::string bodies;
    for (unsigned k = 0; k < layers; ++k) bodies += cube({0, 0, 0.05 * (k + 0.5)}, 0.05, 0.1, 0.6);
    const double top = 0.05 * layers;
    const std::vector<Waypoint> path{{0, {0, 0, top + 0.012}}, {1, {0, 0, top + 0.002}}, {1.1, {0, 0, top + 0.002}}};
    session::RunOptions direct;
    direct.coupling = haptics::CouplingScheme::kDirect;
    const Watched reference = watch(make_scene(setting, 1500, path, bodies, 8, layers + 1), direct, 12'000);
    const Watched cut = watch(make_scene(setting, 1500, path, bodies, 8, layers / 2), {}, 12'000);
    gate(reference, outcome), gate(cut, outcome);
    outcome.holds("there is a border", cut.session->stats.border_max > 0);
    outcome.relative(fmt::format("force on {}, N", layers), cut.mean(11'000, 12'000), reference.mean(11'000, 12'000),
                     0.02);
    outcome.at_most(fmt::format("ripple on {}, N", layers), cut.deviation(11'000, 12'000), 1e-3);
  }
  return outcome;
}

// A hand pushes a row of cubes on the ground: free, with its end at a wall, and with 10 mm to the wall.
Outcome chain_border(const Setting& setting) {
  Outcome outcome;
  const double edge = 0.03;
  const unsigned count = 16;
  const double end = edge * count;
  // By then the hand has left the row and comes back at ten times the speed. The cubes have gaps of their own by now,
  // in which blow follows blow: two runs whose gaps differ by a hair are compared as a whole, not tick by tick.
  constexpr std::size_t kSecondBlow = 1400;
  const struct {
    const char* name;
    double wall_at;
  } kinds[] = {{"free", 0}, {"at a wall", end}, {"10 mm off a wall", end + 0.01}};
  for (const auto& kind : kinds) {
    std::string bodies;
    for (unsigned k = 0; k < count; ++k) bodies += cube({edge * (k + 0.5), 0, 0.5 * edge}, edge, 0.1, 0.3);
    if (kind.wall_at > 0)
      bodies += fmt::format(
          "[[body]]\nshape = \"box\"\nfixed = true\nsize_m = [0.1, 0.4, 0.4]\nfriction = 0.3\nposition_m = [{}, 0, "
          "0]\n",
          kind.wall_at + 0.05);
    const double z = 0.5 * edge;
    const std::vector<Waypoint> path{{0, {-0.0102, 0, z}}, {0.5, {0.02, 0, z}},  {0.8, {0.01, 0, z}},
                                     {1.1, {0.03, 0, z}},  {1.4, {-0.02, 0, z}}, {1.6, {0.02, 0, z}},
                                     {1.8, {0.02, 0, z}}};
    session::RunOptions direct;
    direct.coupling = haptics::CouplingScheme::kDirect;
    const Watched reference = watch(make_scene(setting, 1500, path, bodies, 8, count + 1), direct, 2000);
    const Watched cut = watch(make_scene(setting, 1500, path, bodies, 8, 8), {}, 2000);
    gate(reference, outcome), gate(cut, outcome);
    const auto share_off = [&](std::size_t ticks) {
      double off = 0, all = 0;
      for (std::size_t k = 0; k < ticks; ++k)
        off += norm_squared(cut.force[k] - reference.force[k]), all += norm_squared(reference.force[k]);
      return std::sqrt(off / all);
    };
    outcome.at_most(fmt::format("{}: force off the direct coupling's, share", kind.name), share_off(kSecondBlow), 0.05);
    outcome.at_most(fmt::format("{}: after a blow at 0.2 m/s too, share", kind.name), share_off(2000), 0.1);
    outcome.at_most(fmt::format("{}: largest kinetic energy, J", kind.name), cut.most_energy_J,
                    1.1 * reference.most_energy_J);
  }
  return outcome;
}

// A member on a border contact, pressed with i and pulled with a part of mu i: the contact holds or lets go.
Outcome friction_point(const Setting& setting) {
  Outcome outcome;
  const double mass = 0.5, half = 0.05, friction = 0.4, press = 10;
  for (const double part : {0.99, 1.01}) {
    physics::Capacities capacities;
    capacities.border_contacts = 4;
    CaseWorld world(setting, 1000, capacities);
    world.settings.gravity = {};
    world.energy_is_booked = false;  // the border's work is its own book
    world.add_box(0, {half, half, half}, mass, 0.5, {});
    world.body(0).inertia = {1e6, 1e6, 1e6};  // pressed on one point it would tip over
    physics::BorderContact<double> contact;
    contact.member = 0, contact.outside = 9;
    contact.normal = {0, 0, 1};
    contact.member_anchor = contact.line_point = {0, 0, -half};
    contact.impulse_rate = press + 5, contact.friction = friction;
    world.world.border_mode = physics::BorderMode::kCapped;
    TACTUS_CHECK(world.world.add_border_contact(contact), 0, 0);
    world.hold(0, {{0, 0, -press}, {}});
    world.run(0.3);
    const double pull = part * friction * press;
    world.hold(0, {{pull, 0, -press}, {0, -half * pull, 0}});
    world.run(0.2);
    if (part < 1)
      outcome.at_most("speed at 0.99, m/s", norm(world.velocity(0).linear), 1e-5);
    else
      outcome.holds("slips at 1.01", world.velocity(0).linear.x > 0.01);
    const std::uint64_t last = outcome.hash;
    world.close(outcome);
    outcome.hash ^= last;
  }
  return outcome;
}

// The proxy swings above a row of cubes without touching: bodies come and go, none of them may notice.
Outcome thrash(const Setting& setting) {
  std::string bodies;
  for (int k = 0; k < 5; ++k) bodies += cube({0.06 * (k - 2), 0, 0.025}, 0.05, 0.2, 0.5);
  std::vector<Waypoint> path;
  for (int k = 0; k <= 20; ++k) path.push_back({0.5 * k, {k % 2 == 0 ? -0.1 : 0.1, 0, 0.0615}});
  const Watched watched = watch(make_scene(setting, 1500, path, bodies, 8, 4), {}, 10'000);
  Outcome outcome;
  gate(watched, outcome);
  outcome.holds("bodies come and go", watched.session->global->statistics().joins > 10);
  double moved = 0, energy = 0;
  for (const auto& body : watched.session->global->world().bodies()) {
    if (body.id == watched.session->scene.proxy) continue;
    moved =
        std::max(moved, norm(body.motion.pose.position - watched.session->scene.bodies[body.id].motion.pose.position));
    energy += 0.5 * body.mass * norm_squared(body.motion.velocity.linear);
  }
  outcome.at_most("kinetic energy of the cubes, J", energy, 1e-6);
  outcome.at_most("moved, m", moved, 50e-6);
  return outcome;
}

// A hand taps on a stack that sleeps: awake before it is touched, and it answers in that very tick.
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
        if (touched != 0 && answered == 0 && members.slot_of(hit) >= 0 &&
            members.bodies()[static_cast<std::size_t>(members.slot_of(hit))].motion.velocity != Twistd{})
          answered = out.tick;
      });
  Outcome outcome;
  gate(watched, outcome);
  outcome.relative("asleep before the tap", static_cast<double>(asleep), 5, 0);
  outcome.holds("touched and answered", touched > 0 && answered >= touched);
  outcome.at_most("ticks from touch to answer", static_cast<double>(answered) - static_cast<double>(touched), 1);
  return outcome;
}

// A heap that hangs together, of which the sub-world has room for 64.
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
  scene.solver.sub_steps = settings.sub_steps, scene.solver.relax_sweeps = settings.relax_sweeps;
  const Watched watched = watch(std::move(scene), {}, 1500);
  Outcome outcome;
  gate(watched, outcome);
  outcome.at_most("members", watched.session->stats.members_max, 64);
  outcome.holds("more hang together", watched.session->global->statistics().most_component > 64);
  outcome.at_most("largest step of the force, N", watched.largest_step(), kMostSlew_N * (1 + 1e-9));
  // The heap's cubes may settle; nothing may fly: the energy of all members falling by a cube's edge.
  outcome.at_most("kinetic energy of the members, J", watched.most_energy_J, 64 * 0.075 * kGravity * 0.05);
  return outcome;
}

}  // namespace

std::vector<HardCase> session_cases() {
  return {
      {18, "samples that cannot be", false, bad_samples},
      {31, "stiffest coupling on a wall for 30 s", false, stiff_wall},
      {32, "stack with a border through it", false, stack_border},
      {33, "row of cubes with a border through it", false, chain_border},
      {34, "friction at the border, 0.99 and 1.01", false, friction_point},
      {35, "members come and go", false, thrash},
      {36, "heap larger than the sub-world", false, full_sub_world},
      {37, "late global world", false, late_world},
      {38, "scene begins anew in mid-contact", false, begins_anew},
      {41, "tap on a stack that sleeps", false, tap_on_sleepers},
  };
}

}  // namespace tactus::hard_cases
