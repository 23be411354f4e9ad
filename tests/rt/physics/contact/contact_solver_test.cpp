// Rows of one and rows as wide as a register must be the same solver.
#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "rt/physics/contact/contact_solver.h"
#include "rt/physics/integrate.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;

namespace {

using tactus::test::Random;

template <class T>
struct Heap {
  std::vector<SolverBody<T>> motion;
  std::vector<SymMat3<T>> inverse_inertia;
  std::vector<Contact> contacts;
  Capacities capacities;

  SolverBodies<T> bodies() { return {motion, inverse_inertia}; }
};

// Bodies in any motion, with contacts anywhere among them; body 0 is in more than there are colours when asked.
template <class T>
Heap<T> random_heap(std::uint64_t seed, std::uint32_t bodies, std::uint32_t contacts, bool hub) {
  Random random(seed);
  const auto vec = [&](double size) {
    const Vec3d v = random.vector(size);
    return Vec3<T>{static_cast<T>(v.x), static_cast<T>(v.y), static_cast<T>(v.z)};
  };
  const auto number = [&](double low, double high) { return static_cast<T>(random(low, high)); };
  Heap<T> heap;
  for (std::uint32_t i = 0; i < bodies; ++i) {
    SolverBody<T> body;
    body.v = vec(1);
    body.w = vec(5);
    body.delta_position = vec(1e-3);
    body.delta_rotation = quat_from_rotation_vector(vec(1e-2));
    body.inverse_mass = i % 7 == 6 ? T(0) : number(0.2, 20);
    heap.motion.push_back(body);
    const T inertia = number(20, 2000);
    heap.inverse_inertia.push_back(i % 7 == 6 ? SymMat3<T>{} : SymMat3<T>::identity(inertia));
  }
  for (std::uint32_t k = 0; k < contacts; ++k) {
    Contact c;
    c.slot_a = hub ? 0 : static_cast<std::uint32_t>(random(0, bodies - 1.001));
    c.slot_b = c.slot_a + 1 + static_cast<std::uint32_t>(random(0, bodies - c.slot_a - 1.001));
    c.b_fixed = k % 5 == 4;
    c.normal = normalized_or(random.vector(1), Vec3d{0, 0, 1});
    c.friction = random(0, 1);
    c.count = 1 + k % 4;
    for (std::uint32_t i = 0; i < c.count; ++i) {
      ContactPoint& p = c.points[i];
      p.from_a = random.vector(0.05);
      p.from_b = random.vector(0.05);
      p.separation = random(-1e-3, 1e-3);
      p.normal_impulse = random(0, 0.1);
      p.tangent_impulse[0] = random(-0.02, 0.02);
      p.tangent_impulse[1] = random(-0.02, 0.02);
    }
    heap.contacts.push_back(c);
  }
  heap.capacities.bodies = bodies;
  heap.capacities.contacts = contacts;
  return heap;
}

template <class T, int kWidth>
void solve_steps(Heap<T>& heap) {
  ContactSolver<T, kWidth> solver(heap.capacities);
  const SweepRule<T> rule{Softness<T>::make(T(250), T(10), T(2.5e-4)), T(4000), T(1e-5), T(0.25)};
  solver.prepare(std::span<const Contact>(heap.contacts), heap.bodies(), 1e-3);
  for (int sub_step = 0; sub_step < 3; ++sub_step) {
    solver.warm_start(heap.bodies(), rule);
    solver.solve_biased(heap.bodies(), rule, sub_step > 0);
    solver.relax(heap.bodies(), rule, true, sub_step < 2);
    if (sub_step == 2) solver.add_to_totals();
    solver.scale_impulses(T(0.75));
  }
  solver.relax(heap.bodies(), rule, false, false);
  solver.store(std::span(heap.contacts), 1.0);
}

template <class T>
void check_same_bits(std::uint64_t seed, std::uint32_t bodies, std::uint32_t contacts, bool hub) {
  Heap<T> one = random_heap<T>(seed, bodies, contacts, hub), wide = one;
  const Heap<T> start = one;
  solve_steps<T, 1>(one);
  solve_steps<T, kLanes<Register<T>>>(wide);
  for (std::size_t i = 0; i < one.motion.size(); ++i) {
    REQUIRE(one.motion[i].v == wide.motion[i].v);
    REQUIRE(one.motion[i].w == wide.motion[i].w);
    // The sweeps change velocities alone.
    REQUIRE(wide.motion[i].delta_position == start.motion[i].delta_position);
    REQUIRE(wide.motion[i].delta_rotation == start.motion[i].delta_rotation);
  }
  for (std::size_t k = 0; k < one.contacts.size(); ++k)
    for (std::uint32_t i = 0; i < one.contacts[k].count; ++i) {
      const ContactPoint &p = one.contacts[k].points[i], &q = wide.contacts[k].points[i];
      REQUIRE(p.normal_impulse == q.normal_impulse);
      REQUIRE(p.tangent_impulse[0] == q.tangent_impulse[0]);
      REQUIRE(p.tangent_impulse[1] == q.tangent_impulse[1]);
      REQUIRE(p.total_normal_impulse == q.total_normal_impulse);
      REQUIRE(p.total_friction == q.total_friction);
    }
}

}  // namespace

