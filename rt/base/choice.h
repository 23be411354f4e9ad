// Choices that users name: an enumeration with one row of traits each, found by the compiler where one is forgotten.
//
// `traits_of(choice)` returns a struct with a `name`, empty for a number that is no choice; its switch has no default,
// so that the compiler names an enumerator without traits. Thread: [any], constexpr.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace tactus {

// Does the list hold every choice that has traits, once? Enumerators are below 32.
template <class Choice, std::size_t kCount>
constexpr bool lists_every_choice(const std::array<Choice, kCount>& list) noexcept {
  for (std::uint32_t number = 0; number < 32; ++number) {
    const auto choice = static_cast<Choice>(number);
    if (std::count(list.begin(), list.end(), choice) != (traits_of(choice).name.empty() ? 0 : 1)) return false;
  }
  return true;
}

// Empty for a word that names none of the list.
template <class Choice, std::size_t kCount>
constexpr std::optional<Choice> find_choice(const std::array<Choice, kCount>& list, std::string_view word) noexcept {
  for (const Choice choice : list)
    if (traits_of(choice).name == word) return choice;
  return std::nullopt;
}

}  // namespace tactus
