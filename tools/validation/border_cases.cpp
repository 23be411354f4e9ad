// Hard cases of the border: a row of bodies with a hand of prescribed motion, and friction at one contact.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/base/check.h"
#include "rt/base/hash.h"
#include "tools/experiment/coupling/coupled_worlds.h"
#include "tools/experiment/coupling/scheme.h"
#include "tools/validation/case_scene.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

// --- 33: a row of 24 bodies of 0.1 m, of which 8 are members; the first is the proxy, of 0.2 kg

constexpr unsigned kBodies = 24, kMembers = 8, kRatio = 8;
constexpr std::size_t kRowTicks = 2000;
constexpr double kEdge_m = 0.1, kRowHertz = 250;

sim::Scene row_scene(const Setting& setting, double wall_off_m) {
  std::string text = R"(
title = "Row of cubes"
effects = ["gravity", "friction", "gyroscopic"]
[simulation]
ratio = 8
members = 8
[device]
position_m = [0, 0, 0.05]
[coupling]
stiffness_N_per_m = 2000
damping_Ns_per_m = 4
stiffness_Nm_per_rad = 5
damping_Nms_per_rad = 0.02
[proxy]
shape = "box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 0.2
friction = 0.3
position_m = [0, 0, 0.05]
[[body]]
shape = "plane"
friction = 0.3
)";
  for (unsigned k = 1; k < kBodies; ++k)
    text += fmt::format(
        "[[body]]\nshape = \"box\"\nsize_m = [{0}, {0}, {0}]\nmass_kg = 0.1\nfriction = 0.3\nposition_m = [{1}, 0, "
        "{2}]\n",
        kEdge_m, kEdge_m * k, 0.5 * kEdge_m);
  if (wall_off_m >= 0)
    text += fmt::format(
        "[[body]]\nshape = \"box\"\nfixed = true\nsize_m = [0.1, 1, 1]\nfriction = 0.3\nposition_m = [{}, 0, 0]\n",
        kEdge_m * kBodies + wall_off_m);
  text += "[hand]\nrepeat = false\npath = [{time_s = 0, position_m = [0, 0, 0.05]}]\n";
  return case_scene(text, setting, kRowHertz);
}

// A push at 0.1 m/s, a wobble of 3 mm at 4 Hz, a tap of 20 mm at up to 0.5 m/s. m, along the row.
double hand_at(double t) {
  if (t < 0.5) return 0.1 * t;
  const double wobble = 0.05 + 0.003 * std::sin(2 * kPi * 4 * (t - 0.5));
  return t < 1.5 ? wobble : wobble + 0.01 * (1 - std::cos(2 * kPi * 8 * std::min(t - 1.5, 0.0625)));
}

struct RowRun {
  std::vector<double> force_N;  // on the device, along the row
  double most_kinetic_J{0};     // of all bodies, at synchronisations
  std::uint64_t hash{0};
};

RowRun push_row(const sim::Scene& scene, const experiment::Scheme& scheme) {
  session::RunOptions options;
  scheme.set(options);
  options.members = kMembers;
  experiment::CoupledWorlds worlds(scene, options, {});
  worlds.start_at_rest();
  RowRun run;
  Fnv1a hash;
  for (std::size_t k = 0; k < kRowTicks; ++k) {
    const double t = 1e-3 * static_cast<double>(k), ahead = 1e-6;
    if (worlds.at_synchronisation()) run.most_kinetic_J = std::max(run.most_kinetic_J, worlds.motion().kinetic_J);
    haptics::DeviceTarget target{true, {{hand_at(t), 0, 0.5 * kEdge_m}, {}}, {}};
    target.velocity.linear.x = (hand_at(t + ahead) - hand_at(t - ahead)) / (2 * ahead);
    run.force_N.push_back(worlds.tick(target).on_device.force.x);
    hash.add(run.force_N.back());
  }
  run.hash = hash.value();
  return run;
}

