// Several hands through the public API, in virtual time: the same bits as the program, the part of each hand, errors
// with the remedy.
#include <cmath>
#include <cstring>
#include <filesystem>

#include "sim/loader/scene_load.h"
#include "tests/support/rt_guard.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_file.h"
#include "tests/tools/library/library_bench.h"
#include "tools/validation/two_hands.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

Scene parsed(const std::string& text) {
  Scene scene;
  const Error error = scene.parse(text, "hands");
  INFO(error.message());
  REQUIRE_FALSE(error);
  return scene;
}

Scene tug() { return parsed(hard_cases::tug_text()); }
Scene hand_over() { return parsed(hard_cases::hand_over_text()); }

std::vector<Tick> ticks_of(Session& session, unsigned hand) {
  return {session.ticks(hand).begin(), session.ticks(hand).end()};
}

bool same(const std::vector<Tick>& a, const std::vector<Tick>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Tick)) == 0;
}

// A tool that moves to and fro along x; it counts what the session asks of it.
class Sliding final : public Device {
 public:
  Vector3 force_N{};
  int reads{0}, stops{0};
  DeviceProperties properties() const override { return {}; }
  Reading read(DeviceSample& sample) noexcept override {
    sample.position_m[0] = 0.002 * ((reads++ / 50) % 3);
    return Reading::kFresh;
  }
  void write(const DeviceCommand& command) noexcept override { force_N = command.force_N; }
  void stop() noexcept override { ++stops; }
};

}  // namespace

