#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "tests/support/hostile_device.h"

using namespace tactus;
using test::HostileSession;
using test::Hostilities;

namespace {

// A script whose ticks begin with a byte drawn from `kinds`.
std::vector<std::uint8_t> script_of(std::uint64_t seed, std::initializer_list<std::uint8_t> kinds, unsigned ticks) {
  std::mt19937_64 random(seed);
  const std::vector<std::uint8_t> choice(kinds);
  std::vector<std::uint8_t> script;
  for (unsigned i = 0; i < ticks; ++i) {
    const std::uint8_t what = choice[random() % choice.size()];
    script.push_back(what);
    const unsigned bytes = (what & 8u) != 0   ? 0
                           : (what & 1u) != 0 ? 6 + 24 * ((what >> 1) & 1u) + 8 * ((what >> 2) & 1u) + 3 * (what >> 7)
                                              : 1;
    for (unsigned k = 0; k < bytes; ++k) script.push_back(static_cast<std::uint8_t>(random()));
    if ((what & 9u) == 0)
      for (unsigned k = script.back(); k > 0; --k) script.push_back(static_cast<std::uint8_t>(random()));
  }
  return script;
}

Hostilities play(const hal::DeviceProfile& profile, const std::vector<std::uint8_t>& script) {
  Hostilities found = HostileSession(profile, script).run(1'000'000);
  CAPTURE(profile.name, found.violated);
  REQUIRE(found.violated == nullptr);
  return found;
}

}  // namespace

TEST_CASE("samples of a device that vibrates plausibly are accepted, and its force is within its limits") {
  for (const hal::DeviceProfile& profile : hal::all_profiles()) {
    const Hostilities found = play(profile, script_of(1, {1, 1, 1, 1, 33}, 5000));
    CHECK(found.fresh == found.ticks);
    CHECK(found.faults == 0);
    CHECK(found.most_force_N > 0.0);
  }
}

TEST_CASE("a device that sends bytes of any length never moves the loop") {
  for (const hal::DeviceProfile& profile : hal::all_profiles()) {
    const Hostilities found = play(profile, script_of(2, {0, 32, 64}, 5000));
    CHECK(found.corrupt > 4000);
    CHECK(found.fresh == 0);
    CHECK(found.most_force_N == 0.0);
  }
}

TEST_CASE("random counts, replayed sequences, false states and silence: no command beyond the limits") {
  for (const hal::DeviceProfile& profile : hal::all_profiles()) {
    double most_N = 0;
    std::uint64_t faults = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Hostilities found =
          play(profile,
               script_of(seed, {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 33, 65, 65, 3, 5, 129, 8, 17, 0, 7, 135, 16}, 2000));
      most_N = std::max(most_N, found.most_force_N);
      faults += found.faults;
    }
    CHECK(most_N > 0.0);
    CHECK(faults > 100);
  }
}

TEST_CASE("a device that creeps outwards is followed to its peak force and no further") {
  for (const hal::DeviceProfile& profile : hal::all_profiles()) {
    std::vector<std::uint8_t> script;
    for (unsigned i = 0; i < 4000; ++i) {
      script.push_back(i == 20 ? 33 : 1);
      for (unsigned axis = 0; axis < 6; ++axis) script.push_back(axis < 3 ? 0x20 : 0);  // eight counts a tick
    }
    const Hostilities found = play(profile, script);
    CHECK(found.most_force_N == Approx(profile.properties.max_force_N));
  }
}
