// Graph colouring of contacts: no two contacts of a colour share a moving body, so a colour can be solved in parallel.
//
// Greedy: each contact, in the order of the keys, takes the first colour that neither of its bodies has, so colours
// depend only on the contacts. A contact of two bodies of infinite mass has no colour and is not solved. Contacts for
// which all colours are taken are left over and solved one after the other. Contacts with fixed bodies have colours of
// their own: they are solved last, so their constraints are met best. Thread: construction [setup]; the rest [rt].
// Bound: linear in contacts.
#pragma once

#include <array>
#include <numeric>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/capacity.h"
#include "rt/physics/contact/contact.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

class ContactColours {
 public:
  static constexpr std::uint32_t kColours = 64;  // one bit each in a 64-bit mask
  static constexpr std::uint8_t kLeftOver = 64, kNotSolved = 65;
  // Numbers of contacts by colour, the last entry those left over, and by the number of points, less 1.
  struct Counts {
    std::array<std::array<std::uint32_t, kMaxManifoldPoints>, kColours + 1> of{};

    std::uint32_t in(std::uint32_t colour) const noexcept {
      return std::accumulate(of[colour].begin(), of[colour].end(), 0u);
    }
  };

  explicit ContactColours(const Capacities& capacities)
      : colour_(capacities.contacts), used_(capacities.bodies) {}  // [setup]

  // `motion`: the moving bodies, by slot.
  template <class S>
  void assign(std::span<const Contact> contacts, std::span<const SolverBody<S>> motion) noexcept;

  std::uint8_t of(std::uint32_t contact) const noexcept { return colour_[contact]; }
  const Counts& moving() const noexcept { return moving_; }  // contacts between moving bodies
  const Counts& fixed() const noexcept { return fixed_; }    // with fixed bodies

 private:
  BoundedVector<std::uint8_t> colour_;  // by contact
  struct Used {
    std::uint64_t moving, fixed;  // one bit per colour
  };
  BoundedVector<Used> used_;  // by slot
  Counts moving_, fixed_;
};

}  // namespace tactus::physics
