// Both ends of the USB link over the kernel's own drivers, for the guest of the bench: needs root, dummy_hcd and
// FunctionFS. The device runs in a thread of its own; every wait is for something to happen, and frames are judged by
// their numbers, so that nothing here depends on how fast the machine is.
#include <libusb.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <thread>

#include "firmware/boards/linux/linux_program.h"
#include "firmware/boards/linux_usb/usb_gadget_link.h"
#include "firmware/registers.h"
#include "hal/usb/usb_link.h"
#include "rt/base/clock.h"
#include "tests/support/rt_guard.h"
#include "tests/vm/halt_endpoints.h"

using namespace tactus;
using firmware::CommandFrame;
using firmware::ServiceMessage;
using firmware::StateFrame;
using hal::UsbLink;
using namespace std::chrono_literals;

namespace {

constexpr std::int64_t kPatience_ns = 20'000'000'000;

template <class F>
bool soon(F&& holds) {
  const std::int64_t deadline = MonotonicClock::now_ns() + kPatience_ns;
  while (!holds()) {
    if (MonotonicClock::now_ns() > deadline) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
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
  void sample(firmware::ControllerInputs& inputs) noexcept { inputs.time_us = time_us += 1000; }
  void drive(const firmware::ControllerOutputs&) noexcept {}
};

// A device that runs its periods from construction to destruction, but for pauses.
class Board {
 public:
  explicit Board(const std::string& serial = "GUEST-1") {
    firmware::GadgetOptions options;
    options.serial = serial;
    const std::string error = link.open(options, 81);
    INFO(error);
    REQUIRE(error.empty());
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        if (running) {
          firmware::run_period(device, mechanics, link);
          ++periods;
        }
        std::this_thread::sleep_for(1ms);
      }
    });
  }

  firmware::UsbGadgetLink link;
  firmware::Device device{configuration()};
  StillMechanics mechanics;
  std::atomic<bool> running{true};
  std::atomic<std::uint64_t> periods{0};

 private:
  std::jthread thread_;
};

std::unique_ptr<UsbLink> opened() {
  Result<std::unique_ptr<UsbLink>> link = Status::error("");
  const bool there = soon([&] { return (link = UsbLink::open()).ok(); });
  INFO(link.message());
  REQUIRE(there);
  return std::move(link).value();
}

std::string error_of(const hal::UsbOptions& options) {
  const Result<std::unique_ptr<UsbLink>> link = UsbLink::open(options);
  return link.ok() ? "opened" : link.message();
}

// The host's side of a loop: what came, by its numbers.
class Host {
 public:
  explicit Host(UsbLink& link) : link_(link) {}

  bool receive() {
    std::array<std::byte, firmware::kMaxFrameSize> buffer;
    const test::RtGuard guard;
    const hal::ReceivedFrame frame = link_.receive(buffer);
    breaches += guard.allocations() + guard.frees() + guard.locks();
    if (frame.size == 0) return false;
    StateFrame state;
    if (firmware::decode_state(std::span(buffer).first(frame.size), state) != firmware::DecodeError::kNone) ++broken;
    if (handed > 0 && !firmware::is_newer(state.sequence, newest.sequence)) ++backwards;
    if (frame.arrival_ns > MonotonicClock::now_ns() || frame.arrival_ns <= arrival_ns) ++backwards;
    ++handed;
    superseded += frame.superseded;
    arrival_ns = frame.arrival_ns;
    newest = state;
    return true;
  }
  bool send() {
    CommandFrame command;
    command.sequence = ++sequence;
    std::array<std::byte, firmware::kCommandFrameSize> bytes;
    firmware::encode_command(command, bytes);
    const test::RtGuard guard;
    const bool taken = link_.send(bytes);
    breaches += guard.allocations() + guard.frees() + guard.locks();
    return taken;
  }

  StateFrame newest;
  std::uint64_t handed{0}, superseded{0}, broken{0}, backwards{0};
  std::uint64_t breaches{0};  // of the real-time contract
  std::int64_t arrival_ns{0};
  std::uint32_t sequence{0};

 private:
  UsbLink& link_;
};

ServiceMessage read_request(std::uint16_t address, std::uint8_t tag) {
  return {.operation = firmware::Operation::kRead,
          .status = firmware::ServiceStatus::kGood,
          .tag = tag,
          .address = address,
          .value = 0};
}

}  // namespace

TEST_CASE("USB guest: without a device the error says what to do", "[usb][threads]") {
  CHECK(error_of({}) == "no tactus device on USB (1209:0001): plug it in and switch it on");
}

