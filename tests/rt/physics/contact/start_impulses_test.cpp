// The impulses with which a contact starts a step, where another world gives them.
#include "rt/physics/contact/start_impulses.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::physics;

namespace {

constexpr double kSubStep_s = 0.25e-3;

// Two points of features 3 and 5, with impulses of their own.
Contact contact_of_two_points() {
  Contact contact;
  contact.normal = Vec3d{0.48, -0.6, 0.64};
  contact.count = 2;
  for (std::uint32_t i = 0; i < 2; ++i) {
    ContactPoint& point = contact.points[i];
    point.feature = 3 + 2 * i;
    point.normal_impulse = 1e-3 * (1 + i);
    point.tangent_impulse[0] = 2e-4;
    point.tangent_impulse[1] = -1e-4;
  }
  return contact;
}

// The other world's contact: its first point is feature 5, its second one is unknown here.
WarmStart given_at_one_point() {
  WarmStart given;
  given.count = 2;
  given.features = {5, 8};
  given.normal_force = {40, 70};
  given.friction_force = {Vec3d{3, -2, 1}, Vec3d{9, 9, 9}};
  return given;
}

}  // namespace

TEST_CASE("A contact takes the impulses of another world's contact, point by point of the same feature") {
  const Contact before = contact_of_two_points();
  const WarmStart given = given_at_one_point();
  Contact contact = before;
  set_impulses(given, kSubStep_s, contact);

  const auto [t1, t2] = tangents_of(contact.normal);
  const ContactPoint& point = contact.points[1];
  CHECK(point.normal_impulse == Approx(40 * kSubStep_s));
  CHECK(point.tangent_impulse[0] == Approx(dot(given.friction_force[0], t1) * kSubStep_s));
  CHECK(point.tangent_impulse[1] == Approx(dot(given.friction_force[0], t2) * kSubStep_s));
  CHECK(contact.points[0].normal_impulse == before.points[0].normal_impulse);
  CHECK(contact.points[0].tangent_impulse[0] == before.points[0].tangent_impulse[0]);
  CHECK(contact.points[0].tangent_impulse[1] == before.points[0].tangent_impulse[1]);
}