TEST_CASE("a session of two hands has the bits of the program's, tick by tick and of each hand") {
  Scene scene;
  REQUIRE_FALSE(scene.load(TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml"));
  Options options;
  options.inject = "nan@900+2";
  options.more_injects = {"estop@500"};
  Session session = session_of(scene, options);
  CHECK(scene.hands() == 2);
  CHECK(session.hands() == 2);
  step(session, 700);
  step(session, 500);

  auto inner = sim::load_scene(TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml");
  REQUIRE(inner.ok());
  auto run = hard_cases::TwoHands::create(inner.value(), {"nan@900+2", "estop@500"});
  REQUIRE(run.ok());
  double differs_N = 0;
  std::size_t at = 0;
  const auto summaries = run.value().run(1200, [&](std::uint64_t tick) {
    if (tick < 700) return;  // the session has the ticks of its last step
    for (unsigned hand = 0; hand < 2; ++hand) {
      const Vec3d force_N = run.value().force_N(hand);
      const Vector3& ours = session.ticks(hand)[at].force_N;
      differs_N += std::abs(ours[0] - force_N.x) + std::abs(ours[1] - force_N.y) + std::abs(ours[2] - force_N.z);
    }
    ++at;
  });
  REQUIRE(summaries.ok());
  CHECK(at == 500);
  CHECK(differs_N == 0);
  for (unsigned hand = 0; hand < 2; ++hand) {
    CHECK(session.state_hash(hand) == summaries.value()[hand].state_hash);
    CHECK(session.summary(hand).state_hash == session.state_hash(hand));
    CHECK(session.summary(hand).ticks == 1200);
    CHECK(session.ticks(hand).size() == 500);
    CHECK(session.last(hand).number == 1199);
  }
  CHECK(session.state_hash(0) != session.state_hash(1));
  CHECK(session.state_hash() == session.state_hash(0));
  CHECK(session.last(0).fault == FaultCode::kNone);
  CHECK(session.last(1).fault == FaultCode::kEmergencyStop);
  CHECK(session.summary(0).verdict != Verdict::kBad);
  CHECK(session.summary(1).verdict == Verdict::kBad);
}

TEST_CASE("a session of one hand has the same bits through either call of open") {
  const Scene scene = scene_of("press.toml");
  Session one = session_of(scene), other;
  REQUIRE_FALSE(other.open(scene, {}, std::span<Device* const>()));
  CHECK(other.hands() == 1);
  step(one, 400);
  step(other, 400);
  CHECK(one.state_hash() == other.state_hash());
}

TEST_CASE("each hand has its members, and a body is of one sub-world at most") {
  Session session = session_of(hand_over());
  const BodyNumber part = static_cast<BodyNumber>(number_of(hard_cases::kPart));
  std::vector<unsigned> holders;
  for (int i = 0; i < 300; ++i) {
    step(session, 10);
    std::vector<int> held(session.scene().bodies(), 0);
    for (unsigned hand = 0; hand < 2; ++hand) {
      CHECK(session.members(hand).size() == session.last(hand).members);
      for (const BodyNumber member : session.members(hand)) {
        ++held[member];
        const Role role = session.roles(hand)[member], others = session.roles(1 - hand)[member];
        CHECK((role == Role::kMember || role == Role::kBorder));
        CHECK((others == Role::kGlobal || others == Role::kOutside || others == Role::kAsleep));
        if (member == part && (holders.empty() || holders.back() != hand)) holders.push_back(hand);
      }
      for (const Contact& contact : session.contacts(hand))
        CHECK((contact.a == session.scene().proxy(hand) || contact.a == part));
      const Vector3& proxy_m = session.bodies()[session.scene().proxy(hand)].position_m;
      CHECK(proxy_m == session.last(hand).proxy_position_m);
    }
    for (const int times : held) REQUIRE(times <= 1);
  }
  CHECK(holders == std::vector<unsigned>{0, 1});
}

TEST_CASE("a saved state of two hands continues with the same ticks, before and after the part changed hands",
          "[slow]") {
  const std::uint64_t at = GENERATE(937u, 1733u);
  Options options;
  options.more_injects = {"lost@1800+3"};
  Session session = session_of(hand_over(), options);
  step(session, at);
  SavedState saved;
  REQUIRE_FALSE(session.save(saved));
  const std::uint64_t hashes[] = {session.state_hash(0), session.state_hash(1)};
  step(session, 900);
  const std::vector<Tick> first[] = {ticks_of(session, 0), ticks_of(session, 1)};
  for (const bool reset : {false, true}) {
    if (reset) REQUIRE_FALSE(session.reset());
    REQUIRE_FALSE(session.restore(saved));
    CHECK(session.ticks_done() == at);
    for (unsigned hand = 0; hand < 2; ++hand) {
      CHECK(session.state_hash(hand) == hashes[hand]);
      CHECK(session.last(hand).number == at - 1);
      CHECK(session.ticks(hand).empty());
    }
    step(session, 900);
    for (unsigned hand = 0; hand < 2; ++hand) CHECK(same(ticks_of(session, hand), first[hand]));
  }
}

TEST_CASE("a state saved before or while all hands reset their scene continues as it did") {
  const bool resetting = GENERATE(false, true);
  Session session = session_of(hand_over());
  step(session, 1500);
  if (resetting) session.request(Request::kResetScene, 1);
  step(session, 30);
  CHECK(session.last(0).has(Condition::kSceneReset) == resetting);
  SavedState saved;
  REQUIRE_FALSE(session.save(saved));
  step(session, 2500);
  const std::vector<Tick> first[] = {ticks_of(session, 0), ticks_of(session, 1)};
  // A reset that comes in between is not of the saved state.
  session.request(Request::kResetScene, 0);
  step(session, 10);
  CHECK(session.last(1).has(Condition::kSceneReset));
  REQUIRE_FALSE(session.restore(saved));
  step(session, 2500);
  for (unsigned hand = 0; hand < 2; ++hand) CHECK(same(ticks_of(session, hand), first[hand]));
}

TEST_CASE("a reset gives both hands the same bits again, in the same memory", "[slow]") {
  Session session = session_of(hand_over());
  step(session, 800);
  const std::vector<Tick> first[] = {ticks_of(session, 0), ticks_of(session, 1)};
  const Tick* const memory[] = {session.ticks(0).data(), session.ticks(1).data()};
  const Role* const roles[] = {session.roles(0).data(), session.roles(1).data()};
  REQUIRE_FALSE(session.reset());
  CHECK(session.ticks(1).empty());
  CHECK(session.last(1).number == 0);
  step(session, 800);
  for (unsigned hand = 0; hand < 2; ++hand) {
    CHECK(same(ticks_of(session, hand), first[hand]));
    CHECK(session.ticks(hand).data() == memory[hand]);
    CHECK(session.roles(hand).data() == roles[hand]);
  }
}

TEST_CASE("a device of one's own leads one hand, the simulated one the other") {
  Sliding device;
  const Scene scene = tug();
  {
    Device* const devices[] = {nullptr, &device};
    Session session;
    const Error error = session.open(scene, {}, devices);
    INFO(error.message());
    REQUIRE_FALSE(error);
    step(session, 600);
    CHECK(device.reads == 600);
    CHECK(device.force_N == session.last(1).force_N);
    CHECK(session.last(1).force_N != session.last(0).force_N);
    CHECK(session.last(1).force_N[0] != 0);
    CHECK(device.stops == 0);
    SavedState saved;
    REQUIRE_FALSE(session.save(saved));
    const int reads = device.reads;
    step(session, 200);
    const std::vector<Tick> first[] = {ticks_of(session, 0), ticks_of(session, 1)};
    REQUIRE_FALSE(session.restore(saved));
    device.reads = reads;
    step(session, 200);
    for (unsigned hand = 0; hand < 2; ++hand) CHECK(same(ticks_of(session, hand), first[hand]));
  }
  CHECK(device.stops == 1);
}

TEST_CASE("a request is of its hand, a reset of the scene of all") {
  Options options;
  options.arm_at_start = false;
  Session session = session_of(hand_over(), options);
  session.request(Request::kArm, 1);
  session.request(Request::kArm, 7);  // there is none
  step(session, 100);
  CHECK(session.last(0).has(Condition::kNotArmed));
  CHECK_FALSE(session.last(1).has(Condition::kNotArmed));
  session.request(Request::kResetScene, 0);
  step(session, 5);
  for (unsigned hand = 0; hand < 2; ++hand) CHECK(session.last(hand).has(Condition::kSceneReset));
}

TEST_CASE("a session of two hands writes a tape of each, and both replay to the same bits") {
  const TemporaryFile first;
  const std::string second = session::file_of_hand(first.path(), 1);
  Session session = session_of(hand_over());
  REQUIRE_FALSE(session.record(first.path()));
  step(session, 900);
  REQUIRE_FALSE(session.close());
  CHECK(session.hands() == 2);
  CHECK(session.last(1).number == 899);
  for (const std::string& path : {first.path(), second}) {
    Replay replay;
    const Error error = replay_tape(path, replay);
    INFO(error.message());
    REQUIRE_FALSE(error);
    CHECK(replay.same_bits);
    CHECK(replay.compared == 900);
  }
  std::filesystem::remove(second);
}

TEST_CASE("ticks of two hands and looks at them allocate nothing") {
  TACTUS_NEEDS(RtGuard::available(), "allocations are not counted under a sanitizer");
  Session session = session_of(hand_over());
  step(session, 1);
  const RtGuard guard;
  bool failed = false;
  std::size_t looked = 0;
  for (int i = 0; i < 100; ++i) {
    failed = failed || static_cast<bool>(session.step(10));
    for (unsigned hand = 0; hand < 2; ++hand)
      looked += session.bodies().size() + session.roles(hand).size() + session.members(hand).size() +
                session.contacts(hand).size() + session.border_contacts(hand).size() + session.ticks(hand).size();
  }
  CHECK(guard.allocations() == 0);
  CHECK(guard.locks() == 0);
  CHECK_FALSE(failed);
  CHECK(looked > 0);
}

TEST_CASE("the names and figures of hands, and what a hand that is not there gives") {
  const Scene scene = tug();
  CHECK(scene.proxy(0) == 0);
  CHECK(scene.proxy(1) == 1);
  CHECK(scene.body_name(0) == "proxy");
  CHECK(scene.body_name(1) == "proxy2");
  CHECK(scene.hand_duration_s(0) == 1.5);
  CHECK(scene.hand_duration_s(1) == 0.5);
  CHECK(scene.proxy(2) == 0);
  CHECK(scene.hand_duration_s(2) == 0);
  CHECK(Scene().hands() == 0);
  CHECK(Session().hands() == 0);
  Session session = session_of(scene);
  step(session, 50);
  CHECK(session.ticks(2).empty());
  CHECK(session.last(2).number == 0);
  CHECK(session.members(2).empty());
  CHECK(session.roles(2).empty());
  CHECK(session.contacts(2).empty());
  CHECK(session.border_contacts(2).empty());
  CHECK(session.state_hash(2) == 0);
  CHECK(session.notes(2).empty());
  CHECK(session.summary(2).text.empty());
}

TEST_CASE("gains that are unstable with two hands are lowered, and reported for each", "[slow]") {
  Options options;
  options.ratio = 40;
  const Session session = session_of(tug(), options);
  for (unsigned hand = 0; hand < 2; ++hand) {
    const auto notes = session.notes(hand);
    REQUIRE(notes.size() == 1);
    CHECK_THAT(notes[0], Contains("the most that 2 hands on one light body bear at ratio 40"));
  }
}

TEST_CASE("mistakes about hands are one line each") {
  const auto refused = [](const Scene& scene, const Options& options, std::span<Device* const> devices) {
    Session session;
    const Error error = session.open(scene, options, devices);
    CHECK(error.kind() == Error::Kind::kOption);
    CHECK_FALSE(session.is_open());
    CHECK_THAT(error.message(), !Contains("\n") && !Contains("--") && Contains("accepted: "));
    return error.message();
  };
  Sliding device;
  Device* const three[] = {nullptr, &device, nullptr};
  CHECK_THAT(refused(tug(), {}, three), Contains("3 devices for 2 hands"));
  CHECK_THAT(refused(tug(), {}, {three, 1}), Contains("1 devices for 2 hands"));
  CHECK_THAT(refused(scene_of("press.toml"), {}, three), Contains("3 devices for 1 hands"));
  Options options;
  options.more_injects = {"", "nan@5"};
  CHECK_THAT(refused(tug(), options, {}), Contains("more_injects: 2"));
  options.more_injects = {"teleport"};
  CHECK_THAT(Session().open(tug(), options).message(), Contains("hand 2: inject: fault \"teleport\""));
  CHECK_THAT(refused(scene_of("press.toml"), options, {}), Contains("more_injects: 1"));
  options = {};
  options.real_time = true;
  CHECK_THAT(refused(tug(), options, {}), Contains("real_time: hands has 2 hands"));
  options = {};
  options.coupling = "static";
  CHECK_THAT(refused(tug(), options, {}), Contains("hand 1: coupling static"));
  Session session;
  CHECK_THAT(session.open(tug(), {}, device).message(), Contains("1 devices for 2 hands"));
}
