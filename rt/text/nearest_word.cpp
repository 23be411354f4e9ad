#include "rt/text/nearest_word.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace tactus::text {

std::string_view nearest_word(std::string_view word, std::span<const std::string_view> known) {
  if (word.size() > 64) return {};
  const std::string_view stem = word.substr(0, word.find('_'));
  constexpr std::size_t kOtherStem = 1000;  // larger than any distance
  std::string_view best;
  std::size_t best_distance = kOtherStem + (word.size() + 1) / 2;  // no suggestion from here on
  std::vector<std::size_t> row, before, before_that;  // of the table: after i + 1, i and i - 1 letters of `word`
  for (const auto candidate : known) {
    // Damerau's distance (optimal string alignment): two neighbours that changed places count as one change.
    row.resize(candidate.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 0; i < word.size(); ++i) {
      before_that = std::exchange(before, row);
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t changed = before[j] + (word[i] == candidate[j] ? 0 : 1);
        row[j + 1] = std::min({changed, row[j] + 1, before[j + 1] + 1});
        if (i > 0 && j > 0 && word[i] == candidate[j - 1] && word[i - 1] == candidate[j])
          row[j + 1] = std::min(row[j + 1], before_that[j - 1] + 1);
      }
    }
    // A key without its unit is a common mistake: stiffness for stiffness_N_per_m.
    const bool begins = word.size() >= 3 && candidate.starts_with(word);
    // The same stem with another unit or form: rotation_deg for rotation_vector_rad.
    const bool same_stem = stem.size() >= 3 && stem.size() < word.size() && candidate.starts_with(stem) &&
                           (candidate.size() == stem.size() || candidate[stem.size()] == '_');
    const std::size_t distance = begins ? 1 : row.back() + (same_stem ? 0 : kOtherStem);
    if (distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace tactus::text
