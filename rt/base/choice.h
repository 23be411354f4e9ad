// Choices that users name: an enumeration with one row of traits per enumerator. The compiler finds missing traits.
//
// `traits_of(choice)` returns a struct with a `name`, empty for a number that is not an enumerator; its switch has no
// default, so that the compiler reports an enumerator without traits. Thread: [any], constexpr.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace tactus {

// True if the list contains every choice that has traits exactly once. Enumerators are below 32.
template <class Choice, std::size_t kCount>
constexpr bool lists_every_choice(const std::array<Choice, kCount>& list) noexcept {
  for (std::uint32_t number = 0; number < 32; ++number) {
    const auto choice = static_cast<Choice>(number);
    if (std::count(list.begin(), list.end(), choice) != (traits_of(choice).name.empty() ? 0 : 1)) return false;
  }
  return true;
}

// Finds a choice by its name; empty if no choice of the list has it.
template <class Choice, std::size_t kCount>
constexpr std::optional<Choice> find_choice(const std::array<Choice, kCount>& list, std::string_view word) noexcept {
  for (const Choice choice : list)
    if (traits_of(choice).name == word) return choice;
  return std::nullopt;
}

}  // namespace tactus
