// Compounds: a body of several shapes moves, rests and collides as one, and what is hollow is hollow.
#include "rt/physics/shapes/compound.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "rt/physics/collision/collide_parts.h"
#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::Random;

namespace {

using tactus::test::kGravity;

// Parts whose common centre of mass is the origin and whose products of inertia are 0, of one density.
struct Parts {
  std::vector<CompoundPart> parts;
  Compound compound;

  explicit Parts(std::vector<CompoundPart> given) : parts(std::move(given)) {
    compound.parts = parts;
    compound.half_thickness = half_thickness(parts[0].shape);
    Vec3d moments;
    for (const CompoundPart& part : parts) {
      const double m = volume_of(part.shape);
      const Vec3d d = part.body_from_part.position, own = inertia_of(part.shape, m);
      REQUIRE(part.body_from_part.rotation == Quatd{});
      compound.volume += m;
      moments += own + m * Vec3d{d.y * d.y + d.z * d.z, d.x * d.x + d.z * d.z, d.x * d.x + d.y * d.y};
      const Aabb box = bounds_of(part.shape, part.body_from_part, 0);
      for (int k = 0; k < 3; ++k)
        compound.half_extents[k] = std::max({compound.half_extents[k], -box.lower[k], box.upper[k]});
      compound.bounding_radius = std::max(compound.bounding_radius, norm(d) + bounding_radius(part.shape));
      compound.half_thickness = std::min(compound.half_thickness, half_thickness(part.shape));
    }
    compound.inertia_per_kg = moments * (1 / compound.volume);
  }
};

Parts box_of_two_halves(const Vec3d& half) {
  const Shape part = Shape::box({0.5 * half.x, half.y, half.z});
  return Parts({{part, {{-0.5 * half.x, 0, 0}, {}}}, {part, {{0.5 * half.x, 0, 0}, {}}}});
}

// A cup without a lid cannot have its centre at the origin, so this is a tube: four walls about a square hole along z.
Parts tube(double hole, double wall, double half_height) {
  const double at = 0.5 * hole + 0.5 * wall;
  const Shape x = Shape::box({0.5 * wall, 0.5 * hole + wall, half_height});
  const Shape y = Shape::box({0.5 * hole, 0.5 * wall, half_height});
  return Parts({{x, {{-at, 0, 0}, {}}}, {x, {{at, 0, 0}, {}}}, {y, {{0, -at, 0}, {}}}, {y, {{0, at, 0}, {}}}});
}

Parts dumbbell() {
  const Shape ball = Shape::sphere(0.03);
  return Parts({{ball, {{-0.06, 0, 0}, {}}}, {ball, {{0.06, 0, 0}, {}}}, {Shape::box({0.06, 0.008, 0.008}), {}}});
}

struct Bench {
  std::vector<Compound> compounds;
  World world;
  StepSettings settings;
  StepReport report;

  explicit Bench(std::vector<Compound> list)
      : compounds(std::move(list)), world(Capacities{64, 8, 2048, 512, 0}, {{}, {}, compounds}) {
    settings.gravity = {0, 0, -kGravity};
  }

  Body& add(BodyId id, std::uint32_t compound, double mass, const Posed& pose) {
    Body body = make_dynamic_body(id, compound_shape(compounds[compound], compound), mass, 0.5, pose);
    body.inertia = compounds[compound].inertia_per_kg * mass;
    REQUIRE(world.insert(body));
    return *world.find(id);
  }
  Body& add(const Body& body) {
    REQUIRE(world.insert(body));
    return body.kind == BodyKind::kDynamic ? *world.find(body.id) : unused_;
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      world.begin_step(settings);
      find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
      report = world.finish_step(settings);
    }
  }
  const Posed& pose(BodyId id) { return world.find(id)->motion.pose; }

 private:
  Body unused_;
};

Body floor_at(BodyId id) { return make_fixed_body(id, Shape::box({1, 1, 0.1}), 0.5, {{0, 0, -0.1}, {}}); }

double deepest(const World& world) {
  double depth = 0;
  for (const Contact& contact : world.contacts())
    for (std::uint32_t i = 0; i < contact.count; ++i) depth = std::max(depth, -contact.points[i].separation);
  return depth;
}

}  // namespace

