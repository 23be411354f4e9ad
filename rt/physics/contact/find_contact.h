// The contact of two bodies that both move, among contacts by key: as a world keeps them. Thread: the owner of the
// World. Bound: logarithmic in contacts. None: null.
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
