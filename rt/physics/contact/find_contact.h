// Finds the contact of two moving bodies among contacts sorted by key; null if there is none. Thread: the owner of the
// World. Bound: logarithmic in contacts.
#pragma once

#include <algorithm>
#include <span>

#include "rt/physics/contact/contact.h"

namespace tactus::physics {

inline const Contact* find_contact(std::span<const Contact> contacts, BodyId a, BodyId b) noexcept {
  const PairKey key = PairKey::of(a, b, false);
  const auto at = std::lower_bound(contacts.begin(), contacts.end(), key,
                                   [](const Contact& contact, const PairKey& k) { return contact.key < k; });
  return at != contacts.end() && at->key == key ? &*at : nullptr;
}

}  // namespace tactus::physics
