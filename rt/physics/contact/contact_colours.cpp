#include "rt/physics/contact/contact_colours.h"

#include <bit>

namespace tactus::physics {

template <class S>
void ContactColours::assign(std::span<const Contact> contacts, std::span<const SolverBody<S>> motion) noexcept {
  moving_ = {};
  fixed_ = {};
  used_.resize(static_cast<std::uint32_t>(motion.size()));
  for (Used& used : used_) used = {};
  colour_.resize(static_cast<std::uint32_t>(contacts.size()));
  for (std::uint32_t k = 0; k < colour_.size(); ++k) {
    const Contact& contact = contacts[k];
    const bool is_held =
        motion[contact.slot_a].inverse_mass == S(0) && (contact.b_fixed || motion[contact.slot_b].inverse_mass == S(0));
    if (is_held || contact.is_redundant()) {
      colour_[k] = kNotSolved;
      continue;
    }
    std::uint64_t& a = contact.b_fixed ? used_[contact.slot_a].fixed : used_[contact.slot_a].moving;
    std::uint64_t& b = contact.b_fixed ? a : used_[contact.slot_b].moving;
    const int first = std::countr_one(a | b);  // 64 if all are taken: kLeftOver
    colour_[k] = static_cast<std::uint8_t>(first);
    if (first < static_cast<int>(kColours)) {
      const std::uint64_t bit = std::uint64_t{1} << first;
      a |= bit;
      b |= bit;
    }
    ++(contact.b_fixed ? fixed_ : moving_).of[colour_[k]][contact.count - 1];
  }
}

template void ContactColours::assign(std::span<const Contact>, std::span<const SolverBody<double>>) noexcept;
template void ContactColours::assign(std::span<const Contact>, std::span<const SolverBody<float>>) noexcept;

}  // namespace tactus::physics
