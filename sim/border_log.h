// What crosses the border between members and outside bodies, as the global world sees it: down, the impulses of its
// last step at the border contacts; up, the tangential impulses that the sub-world found there.
//
// The intervals. H(n) tells what the sub-world did over cycle n-1, from t_(n-1) to t_n. The global step over the same
// time is the one before the step that H(n) starts: its contacts are still in the world when H(n) is taken. So J_sub
// of the report and J_global of those contacts are two answers for one interval, and only their difference is news to
// the outside body. Replay hands on J_sub itself, as the paper says: friction then counts in both worlds.
// Thread: the global world's; construction [setup]. Frame: world. Units: SI. Bound: kMaxBorderPoints points; beyond,
// those that press least are left out, ties by order, and counted. Source: the paper, section 2.2.
#pragma once

#include <vector>

#include "rt/haptics/snapshot.h"

namespace tactus::sim {

class BorderLog {
 public:
  explicit BorderLog(std::uint32_t max_contacts);

  // Fills `border` from the contacts of a step of `step_s` that began at `start` (poses by slot): every point that
  // pressed or overlaps, between a member (by slot, 1) and a dynamic body that is none. Static geometry is never a
  // border. Returns how many did not fit.
  std::uint32_t fill(std::span<const physics::Contact<double>> contacts, std::span<const physics::Body<double>> bodies,
                     std::span<const Posed> start, std::span<const std::uint8_t> members, double step_s,
                     FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& border) noexcept;

 private:
  std::vector<haptics::BorderPoint> points_;
  std::vector<std::uint32_t> order_;
};

// What one hand-back did to outside bodies.
struct HandBack {
  Vec3d impulse_Ns;          // sum
  double magnitude_Ns{0};    // sum of the magnitudes
  double energy_J{0};        // kinetic energy that the outside bodies gained
  std::uint32_t skipped{0};  // returns to bodies that are members by now: their own world moves them
};

// Applies the report's tangential impulses to the outside bodies. Call before the next step. `members` by slot: of
// the cycle that begins.
HandBack hand_back_border(std::span<const haptics::BorderReturn> returns, std::span<const std::uint8_t> members,
                          physics::BorderMode mode, physics::World<double>& world) noexcept;

}  // namespace tactus::sim
