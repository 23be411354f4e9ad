// The anytime property: wherever the solver is cut, in every tick of a run, no energy comes from nowhere.
//
// By the energy balance of CaseWorld: kinetic and potential energy and what the contacts' springs hold never rise, so
// kinetic energy never rises beyond external work and released k x^2 / 2.
#include <catch2/catch.hpp>

#include "tools/validation/case_world.h"

using namespace tactus;
using namespace tactus::hard_cases;

namespace {

constexpr BodyId kGround = 1000;

void stack_and_ball(CaseWorld& world) {
  world.add_ground(kGround, 0.5);
  for (BodyId id = 0; id < 4; ++id) world.add_box(id, {0.05, 0.05, 0.05}, 0.2, 0.5, {{0, 0, 0.05 + 0.1 * id}, {}});
  world.add_sphere(10, 0.03, 1.0, 0.5, {0.01, 0, 0.45}, {0.3, 0, -5});
}

void heavy_on_light(CaseWorld& world) {
  world.add_ground(kGround, 0.5);
  for (BodyId id = 0; id < 3; ++id) world.add_box(id, {0.05, 0.05, 0.05}, 0.1, 0.5, {{0, 0, 0.05 + 0.1 * id}, {}});
  world.add_box(3, {0.05, 0.05, 0.05}, 100, 0.5, {{0, 0, 0.36}, {}});
}

void heap(CaseWorld& world) {
  world.add_ground(kGround, 0.8);
  for (BodyId id = 0; id < 12; ++id) {
    const Vec3d at{0.06 * (id % 2), 0.05 * (id / 2 % 2), 0.06 + 0.09 * (id / 4)};
    const Quatd turn = quat_from_rotation_vector(Vec3d{0.3 * id, 0.7, 0.2 * id});
    if (id % 3 == 0)
      world.add_sphere(id, 0.03, 0.3, 0.5, at, {0, 0, -1});
    else
      world.add_box(id, {0.03, 0.02, 0.04}, 0.2, 0.5, {at, turn}, {{0.2, 0, -1}, {5, 0, 3}});
  }
}

void sliding_boxes(CaseWorld& world) {
  world.add_ground(kGround, 0.3, 0.4);
  for (BodyId id = 0; id < 4; ++id)
    world.add_box(id, {0.05, 0.03, 0.02}, 0.5, 0.3, {{0.12 * id, 0, 0.06 - 0.05 * id}, {}}, {{2, 0, 0}, {0, 0, 8}});
}

struct Scenario {
  const char* name;
  void (*fill)(CaseWorld&);
};

// At the same sweep in every tick, or, beyond the last of them, wherever a number drawn for the tick says.
struct Cut {
  std::uint32_t at, sweeps;
  std::uint64_t tick{0};
  std::uint32_t fired{0};
  static bool ask(void* self, std::uint32_t sweep) noexcept {
    auto& cut = *static_cast<Cut*>(self);
    if (sweep == 0) ++cut.tick;
    const auto drawn = static_cast<std::uint32_t>((cut.tick * 6364136223846793005ull + 1442695040888963407ull) >> 33);
    const bool fires = sweep >= (cut.at < cut.sweeps ? cut.at : drawn % (cut.sweeps + 1));
    cut.fired += fires;
    return fires;
  }
};

}  // namespace

namespace {

void check_all_cuts(const Scenario& scenario, double hertz) {
  const CaseWorld whole({}, hertz);
  const std::uint32_t sweeps = whole.settings.sub_steps * (1 + whole.settings.relax_sweeps);
  for (std::uint32_t at = 0; at <= sweeps; ++at) {
    CaseWorld world({}, hertz);
    scenario.fill(world);
    Cut cut{at, sweeps};
    world.cut = {Cut::ask, &cut};
    world.run(0.8);
    INFO(scenario.name << ", contacts at " << hertz << " Hz, cut at sweep " << at << " of " << sweeps);
    Outcome outcome;
    world.close(outcome);
    CHECK(outcome.broken_gates == std::vector<std::string>{});
    CHECK(cut.fired > 500);
  }
}

}  // namespace

TEST_CASE("cut after every sweep of every tick, no run gains energy") {
  const auto scenario = GENERATE(values<Scenario>({{"a ball falls on a stack", stack_and_ball},
                                                   {"100 kg on 0.1 kg", heavy_on_light},
                                                   {"a heap", heap},
                                                   {"boxes slide and turn", sliding_boxes}}));
  for (const double hertz : {250.0, 1000.0}) check_all_cuts(scenario, hertz);
}
