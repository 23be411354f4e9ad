#include "rt/base/denormals.h"

#include <catch2/catch.hpp>
#include <limits>
#include <thread>

TEST_CASE("after set_denormals_flush a thread's denormal results and inputs are zero", "[base][threads]") {
  std::thread([] {
    volatile double smallest = std::numeric_limits<double>::min(), denormal = std::numeric_limits<double>::denorm_min();
    volatile double half = smallest * 0.5;
    CHECK(half > 0.0);  // a new thread inherits the flags: here they are off
    CHECK(!tactus::denormals_flushed());
    tactus::set_denormals_flush();
    CHECK(tactus::denormals_flushed());
    half = smallest * 0.5;
    CHECK(half == 0.0);
    volatile double doubled = denormal * 4503599627370496.0;  // 2^52: the smallest normal number, were it read
    CHECK(doubled == 0.0);
  }).join();
}
