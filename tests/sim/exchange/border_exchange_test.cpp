#include "sim/exchange/border_exchange.h"

#include <catch2/catch.hpp>
#include <memory>

#include "tests/support/body_index.h"
#include "tests/support/physics_bench.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using tactus::test::operator""_slot;
using physics::Shape;
using physics::SlotIndex;
using Return = physics::BorderTraits::Return;
using physics::Body;
using physics::Contact;
using physics::World;
using Border = FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>;

constexpr double kStep_s = 0.01;
constexpr double kRigid = 1e5;  // a2 of contacts that give way to nothing

physics::StepSettings settings() {
  physics::StepSettings s;
  s.dt = kStep_s;
  s.sub_steps = 10;
  s.gravity = {0, 0, -9.81};
  return s;
}

void step(World& world) {
  const auto s = settings();
  world.begin_step(s);
  REQUIRE(physics::find_pairs_brute_force(world.bounds(), world.dynamic_pairs()));
  world.finish_step(s);
}

// A card (1) that slides on a slab (0) that floats: gravity presses the card on, nothing holds the slab, so that both
// fall and the force between them is the card's weight times M / (m + M).
constexpr double kPress_N = 1.0 * 9.81 * 20.0 / 21.0;

std::unique_ptr<World> card_on_slab() {
  auto world = std::make_unique<World>(physics::Capacities{4, 1, 16, 16, 0});
  auto slab = physics::make_dynamic_body(0, Shape::box({0.5, 0.5, 0.05}), 20.0, 0.4, {{0, 0, 0}, {}});
  slab.gravity_scale = 0;
  auto card = physics::make_dynamic_body(1, Shape::box({0.1, 0.1, 0.02}), 1.0, 0.4, {{0, 0, 0.07}, {}});
  card.motion.velocity.linear = {0.5, 0.2, 0};
  REQUIRE(world->insert(slab));
  REQUIRE(world->insert(card));
  for (int i = 0; i < 5; ++i) step(*world);
  return world;
}

// Of its centre, to what the members do at these points.
Twistd member_answer(const haptics::OutsideBody& body, std::span<const haptics::BorderPoint> border) {
  Wrenchd load;
  for (const auto& point : border) {
    const Vec3d force = -(point.impulse_rate_N * point.normal + point.friction_N);
    load += Wrenchd{force, cross(point.outside_point - body.centre, force)};
  }
  return body.admittance * load;
}

Vec3d momentum_of(const World& world, SlotIndex slot) {
  return world.body(slot).mass * world.body(slot).motion.velocity.linear;
}

Vec3d friction_on_slab(const World& world) {
  Vec3d sum;
  const auto& contact = world.contacts()[0];
  for (std::uint32_t i = 0; i < contact.count; ++i) sum -= contact.points[i].total_friction;  // on B, the card
  return sum;
}

// What the sub-world says it found at this pair's two border points, on the member.
std::vector<haptics::BorderReturn> returns(const Vec3d& first, const Vec3d& second) {
  haptics::BorderReturn a, b;
  a.member = b.member = 1;
  a.outside = b.outside = 0;
  a.point = {0.1, 0.1, 0.05};
  b.point = {-0.1, 0.1, 0.05};
  b.feature = 1;
  a.tangent_impulse = first;
  b.tangent_impulse = second;
  return {a, b};
}

const std::vector<std::uint8_t> kCardIsMember{0, 1}, kSlabIsMember{1, 0};

// A card on a slab, and the border that the exchange fills after a step.
struct CardOnSlab {
  std::unique_ptr<World> world = card_on_slab();
  BorderExchange log{4, 16, 0, kRigid};
  std::unique_ptr<Border> border = std::make_unique<Border>();
  FixedVector<haptics::OutsideBody, haptics::kMaxOutsideBodies> outside;

  std::uint32_t fill(const std::vector<std::uint8_t>& members) {
    return log.fill({world->contacts(), world->bodies(), world->last_poses(), kStep_s}, members, false, *border);
  }
  // The only outside body, of `border` as it is.
  const haptics::OutsideBody& outside_body(const std::vector<std::uint8_t>& members, double cycle_s = kStep_s) {
    REQUIRE(log.fill_outside(*world, members, {kStep_s, kStep_s / 10, cycle_s}, border->span(), outside) == 0);
    REQUIRE(outside.size() == 1);
    return outside[0];
  }
  // Its acceleration, the members' load included.
  Twistd acceleration(const std::vector<std::uint8_t>& members, double cycle_s = kStep_s) {
    const haptics::OutsideBody& body = outside_body(members, cycle_s);
    return body.drive + member_answer(body, border->span());
  }
};

}  // namespace

