// Both ends of the CAN link over the kernel's own drivers, for the guest of the bench: needs root, can0 and can1 on one
// bus at 1 Mbit/s, and vcan0 with an MTU of 72. Both ends run in one thread in turn, and each waits for what the other
// sent, so that nothing here depends on how fast the machine is.
#include <linux/can/raw.h>
#include <net/if.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <thread>

#include "firmware/boards/linux_can/can_device_link.h"
#include "hal/can/can_link.h"
#include "rt/base/clock.h"

using namespace tactus;
using firmware::CanDeviceLink;
using firmware::CanFunction;
using firmware::CanSocket;
using hal::CanFormat;
using hal::CanLink;
using hal::CanOptions;
using namespace std::chrono_literals;

namespace {

constexpr std::int64_t kPatience_ns = 5'000'000'000;  // the emulated machine may have a tenth of a slow core

// Asks again until it holds; false if it does not in time.
template <class F>
bool soon(F&& holds, std::int64_t patience_ns = kPatience_ns) {
  const std::int64_t deadline = MonotonicClock::now_ns() + patience_ns;
  while (!holds()) {
    if (MonotonicClock::now_ns() > deadline) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
}

void run(const std::string& command) {
  INFO(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

firmware::Config configuration() {
  firmware::Config config;
  config.quantum.fill(1e-5f);
  config.max_effort.fill(30.0f);
  config.max_speed.fill(10.0f);
  config.max_force_N = config.max_torque_Nm = 35.0f;
  return config;
}

struct StillMechanics {
  std::uint64_t time_us{0};
  firmware::ControllerOutputs outputs;
  void sample(firmware::ControllerInputs& inputs) noexcept {
    inputs.time_us = time_us += 1000;
    for (unsigned i = 0; i < firmware::kAxes; ++i) inputs.counts[i] = 1000 * (static_cast<int>(i) - 2);
  }
  void drive(const firmware::ControllerOutputs& next) noexcept { outputs = next; }
};

struct Board {
  CanDeviceLink link;
  firmware::Device device{configuration()};
  StillMechanics mechanics;

  Board(const char* interface, bool fd) {
    REQUIRE(link.open({interface, 5, fd}).step == firmware::CanOpenError::Step::kNone);
  }
  void period() noexcept { firmware::run_period(device, mechanics, link); }
};

// The device sends while the host listens for it.
std::unique_ptr<CanLink> opened(Board& board, CanOptions options) {
  std::jthread sends([&board](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      board.period();
      std::this_thread::sleep_for(1ms);
    }
  });
  options.node = 5;
  options.first_frame = 2000ms;
  auto link = CanLink::open(options);
  INFO((link.ok() ? std::string() : link.message()));
  REQUIRE(link.ok());
  return std::move(link).value();
}

struct Host {
  std::unique_ptr<CanLink> link;
  firmware::StateFrame state;
  std::uint32_t sequence{0};

  bool receives() {
    std::array<std::byte, firmware::kMaxFrameSize> buffer;
    const hal::ReceivedFrame frame = link->receive(buffer);
    if (frame.size == 0) return false;
    const std::int64_t now = MonotonicClock::now_ns();
    CHECK((frame.arrival_ns <= now && frame.arrival_ns > now - kPatience_ns));
    REQUIRE(firmware::decode_state(std::span<const std::byte>(buffer).first(frame.size), state) ==
            firmware::DecodeError::kNone);
    return true;
  }

  bool sends(firmware::State wanted, bool rearm = false) {
    firmware::CommandFrame command;
    command.wanted = wanted;
    command.rearm = rearm;
    command.sequence = ++sequence;
    command.effort = {1.0f, -2.0f, 0.5f, 0.25f, 0.0f, -0.125f};
    std::array<std::byte, firmware::kCommandFrameSize> bytes;
    firmware::encode_command(command, bytes);
    return link->send(bytes);
  }
};

// One period of both ends: a command that is echoed. On a slow machine the emulated controllers overrun their few
// places, as real ones do behind a slow interrupt: then the next command does it.
void exchange(Board& board, Host& host, firmware::State wanted) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    const std::uint64_t commands = board.link.counters().commands;
    REQUIRE(host.sends(wanted));
    const bool arrived = soon(
        [&] {
          board.period();
          return board.link.counters().commands > commands;
        },
        kPatience_ns / 10);
    if (arrived &&
        soon([&] { return host.receives() && host.state.echoed_sequence == host.sequence; }, kPatience_ns / 10))
      return;
  }
  FAIL("no command was echoed");
}

// Anything on a bus.
struct Node {
  int socket;
  explicit Node(const char* interface) {
    static_assert(sizeof(can_frame) == CAN_MTU);
    socket = ::socket(PF_CAN, SOCK_RAW, CAN_RAW);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface));
    REQUIRE(bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  }
  ~Node() { close(socket); }

