#include "rt/haptics/input_guard.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

using namespace tactus;
using namespace tactus::haptics;

namespace {

constexpr std::uint32_t kEmergencyStop = 77;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

InputGuard make_guard() {
  InputGuard guard{};
  guard.config.emergency_stop_fault = kEmergencyStop;
  return guard;
}

// A device that streams: each fresh() is the next frame.
struct Stream {
  DeviceInput input;
  Stream() {
    input.status = ReadStatus::kFresh;
    input.sample.state = DeviceState::kForce;
    input.sample.sequence = 100;
    input.sample.device_time_ns = 5'000'000;
  }
  DeviceInput& fresh(const Vec3d& position = {}, const Quatd& rotation = {}) {
    ++input.sample.sequence;
    input.sample.device_time_ns += 1'000'000;
    input.sample.device_from_tool = {position, rotation};
    return input;
  }
  DeviceInput lost(ReadStatus status = ReadStatus::kMissing) const {
    DeviceInput copy = input;
    copy.status = status;
    return copy;
  }
};

// A guard that has believed five samples at rest.
struct Running {
  InputGuard guard = make_guard();
  Stream stream;
  Running() {
    for (int i = 0; i < 5; ++i) REQUIRE(guard.accept(stream.fresh()).valid);
  }
};

}  // namespace

TEST_CASE("a steady stream is accepted, the first sample re-bases and the force is not reduced") {
  InputGuard guard = make_guard();
  Stream stream;
  for (int i = 0; i < 100; ++i) {
    const Vec3d x{1e-3 * i, 0, 0};  // 1 m/s: the device's limit
    const GuardedInput out = guard.accept(stream.fresh(x));
    REQUIRE(out.valid);
    CHECK(out.rebased == (i == 0));
    CHECK(out.device_from_tool.position == x);
    CHECK(out.force_scale == 1.0);
    CHECK(out.status == 0);
    CHECK(out.fault == Fault::kNone);
    CHECK(out.device_state == DeviceState::kForce);
  }
}

TEST_CASE("before the first sample there is no force, and a device that takes its time gets it") {
  InputGuard guard = make_guard();
  guard.config.first_frame_ticks = 40;
  Stream stream;
  for (int i = 1; i < 40; ++i) {
    const GuardedInput out = guard.accept(stream.lost());
    REQUIRE(out.fault == Fault::kNone);
    REQUIRE(out.force_scale == 0.0);
  }
  SECTION("in time") { CHECK(guard.accept(stream.fresh()).force_scale == 1.0); }
  SECTION("too late") { CHECK(guard.accept(stream.lost()).fault == Fault::kLinkLost); }
}

TEST_CASE("missing frames fade the force by a tenth each, report from the third and latch at the tenth") {
  for (const ReadStatus status : {ReadStatus::kMissing, ReadStatus::kCorrupt}) {
    Running r;
    for (std::uint32_t missed = 1; missed <= 30; ++missed) {
      const GuardedInput out = r.guard.accept(r.stream.lost(status));
      CHECK_FALSE(out.valid);
      CHECK(out.missed == missed);
      CHECK(out.force_scale == Approx(missed < 10 ? 1.0 - missed / 10.0 : 0.0).margin(1e-15));
      CHECK((out.status & kFrameMissing) != 0);
      CHECK(((out.status & kForceFading) != 0) == (missed >= 3));
      CHECK(out.fault == (missed < 10 ? Fault::kNone : Fault::kLinkLost));
    }
  }
}

TEST_CASE("nine missing frames are forgiven by one good one") {
  Running r;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 9; ++i) REQUIRE(r.guard.accept(r.stream.lost()).fault == Fault::kNone);
    const GuardedInput out = r.guard.accept(r.stream.fresh());
    CHECK(out.valid);
    CHECK_FALSE(out.rebased);
    CHECK(out.force_scale == 1.0);
  }
}

TEST_CASE("frames whose sequence or time does not advance are missed, and stale at the tenth") {
  const int kind = GENERATE(0, 1, 2);
  Running r;
  for (int i = 1; i <= 10; ++i) {
    DeviceInput input = r.stream.input;
    if (kind == 1) input.sample.sequence += 1u + static_cast<unsigned>(i);           // new number, old time
    if (kind == 2) input.sample.device_time_ns += 1000u * static_cast<unsigned>(i);  // new time, old number
    const GuardedInput out = r.guard.accept(input);
    CHECK_FALSE(out.valid);
    CHECK(out.missed == static_cast<std::uint32_t>(i));
    CHECK((out.status & (kFrameMissing | kInputRejected)) == kFrameMissing);
    CHECK(out.fault == (i < 10 ? Fault::kNone : Fault::kInputStale));
  }
}