TEST_CASE(
    "A pair's key has both bodies and both parts, in the order of the ids, and keys of one pair are consecutive") {
  const PairKey key = PairKey::of(BodyPart{700'000, 5}, BodyPart{12, 127}, false);
  CHECK(key.low() == 12);
  CHECK(key.low_part() == 127);
  CHECK(key.high() == 700'000);
  CHECK(key.high_part() == 5);
  CHECK(key.part_of(12) == 127);
  CHECK(key.part_of(700'000) == 5);
  CHECK(!key.with_fixed());
  CHECK(key.of_bodies() == PairKey::of(12, 700'000, false));
  CHECK(PairKey::of(kMaxBodyId, 3, true).high() == kMaxBodyId);
  CHECK(PairKey::of(kMaxBodyId, 3, true).with_fixed());
  CHECK(PairKey::of(BodyPart{1, 127}, BodyPart{2, 127}, false) < PairKey::of(1, 3, false));
  CHECK(PairKey::of(BodyPart{1, 127}, BodyPart{3, 127}, false) < PairKey::of(2, 3, false));
  CHECK(PairKey::of(kMaxBodyId - 1, kMaxBodyId, false) < PairKey::of(0, 1, true));
}

TEST_CASE("A compound of one part, at its centre, moves as the plain shape does") {
  const Shape box = Shape::box({0.05, 0.04, 0.03});
  const Parts one({{box, {}}});
  Bench bench({one.compound}), plain({});
  const Posed start{{0.01, 0.02, 0.1}, quat_from_rotation_vector(Vec3d{0.3, 0.2, 0.1})};
  bench.add(1, 0, 0.4, start);
  plain.add(make_dynamic_body(1, box, 0.4, 0.5, start));
  for (Bench* b : {&bench, &plain}) b->add(floor_at(9));
  for (int i = 0; i < 10; ++i) {
    bench.run(100);
    plain.run(100);
    REQUIRE(norm(bench.pose(1).position - plain.pose(1).position) < 1e-9);
    const Vec3d arm{1, 2, 3};
    REQUIRE(norm(rotate(bench.pose(1).rotation, arm) - rotate(plain.pose(1).rotation, arm)) < 1e-8);
  }
}

TEST_CASE("Two halves in one body fall and rest as the whole box does") {
  const Vec3d half{0.06, 0.04, 0.03};
  const Parts halves = box_of_two_halves(half);
  const Vec3d whole = inertia_of(Shape::box(half), 1);
  CHECK(norm(halves.compound.inertia_per_kg - whole) < 1e-12);
  Bench bench({halves.compound}), plain({});
  for (Bench* b : {&bench, &plain}) b->add(floor_at(9));
  for (BodyId id = 0; id < 5; ++id) {
    const Posed start{{0, 0, half.z + 2 * half.z * id}, {}};
    bench.add(id, 0, 0.3, start);
    plain.add(make_dynamic_body(id, Shape::box(half), 0.3, 0.5, start));
  }
  bench.run(3000);
  plain.run(3000);
  for (BodyId id = 0; id < 5; ++id) {  // as stiff, though it stands on twice as many contacts
    CAPTURE(id, bench.pose(id).position.z - plain.pose(id).position.z);
    CHECK(norm(bench.pose(id).position - plain.pose(id).position) < 2e-5 * (id + 1));
  }
  CHECK(bench.world.kinetic_energy() < 1e-12);
  CHECK(deepest(bench.world) < 1.5 * deepest(plain.world));
  CHECK(bench.report.contacts >= 5 * 2);  // each half has its own
}

TEST_CASE("Tall stacks of compounds come to rest, of few parts or many, as stacks of boxes do") {
  // A block of n slices, and one on four legs.
  const auto slices = [](int n) {
    std::vector<CompoundPart> parts;
    for (int i = 0; i < n; ++i)
      parts.push_back({Shape::box({0.04 / n, 0.04, 0.04}), {{0.04 * ((2 * i + 1.0) / n - 1), 0, 0}, {}}});
    return Parts(parts);
  };
  const Shape leg = Shape::box({0.01, 0.01, 0.04});
  const Parts legs({{leg, {{-0.03, -0.03, 0}, {}}},
                    {leg, {{0.03, -0.03, 0}, {}}},
                    {leg, {{-0.03, 0.03, 0}, {}}},
                    {leg, {{0.03, 0.03, 0}, {}}}});
  for (const Parts& parts : {slices(2), slices(3), slices(4), legs}) {
    CAPTURE(parts.parts.size());
    Bench bench({parts.compound});
    bench.settings.dt = 0.01;  // as in the global world
    bench.settings.sub_steps = 10;
    bench.settings.contact_hertz = 200;
    bench.add(floor_at(99));
    for (BodyId id = 0; id < 8; ++id) bench.add(id, 0, 0.2, {{0, 0, 0.04 + 0.08 * id}, {}});
    bench.run(400);
    CHECK(bench.world.kinetic_energy() < 1e-9);
    for (BodyId id = 0; id < 8; ++id) CHECK(norm(bench.pose(id).position - Vec3d{0, 0, 0.04 + 0.08 * id}) < 2e-3);
  }
}

TEST_CASE("Tall stacks of compounds of many slices come to rest") {
  std::vector<CompoundPart> parts;
  for (int i = 0; i < 8; ++i) parts.push_back({Shape::box({0.005, 0.04, 0.04}), {{0.005 * (2 * i - 7), 0, 0}, {}}});
  const Parts slices(parts);
  Bench bench({slices.compound});
  bench.settings.dt = 0.01;
  bench.settings.sub_steps = 10;
  bench.settings.contact_hertz = 200;
  bench.add(floor_at(99));
  for (BodyId id = 0; id < 8; ++id) bench.add(id, 0, 0.2, {{0, 0, 0.04 + 0.08 * id}, {}});
  bench.run(400);
  CHECK(bench.world.kinetic_energy() < 1e-9);
}

TEST_CASE("What is hollow is hollow: a ball falls through a tube and rests on the ground inside") {
  const Parts walls = tube(0.06, 0.01, 0.05);
  Bench bench({walls.compound});
  bench.add(floor_at(9));
  bench.add(1, 0, 1, {{0, 0, 0.05}, {}});
  bench.add(make_dynamic_body(2, Shape::sphere(0.02), 0.05, 0.5, {{0.005, 0.003, 0.2}, {}}));
  bench.run(2000);
  const Vec3d& ball = bench.pose(2).position;
  CHECK(ball.z == Approx(0.02).margin(1e-4));
  CHECK(std::abs(ball.x) < 0.03);
  CHECK(std::abs(ball.y) < 0.03);
  CHECK(norm(bench.pose(1).position - Vec3d{0, 0, 0.05}) < 1e-3);
}

TEST_CASE("Compounds that meet in free space keep their momentum and gain no energy") {
  const Parts bells = dumbbell(), walls = tube(0.06, 0.02, 0.03);
  Bench bench({bells.compound, walls.compound});
  bench.settings.gravity = {};
  Random random(7);
  for (BodyId id = 0; id < 12; ++id) {
    Body& body = bench.add(
        id, id % 2, 0.2 + 0.05 * id,
        {{0.16 * (id % 3), 0.16 * (id / 3 % 2), 0.16 * (id / 6)}, quat_from_rotation_vector(random.vector(2))});
    body.motion.velocity = {(Vec3d{0.16, 0.08, 0.08} - body.motion.pose.position) * 2.0, random.vector(3)};
  }
  const Wrenchd before = bench.world.momentum();
  double energy = bench.world.kinetic_energy(), allowed = 0;
  bool met = false;
  for (int i = 0; i < 600; ++i) {
    bench.run(1);
    met = met || bench.report.contacts > 0;
    REQUIRE(bench.world.kinetic_energy() <= energy * (1 + 1e-9));
    energy = bench.world.kinetic_energy();
    // Lever arms are those of the step's start: moments are off by what moves within the step.
    for (const Contact& contact : bench.world.contacts())
      for (std::uint32_t k = 0; k < contact.count; ++k)
        for (const std::uint32_t slot : {contact.slot_a, contact.slot_b}) {
          const Twistd& v = bench.world.bodies()[slot].motion.velocity;
          const ContactPoint& point = contact.points[k];
          allowed += (point.total_normal_impulse + norm(point.total_friction)) * bench.settings.dt *
                     (norm(v.linear) + 0.1 * norm(v.angular));
        }
  }
  CHECK(met);
  const Wrenchd after = bench.world.momentum();
  CHECK(norm(after.force - before.force) < 1e-12);
  CHECK(norm(after.torque - before.torque) < allowed);
  CHECK(allowed < 0.01);
}

TEST_CASE("Every two parts within the margin have a contact in the world, wherever their bodies move") {
  const Parts bells = dumbbell(), walls = tube(0.06, 0.02, 0.03);
  Bench bench({bells.compound, walls.compound});
  bench.add(floor_at(99));
  Random random(3);
  for (BodyId id = 0; id < 10; ++id)
    bench.add(id, id % 2, 0.3,
              {{0.09 * (id % 2), 0.05 * (id % 3), 0.1 + 0.08 * id}, quat_from_rotation_vector(random.vector(3))});
  std::size_t seen = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<std::pair<PairKey, double>> touching;  // before the step, by plain narrow phase
    const auto bodies = bench.world.bodies();
    for (std::size_t a = 0; a < bodies.size(); ++a)
      for (std::size_t b = a + 1; b < bodies.size(); ++b)
        for_each_manifold(posed_shape(bodies[a]), posed_shape(bodies[b]), 1e-4, bench.world.shapes(),
                          [&](std::uint32_t p, std::uint32_t q, const Manifold& manifold) {
                            touching.emplace_back(
                                PairKey::of(BodyPart{bodies[a].id, p}, BodyPart{bodies[b].id, q}, false),
                                manifold.points[0].separation);
                          });
    bench.run(1);
    for (const auto& [key, separation] : touching) {
      const auto contacts = bench.world.contacts();
      const bool found =
          std::any_of(contacts.begin(), contacts.end(), [wanted = key](const Contact& c) { return c.key == wanted; });
      INFO("step " << i << ", bodies " << key.low() << " and " << key.high() << ", parts " << key.low_part() << " and "
                   << key.high_part() << ", separation " << separation);
      REQUIRE(found);
      ++seen;
    }
  }
  CHECK(seen > 500);
}

TEST_CASE("A world of compounds restored in every step gives the same bits, and two runs are the same") {
  const Parts bells = dumbbell(), walls = tube(0.06, 0.02, 0.03);
  const auto dropped = [&] {
    auto bench = std::make_unique<Bench>(std::vector<Compound>{bells.compound, walls.compound});
    bench->add(floor_at(99));
    Random random(5);
    for (BodyId id = 0; id < 8; ++id)
      bench->add(id, id % 2, 0.3,
                 {{0.04 * (id % 2), 0.05 * (id % 3), 0.1 + 0.08 * id}, quat_from_rotation_vector(random.vector(3))});
    return bench;
  };
  auto plain = dropped(), restored = dropped();
  std::vector<std::byte> bytes;
  for (int step = 0; step < 500; ++step) {
    plain->run(1);
    bytes.resize(restored->world.save_size_bound());
    ByteWriter out(bytes);
    restored->world.save(out);
    REQUIRE(out.ok());
    auto next = std::make_unique<Bench>(std::vector<Compound>{bells.compound, walls.compound});
    ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
    REQUIRE(next->world.restore(in));
    next->run(1);
    INFO("step " << step);
    REQUIRE(next->world.state_hash() == plain->world.state_hash());
    restored = std::move(next);
  }
}

TEST_CASE("A state with a compound that the world does not have is refused") {
  const Parts bells = dumbbell();
  Bench bench({bells.compound}), other({});
  bench.add(0, 0, 0.3, {});
  std::vector<std::byte> bytes(bench.world.save_size_bound());
  ByteWriter out(bytes);
  bench.world.save(out);
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  CHECK_FALSE(other.world.restore(in));
  CHECK(other.world.bodies().empty());
}

TEST_CASE("Continuous collision detection stops a fast compound at a thin plate, by the part that arrives first") {
  const Parts bells = dumbbell();
  for (const bool ccd : {false, true}) {
    std::vector<Compound> compounds{bells.compound};
    EffectSetups setups;
    const ShapeLists shapes{{}, {}, compounds};
    if (ccd) std::get<ContinuousCollision::Setup>(setups) = {.proxy = 0, .shapes = shapes};
    World world(Capacities{4, 4, 64, 64, 0}, shapes, setups);
    Body body = make_dynamic_body(0, compound_shape(compounds[0], 0), 0.3, 0.5, {{0, 0, 0.5}, {}});
    body.inertia = compounds[0].inertia_per_kg * 0.3;
    body.motion.velocity.linear = {0, 0, -300};
    REQUIRE(world.insert(body));
    REQUIRE(world.insert(make_fixed_body(1, Shape::box({0.2, 0.2, 0.002}), 0.5, {})));
    StepSettings settings;
    for (int i = 0; i < 5; ++i) {
      world.begin_step(settings);
      static_cast<void>(world.finish_step(settings));
    }
    CAPTURE(ccd);
    CHECK((world.bodies()[0].motion.pose.position.z > 0) == ccd);
  }
}
