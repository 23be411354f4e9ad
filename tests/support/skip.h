// What this machine or this build cannot test. A case that only returned would count as passed: ctest takes the line
// for a skipped case, and tools/check names it with its reason.
#pragma once

#include <catch2/catch.hpp>
#include <cstdio>

// The first thing in a test case: what follows runs where `possible` holds. `why` is a text of one line.
#define TACTUS_NEEDS(possible, why)      \
  do {                                   \
    if (!(possible)) {                   \
      std::puts("tactus-skipped: " why); \
      SUCCEED("skipped: " why);          \
      return;                            \
    }                                    \
  } while (false)