  bool send(const can_frame& frame) const { return write(socket, &frame, sizeof frame) == sizeof frame; }
  void error(std::uint32_t what) const {
    can_frame frame{};
    frame.can_id = CAN_ERR_FLAG | what;
    frame.can_dlc = CAN_ERR_DLC;
    REQUIRE(send(frame));
  }
};

void check_exchange(const char* device_interface, const char* host_interface, bool fd) {
  Board board(device_interface, fd);
  Host host{opened(board, {.interface = host_interface}), {}};
  REQUIRE(host.link->is_fd() == fd);
  REQUIRE(host.link->start().ok());
  exchange(board, host, firmware::State::kIdle);
  for (int i = 0; i < 300; ++i) exchange(board, host, firmware::State::kForce);
  CHECK(host.state.state == firmware::State::kForce);
  CHECK(host.state.counts == firmware::AxisCounts{-2000, -1000, 0, 1000, 2000, 3000});
  CHECK(host.state.sequence > 256);  // over the wrap of the byte that a classic state carries
  CHECK(board.mechanics.outputs.effort[1] == -2.0f);
  CHECK(board.mechanics.outputs.effort[5] == -0.125f);
  const hal::LinkCounters counters = host.link->counters();
  CHECK(counters.sent == host.sequence);
  CHECK(counters.send_failed == 0);
  WARN(host.sequence << " commands, " << board.link.counters().commands << " whole there; of states incomplete "
                     << host.link->bus_errors().incomplete << ", controller full "
                     << host.link->bus_errors().controller_full);
  // A part that is missing was lost in a controller, or is still under way; of the first state one may have come before
  // start().
  if (host.link->bus_errors().controller_full == 0) CHECK(counters.malformed <= board.link.counters().send_failed + 1);
}

}  // namespace

TEST_CASE("classic frames carry states and commands between two controllers on one bus", "[threads]") {
  check_exchange("can1", "can0", false);
}

TEST_CASE("FD frames carry states and commands", "[threads]") { check_exchange("vcan0", "vcan0", true); }

TEST_CASE("a classic device is understood on an interface that could do FD", "[threads]") {
  check_exchange("vcan0", "vcan0", false);
}

TEST_CASE("a service question is answered while states flow", "[threads]") {
  Board board("can1", false);
  Host host{opened(board, {.interface = "can0"}), {}};
  std::jthread sends([&board](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      board.period();
      std::this_thread::sleep_for(1ms);
    }
  });
  const auto reply = host.link->call({.operation = firmware::Operation::kRead,
                                      .status = firmware::ServiceStatus::kGood,
                                      .tag = 77,
                                      .address = 0xfff0,
                                      .value = 0},
                                     2000ms);
  INFO((reply.ok() ? std::string() : reply.message()));
  REQUIRE(reply.ok());
  CHECK(reply.value().tag == 77);
  CHECK(reply.value().address == 0xfff0);
  CHECK(reply.value().status == firmware::ServiceStatus::kNoSuchRegister);
}

TEST_CASE("bus-off disconnects the host and silences the device until the restart", "[threads]") {
  Board board("vcan0", true);
  Host host{opened(board, {.interface = "vcan0"}), {}};
  REQUIRE(host.link->start().ok());
  exchange(board, host, firmware::State::kIdle);
  for (int i = 0; i < 3; ++i) exchange(board, host, firmware::State::kForce);
  REQUIRE(board.device.controller().state() == firmware::State::kForce);
  const Node bus("vcan0");
  bus.error(CAN_ERR_BUSOFF);
  REQUIRE(soon([&] {
    (void)host.receives();
    return !host.link->connected();
  }));
  REQUIRE(soon([&] {
    board.period();
    return board.link.bus_off();
  }));
  const std::uint64_t states = board.link.counters().states;
  for (int i = 0; i < 12; ++i) board.period();
  CHECK(board.link.counters().states == states);
  CHECK(board.device.controller().state() == firmware::State::kBrake);  // its watchdog went on counting
  CHECK(host.link->bus_errors().bus_off == 1);
  CHECK(host.link->counters().disconnects == 1);

  bus.error(CAN_ERR_RESTARTED);
  REQUIRE(soon([&] {
    board.period();
    return !board.link.bus_off();
  }));
  REQUIRE(soon([&] {
    board.period();
    return host.receives();
  }));
  CHECK(host.link->connected());
  CHECK(host.link->bus_errors().restarted == 1);
}

