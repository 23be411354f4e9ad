#include "rt/text/nearest_word.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

using tactus::text::nearest_word;
using Words = std::vector<std::string_view>;

TEST_CASE("the nearest word needs the fewest letters inserted, left out or replaced, of equals the first") {
  CHECK(nearest_word("fricton", Words{"function", "friction"}) == "friction");  // two changes, one
  CHECK(nearest_word("massx", Words{"maze", "mass"}) == "mass");
  CHECK(nearest_word("cat", Words{"bat", "hat"}) == "bat");
}

TEST_CASE("two letters that changed places are one change") {
  CHECK(nearest_word("fiel", Words{"fill", "file"}) == "fill");  // one change each, the first
  CHECK(nearest_word("fiel", Words{"mile", "file"}) == "file");
  CHECK(nearest_word("jsno", Words{"json"}) == "json");
  CHECK(nearest_word("ca", Words{"abc"}).empty());
}

TEST_CASE("the beginning of a key counts as one change, however long its unit is") {
  CHECK(nearest_word("stiffness", Words{"stillness", "stiffness_N_per_m"}) == "stiffness_N_per_m");
  CHECK(nearest_word("st", Words{"stiffness_N_per_m"}).empty());  // too short to be one
}

TEST_CASE("a key with the same first part is nearer than any other word") {
  CHECK(nearest_word("rotation_deg", Words{"rotatiqn_deg", "rotation_vector_rad"}) == "rotation_vector_rad");
}

TEST_CASE("nothing is suggested where half of the word would change, or more") {
  CHECK(nearest_word("abcd", Words{"abcz"}) == "abcz");
  CHECK(nearest_word("abcd", Words{"abyz"}).empty());
  CHECK(nearest_word("cube", Words{"box", "sphere", "cone"}).empty());
  CHECK(nearest_word("abcd", Words{}).empty());
  CHECK(nearest_word(std::string(65, 'a'), Words{"aaaa"}).empty());
}