TEST_CASE("an unplugged device latches at once and its force is gone within ten ticks") {
  Running r;
  GuardedInput out = r.guard.accept(r.stream.lost(ReadStatus::kDisconnected));
  CHECK(out.fault == Fault::kDeviceUnplugged);
  CHECK(out.force_scale < 1.0);
  double last = out.force_scale;
  for (int i = 0; i < 9; ++i) {
    out = r.guard.accept(r.stream.fresh());  // even if it comes back: latched
    CHECK(out.force_scale < last);
    last = out.force_scale;
  }
  CHECK(out.force_scale == 0.0);
  CHECK(out.fault == Fault::kDeviceUnplugged);
}

TEST_CASE("each kind of impossible sample is refused and latches its own fault at the third") {
  struct Case {
    Posed pose;
    Fault fault;
  };
  const double huge = 1e300;
  const Case c = GENERATE_COPY(values<Case>({
      {{{kNaN, 0, 0}, {}}, Fault::kInputNotFinite},
      {{{0, std::numeric_limits<double>::infinity(), 0}, {}}, Fault::kInputNotFinite},
      {{{}, {kNaN, 0, 0, 0}}, Fault::kInputNotFinite},
      {{{}, {0, 0, 0, 0}}, Fault::kInputRotation},
      {{{}, {1.00101, 0, 0, 0}}, Fault::kInputRotation},
      {{{}, {0.99899, 0, 0, 0}}, Fault::kInputRotation},
      {{{}, {huge, huge, 0, 0}}, Fault::kInputRotation},
      {{{0.2 * 1.05 + 1e-9, 0, 0}, {}}, Fault::kInputWorkspace},
      {{{huge, huge, huge}, {}}, Fault::kInputWorkspace},
      {{{0, 0, 0.1}, {}}, Fault::kInputJump},
      {{{}, quat_from_rotation_vector(Vec3d{0, 1.0, 0})}, Fault::kInputJump},
  }));
  Running r;
  for (int i = 1; i <= 12; ++i) {
    const GuardedInput out = r.guard.accept(r.stream.fresh(c.pose.position, c.pose.rotation));
    CHECK_FALSE(out.valid);
    CHECK(is_finite(out.device_from_tool));
    CHECK(out.device_from_tool == Posed{});  // at rest before: held where it was
    if (i <= 3) CHECK((out.status & kInputRejected) != 0);
    CHECK(out.fault == (i < 3 ? Fault::kNone : c.fault));
    if (i >= 10) CHECK(out.force_scale == 0.0);
  }
}

TEST_CASE("refused samples of mixed kinds count together, lost frames between them do not clear the count") {
  Running r;
  CHECK(r.guard.accept(r.stream.fresh({kNaN, 0, 0})).fault == Fault::kNone);
  CHECK(r.guard.accept(r.stream.lost()).fault == Fault::kNone);
  CHECK(r.guard.accept(r.stream.fresh({1, 0, 0})).fault == Fault::kNone);
  CHECK(r.guard.accept(r.stream.fresh({}, {0, 0, 0, 0})).fault == Fault::kInputRotation);
}

TEST_CASE("ten ticks without an accepted sample are a fault, also when the tenth is only the first refused") {
  Running r;
  for (int i = 0; i < 9; ++i) REQUIRE(r.guard.accept(r.stream.lost()).fault == Fault::kNone);
  CHECK(r.guard.accept(r.stream.fresh({kNaN, 0, 0})).fault == Fault::kInputNotFinite);
}

TEST_CASE("two refused samples and a good one leave nothing behind") {
  Running r;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 2; ++i) CHECK(r.guard.accept(r.stream.fresh({kNaN, 0, 0})).fault == Fault::kNone);
    CHECK(r.guard.accept(r.stream.fresh()).valid);
  }
}

TEST_CASE("the jump limit is one and a half times the device's speed over the time since the last good sample") {
  // 1 m/s, 10 rad/s, 1 ms, quanta 10 um and 0.1 mrad.
  for (std::uint32_t missed = 0; missed < 9; ++missed) {
    const double reach_m = 1.5e-3 * (1 + missed) + 3e-5, reach_rad = 1.5e-2 * (1 + missed) + 3e-4;
    for (const double share : {0.999, 1.001}) {
      Running by_position, by_rotation;
      for (std::uint32_t i = 0; i < missed; ++i) {
        by_position.guard.accept(by_position.stream.lost());
        by_rotation.guard.accept(by_rotation.stream.lost());
      }
      const Quatd turned = quat_from_rotation_vector(Vec3d{0, 0, share * reach_rad});
      CHECK(by_position.guard.accept(by_position.stream.fresh({0, share * reach_m, 0})).valid == (share < 1));
      CHECK(by_rotation.guard.accept(by_rotation.stream.fresh({}, turned)).valid == (share < 1));
    }
  }
}

