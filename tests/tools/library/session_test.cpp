// The public API in virtual time: the same bits as the program, views that follow the state, errors with the remedy.
#include "rt/base/denormals.h"
#include "sim/model/choice_names.h"
#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tests/tools/library/library_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

std::uint64_t hash_of_inner_run(const std::string& name, const std::string& coupling, std::uint64_t ticks) {
  session::RunOptions options = virtual_options();
  options.coupling = *sim::parse_coupling_scheme(coupling);
  auto session = make_session(scene_file(name), options);
  return run(*session, ticks).state_hash;
}

}  // namespace

TEST_CASE("a session has the bits of the program's virtual run, for every coupling") {
  constexpr std::uint64_t kTicks = 1200;
  const auto [scene, coupling] = GENERATE(from_range(kSceneForCoupling));
  CAPTURE(scene, coupling);
  Options options;
  options.coupling = coupling;
  Session session = session_of(scene_of(scene), options);
  // However it is divided into steps.
  for (int i = 0; i < 100; ++i) REQUIRE_FALSE(session.tick());
  step(session, kTicks - 100);
  CHECK(session.ticks_done() == kTicks);
  CHECK(session.state_hash() == hash_of_inner_run(scene, coupling, kTicks));
  CHECK(session.summary().state_hash == session.state_hash());
  CHECK(session.state_hash() != hash_of_inner_run(scene, coupling, kTicks - 1));
}

TEST_CASE("reset gives the same bits again, in the same memory") {
  Session session = session_of(scene_of("card_house.toml"));
  step(session, 700);
  const std::uint64_t hash = session.state_hash();
  const BodyState* bodies = session.bodies().data();
  const BodyState moved = session.bodies()[session.scene().proxy()];
  REQUIRE_FALSE(session.reset());
  CHECK(session.ticks_done() == 0);
  CHECK(session.last().number == 0);
  CHECK(session.bodies()[session.scene().proxy()].position_m != moved.position_m);
  step(session, 700);
  CHECK(session.state_hash() == hash);
  CHECK(session.bodies().data() == bodies);
  CHECK(session.bodies()[session.scene().proxy()].position_m == moved.position_m);
}

TEST_CASE("a session opens again with its own scene and options") {
  Options options;
  options.members = 9;
  Session session = session_of(scene_of("press.toml"), options);
  step(session, 300);
  const std::uint64_t hash = session.state_hash();
  const Error error = session.open(session.scene(), session.options());
  INFO(error.message());
  REQUIRE_FALSE(error);
  CHECK(session.options().members == 9);
  CHECK(session.ticks_done() == 0);
  step(session, 300);
  CHECK(session.state_hash() == hash);
}

TEST_CASE("two sessions in one program are independent") {
  Session one = session_of(scene_of("press.toml")), other = session_of(scene_of("press.toml"));
  for (int i = 0; i < 10; ++i) {
    step(one, 60);
    step(other, 60);
  }
  Session alone = session_of(scene_of("press.toml"));
  step(alone, 600);
  CHECK(one.state_hash() == alone.state_hash());
  CHECK(other.state_hash() == alone.state_hash());
}

TEST_CASE("bodies are where both worlds have them, members by the sub-world and the others by the global one") {
  auto inner = make_session(scene_file("card_house.toml"), virtual_options());
  run(*inner, 1003);
  Session session = session_of(scene_of("card_house.toml"));
  CHECK(session.bodies().size() == session.scene().bodies());
  step(session, 1003);
  const auto bodies = session.bodies();
  std::size_t members = 0;
  for (const auto& body : inner->global->bodies()) {
    const auto& world = inner->loop->sub_world().world();
    const physics::Body* member = world.find(body.id);
    members += member != nullptr ? 1 : 0;
    const auto& motion = member != nullptr ? member->motion : body.motion;
    CAPTURE(body.id);
    CHECK(bodies[body.id].position_m ==
          Vector3{motion.pose.position.x, motion.pose.position.y, motion.pose.position.z});
    CHECK(bodies[body.id].rotation[0] == motion.pose.rotation.w);
    CHECK(bodies[body.id].angular_velocity_rad_per_s[2] == motion.velocity.angular.z);
    const Role role = session.roles()[body.id];
    CHECK((role == Role::kMember || role == Role::kBorder) == (member != nullptr));
  }
  CHECK(session.members().size() == members);
  CHECK(session.members().size() == session.last().members);
  CHECK(std::ranges::is_sorted(session.members()));
  for (BodyNumber body = 0; body < session.scene().bodies(); ++body)
    CHECK((session.roles()[body] == Role::kFixed) == session.scene().body(body).fixed);
}

