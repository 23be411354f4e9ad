// What --accuracy makes of a scene, and that a tape brings it back.
#include <catch2/catch.hpp>

#include "tests/system/session_bench.h"

using namespace tactus;
using session::Accuracy;

namespace {

std::pair<unsigned, unsigned> members_and_sub_steps(Accuracy accuracy, double contact_Hz = 250) {
  auto scene = test::scene_text(test::kPressScene);
  scene.solver.contact_hertz = contact_Hz;
  scene.solver.global_sub_steps_per_tick = scene.solver.far_sub_steps_per_tick = 4;
  auto options = test::virtual_options();
  options.accuracy = accuracy;
  const auto session = test::make_session(scene, options);
  return {session->members, session->loop->config().sub_world.step.sub_steps};
}

}  // namespace

TEST_CASE("Accuracy halves and doubles members and sub-steps of the scene") {
  CHECK(members_and_sub_steps(Accuracy::kFast) == std::pair{4u, 2u});
  CHECK(members_and_sub_steps(Accuracy::kBalanced) == std::pair{8u, 4u});
  CHECK(members_and_sub_steps(Accuracy::kAccurate) == std::pair{16u, 8u});
}

TEST_CASE("Fast keeps the sub-steps that the contact frequency needs") {
  CHECK(members_and_sub_steps(Accuracy::kFast, 1000).second == 4);
}

TEST_CASE("A requested number of members is kept") {
  auto options = test::virtual_options();
  options.accuracy = Accuracy::kAccurate;
  options.members = 3;
  CHECK(test::make_session(test::scene_text(test::kPressScene), options)->members == 3);
}

TEST_CASE("A tape contains its accuracy") {
  auto options = test::virtual_options();
  options.accuracy = Accuracy::kFast;
  const auto text = session::to_tape_text(options, {}, "press", test::kPressScene);
  const auto back = session::from_tape_text(text);
  INFO(back.message());
  REQUIRE(back.ok());
  CHECK(back.value().options.accuracy == Accuracy::kFast);
  CHECK_FALSE(session::parse_accuracy("perfect"));
}
