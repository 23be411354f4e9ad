// Asks the device on a link, in the guest of the bench: a register, or how it is.
//
//   ask_device LINK read REGISTER              LINK: usb, can:IFACE, can:IFACE:NODE; numbers decimal or 0x...
//   ask_device LINK write REGISTER VALUE       VALUE: an integer, or a float's bits
//   ask_device LINK execute REGISTER VALUE
//   ask_device LINK state
//   ask_device usb halt                        both endpoints, before another program opens them
// Prints `value=0x...`, or `refused=STATUS`, or of the next state frame `state=N fault=N limits=0x... counts=A,B,...`.
// Exit status: 0 it answered, 1 it refused or is silent, 2 bad usage, 3 no such device.
#include <fmt/format.h>

#include <cstdlib>
#include <string_view>
#include <thread>

#include "hal/can/can_link.h"
#include "hal/usb/usb_link.h"
#include "rt/base/clock.h"
#include "tests/vm/halt_endpoints.h"

namespace tactus::vm {
namespace {

using firmware::Operation;
using namespace std::chrono_literals;

constexpr auto kPatience = 1000ms;

int fail(int status, const std::string& message) {
  fmt::print(stderr, "ask_device: {}\n", message);
  return status;
}

template <hal::FrameLink Link>
int tell_state(Link& link) {
  std::array<std::byte, firmware::kMaxFrameSize> buffer;
  const std::int64_t end_ns = MonotonicClock::now_ns() + std::chrono::nanoseconds(kPatience).count();
  while (MonotonicClock::now_ns() < end_ns) {
    const hal::ReceivedFrame frame = link.receive(buffer);
    firmware::StateFrame state;
    if (frame.size > 0 && firmware::decode_state(std::span<const std::byte>(buffer).first(frame.size), state) ==
                              firmware::DecodeError::kNone) {
      fmt::print("state={} fault={} limits={:#06x} counts={}\n", static_cast<unsigned>(state.state), state.fault,
                 state.limits, fmt::join(state.counts, ","));
      return 0;
    }
    std::this_thread::sleep_for(1ms);
  }
  return fail(1, "no state frame comes");
}

template <hal::FrameLink Link>
int ask(Link& link, const firmware::ServiceMessage& request) {
  const auto reply = link.call(request, kPatience);
  if (!reply.ok()) return fail(1, reply.message());
  if (reply.value().status == firmware::ServiceStatus::kGood) {
    fmt::print("value={:#x}\n", reply.value().value);
    return 0;
  }
  fmt::print("refused={}\n", static_cast<unsigned>(reply.value().status));
  return 1;
}

template <class Opened>
int talk(const Opened& opened, std::string_view what, const firmware::ServiceMessage& request) {
  if (!opened.ok()) return fail(3, opened.message());
  auto& link = *opened.value();
  if (what != "state") return ask(link, request);
  if (const Status started = link.start(); !started.ok()) return fail(3, started.message());
  return tell_state(link);
}

int run(int argc, char** argv) {
  const std::string_view what = argc > 2 ? argv[2] : "";
  firmware::ServiceMessage request;
  request.operation = what == "write" ? Operation::kWrite : what == "execute" ? Operation::kExecute : Operation::kRead;
  const int arguments = what == "state" || what == "halt"      ? 3
                        : what == "read"                       ? 4
                        : what == "write" || what == "execute" ? 5
                                                               : 0;
  if (argc != arguments)
    return fail(2, "accepted: LINK read REGISTER, write REGISTER VALUE, execute REGISTER VALUE, state, halt");
  if (argc > 3) request.address = static_cast<std::uint16_t>(std::strtoul(argv[3], nullptr, 0));
  if (argc > 4) request.value = static_cast<std::uint32_t>(std::strtoul(argv[4], nullptr, 0));
  request.tag = 1;

  const std::string name = argv[1];
  if (what == "halt") {
    const int error = name == "usb" ? halt_endpoints() : static_cast<int>(LIBUSB_ERROR_NOT_SUPPORTED);
    return error == 0 ? 0 : fail(1, libusb_strerror(error));
  }
  if (name == "usb") return talk(hal::UsbLink::open(), what, request);
  if (!name.starts_with("can:")) return fail(2, "no link '" + name + "'; accepted: usb, can:IFACE, can:IFACE:NODE");
  hal::CanOptions options;
  const std::size_t colon = name.find(':', 4);
  options.interface = name.substr(4, colon - 4);
  if (colon != std::string::npos)
    options.node = static_cast<std::uint8_t>(std::strtoul(name.c_str() + colon + 1, nullptr, 10));
  return talk(hal::CanLink::open(options), what, request);
}

}  // namespace
}  // namespace tactus::vm

int main(int argc, char** argv) { return tactus::vm::run(argc, argv); }