Outcome row_with_border(const Setting& setting) {
  const struct {
    const char* name;
    double wall_off_m;
  } kinds[] = {{"free", -1}, {"at a wall", 0}, {"60 mm off a wall", 0.06}};
  const struct {
    const char* name;
    physics::BorderMode mode;
    double most_off;
  } borders[] = {{"ghost", physics::BorderMode::kGhost, 0.05}, {"capped", physics::BorderMode::kCapped, 0.25}};
  Outcome outcome;
  Fnv1a hash;
  for (const auto& kind : kinds) {
    const sim::Scene scene = row_scene(setting, kind.wall_off_m);
    const RowRun direct = push_row(scene, experiment::kDirectScheme);
    for (const auto& border : borders) {
      const RowRun cut = push_row(scene, {.border = border.mode, .ratio = kRatio});
      double off = 0, all = 0;
      for (std::size_t k = 0; k < kRowTicks; ++k) {
        off += std::pow(cut.force_N[k] - direct.force_N[k], 2);
        all += std::pow(direct.force_N[k], 2);
      }
      outcome.at_most(fmt::format("{}, {}: force off the direct coupling's, share", kind.name, border.name),
                      std::sqrt(off / all), border.most_off);
      outcome.at_most(fmt::format("{}, {}: largest kinetic energy, J", kind.name, border.name), cut.most_kinetic_J,
                      1.1 * direct.most_kinetic_J);
      hash.add(cut.hash);
    }
    hash.add(direct.hash);
  }
  outcome.hash = hash.value();
  return outcome;
}

// --- 34: a member on a border contact with normal impulse i, pulled with a fraction of mu i: the contact sticks or
// slides

Outcome friction_point(const Setting& setting) {
  Outcome outcome;
  const double mass = 0.5, half = 0.05, friction = 0.4, press = 10;
  for (const auto mode : {physics::BorderMode::kCapped, physics::BorderMode::kGhost})
    for (const double part : {0.99, 1.01}) {
      const std::string of =
          fmt::format(" at {:g}, {}", part, mode == physics::BorderMode::kGhost ? "ghost" : "capped");
      physics::Capacities capacities;
      capacities.border_contacts = 4;
      CaseWorld world(setting, 1000, capacities);
      world.settings.gravity = {};
      world.energy_is_checked = false;  // the border's work is accounted separately
      world.add_box(0, {half, half, half}, mass, 0.5, {});
      world.body(0).inertia = {1e6, 1e6, 1e6};  // large, because the body would tip over on a single point
      physics::BorderContact contact;
      contact.member = 0;
      contact.outside = 9;
      contact.normal = {0, 0, 1};
      contact.member_anchor = contact.line_point = {0, 0, -half};
      contact.impulse_rate = press + 5;
      contact.friction = friction;
      world.world.border_rule.mode = mode;
      if (mode == physics::BorderMode::kGhost) {  // ghost of an immovable body
        physics::BorderGhost ghost;
        ghost.outside = contact.outside;
        ghost.centre = {0, 0, -2 * half};
        TACTUS_CHECK(world.world.border_ghosts().try_push(ghost), 0, 0);
        contact.ghost = 0;
      }
      TACTUS_CHECK(world.world.add_border_contact(contact), 0, 0);
      world.hold(0, {{0, 0, -press}, {}});
      world.run(0.3);
      const double pull = part * friction * press;
      world.hold(0, {{pull, 0, -press}, {0, -half * pull, 0}});
      world.run(0.2);
      if (part < 1)
        outcome.at_most("speed" + of + ", m/s", norm(world.velocity(0).linear), 1e-5);
      else
        outcome.holds("slips" + of, world.velocity(0).linear.x > 0.01);
      const std::uint64_t last = outcome.hash;
      world.close(outcome);
      outcome.hash ^= last;
    }
  return outcome;
}

}  // namespace

std::vector<HardCase> border_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms, and in what.
  return {
      {33,
       "row of 24 bodies with a border through it",
       false,
       row_with_border,
       "capped: force off by 26.1 % free, 25 allowed; at a wall 2.4 times the direct coupling's kinetic energy, 1.1 "
       "allowed",
       "",
       {{"free, capped: force off the direct coupling's, share", 0.28},
        {"at a wall, capped: largest kinetic energy, J", 0.018}}},
      {34, "friction at the border, 0.99 and 1.01", false, friction_point},
  };
}

}  // namespace tactus::hard_cases
