// tactus run of a scene with several hands, from the command line.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/run_command.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

const std::string kScene = TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml";

CommandOutput tactus_run(const std::string& options, const std::string& scene = kScene) {
  return run_command(std::string(TACTUS_PROGRAM) + " run " + scene + " " + options + " 2>&1");
}

}  // namespace

TEST_CASE("several hands: a summary each, and the worst of them is the program's") {
  const auto json = run_command(std::string(TACTUS_PROGRAM) + " run " + kScene +
                                " --virtual-time --duration 0.9 --device sim --device sim --inject '' "
                                "--inject estop@500 --json 2>/dev/null");
  CHECK(json.exit_code == 1);
  const auto object = nlohmann::json::parse(json.out);
  REQUIRE(object["hands"].size() == 2);
  CHECK(object["level"] == "bad");
  CHECK(object["exit_code"] == 1);
  CHECK(object["real_time"] == false);
  CHECK(object["hands"][0]["number"] == 1);
  CHECK(object["hands"][0]["level"] == "good");
  CHECK(object["hands"][0]["faults"].empty());
  CHECK(object["hands"][1]["number"] == 2);
  CHECK(object["hands"][1]["faults"].size() == 1);
  for (const auto& hand : object["hands"]) CHECK(hand["run"]["ticks"] == 900);
  CHECK(object["hands"][0]["state_hash"] != object["hands"][1]["state_hash"]);

  const auto text = tactus_run("--virtual-time --duration 0.3");
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("hand 1 of 2: Two hands push a block to and fro (good)"));
  CHECK_THAT(text.out, Contains("hand 2 of 2: Two hands push a block to and fro (good)"));
}

TEST_CASE("several hands: what is of one hand alone is refused in one line") {
  const auto refused = [](const std::string& options, const std::string& scene = kScene) {
    const auto output = tactus_run(options, scene);
    INFO(output.out);
    CHECK(output.exit_code == 2);
    CHECK(std::count(output.out.begin(), output.out.end(), '\n') == 1);
    CHECK_THAT(output.out, Contains("accepted: "));
    return output.out;
  };
  CHECK_THAT(refused("--view --virtual-time"), Contains("--view: several hands are watched in real time"));
  CHECK_THAT(refused("--control /tmp/x --virtual-time"), Contains("--control: several hands"));
  CHECK_THAT(refused("--hand pointer --virtual-time"), Contains("--hand pointer: several hands"));
  CHECK_THAT(refused("--virtual-time --figures force_z_N:rms"), Contains("--figures: is of one hand"));
  CHECK_THAT(refused("--virtual-time --device sim --device sim --device sim"), Contains("--device: 3 for 2 hands"));
  CHECK_THAT(refused("--virtual-time --device sim --device sim", TACTUS_SOURCE_DIR "/sim/scenes/wall.toml"),
             Contains("--device: 2 for 1 hands"));
  CHECK_THAT(refused("--device can:can0"), Contains("serves one hand"));
  CHECK_THAT(refused("--virtual-time --device sim --device can:can0"), Contains("hand 2: --virtual-time"));
  CHECK_THAT(refused("--virtual-time --coupling static"), Contains("accepted: sub-world"));
  CHECK_THAT(refused("--virtual-time --keep-gains --ratio 40"), Contains("40 to 80 ms late"));
}

TEST_CASE("several hands: a stiffness that is too much for two on one body is lowered, and said") {
  const auto output = tactus_run("--virtual-time --duration 0.1 --ratio 20");
  CHECK(output.exit_code == 0);
  CHECK_THAT(output.out, Contains("tactus run: hand 1: stiffness 900 -> ") &&
                             Contains("the most that 2 hands on one light body bear at ratio 20"));
}

TEST_CASE("several hands: a tape each, that tactus replay takes") {
  const TemporaryFile first;
  const std::string second = first.path() + ".2";  // the file has no extension
  const auto output = tactus_run("--virtual-time --duration 0.5 --record " + first.path());
  CHECK(output.exit_code == 0);
  for (const std::string& tape : {first.path(), second}) {
    const auto replayed = run_command(std::string(TACTUS_PROGRAM) + " replay " + tape + " 2>&1");
    INFO(replayed.out);
    CHECK(replayed.exit_code == 0);
  }
  (void)std::remove(second.c_str());
}

TEST_CASE("several hands: scene check looks at each") {
  const auto output = run_command(std::string(TACTUS_PROGRAM) + " scene check " + kScene + " 2>&1");
  INFO(output.out);
  CHECK(output.exit_code == 0);
}