TEST_CASE(
    "Replay hands on the tangential impulses themselves: momentum and moment of the outside body change by them") {
  auto world = card_on_slab();
  const Vec3d before = momentum_of(*world, 0_slot);
  const auto angular_before = world->bodies()[0].motion.velocity.angular;
  const Vec3d j1{0.3, -0.1, 0}, j2{0.05, 0.2, 0};
  const auto given = returns(j1, j2);
  const ImpulseReturn back = return_impulses(given, kCardIsMember, Return::kImpulse, *world);
  const Vec3d change = momentum_of(*world, 0_slot) - before;
  CHECK(norm(change + (j1 + j2)) < 1e-14);
  CHECK(norm(back.impulse_Ns + (j1 + j2)) < 1e-14);
  const auto& slab = world->bodies()[0];
  const SymMat3d inertia = rotate_diagonal(slab.motion.pose.rotation, slab.inertia);
  Vec3d moment;
  for (const auto& entry : given) moment -= cross(entry.point - slab.motion.pose.position, entry.tangent_impulse);
  CHECK(norm(inertia * (slab.motion.velocity.angular - angular_before) - moment) < 1e-12);
}

TEST_CASE("Otherwise only what the global step did not do itself is handed on") {
  auto world = card_on_slab();
  const Vec3d friction = friction_on_slab(*world);
  REQUIRE(norm(friction) == Approx(0.4 * kPress_N * kStep_s).epsilon(0.01));  // it slides
  const Vec3d before = momentum_of(*world, 0_slot);
  SECTION("the same friction in both worlds: nothing is left to hand on") {
    return_impulses(returns(-0.25 * friction, -0.75 * friction), kCardIsMember, Return::kChange, *world);
    CHECK(norm(momentum_of(*world, 0_slot) - before) < 1e-15);
  }
  SECTION("another friction in the sub-world: the difference") {
    const Vec3d j1{0.3, -0.1, 0}, j2{0.05, 0.2, 0};
    return_impulses(returns(j1, j2), kCardIsMember, Return::kChange, *world);
    CHECK(norm(momentum_of(*world, 0_slot) - before + (j1 + j2 + friction)) < 1e-14);
  }
}

TEST_CASE("The work of outside bodies on members is what changes their energy, normal and friction, with sign") {
  // The card alone: gravity and the slab act on it. Seen from the slab, the card alone does.
  auto world = card_on_slab();
  const auto energy = [&](SlotIndex slot) {
    const auto& body = world->body(slot);
    return kinetic_energy(body) + 9.81 * body.mass * body.gravity_scale * body.motion.pose.position.z;
  };
  const double card_J = energy(1_slot), slab_J = energy(0_slot);
  const std::vector<Twistd> before{world->bodies()[0].motion.velocity, world->bodies()[1].motion.velocity};
  step(*world);
  const auto work_J = [&](std::span<const std::uint8_t> members) {
    return border_work_J(*world, before, members, kStep_s) +
           push_out_J(*world, before, members, kStep_s, settings().gravity, {});
  };
  const double on_card_J = work_J(kCardIsMember);
  const double on_slab_J = work_J(std::vector<std::uint8_t>{1, 0});
  CHECK(on_card_J < 0);  // it is braked
  CHECK(on_slab_J > 0);
  CHECK(on_card_J == Approx(energy(1_slot) - card_J).epsilon(1e-6));
  CHECK(on_slab_J == Approx(energy(0_slot) - slab_J).epsilon(1e-6));
}

TEST_CASE("What outside bodies gained in energy is counted") {
  auto world = card_on_slab();
  const double before = world->kinetic_energy();
  const ImpulseReturn back = return_impulses(returns({-1, 0, 0}, {0, 2, 0}), kCardIsMember, Return::kImpulse, *world);
  CHECK(back.energy_J == Approx(world->kinetic_energy() - before));
  CHECK(back.magnitude_Ns == Approx(3));
}

