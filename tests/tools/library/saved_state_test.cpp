// A session's state, saved and restored: the ticks that follow have the same bits, whatever happened in between.
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tests/tools/library/library_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

void save(const Session& session, SavedState& saved) {
  const Error error = session.save(saved);
  INFO(error.message());
  REQUIRE_FALSE(error);
}

void restore(Session& session, const SavedState& saved) {
  const Error error = session.restore(saved);
  INFO(error.message());
  REQUIRE_FALSE(error);
}

// Of every tick, so that a difference in the middle counts.
std::vector<Tick> ticks_of(Session& session, std::uint64_t count) {
  step(session, count);
  return {session.ticks().begin(), session.ticks().end()};
}

bool same(const std::vector<Tick>& a, const std::vector<Tick>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Tick)) == 0;
}

// A tool on a spring to a point that wanders; a copy of it is its whole state.
class Wanderer final : public Device {
 public:
  struct State {
    Vector3 position{};
    int reads{0};
  } state;
  DeviceProperties properties() const override { return {}; }
  Reading read(DeviceSample& sample) noexcept override {
    state.position[0] = 0.01 * ((state.reads++ / 100) % 3);
    sample.position_m = state.position;
    return Reading::kFresh;
  }
  void write(const DeviceCommand&) noexcept override {}
};

}  // namespace

TEST_CASE("a restored session gives the same ticks again, for every coupling, at any tick of the cycle") {
  const auto [scene, coupling] = GENERATE(from_range(kSceneForCoupling));
  CAPTURE(scene, coupling);
  Options options;
  options.coupling = coupling;
  options.inject = "lost@1200+3,stall@1300+20";
  Session session = session_of(scene_of(scene), options);
  step(session, 1017);
  SavedState saved;
  save(session, saved);
  const std::uint64_t at = session.state_hash();
  const BodyState moved = session.bodies()[session.scene().proxy()];
  const auto first = ticks_of(session, 700);
  const std::uint64_t hash = session.state_hash();
  restore(session, saved);
  CHECK(session.state_hash() == at);
  CHECK(session.ticks_done() == 1017);
  CHECK(session.last().number == 1016);
  CHECK(session.bodies()[session.scene().proxy()].position_m == moved.position_m);
  CHECK(same(ticks_of(session, 700), first));
  CHECK(session.state_hash() == hash);
  CHECK(hash != at);
}

TEST_CASE("a state is restored after a reset, and again") {
  Session session = session_of(scene_of("card_house.toml"));
  step(session, 3200);
  SavedState saved;
  save(session, saved);
  const auto first = ticks_of(session, 300);
  for (int i = 0; i < 2; ++i) {
    REQUIRE_FALSE(session.reset());
    step(session, 40);
    restore(session, saved);
    CHECK(same(ticks_of(session, 300), first));
  }
}

TEST_CASE("a scene that was reset, with its hand on the way back, continues as it did") {
  Session session = session_of(scene_of("press.toml"));
  step(session, 1500);
  session.request(Request::kResetScene);
  step(session, 30);
  SavedState saved;
  save(session, saved);
  const auto first = ticks_of(session, 2500);
  restore(session, saved);
  CHECK(same(ticks_of(session, 2500), first));
}

TEST_CASE("a device of one's own restores its part, the session the rest") {
  Wanderer device;
  Session session;
  REQUIRE_FALSE(session.open(scene_of("press.toml"), {}, device));
  step(session, 730);
  SavedState saved;
  save(session, saved);
  const Wanderer::State own = device.state;
  const auto first = ticks_of(session, 400);
  restore(session, saved);
  device.state = own;
  CHECK(same(ticks_of(session, 400), first));
}

TEST_CASE("a state goes to its own session alone, and to none that writes a tape") {
  Session session = session_of(scene_of("press.toml")), other = session_of(scene_of("press.toml"));
  SavedState saved;
  CHECK_THAT(session.restore(saved).message(), Contains("not of this session"));
  step(session, 10);
  save(session, saved);
  CHECK_FALSE(saved.empty());
  CHECK_THAT(other.restore(saved).message(), Contains("not of this session"));
  const TemporaryFile tape;
  REQUIRE_FALSE(other.record(tape.path()));
  step(other, 10);
  SavedState of_other;
  save(other, of_other);
  CHECK_THAT(other.restore(of_other).message(), Contains("a tape is being written"));
  CHECK_THAT(Session().save(saved).message(), Contains("not open"));
}