TEST_CASE("contacts of a block on the ground carry its weight and what the hand presses") {
  // press.toml of the tests: a ball of 0.2 kg without weight is pressed on a block of 1 kg.
  Scene scene;
  REQUIRE_FALSE(scene.parse(kPressScene, "press"));
  Session session = session_of(scene);
  step(session, 3000);
  const double pressed_N = length(session.last().force_N);
  double ground_N = 0, proxy_N = 0;
  for (const Contact& contact : session.contacts()) {
    CHECK(length(contact.normal) == Approx(1));
    const bool of_proxy = contact.a == scene.proxy() || contact.b == scene.proxy();
    // The ground is fixed, so B; the normal goes from the block into it.
    if (of_proxy) proxy_N += contact.force_N;
    if (contact.b == 1) {
      CHECK(contact.a == 2);
      CHECK(contact.normal[2] == Approx(-1));
      CHECK(contact.position_m[2] == Approx(0).margin(1e-4));
      ground_N += contact.force_N;
    }
  }
  CHECK(session.last().has(Condition::kProxyContact));
  CHECK(pressed_N > 1.0);
  CHECK(proxy_N == Approx(pressed_N).epsilon(0.02));
  CHECK(ground_N == Approx(9.81 + pressed_N).epsilon(0.02));
}

TEST_CASE("a border contact is between a member and an outside body, and the roles say so") {
  Options options;
  options.members = 6;
  Session session = session_of(scene_of("wall.toml"), options);
  bool seen = false;
  for (int i = 0; i < 40; ++i) {
    step(session, 50);
    for (const BorderContact& contact : session.border_contacts()) {
      seen = true;
      CHECK(session.roles()[contact.member] == Role::kBorder);
      CHECK(session.roles()[contact.outside] == Role::kOutside);
      CHECK(contact.force_N > 0);
      CHECK(length(contact.normal) == Approx(1));
    }
  }
  CHECK(seen);
}

TEST_CASE("the ticks of a step are all there, in order, and of a long one the newest") {
  Options options;
  options.history_ticks = 250;
  Session session = session_of(scene_of("press.toml"), options);
  step(session, 100);
  REQUIRE(session.ticks().size() == 100);
  const Tick* memory = session.ticks().data();
  step(session, 617);
  REQUIRE(session.ticks().size() == 250);
  CHECK(session.ticks().data() == memory);
  for (std::size_t i = 0; i < 250; ++i) CHECK(session.ticks()[i].number == 717 - 250 + i);
  CHECK(session.last().number == 716);
  CHECK(session.ticks().back().force_N == session.last().force_N);
  CHECK(session.last().time_s == Approx(0.717));
  CHECK(session.time_s() == Approx(0.717));
}

TEST_CASE("ticks and looks at them allocate nothing") {
  TACTUS_NEEDS(RtGuard::available(), "allocations are not counted under a sanitizer");
  Session session = session_of(scene_of("card_house.toml"));
  step(session, 1);
  const RtGuard guard;
  bool failed = false;
  for (int i = 0; i < 300; ++i) failed = failed || static_cast<bool>(session.tick());
  std::size_t looked = 0;
  for (int i = 0; i < 100; ++i) {
    failed = failed || static_cast<bool>(session.step(5));
    looked += session.bodies().size() + session.roles().size() + session.members().size() + session.contacts().size() +
              session.border_contacts().size() + session.ticks().size();
  }
  CHECK(guard.allocations() == 0);
  CHECK(guard.locks() == 0);
  CHECK_FALSE(failed);
  CHECK(looked > 0);
}

TEST_CASE("the caller's thread keeps its own way with denormal numbers") {
  Session session = session_of(scene_of("press.toml"));
  step(session, 10);
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before & ~(kFlushToZero | kDenormalsAreZero));
  step(session, 10);
  CHECK_FALSE(denormals_flushed());
  set_denormals_flush();
  step(session, 10);
  CHECK(denormals_flushed());
  _mm_setcsr(before);
}

TEST_CASE("what a session has recorded replays to the same bits") {
  const TemporaryFile tape;
  Session session = session_of(scene_of("press.toml"));
  REQUIRE_FALSE(session.record(tape.path()));
  step(session, 900);
  CHECK_THAT(session.record(tape.path()).message(), Contains("before the first tick"));
  REQUIRE_FALSE(session.close());
  CHECK_FALSE(session.is_open());
  CHECK(session.summary().ticks == 900);
  Replay replay;
  REQUIRE_FALSE(replay_tape(tape.path(), replay));
  CHECK(replay.same_bits);
  CHECK(replay.compared == 900);
  CHECK(replay_tape("no.tape", replay).kind() == Error::Kind::kFile);
}