TEST_CASE("an accepted rotation has unit length and the sign of the one before") {
  InputGuard guard = make_guard();
  Stream stream;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  Quatd truth, last;
  for (int i = 0; i < 2000; ++i) {
    truth = normalized(quat_from_rotation_vector(Vec3d{5e-3 * u(random), 5e-3 * u(random), 5e-3 * u(random)}) * truth);
    const double s = (u(random) > 0 ? 1 : -1) * (1 + 9e-4 * u(random));  // either sign, norm off by up to 9e-4
    const GuardedInput out = guard.accept(stream.fresh({}, {s * truth.w, s * truth.x, s * truth.y, s * truth.z}));
    REQUIRE(out.valid);
    const Quatd& q = out.device_from_tool.rotation;
    CHECK(std::abs(norm(q) - 1) < 1e-15);
    if (i > 0) CHECK(q.w * last.w + q.x * last.x + q.y * last.y + q.z * last.z > 0.99);
    last = q;
  }
}

TEST_CASE("while frames are missing the pose moves on with decaying velocity for five ticks and then holds") {
  InputGuard guard = make_guard();
  Stream stream;
  const double speed = 0.4, turn = 2.0;
  for (int i = 0; i < 10; ++i) {
    guard.accept(stream.fresh({speed * 1e-3 * i, 0, 0}, quat_from_rotation_vector(Vec3d{0, 0, turn * 1e-3 * i})));
  }
  double x = speed * 9e-3, angle = turn * 9e-3;
  for (int missed = 1; missed <= 20; ++missed) {
    const double share = missed <= 5 ? (6.0 - missed) / 6.0 : 0.0;
    x += share * speed * 1e-3;
    angle += share * turn * 1e-3;
    const Posed pose = guard.accept(stream.lost()).device_from_tool;
    CHECK(pose.position.x == Approx(x).epsilon(1e-12));
    CHECK(2 * pose.rotation.z == Approx(2 * std::sin(angle / 2)).epsilon(1e-6));
  }
}

TEST_CASE("an extrapolated pose never leaves the workspace that a sample must be in") {
  InputGuard guard = make_guard();
  Stream stream;
  for (int i = 0; i < 10; ++i) guard.accept(stream.fresh({0.2085 + 1e-3 * (i - 8), 0, 0}));
  for (int i = 0; i < 9; ++i) CHECK(norm(guard.accept(stream.lost()).device_from_tool.position) <= 0.21);
}

TEST_CASE("a device in RESET, IDLE or BRAKE at start is no fault, BRAKE after FORCE is") {
  InputGuard guard = make_guard();
  Stream stream;
  for (const DeviceState state : {DeviceState::kReset, DeviceState::kBrake, DeviceState::kIdle, DeviceState::kForce,
                                  DeviceState::kIdle, DeviceState::kForce}) {
    stream.input.sample.state = state;
    const GuardedInput out = guard.accept(stream.fresh());
    CHECK(out.valid);
    CHECK(out.fault == Fault::kNone);
  }
  stream.input.sample.state = DeviceState::kBrake;
  CHECK(guard.accept(stream.fresh()).fault == Fault::kDeviceBrake);
}

TEST_CASE("a fault of the device's own and its emergency stop latch at once, each by its own number") {
  for (const std::uint32_t number : {1u, kEmergencyStop, 4000u}) {
    Running r;
    r.stream.input.sample.device_fault = number;
    r.stream.input.sample.state = DeviceState::kBrake;  // the cause is reported, not its consequence
    const GuardedInput out = r.guard.accept(r.stream.fresh());
    CHECK(out.fault == (number == kEmergencyStop ? Fault::kEmergencyStop : Fault::kDeviceFault));
    CHECK_FALSE(out.valid);
  }
}

TEST_CASE("a device without an emergency stop number reports any fault as its own") {
  Running r;
  r.guard.config.emergency_stop_fault = 0;
  r.stream.input.sample.device_fault = kEmergencyStop;
  CHECK(r.guard.accept(r.stream.fresh()).fault == Fault::kDeviceFault);
}

