#include "firmware/board.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "tests/firmware/device_bench.h"

using namespace tactus::firmware;

namespace {

struct FakeMechanics {
  ControllerInputs inputs;
  ControllerOutputs driven;
  void sample(ControllerInputs& out) noexcept {
    inputs.time_us += 1000;
    out = inputs;
  }
  void drive(const ControllerOutputs& outputs) noexcept { driven = outputs; }
};

struct FakeLink {
  std::optional<CommandFrame> command;
  std::optional<ServiceMessage> request, reply;
  StateFrame state;
  std::size_t receive_command(std::span<std::byte, kMaxFrameSize> buffer) noexcept {
    if (!command) return 0;
    encode_command(*command, buffer.first<kCommandFrameSize>());
    command.reset();
    return kCommandFrameSize;
  }
  void send_state(std::span<const std::byte> frame) noexcept { static_cast<void>(decode_state(frame, state)); }
  bool receive_service(ServiceMessage& message) noexcept {
    if (!request) return false;
    message = *request;
    request.reset();
    return true;
  }
  void reply_service(const ServiceMessage& message) noexcept { reply = message; }
};

struct FakeStorage {
  std::vector<std::byte> kept;
  std::size_t load(std::span<std::byte> buffer) {
    std::copy_n(kept.begin(), std::min(buffer.size(), kept.size()), buffer.begin());
    return kept.size();
  }
  bool store(std::span<const std::byte> block) noexcept {
    kept.assign(block.begin(), block.end());
    return true;
  }
};

static_assert(Mechanics<FakeMechanics> && DeviceLink<FakeLink> && Storage<FakeStorage> && Storage<NoStorage>);

}  // namespace

TEST_CASE("a period takes the command, drives the motors, sends the state, and answers one request") {
  Device device(bench_config());
  FakeMechanics mechanics;
  FakeLink link;
  for (std::uint32_t i = 1; i <= 3; ++i) {
    link.command = CommandFrame{i == 1 ? State::kIdle : State::kForce, false, i, {1, 2, 3, 0, 0, 0}};
    run_period(device, mechanics, link);
  }
  CHECK(link.state.state == State::kForce);
  CHECK(link.state.echoed_sequence == 3);
  CHECK(mechanics.driven.effort[2] == 3.0f);
  CHECK_FALSE(link.reply.has_value());
  link.request = ServiceMessage{
      .operation = Operation::kRead, .status = ServiceStatus::kGood, .tag = 9, .address = number::kState, .value = 0};
  run_period(device, mechanics, link);
  REQUIRE(link.reply.has_value());
  CHECK(link.reply->value == 2);
  CHECK(link.state.missed_commands == 1);
}

TEST_CASE("the registers report the bus errors of a link that counts them, and 0 on another link") {
  struct BusLink : FakeLink {
    BusErrors errors;
    BusErrors bus_errors() const noexcept { return errors; }
  };
  static_assert(TellsBusErrors<BusLink> && !TellsBusErrors<FakeLink>);
  const auto read = [](auto& link, std::uint16_t address) {
    static Device device(bench_config());
    FakeMechanics mechanics;
    link.request = ServiceMessage{
        .operation = Operation::kRead, .status = ServiceStatus::kGood, .tag = 1, .address = address, .value = 0};
    run_period(device, mechanics, link);
    CHECK(link.reply->status == ServiceStatus::kGood);
    return link.reply->value;
  };
  FakeLink other;
  for (const auto address : {number::kCanTransmitErrors, number::kCanReceiveErrors, number::kCanBusOff})
    CHECK(read(other, address) == 0);
  BusLink link;
  link.errors = {136, 96, 3};
  CHECK(read(link, number::kCanTransmitErrors) == 136);
  link.errors.transmit = 0;
  CHECK(read(link, number::kCanTransmitErrors) == 0);
  CHECK(read(link, number::kCanReceiveErrors) == 96);
  CHECK(read(link, number::kCanBusOff) == 3);
}

TEST_CASE("a board with storage starts with the saved configuration, one without reports that it saves nothing") {
  for (const bool keeps : {true, false}) {
    Device device(bench_config());
    FakeMechanics mechanics;
    FakeLink link;
    FakeStorage storage;
    const auto period = [&] {
      keeps ? run_period(device, mechanics, link, storage) : run_period(device, mechanics, link);
    };
    const auto ask = [&](Operation operation, std::uint16_t address, std::uint32_t value) {
      link.request = ServiceMessage{
          .operation = operation, .status = ServiceStatus::kGood, .tag = 1, .address = address, .value = value};
      period();
      return *link.reply;
    };
    CHECK(restore_configuration(device, storage));  // nothing there
    ask(Operation::kWrite, number::kMaxForce, std::bit_cast<std::uint32_t>(5.0f));
    CHECK(ask(Operation::kExecute, number::kSave, 0).status == ServiceStatus::kGood);
    for (int i = 0; i < 200; ++i) period();
    CHECK(ask(Operation::kRead, number::kSaveState, 0).value == (keeps ? 2u : 3u));
    Device next(bench_config());
    CHECK(restore_configuration(next, storage));
    CHECK(next.controller().config().max_force_N == (keeps ? 5.0f : 12.0f));
    if (!keeps) continue;
    storage.kept[20] ^= std::byte{1};
    Device third(bench_config());
    CHECK_FALSE(restore_configuration(third, storage));
    CHECK(third.controller().config().max_force_N == 12.0f);
  }
}