TEST_CASE("Rows of one contact and rows as wide as a register give the same bits") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto bodies = static_cast<std::uint32_t>(2 + seed * 3), contacts = static_cast<std::uint32_t>(1 + seed * 7);
    check_same_bits<double>(seed, bodies, contacts, false);
    check_same_bits<float>(seed, bodies, contacts, false);
  }
}

TEST_CASE("A body with more contacts than there are colours has the rest solved one by one, to the same bits") {
  check_same_bits<double>(3, 200, 190, true);
  check_same_bits<float>(4, 200, 190, true);
}

TEST_CASE("No two contacts of a colour share a moving body, a colour is the first free, what nothing moves has none") {
  const Heap<double> heap = random_heap<double>(5, 60, 300, false);
  ContactColours colours(heap.capacities);
  colours.assign(std::span<const Contact>(heap.contacts), std::span<const SolverBody<double>>(heap.motion));
  const auto is_held = [&](std::uint32_t slot) { return heap.motion[slot].inverse_mass == 0; };
  std::size_t not_solved = 0;
  for (std::size_t k = 0; k < heap.contacts.size(); ++k) {
    const Contact& c = heap.contacts[k];
    const bool held = is_held(c.slot_a) && (c.b_fixed || is_held(c.slot_b));
    CHECK((colours.of(static_cast<std::uint32_t>(k)) == ContactColours::kNotSolved) == held);
    if (held && ++not_solved > 0) continue;
    std::uint64_t taken = 0;
    for (std::size_t j = 0; j < k; ++j) {
      const Contact& d = heap.contacts[j];
      if (c.b_fixed != d.b_fixed || colours.of(static_cast<std::uint32_t>(j)) == ContactColours::kNotSolved) continue;
      const bool shared =
          c.b_fixed ? c.slot_a == d.slot_a
                    : c.slot_a == d.slot_a || c.slot_a == d.slot_b || c.slot_b == d.slot_a || c.slot_b == d.slot_b;
      if (shared) taken |= std::uint64_t{1} << colours.of(static_cast<std::uint32_t>(j));
    }
    std::uint32_t first = 0;
    while ((taken >> first & 1) != 0) ++first;
    CHECK(colours.of(static_cast<std::uint32_t>(k)) == first);
  }
  CHECK(not_solved > 0);
}

TEST_CASE("Bodies moved together have the bits of bodies moved one by one") {
  Random random(11);
  const auto make = [&](std::size_t count) {
    std::vector<Body> bodies(count);
    std::vector<SolverBody<double>> motion(count);
    for (std::size_t i = 0; i < count; ++i) {
      bodies[i].inertia = i % 9 == 8 ? Vec3d{1, 2, 3} : Vec3d{1, 1, 1};
      motion[i].v = random.vector(2);
      motion[i].w = random.vector(i % 11 == 10 ? 900 : 9);
      motion[i].delta_position = random.vector(1e-3);
      motion[i].delta_rotation = quat_from_rotation_vector(random.vector(1e-2));
      motion[i].inverse_mass = i % 5 == 4 ? 0 : 1;
      if (motion[i].inverse_mass == 0) motion[i].v = motion[i].w = {};
      motion[i].gyroscopic = is_anisotropic(bodies[i].inertia) ? 1 : 0;
    }
    return std::pair{bodies, motion};
  };
  auto [bodies, motion] = make(103);
  auto single = motion;
  const double h = 2.5e-4;
  move_bodies<double>(motion, bodies, h);
  for (std::size_t i = 0; i < single.size(); ++i) {
    move_bodies<double>(std::span(single).subspan(i, 1), std::span<const Body>(bodies).subspan(i, 1), h);
    CHECK(motion[i].delta_position == single[i].delta_position);
    CHECK(motion[i].delta_rotation == single[i].delta_rotation);
    CHECK(motion[i].w == single[i].w);
    CHECK(motion[i].v == single[i].v);
  }
}
