// Finds the contacts of two moving bodies among contacts sorted by key: one for each two parts that are near each
// other, so at most one if neither is a compound. Thread: the owner of the World. Bound: logarithmic in contacts,
// linear in those found.
#pragma once

#include <algorithm>
#include <span>

#include "rt/physics/contact/contact.h"

namespace tactus::physics {

// The contacts from this key on.
inline std::span<const Contact> contacts_from(std::span<const Contact> contacts, PairKey key) noexcept {
  return {std::lower_bound(contacts.begin(), contacts.end(), key,
                           [](const Contact& contact, const PairKey& k) { return contact.key < k; }),
          contacts.end()};
}

// The contact of two parts; null if there is none.
inline const Contact* find_contact(std::span<const Contact> contacts, PairKey key) noexcept {
  const auto found = contacts_from(contacts, key);
  return !found.empty() && found[0].key == key ? &found[0] : nullptr;
}

// The contacts from the first on that are of the same two bodies.
inline std::span<const Contact> contacts_of_first_pair(std::span<const Contact> contacts) noexcept {
  std::size_t count = 0;
  while (count < contacts.size() && contacts[count].key.of_bodies() == contacts[0].key.of_bodies()) ++count;
  return contacts.first(count);
}

inline std::span<const Contact> find_contacts(std::span<const Contact> contacts, BodyId a, BodyId b) noexcept {
  const PairKey key = PairKey::of(a, b, false);
  const auto found = contacts_from(contacts, key);
  return !found.empty() && found[0].key.of_bodies() == key ? contacts_of_first_pair(found) : std::span<const Contact>{};
}

inline bool any_touching(std::span<const Contact> contacts) noexcept {
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& contact) { return contact.touching(); });
}

}  // namespace tactus::physics