TEST_CASE("error frames of other kinds are counted and do not disconnect the link", "[threads]") {
  Board board("vcan0", false);
  Host host{opened(board, {.interface = "vcan0"}), {}};
  REQUIRE(host.link->start().ok());
  const Node bus("vcan0");
  bus.error(CAN_ERR_LOSTARB);
  can_frame passive{};
  passive.can_id = CAN_ERR_FLAG | CAN_ERR_CRTL | CAN_ERR_CNT;
  passive.can_dlc = CAN_ERR_DLC;
  passive.data[1] = CAN_ERR_CRTL_TX_PASSIVE;
  passive.data[6] = 130;
  passive.data[7] = 7;
  REQUIRE(bus.send(passive));
  REQUIRE(soon([&] {
    (void)host.receives();
    return host.link->counters().errors == 2;
  }));
  const hal::CanBusErrors errors = host.link->bus_errors();
  CHECK((errors.arbitration_lost == 1 && errors.error_passive == 1));
  CHECK((errors.tx_errors == 130 && errors.rx_errors == 7));
  CHECK(host.link->connected());
}

TEST_CASE("an interface that goes down and comes up again is connected again by itself", "[threads]") {
  const bool fd = GENERATE(true, false);
  const std::string device = fd ? "vcan0" : "can1", name = fd ? "vcan0" : "can0";
  Board board(device.c_str(), fd);
  Host host{opened(board, {.interface = name}), {}};
  REQUIRE(host.link->start().ok());
  exchange(board, host, firmware::State::kIdle);
  run("/bin/ip link set " + name + " down");
  REQUIRE(soon([&] {
    (void)host.receives();
    return !host.link->connected();
  }));
  CHECK_FALSE(host.sends(firmware::State::kIdle));
  CHECK(host.link->counters().disconnects == 1);
  CHECK(host.link->counters().send_failed == 1);
  run("/bin/ip link set " + name + " up");
  REQUIRE(soon([&] {
    board.period();
    return host.receives();
  }));
  CHECK(host.link->connected());
  exchange(board, host, firmware::State::kIdle);
}

TEST_CASE("an adapter that is pulled out and put back is bound again", "[threads]") {
  run("/bin/ip link add vcan7 type vcan && /bin/ip link set vcan7 up");
  auto board = std::make_unique<Board>("vcan7", false);
  Host host{opened(*board, {.interface = "vcan7"}), {}};
  REQUIRE(host.link->start().ok());
  run("/bin/ip link del vcan7");
  REQUIRE(soon([&] {
    (void)host.receives();
    return !host.link->connected();
  }));
  run("/bin/ip link add vcan7 type vcan && /bin/ip link set vcan7 up");
  board = std::make_unique<Board>("vcan7", false);
  REQUIRE(soon([&] {
    board->period();
    return host.receives();
  }));
  CHECK(host.link->connected());
  exchange(*board, host, firmware::State::kIdle);
  run("/bin/ip link del vcan7");
}