TEST_CASE("An impulse about an outside body's centre is applied and counted, one on an unknown body is not") {
  auto world = card_on_slab();
  const BodyId slab = world->body(0_slot).id;
  const Vec3d momentum = momentum_of(*world, 0_slot), given{1, 2, -2};
  const double before = world->kinetic_energy();
  const haptics::OutsideImpulse impulses[] = {{.id = slab, .impulse = {given, {0.1, 0, 0}}},
                                              {.id = 77, .impulse = {given, {}}}};
  const ImpulseReturn back = return_impulses(impulses, *world);
  CHECK(norm(momentum_of(*world, 0_slot) - momentum - given) < 1e-12);
  CHECK(back.energy_J == Approx(world->kinetic_energy() - before));
  CHECK(back.magnitude_Ns == Approx(3));
}

TEST_CASE("A body that is a member by now gets nothing: its own world moves it") {
  auto world = card_on_slab();
  const Vec3d before = momentum_of(*world, 0_slot);
  const std::vector<std::uint8_t> both{1, 1};
  const ImpulseReturn back = return_impulses(returns({1, 0, 0}, {1, 0, 0}), both, Return::kImpulse, *world);
  CHECK(back.skipped == 2);
  CHECK(momentum_of(*world, 0_slot) == before);
}

TEST_CASE("A return of an unknown body, or one that is not a number, changes nothing") {
  auto world = card_on_slab();
  const std::uint64_t before = world->state_hash();
  auto broken = returns({std::nan(""), 0, 0}, {1, 0, 0});
  broken[1].outside = 77;
  return_impulses(broken, kCardIsMember, Return::kImpulse, *world);
  CHECK(world->state_hash() == before);
}

TEST_CASE("A border point of two balls that roll on each other is between their centres after the step, too") {
  const double r = 0.03, step_s = 8e-3, turn = 50;
  const bool member_is_a = GENERATE(true, false);
  Body a = make_dynamic_body(0, Shape::sphere(r), 1, 0.5, {{0, 0, 0}, quat_from_rotation_vector(Vec3d{1, 2, 3})});
  Body b = make_dynamic_body(1, Shape::sphere(r), 1, 0.5, {{0, 0, 2 * r}, quat_from_rotation_vector(Vec3d{0, 1, 0})});
  const Posed start_a = a.motion.pose, start_b = b.motion.pose;
  Contact contact;
  contact.key = PairKey::of(0, 1, false);
  contact.normal = {0, 0, 1};
  contact.count = 1;
  contact.points[0].from_a = {0, 0, r};
  contact.points[0].from_b = {0, 0, -r};
  contact.round_a = contact.round_b = r;
  const auto turned = [&](Body& body, double sign) {
    body.motion.pose.rotation =
        quat_from_rotation_vector(Vec3d{0, sign * turn * step_s, 0}) * body.motion.pose.rotation;
  };
  turned(a, 1);
  turned(b, -1);
  const BodyOverStep of_a{a, start_a}, of_b{b, start_b};
  const auto point = border_point(contact, contact.points[0], member_is_a, member_is_a ? of_a : of_b,
                                  member_is_a ? of_b : of_a, step_s);
  const Body& member = member_is_a ? a : b;
  CHECK(point.member_round_m == r);
  CHECK(point.outside_round_m == r);
  const Vec3d touched = member.motion.pose * point.member_anchor - point.member_round_m * point.normal;
  CHECK(norm(touched - Vec3d{0, 0, r}) < 1e-12);
  CHECK(norm(point.outside_point - Vec3d{0, 0, r}) < 1e-12);
  CHECK(norm(point.outside_velocity - Vec3d{turn * r, 0, 0}) < 1e-9);  // of either ball, where they touch
}

