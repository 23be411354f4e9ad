// A Falcon on simulated hardware: its start with and without firmware, faults of the line, forces, zeros on every way
// out.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <thread>

#include "firmware/faults.h"
#include "hal/falcon/falcon_device.h"
#include "hal/falcon/falcon_faults.h"
#include "hal/falcon/simulated_falcon.h"

using namespace tactus;
using namespace tactus::hal;
using Catch::Matchers::Contains;
using haptics::DeviceCommand;
using haptics::DeviceInput;
using haptics::DeviceState;
using haptics::ReadStatus;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

std::vector<std::uint8_t> some_image() {
  std::vector<std::uint8_t> image(8000);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint8_t>(i * 37 + i / 251);
  return image;
}

struct Bench {
  SimulatedFalcon device{HandModel(), kPeriod_ns};
  DeviceInput input;
  DeviceCommand command;
  void ticks(unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
      device.read(input);
      ++command.sequence;
      device.write(command);
    }
  }
  void rearm() {
    command.rearm = 1;
    ticks(2);
    command.rearm = 0;
    ticks(5);
  }
};

}  // namespace

TEST_CASE("falcon: a running firmware is used as it is, without an image") {
  SimulatedFalconPort port(HandModel(), kFalconGain, kPeriod_ns, true);
  CHECK(start_falcon(port, {}).ok());
  CHECK(port.image_bytes() == 0);
}

TEST_CASE("falcon: without firmware and without an image the error names what is needed") {
  SimulatedFalconPort port(HandModel(), kFalconGain, kPeriod_ns, false);
  CHECK_THAT(start_falcon(port, {}).message(), Contains("falcon:FILE"));
}

TEST_CASE("falcon: the image is loaded whole, also after failed greetings and wrong echoes") {
  const std::vector<std::uint8_t> image = some_image();
  for (const auto& [handshakes, echoes] : {std::pair{0u, 0u}, {30u, 0u}, {0u, 3u}, {150u, 2u}}) {
    CAPTURE(handshakes, echoes);
    SimulatedFalconPort port(HandModel(), kFalconGain, kPeriod_ns, false);
    port.faults.failed_handshakes = handshakes;
    port.faults.wrong_echoes = echoes;
    const Status started = start_falcon(port, image);
    INFO(started.message());
    CHECK(started.ok());
    CHECK(port.image_bytes() == image.size());
  }
  SimulatedFalconPort port(HandModel(), kFalconGain, kPeriod_ns, false);
  port.faults.failed_handshakes = 100'000;
  CHECK_THAT(start_falcon(port, image).message(), Contains(falcon_checksum(image)) && Contains("10 attempts"));
}

TEST_CASE("falcon: an image file is read, and what is none is refused") {
  CHECK_THAT(load_falcon_image("/nowhere").message(), Contains("/nowhere") && Contains("accepted:"));
  CHECK_THAT(load_falcon_image(TACTUS_SOURCE_DIR "/hal").message(), Contains("accepted:"));
  const auto read = load_falcon_image(TACTUS_SOURCE_DIR "/hal/devices/desk3d.toml");
  REQUIRE(read.ok());
  CHECK(read.value().size() > 500);
  CHECK(falcon_checksum(std::span<const std::uint8_t>()) == "cbf29ce484222325");
}

TEST_CASE("falcon: it waits until all axes are homed, and says how") {
  SimulatedFalconPort port(HandModel(), kFalconGain, kPeriod_ns, true);
  CHECK(wait_until_homed(port, std::chrono::milliseconds(0)).ok());
  port.faults.homed = 5;
  CHECK_THAT(wait_until_homed(port, std::chrono::milliseconds(0)).message(), Contains("not homed") && Contains("pull"));
  port.faults.mute = true;
  CHECK_THAT(wait_until_homed(port, std::chrono::milliseconds(0)).message(), Contains("stopped answering"));
}

