// Any bytes as what a device on a link does: frame decoding, the input guard and the loop must survive them, and no
// command goes beyond the device's limits. The script's first byte chooses the device; hostile_device.h plays the rest.
#include <cstdio>
#include <cstdlib>

#include "tests/support/hostile_device.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactus;
  if (size == 0) return 0;
  const auto profiles = hal::all_profiles();
  test::HostileSession session(profiles[data[0] % profiles.size()], {data + 1, size - 1});
  const test::Hostilities found = session.run(2000);
  if (found.violated != nullptr) {
    std::fprintf(stderr, "beyond its limit: %s\n", found.violated);
    std::abort();
  }
  return 0;
}
