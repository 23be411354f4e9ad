// Cases whose effect tactus does not have: listed, shown as not run, never as passed.
#include "tools/experiment/hard_cases/cases.h"

namespace tactus::hard_cases {

std::vector<HardCase> waiting_cases() {
  return {
      {25, "two balls meet, e = 1 and e = 0.5", "restitution", true, nullptr},
      {26, "bouncing ball, e = 0.8", "restitution", true, nullptr},
      {27, "Newton's cradle", "restitution, joints", true, nullptr},
      {29, "heavy top", "ball joint", true, nullptr},
      {38, "global world begins anew in mid-contact", "a new scene in a running session", false, nullptr},
      {44, "two devices squeeze one body", "several devices in a session", false, nullptr},
      {109, "spinning disc, uniform pressure", "torsional friction", true, nullptr},
  };
}

}  // namespace tactus::hard_cases