TEST_CASE("stop ends a step after its tick, and the session goes on") {
  Session session = session_of(scene_of("press.toml"));
  session.stop();
  step(session, 100);
  CHECK(session.ticks_done() == 0);
  step(session, 100);
  CHECK(session.ticks_done() == 100);
}

TEST_CASE("requests disarm and arm, and a fault that was injected is taken back by a re-arm") {
  Options options;
  options.inject = "nan@300+5";
  options.arm_at_start = false;
  Session session = session_of(scene_of("press.toml"), options);
  step(session, 50);
  CHECK(session.last().has(Condition::kNotArmed));
  session.request(Request::kArm);
  step(session, 50);
  CHECK_FALSE(session.last().has(Condition::kNotArmed));
  session.request(Request::kDisarm);
  step(session, 50);
  CHECK(session.last().has(Condition::kNotArmed));
  step(session, 250);
  CHECK(session.last().fault == FaultCode::kInputNotFinite);
  CHECK_THAT(std::string(describe(session.last().fault)), Contains("NaN"));
  CHECK(session.summary().verdict == Verdict::kBad);
  CHECK(session.summary().faults == 1);
  session.request(Request::kRearm);
  step(session, 400);
  CHECK(session.last().fault == FaultCode::kNone);
  CHECK(session.summary().verdict != Verdict::kBad);
}

TEST_CASE("a session that is not open says so, does nothing, and ends nothing") {
  Session session;
  for (const Error& error : {session.step(1), session.run(1), session.record("x"), session.reset()}) {
    CHECK(error.kind() == Error::Kind::kUse);
    CHECK_THAT(error.message(), Contains("after Session::open"));
  }
  CHECK_FALSE(session.close());
  session.request(Request::kArm);
  session.stop();
  CHECK(session.bodies().empty());
  CHECK(session.contacts().empty());
  CHECK(session.ticks().empty());
  CHECK(session.last().number == 0);
  CHECK(session.summary().text.empty());
  CHECK(session.scene().empty());
  CHECK(session.state_hash() == 0);
  Session other = session_of(scene_of("press.toml"));
  Session moved = std::move(other);
  CHECK_FALSE(other.is_open());  // NOLINT(bugprone-use-after-move)
  CHECK(other.step(1).kind() == Error::Kind::kUse);
  step(moved, 1);
  moved = Session();
  CHECK_FALSE(moved.is_open());
}

TEST_CASE("mistakes are errors with the library's own words, and the session is not open") {
  const Scene scene = scene_of("press.toml");
  const auto said = [&](auto&& change) {
    Options options;
    change(options);
    Session session;
    const Error error = session.open(scene, options);
    CHECK(error.kind() == Error::Kind::kOption);
    CHECK_FALSE(session.is_open());
    CHECK_THAT(error.message(), !Contains("--") && !Contains("\n"));
    return error.message();
  };
  CHECK_THAT(said([](Options& o) { o.coupling = "glue"; }), Contains("coupling: 'glue' is none; accepted: sub-world"));
  CHECK_THAT(said([](Options& o) { o.rate_Hz = 5; }),
             Contains("rate_Hz: 5 is out of range; accepted: 100 to 10000 Hz"));
  CHECK_THAT(said([](Options& o) { o.members = 257; }), Contains("members: 257") && Contains("1 to 256"));
  CHECK_THAT(said([](Options& o) { o.history_ticks = 0; }), Contains("history_ticks") && Contains("1 to"));
  CHECK_THAT(said([](Options& o) { o.device = "usb"; }), Contains("real_time = false: usb keeps real time"));
  CHECK_THAT(said([](Options& o) { o.device = "joystick"; }), Contains("joystick"));
  CHECK_THAT(said([](Options& o) { o.device = "own"; }), Contains("own"));
  CHECK_THAT(said([](Options& o) { o.inject = "gremlin@3"; }), Contains("gremlin"));
  CHECK_THAT(said([](Options& o) { o.late_s = -1; }), Contains("late_s"));
  CHECK_THAT(said([](Options& o) { o.rate_Hz = std::nan(""); }), Contains("rate_Hz"));

  Session session;
  const Error file = session.open("no/scene.toml");
  CHECK(file.kind() == Error::Kind::kFile);
  CHECK_THAT(file.message(), Contains("no/scene.toml") && Contains("cannot be read"));
  CHECK(session.open(Scene(), {}).kind() == Error::Kind::kUse);
  Options real;
  real.real_time = true;
  real.device = "can:no_such_bus";
  CHECK(session.open(scene, real).kind() == Error::Kind::kMachine);
  real.device = "sim";
  REQUIRE_FALSE(session.open(scene, real));
  CHECK_THAT(session.step(1).message(), Contains("run()"));
  CHECK_THAT(session.run(-1).message(), Contains("0.01 to"));
  CHECK_THAT(session.run(std::nan("")).message(), Contains("0.01 to"));
  session = session_of(scene);
  CHECK_THAT(session.run(1).message(), Contains("step()"));
  CHECK_THAT(session.record("/no/folder/a.tape").message(), Contains("cannot be written"));
}