TEST_CASE("A border point is where the bodies touch, with the normal from the outside body to the member") {
  auto world = card_on_slab();
  std::vector<Posed> start;
  for (const auto& body : world->bodies()) start.push_back(body.motion.pose);
  step(*world);
  BorderExchange log(4, 16, 0, kRigid);
  auto border = std::make_unique<Border>();
  const bool card_is_member = GENERATE(true, false);
  const std::vector<std::uint8_t> members =
      card_is_member ? std::vector<std::uint8_t>{0, 1} : std::vector<std::uint8_t>{1, 0};
  const auto& bodies = world->bodies();
  REQUIRE(log.fill({world->contacts(), bodies, start, kStep_s}, members, false, *border) == 0);
  REQUIRE(border->size() == 4);
  const std::uint32_t member = card_is_member ? 1 : 0, outside = 1 - member;
  double force = 0;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const auto& point = (*border)[i];
    const auto& contact_point = world->contacts()[0].points[i];
    CHECK(point.member == member);
    CHECK(point.outside == outside);
    CHECK(point.feature == contact_point.feature);
    CHECK(point.friction == Approx(0.4));
    CHECK(point.normal.z == Approx(card_is_member ? 1 : -1));
    // At the start of the step the anchor is the contact point, seen from either body.
    CHECK(norm(start[member] * point.member_anchor - (start[0].position + contact_point.from_a)) < 1e-12);
    CHECK(norm(start[member] * point.member_anchor - (start[1].position + contact_point.from_b)) < 1e-12);
    // The outside surface's point goes with its body; its velocity is the mean over the step.
    const Vec3d before = start[member] * point.member_anchor;
    const Vec3d after = bodies[outside].motion.pose * (inverse(start[outside]) * before);
    CHECK(norm(point.outside_point - after) < 1e-12);
    CHECK(norm(point.outside_velocity - (after - before) * (1 / kStep_s)) < 1e-9);
    CHECK(point.separation_m == contact_point.separation);
    force += point.impulse_rate_N;
  }
  CHECK(force == Approx(kPress_N).epsilon(0.01));
}

TEST_CASE(
    "Contacts inside, outside or with static geometry are no border, nor, but for ghosts, are points that only came "
    "near") {
  physics::Contact contact;
  contact.slot_a = 0;
  contact.slot_b = 1;
  contact.count = 2;
  contact.normal = {0, 0, 1};
  contact.points[0].total_normal_impulse = 1;
  contact.points[0].separation = 0.001;
  contact.points[1].separation = 0.001;
  const std::vector<physics::Body> bodies(3);
  const std::vector<Posed> start(3);
  BorderExchange log(4, 16, 0, kRigid);
  auto border = std::make_unique<Border>();
  bool near_points = false;
  const auto count = [&](std::vector<std::uint8_t> members) {
    log.fill({std::span(&contact, 1), bodies, start, kStep_s}, members, near_points, *border);
    return border->size();
  };
  CHECK(count({1, 0, 0}) == 1);
  CHECK(count({0, 1, 0}) == 1);
  near_points = true;  // for ghosts
  CHECK(count({1, 0, 0}) == 2);
  near_points = false;
  CHECK(count({1, 1, 0}) == 0);
  CHECK(count({0, 0, 1}) == 0);
  contact.points[1].separation = -0.001;
  CHECK(count({1, 0, 0}) == 2);
  contact.b_fixed = true;
  CHECK(count({1, 0, 0}) == 0);
}

TEST_CASE("When border points do not fit, those that press least are left out and the order stays") {
  constexpr std::uint32_t kContacts = 300;  // 1200 points
  std::vector<physics::Contact> contacts(kContacts);
  std::vector<physics::Body> bodies(kContacts + 1);
  std::vector<std::uint8_t> members(kContacts + 1, 0);
  members[0] = 1;
  for (std::uint32_t i = 0; i < kContacts; ++i) {
    bodies[i + 1].id = i + 1;
    contacts[i].slot_b = i + 1;
    contacts[i].count = 4;
    // Every fourth point hardly presses: 300 of them, 176 of which must go.
    for (std::uint32_t p = 0; p < 4; ++p) {
      contacts[i].points[p].feature = p;
      contacts[i].points[p].total_normal_impulse = p == 2 ? 1e-6 * (i + 1) : 1.0;
    }
  }
  bodies[0].id = 0;
  const std::vector<Posed> start(kContacts + 1);
  BorderExchange log(kContacts + 1, kContacts, 0, kRigid);
  auto border = std::make_unique<Border>();
  CHECK(log.fill({contacts, bodies, start, kStep_s}, members, false, *border) == 176);
  REQUIRE(border->size() == 1024);
  for (std::uint32_t i = 1; i < 1024; ++i) {
    const auto &last = (*border)[i - 1], &point = (*border)[i];
    CHECK(std::pair(last.outside, last.feature) < std::pair(point.outside, point.feature));
    if (point.feature == 2) CHECK(point.outside > 176);
  }
}

