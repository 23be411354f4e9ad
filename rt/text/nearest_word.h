// Finds the known word closest to a misspelt one, for the keys of a scene and the options of a command.
// Thread: [any], normal priority: it allocates. Bound: for a word of more than 64 characters the result is empty.
#pragma once

#include <span>
#include <string_view>

namespace tactus::text {

// The word of `known` with the fewest changes to `word`, ties to the first; a known word that starts with `word` counts
// as one change. Two neighbours that changed places are one change. Empty if half of `word` or more would have to
// change.
std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known);

}  // namespace tactus::text
