#include "rt/physics/world.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;
using tactus::test::Random;

namespace {

// A small heap that falls on a plane and a fixed block, with spin: everything a step does happens in it.
std::vector<Body> heap(std::uint64_t seed) {
  Random random(seed);
  std::vector<Body> bodies;
  bodies.push_back(make_fixed_body(0, Shape::plane(), 0.6, {}));
  for (BodyId n = 1; n <= 18; ++n) {
    const BodyId id = 2 * n;  // between them there is room for visitors
    const Posed pose{{0.07 * (n % 3) + random(-0.01, 0.01), 0.07 * (n / 3 % 2), 0.05 + 0.08 * (n / 6)},
                     quat_from_rotation_vector(random.vector(0.4))};
    const Shape shape = n % 3 == 0   ? Shape::sphere(0.03)
                        : n % 3 == 1 ? Shape::box({0.03, 0.025, 0.02})
                                     : Shape::capsule(0.02, 0.02);
    bodies.push_back(make_dynamic_body(id, shape, random(0.1, 0.5), 0.5, pose));
    bodies.back().motion.velocity = {random.vector(0.5), random.vector(5)};
  }
  bodies.push_back(make_fixed_body(50, Shape::box({0.1, 0.1, 0.02}), 0.6, {{0.1, 0, 0}, {}}));
  return bodies;
}

void insert_all(PhysicsBench& bench, const std::vector<Body>& bodies) {
  for (const Body& body : bodies) REQUIRE(bench.world.insert(body));
}

std::uint64_t contacts_hash(const World& world) {
  std::uint64_t hash = 0;
  for (const Contact& contact : world.contacts())
    for (std::uint32_t i = 0; i < contact.count; ++i) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &contact.points[i].normal_impulse, sizeof bits);
      hash = hash * 31 + bits + contact.key.value + contact.points[i].feature;
    }
  return hash;
}

