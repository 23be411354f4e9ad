// The table of states and events.
#include <catch2/catch.hpp>

#include "tests/firmware/controller_bench.h"

using namespace tactus::firmware;

namespace {

void inflict(Bench& b, Event event) {
  switch (event) {
    case Event::kEmergencyStop:
      b.inputs.emergency_stop = true;
      b.command(State::kForce);
      break;
    case Event::kMotorBus:
      b.inputs.motor_bus_ok = false;
      b.command(State::kForce);
      break;
    case Event::kOverspeed:
      b.inputs.counts[1] += 201;  // 2.01 m/s
      b.command(State::kForce);
      break;
    case Event::kSupervision:
      b.supervision.fault = Fault::kEncoder;
      b.command(State::kForce);
      break;
    case Event::kEffortNotFinite:
      b.command(State::kForce, {kNan});
      break;
    case Event::kCommandsLost:
      b.nothing(10);
      break;
    case Event::kWantBrake:
      b.command(State::kBrake);
      break;
    case Event::kRearm:
      b.command(State::kForce, {}, true);
      break;
    case Event::kWantForce:
      b.command(State::kForce);
      break;
    case Event::kWantIdle:
      b.command(State::kIdle);
      break;
    case Event::kNothing:
      b.nothing();
      break;
  }
}

// The rules in words, not the table.
State expected(State state, Event event) {
  const bool stops = event == Event::kEmergencyStop || event == Event::kSupervision ||
                     event == Event::kEffortNotFinite || event == Event::kWantBrake;
  const bool stops_when_up = event == Event::kMotorBus || event == Event::kOverspeed;
  if (state == State::kBrake) return event == Event::kRearm ? State::kIdle : State::kBrake;
  if (stops) return State::kBrake;
  if (state == State::kReset) return stops_when_up ? State::kReset : State::kIdle;
  if (stops_when_up) return State::kBrake;
  if (state == State::kIdle) return event == Event::kWantForce ? State::kForce : State::kIdle;
  if (event == Event::kCommandsLost) return State::kBrake;
  return event == Event::kWantIdle ? State::kIdle : State::kForce;
}

Fault expected_fault(Event event) {
  switch (event) {
    case Event::kEmergencyStop:
      return Fault::kEmergencyStop;
    case Event::kMotorBus:
      return Fault::kMotorBus;
    case Event::kOverspeed:
      return Fault::kOverspeed;
    case Event::kSupervision:
      return Fault::kEncoder;
    case Event::kEffortNotFinite:
      return Fault::kEffortNotFinite;
    case Event::kCommandsLost:
      return Fault::kCommandsLost;
    default:
      return Fault::kNone;
  }
}

}  // namespace

TEST_CASE("every state answers every event as the rules say") {
  for (unsigned s = 0; s < kStates; ++s)
    for (unsigned e = 0; e < kEvents; ++e) {
      const auto state = static_cast<State>(s);
      const auto event = static_cast<Event>(e);
      CAPTURE(s, e);
      CHECK(next_state(state, event) == expected(state, event));
      Bench b = bench_in(state);
      REQUIRE(b.state() == state);
      inflict(b, event);
      // Ten silent periods are nine calm ones and the loss: RESET is long left by then.
      CHECK(b.state() == expected(state, event));
      if (b.state() == State::kBrake && state != State::kBrake) CHECK(b.controller.fault() == expected_fault(event));
      if (b.state() != State::kForce) CHECK(b.norm_of_effort() == 0.0f);
      CHECK(b.outputs.brake == (b.state() == State::kBrake || b.state() == State::kReset));
      CHECK(b.frame.state == b.state());
      CHECK(b.frame.fault == static_cast<std::uint16_t>(b.controller.fault()));
    }
}

TEST_CASE("FORCE ends in the period in which it is no longer allowed, with a command or without") {
  for (const bool commanded : {false, true}) {
    Bench b = bench_in(State::kForce);
    b.supervision.force_allowed = false;
    if (commanded)
      b.command(State::kForce, {1, 0, 0, 0, 0, 0});
    else
      b.nothing();
    CHECK(b.state() == State::kIdle);
    CHECK(b.norm_of_effort() == 0.0f);
    CHECK(b.controller.fault() == Fault::kNone);
  }
}

TEST_CASE("the more urgent of two events wins") {
  Bench b = bench_in(State::kBrake);
  b.inputs.emergency_stop = true;
  b.command(State::kForce, {}, true);
  CHECK(b.state() == State::kBrake);  // no re-arm under an active e-stop
  b = bench_in(State::kForce);
  b.inputs.emergency_stop = true;
  b.command(State::kForce, {kNan});
  CHECK(b.controller.fault() == Fault::kEmergencyStop);
}
