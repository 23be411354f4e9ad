// The firmware's tests on the target: Catch2 on newlib, output and exit status over semihosting.
#define CATCH_CONFIG_RUNNER
#include <array>
#include <catch2/catch.hpp>

#include "firmware/boards/cortex_m/startup.h"
#include "tests/firmware/boards/cortex_m/emulated/semihosting.h"

extern "C" {
void initialise_monitor_handles();  // newlib: opens stdin, stdout and stderr at the emulator
// What the toolchain's own start-up files would bring; test_image.ld has the rest.
void _init() {}
void _fini() {}

[[noreturn]] void stop_after_fault(const std::uint32_t*) {
  constexpr std::uint32_t fault_status = 99;
  tactus::firmware::cortex_m::exit_emulator(fault_status);
}

int main() {
  initialise_monitor_handles();
  std::array<const char*, 1> arguments{"firmware_tests"};
  tactus::firmware::cortex_m::exit_emulator(
      static_cast<std::uint32_t>(Catch::Session().run(static_cast<int>(arguments.size()), arguments.data())));
}
}
