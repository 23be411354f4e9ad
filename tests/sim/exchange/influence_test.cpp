#include "sim/exchange/influence.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/body_index.h"

namespace {

using namespace tactus;
using sim::BodyIndex;
using sim::ContactEdge;
using sim::ContactGraph;
using sim::Influence;
using tactus::test::operator""_b;
using Bodies = std::vector<physics::Body>;

// Spheres of 0.2 m in a row along x, touching; body 0 is the proxy.
Bodies row(const std::vector<double>& masses) {
  Bodies bodies;
  for (const double mass : masses) {
    const auto id = static_cast<BodyId>(bodies.size());
    bodies.push_back(physics::make_dynamic_body(id, physics::Shape::sphere(0.1), mass, 0.5, {{0.2 * id, 0, 0}, {}}));
  }
  return bodies;
}

ContactEdge row_touch(std::uint32_t a) { return {BodyIndex{a}, BodyIndex{a + 1}, {0.2 * a + 0.1, 0, 0}, {1, 0, 0}}; }

std::vector<double> influence_by_body(const Bodies& bodies, const std::vector<ContactEdge>& touches,
                                      const std::vector<BodyIndex>& near = {}, std::uint32_t enough = 1000) {
  const auto count = static_cast<std::uint32_t>(bodies.size());
  ContactGraph graph(count, 200);
  graph.build(count, touches);
  Influence influence(count, 200);
  std::vector<double> result(count, -1);
  double last = 1;
  for (const auto& body : influence.find(graph, sim::BodySpan(std::span(bodies)), 0_b, near, enough)) {
    CHECK(body.influence <= last);
    last = body.influence;
    result[number_of(body.index)] = body.influence;
  }
  return result;
}

}  // namespace

TEST_CASE("In a row of equal spheres influence halves with every contact") {
  // Central contacts: tau = (1/m) / sqrt(2/m 2/m) = 1/2.
  const auto found = influence_by_body(row({1, 1, 1, 1, 1}), {row_touch(0), row_touch(1), row_touch(2), row_touch(3)});
  for (std::uint32_t body = 1; body < 5; ++body) CHECK(found[body] == Approx(std::pow(0.5, body - 1)));
  CHECK(found[0] == -1);  // the proxy itself is not listed
}

TEST_CASE("A heavy body stops the expansion") {
  // tau through a body of mass M between unit masses: (1/M) / (1 + 1/M) = 1 / (M + 1).
  for (const double heavy : {1.0, 3.0, 9.0, 49.0}) {
    const auto found = influence_by_body(row({1, heavy, 1}), {row_touch(0), row_touch(1)});
    CHECK(found[2] == Approx(1 / (heavy + 1)));
  }
  const auto wall = influence_by_body(row({1, 1e6, 1}), {row_touch(0), row_touch(1)});
  CHECK(wall[2] == Approx(Influence::kMinTau));  // friction may still couple it
}

TEST_CASE("Contacts at right angles through a centre are coupled by friction only") {
  Bodies bodies = row({1, 1, 1});
  bodies[2].motion.pose.position = {0.2, 0.2, 0};
  const auto found = influence_by_body(bodies, {row_touch(0), {1_b, 2_b, {0.2, 0.1, 0}, {0, 1, 0}}});
  CHECK(found[2] == Approx(Influence::kMinTau));
}

TEST_CASE("A lever arm couples contacts at right angles") {
  // A rod of mass m and length 2 l along x, pushed at one end along y, touched at the other along y: without turning
  // tau would be 1/2; with it the far end moves the other way: n n / m + (r x n) I^-1 (r x n') = 1/m - l^2 / I.
  const double m = 2, l = 0.5;
  Bodies bodies = row({1, m, 1});
  bodies[0].mass = bodies[2].mass = 1e9;  // only the rod's own terms are left in A
  bodies[1].shape = physics::Shape::box({l, 0.01, 0.01});
  bodies[1].inertia = {1e-3, 0.2, 0.25};
  bodies[0].motion.pose.position = {-l, -0.1, 0};
  bodies[1].motion.pose.position = {0, 0, 0};
  bodies[2].motion.pose.position = {l, 0.1, 0};
  const auto found = influence_by_body(bodies, {{0_b, 1_b, {-l, 0, 0}, {0, 1, 0}}, {1_b, 2_b, {l, 0, 0}, {0, 1, 0}}});
  const double inverse_inertia = 1 / 0.25;
  const double expected = std::abs(1 / m - l * l * inverse_inertia) / (1 / m + l * l * inverse_inertia);
  CHECK(found[2] == Approx(expected).epsilon(1e-6));
}