TEST_CASE("a babbling node costs a bounded number of frames a look, each one counted, and the states come through",
          "[threads]") {
  const bool our_identifiers = GENERATE(true, false);
  Board board("vcan0", false);
  Host host{opened(board, {.interface = "vcan0"}), {}};
  REQUIRE(host.link->start().ok());
  const Node babbler("vcan0");
  can_frame frame{};
  const auto function = our_identifiers ? CanFunction::kStatus : CanFunction::kState0;
  frame.can_id = firmware::can_id(function, our_identifiers ? 5 : 6);
  frame.can_dlc = 3;  // no frame of ours has this length
  std::uint64_t babbled = 0;
  for (int look = 0; look < 20; ++look) {
    for (int i = 0; i < 500; ++i) {
      if (babbler.send(frame)) ++babbled;
    }
    const std::uint64_t before = host.link->counters().malformed;
    (void)host.receives();
    CHECK(host.link->counters().malformed - before <= CanLink::kMaxFrames + CanSocket::kBatch * CanLink::kMaxWakes);
  }
  REQUIRE(soon([&] {
    board.period();
    return host.receives();
  }));
  const hal::CanBusErrors errors = host.link->bus_errors();
  const auto seen = host.link->counters().malformed - errors.incomplete, dropped = errors.queue_full;
  CHECK(seen + dropped >= (our_identifiers ? babbled : 0));
  if (!our_identifiers) CHECK((seen == 0 && dropped == 0));
  CHECK(host.link->connected());
  exchange(board, host, firmware::State::kIdle);
}

TEST_CASE("a host that did not look for long is given the newest state in one look", "[threads]") {
  Board board("vcan0", false);
  Host host{opened(board, {.interface = "vcan0"}), {}};
  REQUIRE(host.link->start().ok());
  for (int i = 0; i < 20; ++i) board.period();
  REQUIRE(soon([&] { return host.receives(); }));
  CHECK(host.state.time_us / 8 == board.mechanics.time_us / 8);
  CHECK(host.link->counters().superseded == 19);
}

TEST_CASE("a queue that ran over is empty after one look, its losses are counted, and what comes next is new",
          "[threads]") {
  Board board("vcan0", false);
  Host host{opened(board, {.interface = "vcan0"}), {}};
  REQUIRE(host.link->start().ok());
  for (int i = 0; i < 300; ++i) board.period();
  std::this_thread::sleep_for(500ms);
  REQUIRE(host.receives());
  CHECK(host.link->counters().received <= CanLink::kMaxFrames / 3);
  CHECK_FALSE(host.receives());
  for (int i = 0; i < 12; ++i) {
    board.period();
    REQUIRE(soon([&] { return host.receives(); }));
  }
  CHECK(host.link->bus_errors().queue_full > 0);
  CHECK(host.state.time_us / 8 == board.mechanics.time_us / 8);
}

TEST_CASE("a frame's arrival is when it came, not when it was read", "[threads]") {
  Board board("can1", false);
  Host host{opened(board, {.interface = "can0"}), {}};
  REQUIRE(host.link->start().ok());
  const std::int64_t before = MonotonicClock::now_ns();
  board.period();
  std::this_thread::sleep_for(500ms);
  const std::int64_t read = MonotonicClock::now_ns();
  std::array<std::byte, firmware::kMaxFrameSize> buffer;
  const hal::ReceivedFrame frame = host.link->receive(buffer);
  REQUIRE(frame.size > 0);
  CHECK(frame.arrival_ns >= before);
  CHECK(frame.arrival_ns < read - 100'000'000);
}

TEST_CASE("what is wrong at opening is said in one line that holds its remedy", "[threads]") {
  const auto message = [](CanOptions options) {
    options.first_frame = 50ms;
    const auto link = CanLink::open(options);
    REQUIRE_FALSE(link.ok());
    WARN(link.message());
    CHECK(link.message().find('\n') == std::string::npos);
    return link.message();
  };
  using Catch::Contains;
  CHECK_THAT(message({.interface = "can9"}), Contains("no interface 'can9'") && Contains("can0"));
  CHECK_THAT(message({.interface = "lo"}), Contains("no CAN interface"));
  CHECK_THAT(message({.interface = "can0", .format = CanFormat::kFd}), Contains("FD"));
  CHECK_THAT(message({.interface = "can0", .node = 9}), Contains("node id 9") && Contains("none is heard"));
  CHECK_THAT(message({.interface = "can0", .node = 0}), Contains("1 to 127"));
  {
    Board board("can1", false);
    std::jthread sends([&board](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        board.period();
        std::this_thread::sleep_for(1ms);
      }
    });
    CHECK_THAT(message({.interface = "can0", .node = 5, .period = 500us}), Contains("1000000 bit/s"));
    CHECK_THAT(message({.interface = "can0", .node = 9}), Contains("heard: 5"));
  }
  run("/bin/ip link set vcan0 down");
  CHECK_THAT(message({.interface = "vcan0"}), Contains("ip link set vcan0 up"));
  run("/bin/ip link set vcan0 up");
}