TEST_CASE("An outside body that slides to rest is reported with its deceleration, one that vibrates or stops without") {
  CardOnSlab bench;
  const auto told = [&] {
    step(*bench.world);
    bench.fill(kSlabIsMember);
    return bench.acceleration(kSlabIsMember).linear;
  };
  const Vec3d sliding = told(), direction = normalized_or(Vec3d{0.5, 0.2, 0}, Vec3d{1, 0, 0});
  CHECK(dot(sliding, direction) == Approx(-0.4 * kPress_N).epsilon(0.02));
  CHECK(sliding.z == Approx(kPress_N - 9.81).margin(0.1));         // both fall
  bench.world->bodies()[1].motion.velocity.linear = {0.05, 0, 0};  // four fifths of it go in a step
  const Vec3d stopping = told();
  CHECK(stopping == Vec3d{});
}

TEST_CASE("An outside body that turns faster and faster is reported with its angular acceleration") {
  CardOnSlab bench;
  const auto turn = [&] {
    bench.world->apply_wrench(0_slot, {{}, {0, 0, 0.5}});
    step(*bench.world);
  };
  for (int i = 0; i < 20; ++i) turn();
  const double before = bench.world->bodies()[0].motion.velocity.angular.z;
  turn();
  const double acceleration = (bench.world->bodies()[0].motion.velocity.angular.z - before) / kStep_s;
  REQUIRE(acceleration > 0.1);
  bench.fill(kCardIsMember);
  CHECK(bench.acceleration(kCardIsMember).angular.z == Approx(acceleration).epsilon(0.02));
}

// The mean force of an impact in the drive would push the ghost against the member for a whole cycle.
TEST_CASE("Of a load that more than doubles in a step twice the former one counts as lasting") {
  CardOnSlab bench;
  step(*bench.world);
  const auto drive_under = [&](double force_N) {
    haptics::BorderPoint point;
    point.member = 1;
    point.outside = 0;
    point.normal = {0, 0, 1};
    point.outside_point = bench.world->bodies()[0].motion.pose.position;
    point.impulse_rate_N = force_N;
    bench.border->clear();
    REQUIRE(bench.border->try_push(point));
    bench.log.begin_step();
    return bench.outside_body(kCardIsMember).drive.linear.z;
  };
  const double of_5_N = drive_under(5);  // not known before: all of it
  const double per_N = drive_under(6) - of_5_N;
  CHECK(per_N == Approx(1 / 20.0).epsilon(1e-6));
  CHECK(drive_under(60) - of_5_N == Approx(per_N * (2 * 6 - 5)).epsilon(1e-9));
  CHECK(drive_under(60) - of_5_N == Approx(per_N * (60 - 5)).epsilon(1e-9));  // it lasts
  CHECK(drive_under(1) - of_5_N == Approx(per_N * (1 - 5)).epsilon(1e-9));
}

TEST_CASE("The acceleration over a macro step is extrapolated where it is even over the cycle") {
  CardOnSlab bench;
  step(*bench.world);
  bench.fill(kSlabIsMember);
  const auto sliding = [&](double cycle_s) { return norm(bench.acceleration(kSlabIsMember, cycle_s).linear); };
  REQUIRE(sliding(kStep_s) > 0.1);
  CHECK(sliding(2 * kStep_s) == Approx(sliding(kStep_s)));
  CHECK(sliding(1000 * kStep_s) == 0);
}

TEST_CASE("An outside body is reported with its motion") {
  CardOnSlab bench;
  step(*bench.world);
  REQUIRE(bench.fill(kCardIsMember) == 0);
  const haptics::OutsideBody& outside = bench.outside_body(kCardIsMember);
  const auto& slab = bench.world->bodies()[0];
  CHECK(outside.id == 0);
  CHECK(outside.centre == slab.motion.pose.position);
  CHECK(norm(outside.velocity.linear - slab.motion.velocity.linear) < 1e-12);
  CHECK(norm(outside.velocity.angular - slab.motion.velocity.angular) < 1e-12);
  CHECK(outside.admittance.linear.xx == Approx(1 / 20.0).epsilon(1e-9));  // nothing holds the slab
  // Its own share of the contact's inverse mass: 1 / M and the corner's lever_arm on its inertia.
  const Vec3d r = (*bench.border)[0].outside_point - slab.motion.pose.position;
  CHECK((*bench.border)[0].outside_inverse_mass ==
        Approx(1 / 20.0 + r.y * r.y / slab.inertia.x + r.x * r.x / slab.inertia.y).epsilon(1e-3));
  Vec3d friction;
  for (const auto& point : *bench.border) friction += point.friction_N;
  CHECK(norm(friction + friction_on_slab(*bench.world) * (1 / kStep_s)) < 1e-12);
}
