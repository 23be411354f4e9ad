// The known word that somebody probably meant: for the keys of a scene, the options of a command.
// Thread: [any], normal priority: it allocates. Bound: a word of more than 64 characters is near nothing.
#pragma once

#include <span>
#include <string_view>

namespace tactus::sim {

// The word of `known` that needs the fewest changes to become `word`, ties to the first; one that begins with `word`
// counts as one change away. Empty where none is near: where more than half of the word would have to change.
std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known);

}  // namespace tactus::sim