TEST_CASE("USB guest: a device is listed with what it is, and opened alone or by its serial", "[usb][threads]") {
  Board board("SERIAL-7");
  REQUIRE(opened() != nullptr);
  const auto list = hal::enumerate_usb();
  REQUIRE(list.ok());
  REQUIRE(list.value().size() == 1);
  const hal::UsbDeviceInfo& info = list.value().front();
  CHECK(info.serial == "SERIAL-7");
  CHECK(info.speed == "high");
  CHECK(info.release == firmware::kUsbDeviceRelease);
  CHECK(info.protocol_version == firmware::kProtocolVersion);
  CHECK(info.problem.empty());
  CHECK(error_of({.device = {.serial = "SERIAL-7"}}) == "opened");
  CHECK(error_of({.device = {.serial = "SERIAL-8"}}) ==
        "no USB device with serial SERIAL-8; there are: " + describe(info));
}

TEST_CASE("USB guest: a device that is in use, or not ours to open, is an error with its remedy", "[usb][threads]") {
  Board board;
  {
    const auto link = opened();
    CHECK(error_of({}).find("another program uses it") != std::string::npos);
  }
  CHECK(error_of({}) == "opened");
  REQUIRE(seteuid(1000) == 0);
  const std::string error = error_of({});
  const auto list = hal::enumerate_usb();
  REQUIRE(seteuid(0) == 0);
  CHECK(error.find("no permission") != std::string::npos);
  CHECK(error.find("/etc/udev/rules.d/") != std::string::npos);
  CHECK(error.find("ATTR{idVendor}==\"1209\"") != std::string::npos);
  REQUIRE(list.ok());
  REQUIRE(list.value().size() == 1);
  CHECK(list.value().front().problem.find("no permission") != std::string::npos);
}

TEST_CASE("USB guest: frames flow both ways, and each one is accounted for", "[usb][threads]") {
  Board board;
  const auto link = opened();
  REQUIRE(link->start().ok());
  Host host(*link);
  std::mt19937 random(21);
  for (int i = 0; i < 800; ++i) {
    if (random() % 4 != 0) host.receive();
    if (random() % 4 != 0) host.send();
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 1500));
  }
  REQUIRE(soon([&] {
    host.receive();
    return host.newest.echoed_sequence == host.sequence;  // the newest command came back, told by the newest state
  }));
  board.running = false;
  REQUIRE(soon([&] { return !host.receive() && board.link.counters().states_sent > 0; }));
  std::this_thread::sleep_for(100ms);
  host.receive();

  CHECK(host.broken == 0);
  CHECK(host.backwards == 0);
  CHECK(host.breaches == 0);
  CHECK(host.handed > 10);
  const hal::LinkCounters counters = link->counters();
  CHECK(counters.received == host.handed + host.superseded);
  CHECK(counters.superseded == host.superseded);
  CHECK(counters.malformed == 0);
  CHECK(counters.errors == 0);
  CHECK(counters.send_failed == 0);
  CHECK(counters.disconnects == 0);
  CHECK(counters.sent == host.sequence);
  const firmware::GadgetCounters device = board.link.counters();
  CHECK(device.commands_received == counters.sent - counters.send_superseded);
  CHECK(device.states_sent + device.states_superseded == board.periods);
  CHECK(device.transfer_errors == 0);
  CHECK(device.states_sent >= counters.received);  // those before start()
}

TEST_CASE("USB guest: questions are answered while frames flow", "[usb][threads]") {
  Board board;
  const auto link = opened();
  Host host(*link);
  std::atomic<bool> done{false};
  unsigned good = 0;
  std::string error;
  std::thread asks([&] {
    const ServiceMessage known = firmware::Device(configuration()).serve(read_request(firmware::number::kFirmware, 0));
    for (unsigned i = 0; i < 100; ++i) {
      const auto tag = static_cast<std::uint8_t>(i);
      const auto reply = link->call(read_request(firmware::number::kFirmware, tag), 5s);
      if (reply.ok() && reply.value().tag == tag && reply.value().value == known.value) ++good;
      if (!reply.ok()) error = reply.message();
    }
    done = true;
  });
  while (!done) {
    host.receive();
    host.send();
    std::this_thread::sleep_for(1ms);
  }
  asks.join();
  INFO(error);
  CHECK(good == 100);
  CHECK(host.handed > 10);
  CHECK(host.broken == 0);
  // Of a register that is none the device says so itself.
  const auto unknown = link->call(read_request(0xffff, 1), 5s);
  REQUIRE(unknown.ok());
  CHECK(unknown.value().status == firmware::ServiceStatus::kNoSuchRegister);
}

