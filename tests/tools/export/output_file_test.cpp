// An output replaces a file of its own kind, and no other file.
#include "tools/export/output_file.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/temporary_file.h"

using namespace tactus;
using namespace tactus::exporting;
using Catch::Matchers::Contains;

namespace {

struct Example {
  OutputKind kind;
  std::string text;
};

// As each is written.
const Example kOwn[] = {{OutputKind::kTape, std::string("TACTAPE\0\x10", 9)},
                        {OutputKind::kCsv, "tick,time_s,force_x_N\n0,0,0\n"},
                        {OutputKind::kCsv, "coupling,rate [Hz],tick_p50 [us]\nsub-world,1000,40\n"},
                        {OutputKind::kHdf5, "\x89HDF\r\n\x1a\n"},
                        {OutputKind::kSvg, "<svg xmlns=\"http://www.w3.org/2000/svg\">"},
                        {OutputKind::kPage, "<!doctype html><html lang=\"en\">"},
                        {OutputKind::kTrace, "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[]}"},
                        {OutputKind::kJunit, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite"},
                        {OutputKind::kBudget, "{\n \"tactus\": \"budget\",\n \"format\": 1}"}};

}  // namespace

TEST_CASE("an output replaces a file of its own kind, and none of another") {
  const test::TemporaryFile file;
  for (const Example& there : kOwn) {
    std::ofstream(file.path(), std::ios::binary) << there.text;
    for (const Example& wanted : kOwn) {
      CAPTURE(there.text, wanted.text);
      CHECK(check_replaced(file.path(), wanted.kind).ok() == (there.kind == wanted.kind));
    }
  }
}

TEST_CASE("a scene, a configuration or a note is never replaced") {
  const test::TemporaryFile file;
  for (const char* text : {"[proxy]\nshape = \"sphere\"\n", "title = \"a, b\"\n", "# a scene, mine\n",
                           "{\"my\": \"data\"}\n", "scene = \"a.toml\"\n"})
    for (const Example& wanted : kOwn) {
      std::ofstream(file.path(), std::ios::binary) << text;
      CAPTURE(text, wanted.text);
      const Status status = check_replaced(file.path(), wanted.kind);
      REQUIRE_FALSE(status.ok());
      CHECK_THAT(status.message(), Contains(file.path() + ": is there and is no ") && Contains("; accepted: another"));
      std::ifstream left(file.path());
      CHECK(std::string(std::istreambuf_iterator<char>(left), {}) == text);
    }
}

TEST_CASE("an empty file, a new one and what is no regular file may be written, a folder or a file in none may not") {
  const test::TemporaryFile file;
  CHECK(check_replaced(file.path(), OutputKind::kTape).ok());
  CHECK(check_replaced(file.path() + ".new", OutputKind::kCsv).ok());
  CHECK_FALSE(std::filesystem::exists(file.path() + ".new"));
  CHECK(check_replaced("/dev/null", OutputKind::kPage).ok());
  CHECK_THAT(check_replaced("/", OutputKind::kCsv).message(), Contains("is a folder; accepted: a file"));
  CHECK_THAT(check_replaced("/nonexistent/x.csv", OutputKind::kCsv).message(),
             Contains("cannot be written: No such file or directory; accepted: a file in a folder that exists"));
}
