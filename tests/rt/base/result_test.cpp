#include "rt/base/result.h"

#include <catch2/catch.hpp>
#include <memory>

using namespace tactus;

TEST_CASE("a good status has no message, an error has the one it was given", "[base]") {
  CHECK(Status::good().ok());
  CHECK(Status::good().message().empty());
  const Status error = Status::error("no such scene");
  CHECK(!error.ok());
  CHECK(error.message() == "no such scene");
}

TEST_CASE("an error without a text is an error all the same", "[base]") { CHECK(!Status::error("").ok()); }

TEST_CASE("a result holds its value or the reason why not", "[base]") {
  const Result<int> five = 5;
  CHECK(five.ok());
  CHECK(five.value() == 5);
  CHECK(five.message().empty());
  const Result<int> none = Status::error("why");
  CHECK(!none.ok());
  CHECK(none.message() == "why");
  CHECK(none.status().message() == "why");
}

TEST_CASE("a result gives away a value that cannot be copied", "[base]") {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(7);
  const std::unique_ptr<int> taken = std::move(result).value();
  CHECK(*taken == 7);
}
