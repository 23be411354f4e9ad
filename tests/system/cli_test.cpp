// The command line: what is wrong is one line on stderr, with the exit status that says what kind of wrong.
#include <sys/wait.h>

#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

using Catch::Matchers::Contains;

namespace {

struct Output {
  int exit_code{-1};
  std::string out, err;
};

// A file of its own for each process: ctest runs cases side by side.
std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("tactus_cli_" + std::to_string(getpid()) + name)).string();
}

Output run(const std::string& arguments) {
  const std::string error_file = temporary(".err");
  FILE* pipe = popen((std::string(TACTUS_PROGRAM) + " " + arguments + " 2>" + error_file).c_str(), "r");
  REQUIRE(pipe != nullptr);
  Output output;
  char buffer[4096];
  for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.out.append(buffer, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) output.exit_code = WEXITSTATUS(status);
  std::ifstream errors(error_file);
  output.err.assign(std::istreambuf_iterator<char>(errors), {});
  std::filesystem::remove(error_file);
  return output;
}

auto lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

const std::string kScenes = TACTUS_SOURCE_DIR "/sim/scenes/";

}  // namespace

TEST_CASE("bad usage is one line on stderr that says what is accepted, and exit 2") {
  const struct {
    const char *arguments, *says;
  } cases[] = {
      {"", "tactus: no command; accepted: "},
      {"scnee", "tactus: scnee: no such command, did you mean scene?; accepted: "},
      {"--jsno", "tactus: --jsno: no such option"},
      {"scene", "tactus scene: no command; accepted: check"},
      {"scene chekc", "tactus scene: chekc: no such command, did you mean check?"},
      {"scene check", "tactus scene check: FILE is required"},
      {"scene check --jsno x.toml", "tactus scene check: --jsno: no such option, did you mean --json?"},
      {"scene check --rate=fast x.toml", "tactus scene check: "},
      {"scene check --rate 1 x.toml", "tactus scene check: "},
      {"scene check a.toml b.toml", "tactus scene check: b.toml: one argument too many"},
      {"scene check /nowhere.toml", "tactus: /nowhere.toml: the file: cannot be read; accepted: "},
  };
  for (const auto& c : cases) {
    const Output output = run(c.arguments);
    INFO("tactus " << c.arguments << "\n" << output.err);
    CHECK(output.exit_code == 2);
    CHECK(output.out.empty());
    CHECK(lines(output.err) == 1);
    CHECK_THAT(output.err, Contains(c.says));
    CHECK_THAT(output.err, Contains("accepted: "));
  }
}

TEST_CASE("a bad scene is a line for each mistake, with file, line and column, and exit 2") {
  const std::string file = temporary(".toml");
  std::ofstream(file) << "titel = 1\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = -1\n";
  const Output output = run("scene check " + file);
  CHECK(output.exit_code == 2);
  CHECK(lines(output.err) == 2);
  CHECK_THAT(output.err, Contains(file + ":1:1: titel: not a key, did you mean title?; accepted: "));
  CHECK_THAT(output.err, Contains(file + ":5:11: [proxy] mass_kg: -1 is not a mass; accepted: "));
  const Output json = run("scene check --json " + file);
  CHECK(json.exit_code == 2);
  CHECK_THAT(json.out, Contains("\"accepted\": false"));
  CHECK_THAT(json.out, Contains("\"line\": 5"));
  std::filesystem::remove(file);
}

TEST_CASE("a scene that will not run well is exit 1, with the reason") {
  const std::string file = temporary(".toml");
  std::ofstream(file) << "[coupling]\nstiffness_N_per_m = 90000\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\n"
                         "mass_kg = 0.1\n[[body]]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 1\n"
                         "position_m = [0.015, 0, 0]\n";
  const Output output = run("scene check " + file);
  CHECK(output.exit_code == 1);
  CHECK_THAT(output.out, Contains("problem: [coupling] translation: 90000 N/m"));
  CHECK_THAT(output.out, Contains("problem: bodies 0 and 1 overlap by 0.005 m"));
  CHECK_THAT(output.out, Contains("verdict: bad"));
  std::filesystem::remove(file);
}

TEST_CASE("a good scene is exit 0, as text and as one JSON object") {
  const Output text = run("scene check " + kScenes + "card_house.toml");
  INFO(text.err);
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("verdict: good"));
  CHECK(text.err.empty());
  const Output json = run("scene check --json " + kScenes + "card_house.toml");
  CHECK(json.exit_code == 0);
  CHECK(json.out.front() == '{');
  CHECK_THAT(json.out, Contains("\"stiffness_allowed_N_per_m\"") && Contains("\"good\": true"));
}

TEST_CASE("help teaches with an example") {
  for (const char* command : {"", "scene ", "scene check "}) {
    const Output output = run(std::string(command) + "--help");
    CHECK(output.exit_code == 0);
    CHECK(output.err.empty());
    CHECK_THAT(output.out, Contains("Example") && Contains("  tactus scene check sim/scenes/card_house.toml"));
  }
}
