// Cases whose effect tactus does not have: listed, shown as not run, never as passed.
#include "tools/experiment/hard_cases/cases.h"

namespace tactus::hard_cases {

std::vector<HardCase> waiting_cases() {
  return {
      {44, "two devices squeeze one body", "several devices in a session", false, nullptr},
  };
}

}  // namespace tactus::hard_cases