TEST_CASE("USB guest: a control loop that stands still is an error after the time given, and then answers again",
          "[usb][threads]") {
  Board board;
  const auto link = opened();
  REQUIRE(link->call(read_request(firmware::number::kFirmware, 1), 5s).ok());
  board.running = false;
  std::this_thread::sleep_for(50ms);
  const auto reply = link->call(read_request(firmware::number::kFirmware, 2), 600ms);
  CHECK_FALSE(reply.ok());
  CHECK(reply.message().find("did not answer within 600 ms") != std::string::npos);
  board.running = true;
  CHECK(link->call(read_request(firmware::number::kFirmware, 3), 5s).ok());
  CHECK(link->connected());
}

TEST_CASE("USB guest: unplugged is told at once, and plugged in again it goes on by itself", "[usb][threads]") {
  Board board;
  const auto link = opened();
  REQUIRE(link->start().ok());
  Host host(*link);
  for (unsigned cycle = 1; cycle <= 3; ++cycle) {
    REQUIRE(soon([&] {
      host.send();
      return host.receive();
    }));
    board.link.unplug();
    REQUIRE(soon([&] { return !link->connected(); }));
    CHECK(link->counters().disconnects == cycle);
    CHECK_FALSE(host.send());
    CHECK(link->call(read_request(0, 1), 1s).message().find("unplugged") != std::string::npos);
    while (host.receive()) {}  // the last one that came
    std::this_thread::sleep_for(20ms);
    CHECK_FALSE(host.receive());

    REQUIRE(board.link.plug().empty());
    REQUIRE(soon([&] { return link->connected(); }));
    const std::uint32_t before = host.sequence;
    REQUIRE(soon([&] {
      host.send();
      host.receive();
      return host.handed > 0 && host.newest.echoed_sequence > before;  // both directions, with what was sent after
    }));
    CHECK(link->call(read_request(firmware::number::kFirmware, 1), 5s).ok());
  }
  CHECK(host.broken == 0);
  CHECK(host.backwards == 0);
  CHECK(host.breaches == 0);
  CHECK(board.link.counters().disconnects == 3);
}

TEST_CASE("USB guest: an endpoint that halts is cleared when the link opens and while frames flow", "[usb][threads]") {
  Board board;
  std::unique_ptr<UsbLink> link = opened();
  for (unsigned cycle = 0; cycle < 10; ++cycle) {
    if (cycle % 2 == 0) {
      link.reset();
      REQUIRE(soon([] { return vm::halt_endpoints() == 0; }));
      link = opened();
    }
    REQUIRE(link->start().ok());
    Host host(*link);
    const auto flows = [&] {
      const std::uint32_t before = host.sequence;
      return soon([&] {
        host.send();
        host.receive();
        return host.handed > 0 && host.newest.echoed_sequence > before;
      });
    };
    REQUIRE(flows());
    // Above the link's own threads, which use the endpoint all the time; it waits for the transfer that is under way.
    std::atomic<bool> halted{false};
    const std::jthread halting([&] {
      (void)firmware::make_realtime(98, -1);
      board.link.halt(cycle % 4 < 2);
      halted = true;
    });
    REQUIRE(soon([&] {
      host.send();
      host.receive();
      return halted.load();
    }));
    REQUIRE(flows());
    REQUIRE(flows());
    CHECK(link->connected());
    CHECK(link->counters().disconnects == 0);
    CHECK(host.breaches == 0);
    CHECK(link->call(read_request(firmware::number::kFirmware, 1), 5s).ok());
  }
}

TEST_CASE("USB guest: another device in the place of the one that was pulled is not taken for it", "[usb][threads]") {
  std::unique_ptr<UsbLink> link;
  {
    Board board("FIRST");
    link = opened();
    CHECK(link->info().serial == "FIRST");
  }
  REQUIRE(soon([&] { return !link->connected(); }));
  {
    Board other("SECOND");
    REQUIRE(soon([&] { return hal::enumerate_usb().value().size() == 1; }));
    std::this_thread::sleep_for(3 * UsbLink::kReplugLook);
    CHECK_FALSE(link->connected());
  }
  Board again("FIRST");
  CHECK(soon([&] { return link->connected(); }));
}

TEST_CASE("USB guest: what a device sends is handed out as it is, whatever it is", "[usb][threads]") {
  firmware::UsbGadgetLink device;
  firmware::GadgetOptions options;
  options.serial = "HOSTILE";
  REQUIRE(device.open(options, 0).empty());
  const auto link = opened();
  std::mt19937 random(22);
  for (int i = 0; i < 60; ++i) {
    std::vector<std::byte> sent(1 + random() % firmware::kMaxFrameSize);
    for (std::byte& byte : sent) byte = static_cast<std::byte>(random());
    device.send_state(sent);
    std::array<std::byte, firmware::kMaxFrameSize> buffer{};
    hal::ReceivedFrame frame;
    REQUIRE(soon([&] { return (frame = link->receive(buffer)).size > 0; }));
    CHECK(frame.size == sent.size());
    CHECK(std::equal(sent.begin(), sent.end(), buffer.begin()));
  }
}

