#include "rt/haptics/coupling/device_track.h"

#include <catch2/catch.hpp>

using namespace tactus;
using haptics::DeviceTarget;
using haptics::DeviceTrack;

namespace {

constexpr double kPeriod_s = 1e-3;

// A device that turns about z and moves along x, evenly, as seen at the beginning of tick `tick`.
DeviceTarget in_tick(int tick) {
  const Twistd velocity{{0.2, 0, 0}, {0, 0, 1.5}};
  return {true,
          {velocity.linear * (tick * kPeriod_s), quat_from_rotation_vector(velocity.angular * (tick * kPeriod_s))},
          velocity};
}

}  // namespace

TEST_CASE("a device that does not hold the proxy is nowhere") {
  DeviceTrack track;
  CHECK_FALSE(track.latest().engaged);
  track.note(in_tick(0), kPeriod_s);
  CHECK(track.latest().engaged);
  track.note({}, kPeriod_s);
  CHECK_FALSE(track.latest().engaged);
  CHECK_FALSE(track.over_cycle(1, kPeriod_s).engaged);
}

TEST_CASE("after a tick the device is where its velocity brings it in the tick") {
  DeviceTrack track;
  for (int tick = 0; tick < 8; ++tick) track.note(in_tick(tick), kPeriod_s);
  const DeviceTarget now = track.latest(), due = in_tick(8);
  CHECK(norm(now.pose.position - due.pose.position) < 1e-15);
  CHECK(norm(small_rotation_vector(now.pose.rotation * conjugate(due.pose.rotation))) < 1e-12);
}

TEST_CASE("over a cycle the mean velocity counts, of a cycle that was broken the last one") {
  const auto noisy = [](int tick) {  // the encoder's noise is in the velocity, not in the way
    DeviceTarget target = in_tick(tick);
    target.velocity.linear.x += tick % 2 == 0 ? 0.05 : -0.05;
    return target;
  };
  DeviceTrack track;
  for (int tick = 0; tick < 8; ++tick) track.note(noisy(tick), kPeriod_s);
  track.begin_cycle();
  for (int tick = 8; tick < 16; ++tick) track.note(noisy(tick), kPeriod_s);
  CHECK(track.over_cycle(8, kPeriod_s).velocity.linear.x == Approx(0.2));
  CHECK(track.over_cycle(8, kPeriod_s).velocity.angular.z == Approx(1.5));
  CHECK(track.latest().velocity.linear.x == Approx(0.15));
  track.begin_cycle();
  track.note({}, kPeriod_s);
  track.note(noisy(17), kPeriod_s);
  CHECK(track.over_cycle(2, kPeriod_s).velocity.linear.x == Approx(0.15));
}