TEST_CASE("falcon: the force at the tool is the commanded one within two per cent, and cut with its direction") {
  Bench bench;
  bench.command.wanted = DeviceState::kForce;
  bench.ticks(5);
  for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{-0.6, 0, 0.8}}) {
    bench.command.wrench.force = direction * 2;
    bench.ticks(3);
    CHECK(norm(bench.device.force() - bench.command.wrench.force) < 0.04);
    bench.command.wrench.force = direction * 1e6;
    bench.ticks(2);
    const Vec3d most = bench.device.force();
    CHECK(norm(most) <= 1.02 * kFalconForce_N);
    CHECK(dot(most, direction) > 0.98 * norm(most));
  }
}

TEST_CASE("falcon: faults of the line are missing samples, and pass") {
  Bench bench;
  bench.command.wanted = DeviceState::kForce;
  bench.ticks(10);
  FalconFaults& faults = bench.device.port().faults;
  faults.garbage = true;
  bench.ticks(2);
  CHECK(bench.input.status == ReadStatus::kFresh);  // the packet behind it is found
  faults.garbage = false;
  faults.twice = true;
  bench.ticks(5);
  CHECK(bench.input.status == ReadStatus::kFresh);
  faults.twice = false;
  faults.cut_packets = true;
  bench.ticks(1);
  CHECK(bench.input.status == ReadStatus::kMissing);
  faults.cut_packets = false;
  bench.ticks(2);
  CHECK(bench.input.status == ReadStatus::kFresh);
  faults.unplugged = true;
  bench.ticks(1);
  CHECK(bench.input.status == ReadStatus::kDisconnected);
}

TEST_CASE("falcon: a homed bit that goes latches a fault, and force comes back by a re-arm after it is homed") {
  Bench bench;
  bench.command.wanted = DeviceState::kForce;
  bench.command.wrench.force = {2, 0, 0};
  bench.ticks(10);
  bench.device.port().faults.homed = 3;
  bench.ticks(3);
  CHECK(bench.input.sample.state == DeviceState::kBrake);
  CHECK(bench.input.sample.device_fault == kFalconNotHomed);
  CHECK(norm(bench.device.force()) == 0);
  bench.rearm();
  CHECK(bench.input.sample.state == DeviceState::kBrake);  // not homed yet
  bench.device.port().faults.homed = 7;
  bench.ticks(3);
  bench.rearm();
  CHECK(bench.input.sample.state == DeviceState::kForce);
  CHECK(norm(bench.device.force()) > 1.9);
}

namespace {

// A port that the test keeps an eye on while the device's thread uses it.
struct WatchedPort final : FalconPort {
  SimulatedFalconPort inner{HandModel(), kFalconGain, kPeriod_ns, true};
  std::atomic<bool>* has_force;
  explicit WatchedPort(std::atomic<bool>& flag) : has_force(&flag) {}
  bool control(FtdiRequest request, std::uint16_t value) noexcept override { return inner.control(request, value); }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    const bool written = inner.write(bytes);
    has_force->store(norm(inner.force()) > 0);
    return written;
  }
  int read(std::span<std::uint8_t> bytes, std::chrono::milliseconds longest) noexcept override {
    return inner.read(bytes, longest);
  }
};

bool becomes(const std::atomic<bool>& flag, bool wanted) {
  for (int i = 0; i < 2000 && flag.load() != wanted; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return flag.load() == wanted;
}

}  // namespace

TEST_CASE("falcon: its thread ends the force when the loop stops, and when the device is closed",
          "[no-tsan][threads]") {
  std::atomic<bool> has_force{false};
  auto started = FalconDevice::start(std::make_unique<WatchedPort>(has_force), kFalconGain, kPeriod_ns);
  REQUIRE(started.ok());
  auto device = std::move(started).value();
  DeviceInput input;
  DeviceCommand command;
  command.wanted = DeviceState::kForce;
  command.wrench.force = {2, 0, 0};
  const auto push = [&] {
    for (int i = 0; i < 2000 && !has_force.load(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      device->read(input);
      ++command.sequence;
      device->write(command);
    }
    return has_force.load();
  };
  REQUIRE(push());
  CHECK(becomes(has_force, false));  // read and write are called no more
  REQUIRE(push());
  device.reset();
  CHECK_FALSE(has_force.load());
}