// Do the slots of every contact name the bodies of its key?
bool slots_match(const World& world) {
  for (const Contact& contact : world.contacts()) {
    const BodyId a = world.bodies()[contact.slot_a].id;
    const BodyId b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b].id : world.bodies()[contact.slot_b].id;
    if (PairKey::of(a, b, contact.b_fixed) != contact.key) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("The same world stepped twice gives the same bits") {
  std::vector<std::uint64_t> hashes[2];
  for (auto& list : hashes) {
    PhysicsBench bench;
    insert_all(bench, heap(1));
    for (int k = 0; k < 300; ++k) {
      bench.step();
      list.push_back(bench.world.state_hash());
    }
    CHECK(bench.report.contacts > 10);
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("Bodies inserted in any order have the slots of their ids and give the same bits") {
  const std::vector<Body> sorted = heap(2);
  PhysicsBench reference;
  insert_all(reference, sorted);
  reference.run(100);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::vector<Body> shuffled = sorted;
    Random random(seed);
    for (std::size_t i = shuffled.size() - 1; i > 0; --i)
      std::swap(shuffled[i], shuffled[static_cast<std::size_t>(random(0, static_cast<double>(i) + 0.999))]);
    PhysicsBench bench;
    insert_all(bench, shuffled);
    for (std::uint32_t slot = 0; slot < bench.world.bodies().size(); ++slot)
      CHECK(bench.world.slot_of(bench.world.bodies()[slot].id) == SlotIndex{slot});
    bench.run(100);
    CHECK(bench.world.state_hash() == reference.world.state_hash());
  }
}

TEST_CASE("Bodies that come and go far away change no bit of the others") {
  PhysicsBench alone, visited;
  insert_all(alone, heap(3));
  insert_all(visited, heap(3));
  for (int k = 0; k < 200; ++k) {
    const BodyId visitor = 1 + 2 * static_cast<BodyId>(k % 19);  // below, between and above the others
    if (k % 2 == 0) visited.add_sphere(visitor, 0.02, 0.1, 0.5, {50, 0, 50});
    alone.step();
    visited.step();
    REQUIRE(slots_match(visited.world));
    if (k % 2 == 0) REQUIRE(visited.world.remove(visitor));
    REQUIRE(slots_match(visited.world));
    if (k == 50) visited.world.insert(make_fixed_body(40, Shape::box({1, 1, 1}), 0.5, {{0, 0, -60}, {}}));
    REQUIRE(alone.world.state_hash() == visited.world.state_hash());
  }
  CHECK(contacts_hash(alone.world) == contacts_hash(visited.world));
}

TEST_CASE("Inserting and removing moves the slots of contacts, spring and frozen flags along") {
  PhysicsBench bench;
  bench.add_ground(100, 0.5);
  for (BodyId id = 10; id < 14; ++id) bench.add_sphere(id, 0.05, 0.2, 0.5, {0.3 * (id - 10), 0, 0.05});
  bench.world.device_spring().enabled = true;
  bench.world.device_spring().slot = bench.slot(12);
  bench.world.set_frozen(bench.slot(13), true);
  bench.run(50);
  bench.add_sphere(1, 0.05, 0.2, 0.5, {5, 0, 5});
  CHECK(bench.world.device_spring().slot == bench.slot(12));
  for (const Contact& contact : bench.world.contacts())
    CHECK(bench.world.bodies()[contact.slot_a].id == contact.key.low());
  REQUIRE(bench.world.remove(10));
  CHECK(bench.world.device_spring().slot == bench.slot(12));
  CHECK(bench.world.contacts().size() == 2);  // 11 and 12; a frozen body needs no contact with what is fixed
  for (const Contact& contact : bench.world.contacts()) {
    CHECK(contact.key.low() != 10);
    CHECK(bench.world.bodies()[contact.slot_a].id == contact.key.low());
  }
  bench.position(13).z = 0.5;
  bench.run(10);
  CHECK(bench.position(13).z == 0.5);  // still the frozen one
  REQUIRE(bench.world.remove(12));
  CHECK_FALSE(bench.world.device_spring().enabled);
  CHECK_FALSE(bench.world.remove(12));
  REQUIRE(bench.world.remove(100));
  CHECK(bench.world.contacts().empty());
  CHECK(bench.world.fixed_bodies().empty());
}

TEST_CASE("An id that is there already is refused, whatever its kind") {
  PhysicsBench bench;
  bench.add_ground(4, 0.5);
  bench.add_sphere(5, 0.05, 0.2, 0.5, {0, 0, 1});
  const auto sphere = [](BodyId id) { return make_dynamic_body(id, Shape::sphere(0.1), 1.0, 0.5, {}); };
  CHECK_FALSE(bench.world.insert(sphere(5)));
  CHECK_FALSE(bench.world.insert(sphere(4)));
  CHECK_FALSE(bench.world.insert(make_fixed_body(5, Shape::plane(), 0.5, {})));
  CHECK(bench.world.bodies().size() == 1);
  CHECK_FALSE(bench.world.slot_of(4));  // fixed bodies have no dynamic slot
  CHECK_FALSE(bench.world.slot_of(6));
}

TEST_CASE("Each capacity that runs out sets its bit, counts and is kept") {
  Capacities capacities;
  capacities.bodies = 6;
  capacities.fixed_bodies = 1;
  PhysicsBench bench(capacities);
  bench.add_ground(0, 0.5);
  for (BodyId id = 1; id <= 6; ++id) bench.add_sphere(id, 0.05, 0.2, 0.5, {0.2 * id, 0, 0.0501 - 1e-5 * id});
  const auto sphere = make_dynamic_body(7, Shape::sphere(0.1), 1.0, 0.5, {});
  CHECK_FALSE(bench.world.insert(sphere));
  CHECK_FALSE(bench.world.insert(sphere));
  CHECK_FALSE(bench.world.insert(make_fixed_body(8, Shape::plane(), 0.5, {})));
  bench.step();
  CHECK(bench.report.capacity_bits == (kBodiesFull | kFixedBodiesFull));
  CHECK(bench.report.dropped == 3);
  bench.step();
  CHECK(bench.report.capacity_bits == 0);
  CHECK(bench.report.dropped == 0);
  CHECK(bench.report.contacts == 6);
  CHECK(bench.report.points == 6);
}

TEST_CASE("Beyond the capacity of pairs those with the highest keys are dropped") {
  Capacities capacities;
  capacities.pairs = 4;
  PhysicsBench bench(capacities);
  bench.add_ground(0, 0.5);
  for (BodyId id = 1; id <= 7; ++id) bench.add_sphere(id, 0.05, 0.2, 0.5, {0.2 * id, 0, 0.0499});
  bench.step();
  CHECK(bench.report.capacity_bits == kPairsFull);
  CHECK(bench.report.dropped == 3);
  REQUIRE(bench.report.contacts == 4);
  for (std::uint32_t i = 0; i < 4; ++i) CHECK(bench.world.contacts()[i].key == PairKey::of(i + 1, 0, true));
  // The same with pairs of dynamic bodies, in whatever order the finder finds them.
  for (const bool reversed : {false, true}) {
    PhysicsBench row(capacities);
    row.settings.gravity = {};
    for (BodyId id = 1; id <= 6; ++id) row.add_sphere(id, 0.05, 0.2, 0.5, {0.0999 * id, 0, 0});
    row.world.begin_step(row.settings);
    for (std::uint32_t k = 0; k < 5; ++k) {
      const std::uint32_t slot = reversed ? 4 - k : k;
      REQUIRE(row.world.dynamic_pairs().try_push({slot, slot + 1}));
    }
    row.report = row.world.finish_step(row.settings);
    CHECK(row.report.capacity_bits == kPairsFull);
    CHECK(row.report.dropped == 1);
    REQUIRE(row.report.contacts == 4);
    for (std::uint32_t i = 0; i < 4; ++i) CHECK(row.world.contacts()[i].key == PairKey::of(i + 1, i + 2, false));
  }
}

TEST_CASE("Beyond the capacity of pairs those with fixed bodies stay, so that nothing falls through the ground") {
  Capacities capacities;
  capacities.pairs = 8;
  PhysicsBench bench(capacities);
  bench.add_ground(0, 0.5);
  for (BodyId id = 1; id <= 6; ++id) bench.add_sphere(id, 0.05, 0.2, 0.5, {0.0999 * id, 0, 0.0499});
  bench.step();
  CHECK(bench.report.capacity_bits == kPairsFull);
  CHECK(bench.report.dropped == 3);
  std::uint32_t grounded = 0;
  for (const Contact& contact : bench.world.contacts()) grounded += contact.b_fixed ? 1 : 0;
  CHECK(grounded == 6);
}

TEST_CASE("Beyond the capacity of contacts the deepest are kept, ties by the lower key") {
  Capacities capacities;
  capacities.contacts = 3;
  PhysicsBench bench(capacities);
  bench.add_ground(0, 0.5);
  const double depth[] = {1e-5, 4e-5, 2e-5, 5e-5, 2e-5, 2e-5};  // kept: 2 and 4, and of the ties the first, 3
  for (BodyId id = 1; id <= 6; ++id) bench.add_sphere(id, 0.05, 0.2, 0.5, {0.2 * id, 0, 0.05 - depth[id - 1]});
  bench.step();
  CHECK(bench.report.capacity_bits == kContactsFull);
  CHECK(bench.report.dropped == 3);
  CHECK(bench.report.deepest_m == Approx(5e-5));
  REQUIRE(bench.report.contacts == 3);
  const BodyId kept[] = {2, 3, 4};
  for (std::uint32_t i = 0; i < 3; ++i) CHECK(bench.world.contacts()[i].key == PairKey::of(kept[i], 0, true));
}

TEST_CASE("Pairs that touch nothing, pairs given twice and pairs given backwards change no bit") {
  PhysicsBench plain, noisy;
  insert_all(plain, heap(4));
  insert_all(noisy, heap(4));
  for (int k = 0; k < 200; ++k) {
    plain.step();
    noisy.world.begin_step(noisy.settings);
    const auto count = static_cast<std::uint32_t>(noisy.world.bodies().size());
    for (std::uint32_t a = count; a-- > 0;)
      for (std::uint32_t b = 0; b < count; ++b)
        if (a != b) REQUIRE(noisy.world.dynamic_pairs().try_push({a, b}));
    noisy.report = noisy.world.finish_step(noisy.settings);
    REQUIRE(noisy.world.state_hash() == plain.world.state_hash());
    REQUIRE(noisy.report.capacity_bits == 0);
  }
}

TEST_CASE("A world restored from its bytes goes on with the same bits") {
  Capacities capacities;
  capacities.border_contacts = 2;
  const auto make = [&] {
    auto bench = std::make_unique<PhysicsBench>(capacities);
    insert_all(*bench, heap(5));
    return bench;
  };
  auto bench = make();
  bench->run(80);
  // Everything that a step depends on is set.
  bench->world.set_frozen(SlotIndex{3}, true);
  bench->world.device_spring() = {.enabled = true,
                                  .slot = SlotIndex{2},
                                  .stiffness_N_per_m = 500,
                                  .damping_Ns_per_m = 2,
                                  .stiffness_Nm_per_rad = 1,
                                  .damping_Nms_per_rad = 0.01,
                                  .target = {{0, 0, 0.1}, {}},
                                  .target_velocity = {{0.1, 0, 0}, {}},
                                  .step_impulse = {}};
  bench->world.border_rule.mode = BorderMode::kReplay;
  BorderContact border;
  border.member = 10;
  border.outside = 99;
  border.normal = {0, 0, 1};
  border.impulse_rate = 1;
  border.friction = 0.5;
  REQUIRE(bench->world.add_border_contact(border));
  bench->run(20);
  bench->world.apply_wrench(SlotIndex{1}, {{1, 0, 0}, {0, 0, 0.1}});
  REQUIRE_FALSE(bench->world.contacts().empty());
  REQUIRE(bench->world.add_warm_start(World::warm_start_of(bench->world.contacts()[0], bench->h())));

  std::vector<std::byte> bytes(bench->world.save_size_bound());
  ByteWriter out(bytes);
  bench->world.save(out);
  REQUIRE(out.ok());
  PhysicsBench copy(capacities);
  copy.add_sphere(77, 0.1, 1, 0.5, {});  // whatever was there is gone afterwards
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(copy.world.restore(in));
  CHECK(in.remaining() == 0);
  CHECK(copy.world.state_hash() == bench->world.state_hash());
  bench->settings.sub_steps = copy.settings.sub_steps = 8;  // impulses are scaled: the last sub-step is remembered
  for (int k = 0; k < 100; ++k) {
    bench->step();
    copy.step();
    REQUIRE(copy.world.state_hash() == bench->world.state_hash());
    REQUIRE(contacts_hash(copy.world) == contacts_hash(bench->world));
    REQUIRE(copy.world.border_contacts()[0].work == bench->world.border_contacts()[0].work);
  }
  // The same state is the same bytes.
  std::vector<std::byte> first(bench->world.save_size_bound()), second(first);
  ByteWriter one(first), two(second);
  bench->world.save(one);
  copy.world.save(two);
  CHECK(first == second);
}

TEST_CASE("Bytes that are short or hold too much are refused and leave an empty world") {
  PhysicsBench bench;
  insert_all(bench, heap(6));
  bench.run(50);
  std::vector<std::byte> bytes(bench.world.save_size_bound());
  ByteWriter out(bytes);
  bench.world.save(out);
  std::vector<std::size_t> sizes{out.size() - 1};
  for (std::size_t size = 0; size < out.size(); size += 1 + size / 20) sizes.push_back(size);
  for (const std::size_t size : sizes) {
    PhysicsBench copy;
    ByteReader in(std::span<const std::byte>(bytes).first(size));
    CHECK_FALSE(copy.world.restore(in));
    CHECK(copy.world.bodies().empty());
    copy.step();  // an empty world steps
  }
  Capacities small;
  small.bodies = 4;
  PhysicsBench copy(small);
  ByteReader in(bytes);
  CHECK_FALSE(copy.world.restore(in));
}

TEST_CASE("Damaged bytes are refused or give a world that can be queried, never a missing slot") {
  PhysicsBench bench;
  insert_all(bench, heap(8));
  bench.run(50);
  std::vector<std::byte> bytes(bench.world.save_size_bound());
  ByteWriter out(bytes);
  bench.world.save(out);
  Random random(11);
  int refused = 0;
  for (int k = 0; k < 2000; ++k) {
    std::vector<std::byte> damaged(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(out.size()));
    damaged[static_cast<std::size_t>(random(0, static_cast<double>(out.size())))] ^= std::byte{0x80};
    PhysicsBench copy;
    ByteReader in(damaged);
    if (!copy.world.restore(in)) {
      ++refused;
      CHECK(copy.world.bodies().empty());
      continue;
    }
    for (const Contact& contact : copy.world.contacts()) {
      REQUIRE(contact.slot_a < copy.world.bodies().size());
      REQUIRE(contact.slot_b < (contact.b_fixed ? copy.world.fixed_bodies().size() : copy.world.bodies().size()));
      REQUIRE(contact.count <= kMaxManifoldPoints);
    }
    for (const Body& body : copy.world.bodies()) REQUIRE(is_finite(body.motion.pose));
  }
  CHECK(refused > 20);
}

TEST_CASE("Impulses given from another world start a contact as if it had been here all along") {
  const auto make = [](PhysicsBench& bench) {
    bench.add_ground(0, 0.5, 0.1);
    bench.add_stack(1, 4, 0.05, 0.2, 0.5);
  };
  PhysicsBench old;
  make(old);
  old.run(1000);
  PhysicsBench with, without;
  for (PhysicsBench* bench : {&with, &without}) {
    bench->add_ground(0, 0.5, 0.1);
    for (const Body& body : old.world.bodies()) REQUIRE(bench->world.insert(body));
  }
  const auto contacts = old.world.contacts();
  for (std::size_t i = contacts.size(); i-- > 0;)  // in any order
    REQUIRE(with.world.add_warm_start(World::warm_start_of(contacts[i], old.h())));
  old.settings.sub_steps = with.settings.sub_steps = without.settings.sub_steps = 8;  // forces, not impulses, travel
  old.step();
  with.step();
  without.step();
  for (BodyId id = 1; id <= 4; ++id) {
    CHECK(norm(with.velocity(id).linear - old.velocity(id).linear) < 1e-12);
    CHECK(norm(with.velocity(id).angular - old.velocity(id).angular) < 1e-11);
  }
  CHECK(norm(without.velocity(1).linear - old.velocity(1).linear) > 1e-6);
}

TEST_CASE("A contact of another world continues along the axis that it has there, with its impulses") {
  constexpr double kSize = 0.05, kOverlap = 12e-6;
  constexpr Vec3d kCorner{kSize - kOverlap, 0, kSize - kOverlap};  // above and beside: either axis is as good
  const auto come_from = [&](PhysicsBench& bench, const Vec3d& way) {
    bench.settings.gravity = {};
    bench.add_box(1, {0.5 * kSize, 0.5 * kSize, 0.5 * kSize}, 0.2, 0.5, {});
    bench.add_box(2, {0.5 * kSize, 0.5 * kSize, 0.5 * kSize}, 0.2, 0.5, {kCorner - 1e-3 * way, {}});
    for (const Vec3d& at : {kCorner - 1e-3 * way, kCorner}) {
      bench.world.find(1)->motion = {};
      bench.world.find(2)->motion = {{at, {}}, {-0.01 * (Vec3d{1, 0, 1} - way), {}}};
      bench.step();
      REQUIRE(bench.world.contacts().size() == 1);
    }
  };
  PhysicsBench above, beside;
  come_from(above, {1, 0, 0});  // slid along x over the top, and touches it
  come_from(beside, {0, 0, 1});
  REQUIRE(above.world.contacts()[0].normal == Vec3d{0, 0, 1});
  REQUIRE(beside.world.contacts()[0].normal == Vec3d{1, 0, 0});
  REQUIRE(beside.world.continue_contact(World::warm_start_of(above.world.contacts()[0], above.h()), beside.h()));
  for (const BodyId id : {1u, 2u}) beside.world.find(id)->motion = above.world.find(id)->motion;
  above.step();
  beside.step();
  CHECK(beside.world.contacts()[0].normal.z > 0.999999);  // searched again: the bodies have turned a little
  for (const BodyId id : {1u, 2u}) CHECK(norm(beside.velocity(id).linear - above.velocity(id).linear) < 1e-7);
  CHECK(norm(above.velocity(2).linear) > 1e-3);
}

TEST_CASE("Impulses of a pair that does not touch are dropped after the next step") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  bench.add_ground(0, 0.5);
  bench.add_sphere(1, 0.05, 0.2, 0.5, {0, 0, 0.2});
  PhysicsBench touching;
  touching.add_ground(0, 0.5);
  touching.add_sphere(1, 0.05, 0.2, 0.5, {0, 0, 0.05});
  touching.run(10);
  REQUIRE(touching.report.contacts == 1);
  WarmStart given = World::warm_start_of(touching.world.contacts()[0], touching.h());
  given.normal_force[0] = 100;
  REQUIRE(bench.world.add_warm_start(given));
  PhysicsBench fresh;
  fresh.settings.gravity = {};
  fresh.add_ground(0, 0.5);
  fresh.add_sphere(1, 0.05, 0.2, 0.5, {0, 0, 0.2});
  bench.step();
  fresh.step();
  REQUIRE(bench.report.contacts == 0);
  // Nothing is left of them in all that the next step depends on.
  std::vector<std::byte> first(bench.world.save_size_bound()), second(first);
  ByteWriter one(first), two(second);
  bench.world.save(one);
  fresh.world.save(two);
  CHECK(one.size() == two.size());
  CHECK(first == second);
}

TEST_CASE("A frozen body stays as it is, bears any load and goes on with its velocity") {
  PhysicsBench bench;
  bench.add_sphere(1, 0.05, 0.2, 0.5, {0, 0, 0}, {0, 0, 1});
  bench.add_sphere(2, 0.05, 50, 0.5, {0, 0, 0.1001});
  bench.world.set_frozen(SlotIndex{0}, true);
  const BodyMotion before = bench.body(1).motion;
  bench.run(500);
  CHECK(bench.body(1).motion == before);
  // To the other it is infinitely heavy and at rest.
  CHECK(0.1 - bench.position(2).z == Approx(bench.overlap_under(50 * tactus::test::kGravity, 50)).epsilon(0.01));
  bench.world.apply_impulse(SlotIndex{0}, {{1, 0, 0}, {}});
  CHECK(bench.body(1).motion == before);
  bench.world.set_frozen(SlotIndex{0}, false);
  bench.position(2).x = 10;
  bench.step();
  CHECK(bench.velocity(1).linear.z == Approx(1 - tactus::test::kGravity * bench.settings.dt));
}

TEST_CASE("Brute force finds every overlapping pair once, in the order of slots, and says when there are too many") {
  Random random(9);
  std::vector<Aabb> boxes;
  for (int i = 0; i < 40; ++i) {
    const Vec3d at = random.vector(1);
    boxes.push_back({at, at + Vec3d{0.6, 0.6, 0.6}});
  }
  BoundedVector<SlotPair> pairs(1000);
  REQUIRE(find_pairs_brute_force(boxes, pairs));
  std::size_t next = 0;
  for (std::uint32_t a = 0; a < 40; ++a)
    for (std::uint32_t b = a + 1; b < 40; ++b) {
      const auto near = [&](double la, double lb) { return std::abs(la - lb) <= 0.6; };
      const Vec3d &p = boxes[a].lower, &q = boxes[b].lower;
      if (!(near(p.x, q.x) && near(p.y, q.y) && near(p.z, q.z))) continue;
      REQUIRE(next < pairs.size());
      CHECK(pairs[static_cast<std::uint32_t>(next)].a == a);
      CHECK(pairs[static_cast<std::uint32_t>(next)].b == b);
      ++next;
    }
  CHECK(next == pairs.size());
  CHECK(next > 50);
  BoundedVector<SlotPair> few(static_cast<std::uint32_t>(next) - 1);
  CHECK_FALSE(find_pairs_brute_force(boxes, few));
  CHECK(few.full());
}
