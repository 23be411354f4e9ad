// The boundary cube: the proxy touches no body before it is a member.
#include "rt/physics/collision/manifold.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

// How deep the proxy, where the hand feels it, is in a body that is no member, where the global world has it [m].
double depth_in_outsiders(const session::Session& session) {
  const auto& members = session.loop->sub_world().world();
  const auto bodies = session.global->world().bodies();
  const physics::Body* proxy = nullptr;
  for (const auto& body : bodies)
    if (body.id == session.scene.proxy) proxy = &body;
  REQUIRE(proxy != nullptr);
  const Posed& felt = session.loop->sub_world().proxy().pose;
  double deepest = 0;
  for (const auto& body : bodies) {
    if (body.id == session.scene.proxy || members.find(body.id) != nullptr) continue;
    physics::AxisCache cache;
    const auto manifold = physics::collide({proxy->shape, felt}, posed_shape(body), {.margin = 0.0}, cache);
    for (std::uint32_t i = 0; i < manifold.count; ++i) deepest = std::max(deepest, -manifold.points[i].separation);
  }
  return deepest;
}

// A floating field of cubes that a fast hand sweeps through: as fast as the device can.
std::string field_scene() {
  std::string text = R"(
title = "Sweep through a field of cubes"
effects = ["friction"]
[simulation]
ratio = 16
members = 24
[device]
position_m = [0, 0, 0]
[coupling]
stiffness_N_per_m = 1500
damping_Ns_per_m = 5
stiffness_Nm_per_rad = 4
damping_Nms_per_rad = 0.02
[proxy]
shape = "box"
size_m = [0.02, 0.06, 0.02]
mass_kg = 0.2
friction = 0.3
position_m = [-0.2, 0, 0]
[hand]
stiffness_N_per_m = 500
repeat = true
path = [
  {time_s = 0.0, position_m = [-0.2, 0, 0]},
  {time_s = 0.9, position_m = [0.2, 0, 0], rotation_vector_rad = [0, 0, 0.6]},
  {time_s = 1.8, position_m = [-0.2, 0.1, 0]},
  {time_s = 2.7, position_m = [-0.2, 0, 0]},
]
)";
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 6; ++y)
      text += "[[body]]\nshape = \"box\"\nsize_m = [0.03, 0.03, 0.03]\nmass_kg = 0.05\nfriction = 0.3\nposition_m = [" +
              std::to_string(-0.13 + 0.05 * x) + ", " + std::to_string(-0.125 + 0.05 * y) + ", 0]\n";
  return text;
}

}  // namespace

TEST_CASE("no body is touched before it is a member: a fast hand in a field of cubes") {
  auto session = make_session(scene_text(field_scene()), virtual_options());
  double deepest_m = 0;
  std::uint64_t contact_ticks = 0;
  run(*session, 3000, [&](const loop::TickOutput& out) {
    deepest_m = std::max(deepest_m, depth_in_outsiders(*session));
    contact_ticks += (out.status & kProxyContact) != 0;
    return true;
  });
  CHECK(contact_ticks > 100);
  CHECK(deepest_m <= 1e-4);  // rounding and the global clock, which is up to a cycle ahead of what the hand feels
}

TEST_CASE("no body is touched before it is a member: a pile whose component is larger than the cap",
          "[no-asan][no-tsan]") {
  auto session = make_session(scene_file("pile700.toml"), virtual_options());
  double deepest_m = 0;
  std::uint64_t tick = 0;
  run(*session, 1200, [&](const loop::TickOutput&) {
    if (tick++ % 10 == 9) deepest_m = std::max(deepest_m, depth_in_outsiders(*session));
    return true;
  });
  CHECK(deepest_m <= 1e-4);
}
