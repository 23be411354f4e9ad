#include "rt/text/read_file.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "tests/support/temporary_file.h"

using tactus::text::read_file;

TEST_CASE("a file is read completely, one above the limit up to a byte more, and an unreadable one is reported") {
  const tactus::test::TemporaryFile file;
  std::ofstream(file.path()) << "twelve bytes";
  CHECK(read_file(file.path(), 100) == "twelve bytes");
  CHECK(read_file(file.path(), 12) == "twelve bytes");
  CHECK(read_file(file.path(), 5) == "twelve");
  CHECK_FALSE(read_file(file.path() + ".none", 100).has_value());
  CHECK_FALSE(read_file("/", 100).has_value());
  CHECK_FALSE(read_file("/proc/self/mem", 100).has_value());  // it opens, and its first byte cannot be read
}
