// A person's wishes reach the simulated hand in the tick after they were sent; silence holds it, in ticks.
#include "tools/session/hand_input.h"

#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/session/replay.h"

using namespace tactus;
using namespace tactus::test;

namespace {

struct LedRun {
  std::unique_ptr<session::Session> session;
  session::VirtualRun run;

  explicit LedRun(const std::string& tape = "") : session(recorded(tape)), run(*session) {}
  static std::unique_ptr<session::Session> recorded(const std::string& tape) {
    session::RunOptions options = virtual_options();
    options.record = tape;
    auto made = make_session(scene_text(kPressScene), options);
    REQUIRE(made->record(tape).ok());
    REQUIRE(made->rest_hand());
    return made;
  }
  Vec3d target() const { return session->simulated()->hand_target().pose.position; }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) (void)run.tick();
  }
};

}  // namespace

TEST_CASE("a hand that rests for the pointer does nothing until it is taken, then what is wished") {
  LedRun led;
  const Vec3d start = led.target();
  led.ticks(800);
  CHECK(led.target() == start);  // the script would have pressed by now
  led.session->hand_input.take();
  for (int i = 0; i < 100; ++i) {
    led.session->hand_input.lead({0, 0, -0.01}, {});
    led.ticks(16);
  }
  const Vec3d moved = led.target() - start;
  CHECK(norm(moved) == Approx(0.01).margin(1e-6));
}

TEST_CASE("after 200 ticks of silence the hand is held where it is") {
  LedRun led;
  led.session->hand_input.take();
  led.session->hand_input.lead({0.4, 0, 0}, {});  // far: it would take 0.8 s
  led.ticks(199);
  const double before = norm(led.session->simulated()->hand_target().twist.linear);
  CHECK(before == Approx(0.5).epsilon(0.01));
  led.ticks(300);
  CHECK(norm(led.session->simulated()->hand_target().twist.linear) < 1e-3);
  CHECK(led.target().x < 0.2);
  led.session->hand_input.rest();
  led.ticks(10);
  CHECK(norm(led.session->simulated()->hand_target().twist.linear) < 1e-3);
}

TEST_CASE("a run with a hand that was led replays like any other") {
  const TemporaryFile tape;
  {
    LedRun led(tape.path());
    led.ticks(50);
    led.session->hand_input.take();
    for (int i = 0; i < 60; ++i) {
      led.session->hand_input.lead({0, 0, -0.001 * i}, {0, 0, 0.01 * i});
      led.ticks(17);
    }
    session::RunSummary summary;
    led.session->close_tape(summary);
    CHECK(summary.tape_fault.empty());
  }
  const auto report = session::replay(tape.path());
  REQUIRE(report.ok());
  CHECK(report.value().good());
  CHECK(report.value().compared > 1000);
}