TEST_CASE("a latched fault stays, whatever comes, until rearm, then the first good sample re-bases anywhere") {
  Running r;
  for (int i = 0; i < 10; ++i) r.guard.accept(r.stream.lost());
  for (int i = 0; i < 100; ++i) {
    const GuardedInput out = r.guard.accept(r.stream.fresh());
    REQUIRE(out.fault == Fault::kLinkLost);
    REQUIRE(out.force_scale == 0.0);
    REQUIRE_FALSE(out.valid);
  }
  r.guard.rearm();
  CHECK(r.guard.accept(r.stream.lost()).force_scale == 0.0);
  r.stream.input.sample.sequence = 3;  // the device restarted
  r.stream.input.sample.device_time_ns = 17;
  const GuardedInput out = r.guard.accept(r.stream.fresh({0.15, 0, 0}, {0, 1, 0, 0}));
  CHECK(out.valid);
  CHECK(out.rebased);
  CHECK(out.force_scale == 1.0);
  CHECK(out.fault == Fault::kNone);
  CHECK(out.device_from_tool.position.x == 0.15);
}

TEST_CASE("a dead link latches again ten ticks after rearm") {
  Running r;
  for (int i = 0; i < 10; ++i) r.guard.accept(r.stream.lost());
  r.guard.rearm();
  for (int i = 1; i <= 10; ++i) {
    CHECK(r.guard.accept(r.stream.lost()).fault == (i < 10 ? Fault::kNone : Fault::kLinkLost));
  }
}

TEST_CASE("after rearm the device gets time to clear its fault, without force, one that does not is a fault again") {
  Running r;
  r.stream.input.sample.device_fault = 9;
  r.stream.input.sample.state = DeviceState::kBrake;
  r.guard.accept(r.stream.fresh());
  r.guard.rearm();
  for (int i = 0; i < 49; ++i) {
    const GuardedInput out = r.guard.accept(r.stream.fresh());
    REQUIRE(out.fault == Fault::kNone);
    REQUIRE(out.force_scale == 0.0);
    REQUIRE((out.status & kNotArmed) != 0);
  }
  SECTION("cleared") {
    r.stream.input.sample.device_fault = 0;
    r.stream.input.sample.state = DeviceState::kIdle;
    const GuardedInput out = r.guard.accept(r.stream.fresh());
    CHECK(out.rebased);
    CHECK(out.status == 0);
  }
  SECTION("not cleared") {
    r.guard.accept(r.stream.fresh());
    CHECK(r.guard.accept(r.stream.fresh()).fault == Fault::kDeviceFault);
  }
}

TEST_CASE("a three-degree-of-freedom device's rotation is not looked at") {
  InputGuard guard = make_guard();
  guard.config.device.has_rotation = false;
  Stream stream;
  for (int i = 0; i < 5; ++i) {
    const GuardedInput out = guard.accept(stream.fresh({}, {kNaN, 0, 0, static_cast<double>(i)}));
    CHECK(out.valid);
    CHECK(out.device_from_tool.rotation == Quatd{});
  }
}

TEST_CASE("whatever a device sends, what comes out is finite, unit, in the workspace and scaled between 0 and 1") {
  std::mt19937_64 random(5);
  const double odd[] = {0, -0.0, 1, -1, 0.1, kNaN, std::numeric_limits<double>::infinity(), 1e308, 5e-324, 0.2099};
  for (int run = 0; run < 200; ++run) {
    InputGuard guard = make_guard();
    Stream stream;
    for (int tick = 0; tick < 100; ++tick) {
      const auto pick = [&] {
        return random() % 8 == 0 ? odd[random() % 10] : 1e-4 * static_cast<double>(random() % 9);
      };
      DeviceInput input = stream.fresh({pick(), pick(), pick()}, {1, pick(), pick(), pick()});
      if (random() % 4 == 0) input.status = static_cast<ReadStatus>(random() % 5);
      if (random() % 16 == 0) input.sample.sequence = random();
      if (random() % 64 == 0) guard.rearm();
      const Fault before = guard.state.fault;
      const GuardedInput out = guard.accept(input);
      REQUIRE(is_finite(out.device_from_tool));
      REQUIRE(std::abs(norm(out.device_from_tool.rotation) - 1) < 1e-12);
      REQUIRE(norm(out.device_from_tool.position) <= 0.2 * 1.05);
      REQUIRE((out.force_scale >= 0 && out.force_scale <= 1));
      if (before != Fault::kNone) REQUIRE(out.fault == before);
      if (out.missed >= 10) REQUIRE(out.force_scale == 0.0);
    }
  }
}