namespace {

// A host of its own kind: raw control transfers to the device.
class RawHost {
 public:
  RawHost() {
    libusb_init(&context_);
    REQUIRE(soon([&] {
      handle_ = libusb_open_device_with_vid_pid(context_, firmware::kUsbVendor, firmware::kUsbProduct);
      if (handle_ == nullptr) {  // a new look
        libusb_exit(context_);
        libusb_init(&context_);
      }
      return handle_ != nullptr;
    }));
    REQUIRE(soon([&] { return libusb_claim_interface(handle_, 0) == 0; }));
  }
  ~RawHost() {
    libusb_close(handle_);
    libusb_exit(context_);
  }

  int control(unsigned type, unsigned request, unsigned value, unsigned index, unsigned size) {
    return libusb_control_transfer(handle_, static_cast<std::uint8_t>(type), static_cast<std::uint8_t>(request),
                                   static_cast<std::uint16_t>(value), static_cast<std::uint16_t>(index), data.data(),
                                   static_cast<std::uint16_t>(size), 5000);
  }
  std::string text(int from, int size) const {
    return {reinterpret_cast<const char*>(data.data()) + from, static_cast<std::size_t>(size)};
  }
  std::array<unsigned char, 256> data{};

 private:
  libusb_context* context_{nullptr};
  libusb_device_handle* handle_{nullptr};
};

}  // namespace

TEST_CASE("USB guest: Windows finds the Microsoft OS descriptors", "[usb][threads]") {
  Board board;
  RawHost host;
  REQUIRE(host.control(0x80, LIBUSB_REQUEST_GET_DESCRIPTOR, 0x03ee, 0, 255) == 18);
  CHECK(host.text(2, 14) == std::string("M\0S\0F\0T\0001\0000\0000\0", 14));
  CHECK(host.data[16] == firmware::kUsbMicrosoftVendorCode);
  REQUIRE(host.control(0xc0, firmware::kUsbMicrosoftVendorCode, 0, 4, 255) == 40);
  CHECK(host.text(18, 8) == std::string("WINUSB\0\0", 8));
  const int size = host.control(0xc1, firmware::kUsbMicrosoftVendorCode, 0, 5, 255);
  REQUIRE(size > 50);
  std::string narrow;
  for (int i = 0; i < size; ++i) {
    if (host.data[static_cast<std::size_t>(i)] != 0)
      narrow += static_cast<char>(host.data[static_cast<std::size_t>(i)]);
  }
  CHECK(narrow.find("DeviceInterfaceGUID") != std::string::npos);
  CHECK(narrow.find(firmware::kUsbInterfaceGuid) != std::string::npos);
}

TEST_CASE("USB guest: requests that are none are refused, and the next good one is answered", "[usb][threads]") {
  Board board;
  RawHost host;
  const unsigned out = firmware::kUsbRequestOut, in = firmware::kUsbRequestIn;
  const unsigned write = firmware::kUsbWriteService, read = firmware::kUsbReadService;
  CHECK(host.control(in, read, 0, 0, 16) == LIBUSB_ERROR_PIPE);  // nothing was asked
  std::mt19937 random(23);
  const auto pick = [&random](unsigned count) { return static_cast<unsigned>(random() % count); };
  for (int i = 0; i < 30; ++i) {
    CHECK(host.control(out, write, 0, 0, pick(16)) == LIBUSB_ERROR_PIPE);
    CHECK(host.control(out, 3 + pick(100), 0, 0, 16) == LIBUSB_ERROR_PIPE);
    CHECK(host.control(in, 3 + pick(100), 0, 0, 16) == LIBUSB_ERROR_PIPE);
    for (unsigned char& byte : host.data) byte = static_cast<unsigned char>(random());
    host.data[0] = 0;  // not the magic
    host.control(out, write, 0, 0, 16);
    CHECK(host.control(in, read, 0, 0, 16) == LIBUSB_ERROR_PIPE);
  }
  std::array<std::byte, firmware::kServiceFrameSize> request;
  firmware::encode_service(read_request(firmware::number::kFirmware, 9), firmware::ServiceDirection::kRequest, request);
  std::copy(request.begin(), request.end(), reinterpret_cast<std::byte*>(host.data.data()));
  REQUIRE(host.control(out, write, 0, 0, 16) == 16);
  REQUIRE(soon([&] { return host.control(in, read, 0, 0, 16) == 16; }));
  ServiceMessage reply;
  const std::span<const unsigned char> bytes(host.data.data(), 16);
  REQUIRE(firmware::decode_service(std::as_bytes(bytes), firmware::ServiceDirection::kReply, reply) ==
          firmware::DecodeError::kNone);
  CHECK(reply.tag == 9);
  CHECK(board.link.counters().service_refused >= 120);
}