TEST_CASE("The best of several ways counts") {
  // 0 - 1 - 3 through a heavy body, 0 - 2 - 3 through a light one.
  Bodies bodies = row({1, 100, 1, 1});
  const std::vector<ContactEdge> touches{{0_b, 1_b, {0.1, 0, 0}, {1, 0, 0}},
                                         {0_b, 2_b, {0.1, 0, 0}, {1, 0, 0}},
                                         {1_b, 3_b, {0.3, 0, 0}, {1, 0, 0}},
                                         {2_b, 3_b, {0.5, 0, 0}, {1, 0, 0}}};
  CHECK(influence_by_body(bodies, touches)[3] == Approx(0.5));
}

TEST_CASE("A body that is only near has half the influence, and what it touches goes on from there") {
  // 1 is near, 2 touches it in line: tau = 1/2 as for a contact.
  const auto found = influence_by_body(row({1, 1, 1, 1}), {row_touch(1)}, {1_b});
  CHECK(found[1] == Approx(Influence::kNearDiscount));
  CHECK(found[2] == Approx(Influence::kNearDiscount * 0.5));
  CHECK(found[3] == -1);
  // A contact beats nearness.
  CHECK(influence_by_body(row({1, 1}), {row_touch(0)}, {1_b})[1] == 1);
}

TEST_CASE("On any graph influence is in [0, 1] and equals the best of all ways by exhaustive search") {
  std::mt19937 random(11);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
  for (int round = 0; round < 30; ++round) {
    Bodies bodies;
    for (BodyId id = 0; id < 6; ++id) {
      const Vec3d where{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      bodies.push_back(physics::make_dynamic_body(id, physics::Shape::box({0.1, 0.2, 0.3}), uniform(0.1, 5), 0.5,
                                                  {where, quat_from_rotation_vector(5.0 * where)}));
    }
    std::vector<ContactEdge> touches;
    for (std::uint32_t a = 0; a < 6; ++a)
      for (std::uint32_t b = a + 1; b < 6; ++b) {
        if (uniform(0, 1) < 0.4) continue;
        const Vec3d n = normalized_or(Vec3d{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}, Vec3d{1, 0, 0});
        const Vec3d middle =
            0.5 * (bodies[a].motion.pose.position + bodies[b].motion.pose.position) + 0.1 * Vec3d{n.y, n.z, n.x};
        touches.push_back({BodyIndex{a}, BodyIndex{b}, middle, n});
      }
    // tau from its definition, with full inertia matrices.
    const auto coupling = [&](const ContactEdge& c, const ContactEdge& d, BodyIndex body) {
      const auto& q = bodies[number_of(body)];
      const Vec3d inverse{1 / q.inertia.x, 1 / q.inertia.y, 1 / q.inertia.z};
      const SymMat3d i = rotate_diagonal(q.motion.pose.rotation, inverse);
      const Vec3d rc = cross(c.point - q.motion.pose.position, c.normal);
      const Vec3d rd = cross(d.point - q.motion.pose.position, d.normal);
      return dot(c.normal, d.normal) / q.mass + dot(rc, i * rd);
    };
    const auto own = [&](const ContactEdge& c) { return coupling(c, c, c.a) + coupling(c, c, c.b); };
    std::vector<double> best(6, -1);
    const auto follow = [&](const auto& self, double value, BodyIndex at, std::uint32_t through, int depth) -> void {
      best[number_of(at)] = std::max(best[number_of(at)], value);
      if (depth == 7) return;
      for (std::uint32_t t = 0; t < touches.size(); ++t) {
        if (t == through || (touches[t].a != at && touches[t].b != at)) continue;
        const BodyIndex to = touches[t].a == at ? touches[t].b : touches[t].a;
        if (to == 0_b) continue;
        const double tau =
            std::abs(coupling(touches[through], touches[t], at)) / std::sqrt(own(touches[through]) * own(touches[t]));
        CHECK(tau <= 1 + 1e-12);
        self(self, value * std::clamp(tau, Influence::kMinTau, 1.0), to, t, depth + 1);
      }
    };
    for (std::uint32_t t = 0; t < touches.size(); ++t)
      if (touches[t].a == 0_b) follow(follow, 1.0, touches[t].b, t, 0);
    const auto found = influence_by_body(bodies, touches);
    for (std::uint32_t body = 1; body < 6; ++body) CHECK(found[body] == Approx(best[body]));
  }
}

TEST_CASE("The search stops when nothing left can matter, and never short of what was asked") {
  std::vector<double> masses(100, 1.0);
  std::vector<ContactEdge> touches;
  for (std::uint32_t a = 0; a + 1 < 100; ++a) touches.push_back(row_touch(a));
  const auto found = influence_by_body(row(masses), touches, {}, 5);
  const auto count = std::count_if(found.begin(), found.end(), [](double i) { return i >= 0; });
  // The fifth has 1/16; the sixth, at half of that, may still be a member with doubled score.
  CHECK(count == 6);
}
