// firmware/conformance.txt against the firmware. Where the sources are not at hand (on a target), there is no file.
#ifdef TACTUS_SOURCE_DIR

#include "tests/support/conformance.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <map>

TEST_CASE("the conformance file is what the firmware does, line by line") {
  std::ifstream file(TACTUS_SOURCE_DIR "/firmware/conformance.txt");
  REQUIRE(file.good());
  tactus::test::ConformanceDevice device;
  std::map<std::string, unsigned> answers;
  std::string line, last_case;
  for (unsigned number = 1; std::getline(file, line); ++number) {
    const std::string word = line.substr(0, line.find(' '));
    if (word == "case") last_case = line;
    CAPTURE(number, last_case);
    CHECK(device.answer(line) == line);
    ++answers[word];
  }
  for (const char* word : {"case", "out", "says", "motors", "reply", "fragments", "joined"}) {
    CAPTURE(word);
    CHECK(answers[word] >= 5);
  }
}

#endif