TEST_CASE("changed options are reported") {
  Options options;
  CHECK(session_of(scene_of("stack20.toml"), options).notes().empty());
  options.coupling = "interpolation";
  const auto notes = session_of(scene_of("stack20.toml"), options).notes();
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("coupling interpolation"));
}

TEST_CASE("poses are of the frames that the scene places, whatever the centre of mass") {
  // A hammer, heavy at one end, and a wedge away from its points' origin, both falling; a paddle on a path.
  constexpr std::string_view kText = R"(
effects = ["gravity", "friction", "kinematic"]
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
position_m = [0, 0, 1]
[[body]]
name = "hammer"
shape = "compound"
position_m = [0.3, 0.1, 0.2]
rotation_vector_rad = [0, 0, 0.4]
parts = [{shape = "box", size_m = [0.2, 0.02, 0.02], mass_kg = 0.1},
         {shape = "box", size_m = [0.04, 0.1, 0.04], position_m = [0.1, 0, 0.01], mass_kg = 1},
         {shape = "cone", radius_m = 0.01, length_m = 0.02, position_m = [-0.1, 0, 0], mass_kg = 1e-6}]
[[body]]
name = "wedge"
shape = "hull"
points_m = [[0.1, 0, 0], [0.2, 0, 0], [0.1, 0.1, 0], [0.1, 0, 0.05], [0.2, 0.1, 0]]
density_kg_per_m3 = 500
position_m = [-0.4, 0.2, 0.3]
rotation_vector_rad = [0.1, 0.2, 0]
[[body]]
name = "paddle"
shape = "compound"
kinematic = true
parts = [{shape = "box", size_m = [0.02, 0.02, 0.2]}, {shape = "box", size_m = [0.1, 0.02, 0.05], position_m = [0.03, 0, 0.1]}]
[[body.path]]
time_s = 0
position_m = [0, 0.5, 0.3]
[[body.path]]
time_s = 0.2
position_m = [0.1, 0.5, 0.3]
rotation_vector_rad = [0, 0, 0.5]
)";
  Scene scene;
  const Error error = scene.parse(kText, "frames");
  INFO(error.message());
  REQUIRE_FALSE(error);
  const auto differ = [](const Vector3& a, const Vector3& b) {
    return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
  };
  const auto check_pose = [&](const auto& of, const Vector3& position, const Vec3d& turned) {
    CHECK(differ(of.position_m, position) < 1e-12);
    const Quatd q = quat_from_rotation_vector(turned);
    const double same = of.rotation[0] * q.w + of.rotation[1] * q.x + of.rotation[2] * q.y + of.rotation[3] * q.z;
    CHECK(std::abs(same) > 1 - 1e-12);
  };
  check_pose(scene.body(1), {0.3, 0.1, 0.2}, {0, 0, 0.4});
  CHECK(differ(scene.body(1).centre_of_mass_m, {1.0 / 11, 0, 0.1 / 11}) < 1e-6);
  CHECK(differ(scene.parts(1)[1].position_m, {0.1, 0, 0.01}) < 1e-12);
  CHECK(differ(scene.parts(1)[2].position_m, {-0.1, 0, 0}) < 1e-12);  // of a cone the middle of its base
  const auto corners = scene.corners(2);
  CHECK(std::ranges::any_of(corners, [&](const Vector3& at) { return differ(at, {0.2, 0.1, 0}) < 1e-12; }));

  for (const char* coupling : {"direct", "sub-world"}) {
    CAPTURE(coupling);
    Options options;
    options.coupling = coupling;
    Session session = session_of(scene, options);
    check_pose(session.bodies()[1], {0.3, 0.1, 0.2}, {0, 0, 0.4});
    check_pose(session.bodies()[2], {-0.4, 0.2, 0.3}, {0.1, 0.2, 0});
    check_pose(session.bodies()[3], {0, 0.5, 0.3}, {});
    step(session, 400);  // the path ends at 0.2 s
    check_pose(session.bodies()[3], {0.1, 0.5, 0.3}, {0, 0, 0.5});
    const double fallen = 0.5 * 9.81 * 0.4 * 0.4;
    CHECK(session.bodies()[1].position_m[2] == Approx(0.2 - fallen).epsilon(0.01));
    CHECK(session.bodies()[2].velocity_m_per_s[2] == Approx(-9.81 * 0.4).epsilon(1e-6));
  }
}
