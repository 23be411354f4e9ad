#include "firmware/boards/linux_can/can_error_frame.h"

#include <array>
#include <catch2/catch.hpp>

using namespace tactus::firmware;

namespace {

// A kernel's error frame always has eight bytes; the counters are the last two.
std::array<std::byte, 8> counters(unsigned transmit, unsigned receive) {
  std::array<std::byte, 8> data{};
  data[6] = static_cast<std::byte>(transmit);
  data[7] = static_cast<std::byte>(receive);
  return data;
}

}  // namespace

TEST_CASE("an error frame with counters sets both, one without leaves them") {
  BusErrors errors;
  take_bus_errors(CAN_ERR_CRTL | CAN_ERR_CNT, counters(136, 250), errors);
  CHECK(errors == BusErrors{136, 250, 0});
  take_bus_errors(CAN_ERR_CRTL, counters(7, 8), errors);
  CHECK(errors == BusErrors{136, 250, 0});
  const auto whole = counters(7, 8);
  take_bus_errors(CAN_ERR_CRTL | CAN_ERR_CNT, std::span(whole).first(6), errors);  // cut short
  CHECK(errors == BusErrors{136, 250, 0});
  take_bus_errors(CAN_ERR_CRTL | CAN_ERR_CNT, counters(0, 95), errors);
  CHECK(errors == BusErrors{0, 95, 0});
}

TEST_CASE("every bus-off is counted up to the counter's end, and a restart leaves the errors at zero") {
  BusErrors errors;
  for (std::uint32_t n = 1; n <= 3; ++n) {
    take_bus_errors(CAN_ERR_BUSOFF | CAN_ERR_CNT, counters(248, 5), errors);
    CHECK(errors == BusErrors{248, 5, n});
    take_bus_errors(CAN_ERR_RESTARTED, counters(0, 0), errors);
    CHECK(errors == BusErrors{0, 0, n});
  }
  errors.bus_off = 0xffffffff;
  take_bus_errors(CAN_ERR_BUSOFF, {}, errors);
  CHECK(errors.bus_off == 0xffffffff);
}
