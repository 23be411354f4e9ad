#include <algorithm>

#include "tools/validation/cases.h"

namespace tactus::hard_cases {

const std::vector<HardCase>& hard_cases() {
  static const std::vector<HardCase> all = [] {
    std::vector<HardCase> cases;
    for (const auto& family :
         {stack_cases(), rest_cases(), friction_cases(), motion_cases(), impact_cases(), coupling_cases(),
          border_cases(), session_cases(), effect_cases(), device_cases(), hands_cases()})
      cases.insert(cases.end(), family.begin(), family.end());
    std::sort(cases.begin(), cases.end(), [](const HardCase& a, const HardCase& b) { return a.number < b.number; });
    return cases;
  }();
  return all;
}

}  // namespace tactus::hard_cases
