#include "rt/base/status.h"

#include <bit>
#include <catch2/catch.hpp>
#include <set>
#include <string>

using namespace tactus;

namespace {

// The enumerations have explicit numbers without gaps; the first unknown one is the end.
constexpr std::uint32_t kFaults = 13, kBits = 16;

}  // namespace

TEST_CASE("every fault has a text of its own", "[base]") {
  std::set<std::string> texts;
  for (std::uint32_t number = 0; number < kFaults; ++number) {
    const std::string text(describe(static_cast<Fault>(number)));
    INFO(number << ": " << text);
    CHECK(!text.empty());
    CHECK(text.find('\n') == std::string::npos);
    CHECK(texts.insert(text).second);
  }
}

TEST_CASE("a fault number of a newer release still has a text, unlike all known ones", "[base]") {
  const auto unknown = describe(static_cast<Fault>(kFaults));
  CHECK(!unknown.empty());
  for (std::uint32_t number = 0; number < kFaults; ++number) CHECK(describe(static_cast<Fault>(number)) != unknown);
}

TEST_CASE("every status bit has a short word of its own, and an unknown one has none", "[base]") {
  std::set<std::string> words;
  for (std::uint32_t i = 0; i < 32; ++i) {
    const std::string word(name_of(static_cast<StatusBit>(1u << i)));
    INFO("bit " << i << ": " << word);
    CHECK(word.empty() == (i >= kBits));
    CHECK(word.find(' ') == std::string::npos);
    CHECK(word.size() <= 20);
    if (!word.empty()) CHECK(words.insert(word).second);
  }
  CHECK(std::bit_width(static_cast<std::uint32_t>(kSceneReset)) == static_cast<int>(kBits));
}
